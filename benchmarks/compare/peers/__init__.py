"""One module per timed library; each runs in a separate process and, except ours, in its own environment."""
