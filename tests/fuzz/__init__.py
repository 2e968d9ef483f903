"""Random calls of every Python entry point. `python -m tests.fuzz --minutes 10`, one case again: `--case SEED`."""
