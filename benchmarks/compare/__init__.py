"""The project compared with other libraries: `python -m benchmarks.compare`."""
