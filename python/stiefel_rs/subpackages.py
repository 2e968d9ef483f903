"""Subpackages as attributes of the package, imported when they are first used.

They need packages that may be missing, or take long to import.
"""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Final

__all__ = ["SUBPACKAGES", "ModuleType", "subpackage"]

SUBPACKAGES: Final = ("dask", "explore", "jax", "plotting", "pymanopt", "reproduce", "torch")


def subpackage(name: str) -> ModuleType:
    """Import a subpackage.

    Raises
    ------
    AttributeError
        There is none of that name.
    """
    if name in SUBPACKAGES:
        return importlib.import_module(f"{__package__}.{name}")
    raise AttributeError(f"module {__package__!r} has no attribute {name!r}")
