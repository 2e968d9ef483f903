"""Checks of what is released."""
