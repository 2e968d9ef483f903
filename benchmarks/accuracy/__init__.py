"""Errors of functions, geodesics and curves, compared with many digits: `python -m benchmarks.accuracy`."""
