"""Checks of what is released, and the map of the paper."""
