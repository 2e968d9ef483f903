"""Sweeps on a local cluster of processes: `python -m benchmarks.cluster`."""
