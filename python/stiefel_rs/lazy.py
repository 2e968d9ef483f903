"""Attributes of the package that are imported on first use: they need optional dependencies, or take long to import."""

from __future__ import annotations

import importlib
from typing import Any, Final

__all__ = ["MODULES", "SUBPACKAGES", "attribute"]

SUBPACKAGES: Final = ("dask", "explore", "jax", "plotting", "pymanopt", "reproduce", "torch")
# The module of each class or function.
MODULES: Final = {
    "PoseSpline": "pose",
    "RotationSpline": "rotation",
    "load": "storage",
    "read_trajectory": "trajectory_files",
    "read_tum": "trajectory_files",
    "write_trajectory": "trajectory_files",
    "write_tum": "trajectory_files",
}


def attribute(name: str) -> Any:
    """Import a subpackage, a module, a class or a function.

    Raises
    ------
    AttributeError
        There is none of this name, or one of its dependencies is missing; `hasattr` and `help` then skip it.
    """
    if name in MODULES:
        return getattr(importlib.import_module(f"{__package__}.{MODULES[name]}"), name)
    if name in MODULES.values():
        return importlib.import_module(f"{__package__}.{name}")
    if name in SUBPACKAGES:
        try:
            return importlib.import_module(f"{__package__}.{name}")
        except ImportError as error:
            raise AttributeError(f"{__package__}.{name}: {error}; pip install 'stiefel-rs[{name}]'") from error
    raise AttributeError(f"module {__package__!r} has no attribute {name!r}")
