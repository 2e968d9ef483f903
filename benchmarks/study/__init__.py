"""Integrators of Riemannian cubics, compared: `python -m benchmarks.study`."""
