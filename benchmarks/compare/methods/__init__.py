"""Alternatives to the crate's algorithms, written with NumPy and SciPy alone, for comparison."""
