"""Errors of `skew_exp` and `orthogonal_log`, compared with many digits: `python -m benchmarks.accuracy`."""
