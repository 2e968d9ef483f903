"""Comparative benchmarks and the accuracy table of stiefel_rs. Not part of the installed package."""
