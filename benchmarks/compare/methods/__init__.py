"""Alternatives to the crate's algorithms, written with NumPy and SciPy alone, to be timed beside it."""
