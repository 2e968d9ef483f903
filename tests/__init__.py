"""Tests of the package; the Python ones are collected by pytest, those of the crate by cargo."""
