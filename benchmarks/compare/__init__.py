"""The project beside other libraries: `python -m benchmarks.compare`."""
