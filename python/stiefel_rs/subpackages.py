"""Subpackages as attributes of the package, imported on first use.

They need optional dependencies, or take long to import.
"""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Final

__all__ = ["SUBPACKAGES", "subpackage"]

SUBPACKAGES: Final = ("dask", "explore", "jax", "plotting", "pymanopt", "reproduce", "torch")


def subpackage(name: str) -> ModuleType:
    """Import a subpackage.

    Raises
    ------
    AttributeError
        No subpackage has this name, or one of its dependencies is missing; `hasattr` and `help` then skip it.
    """
    if name in SUBPACKAGES:
        try:
            return importlib.import_module(f"{__package__}.{name}")
        except ImportError as error:
            raise AttributeError(f"{__package__}.{name}: {error}; pip install 'stiefel-rs[{name}]'") from error
    raise AttributeError(f"module {__package__!r} has no attribute {name!r}")
