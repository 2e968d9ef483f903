"""The option `manifold=` of curves: a manifold of this package, described by JSON values in tasks and stores."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

import stiefel_rs

from ._blocks import Number
from ._manifold import Description, Manifold, describe, rebuild

AnyManifold: TypeAlias = stiefel_rs.Stiefel | stiefel_rs.Grassmann | Manifold


def described(manifold: AnyManifold | None) -> Description | None:
    """Return the description of a manifold; raise unless it is one, or None."""
    if manifold is None:
        return None
    compiled = manifold._manifold if isinstance(manifold, Manifold) else manifold
    if not isinstance(compiled, (stiefel_rs.Stiefel, stiefel_rs.Grassmann)):
        raise TypeError(f"manifold: expected a Stiefel or a Grassmann, found {type(compiled).__name__}")
    return describe(compiled)


def keyword(description: Description | None) -> dict[str, Any]:
    """Return the keyword of a curve for the described manifold; empty for None."""
    return {} if description is None else {"manifold": rebuild(description)}


def number(description: Description | None) -> Number:
    """Return the type that arrays must have at least: complex128 on a complex manifold."""
    return np.complex128 if description is not None and description["field"] == "complex" else np.float64
