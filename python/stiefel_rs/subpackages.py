"""Subpackages as attributes of the package, imported when they are first used.

They need packages that may be missing, or take long to import.
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
        There is none of that name, or a package that it needs is missing: so `hasattr` and `help` pass it by.
    """
    if name in SUBPACKAGES:
        try:
            return importlib.import_module(f"{__package__}.{name}")
        except ImportError as error:
            raise AttributeError(f"{__package__}.{name}: {error}; pip install 'stiefel-rs[{name}]'") from error
    raise AttributeError(f"module {__package__!r} has no attribute {name!r}")
