"""Errors of `skew_exp` and `orthogonal_log` against many digits: `python -m benchmarks.accuracy`."""
