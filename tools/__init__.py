"""Checks of releases, and the map of the paper."""
