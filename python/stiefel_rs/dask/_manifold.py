"""Methods of a manifold as tasks: the base of `Stiefel` and `Grassmann`."""

from __future__ import annotations

from typing import Any, TypeAlias

import dask.array as da
import numpy as np
from numpy.typing import NDArray

import stiefel_rs

from . import _blocks
from ._blocks import Batch
from ._maps import Layout, filled, map_records

# Class name and arguments of a manifold: JSON values, for tasks and stores.
Description: TypeAlias = dict[str, Any]


def describe(manifold: stiefel_rs.Stiefel | stiefel_rs.Grassmann) -> Description:
    """Return the class name and the arguments of a manifold."""
    description = {"name": type(manifold).__name__, "n": manifold.n, "k": manifold.k, "field": manifold.field}
    return {**description, "metric": manifold.alpha} if isinstance(manifold, stiefel_rs.Stiefel) else description


def rebuild(description: Description) -> stiefel_rs.Stiefel | stiefel_rs.Grassmann:
    """Return the manifold of a description."""
    arguments = dict(description)
    manifold: stiefel_rs.Stiefel | stiefel_rs.Grassmann = getattr(stiefel_rs, arguments.pop("name"))(**arguments)
    return manifold


class Manifold:
    """Manifold of matrices whose methods run on the blocks of dask arrays.

    Parameters
    ----------
    manifold : stiefel_rs.Stiefel or stiefel_rs.Grassmann
        Manifold whose methods the tasks run.
    **shapes : tuple of int
        Shapes of the arguments that are not of shape (n, k), by name.
    """

    def __init__(self, manifold: stiefel_rs.Stiefel | stiefel_rs.Grassmann, **shapes: tuple[int, int]) -> None:
        self._manifold, self._shapes = manifold, shapes
        self.n, self.k, self.dim, self.field = manifold.n, manifold.k, manifold.dim, manifold.field

    def _vectors(self, method: str, keywords: dict[str, Any] | None = None, /, **arrays: Batch) -> da.Array:
        return self._records(method, [("value", (self.n, self.k))], keywords or {}, **arrays)["value"]

    def _numbers(self, method: str, /, **arrays: Batch) -> da.Array:
        return self._records(method, [("value", ())], {}, **arrays)["value"]

    def _records(self, method: str, layout: Layout, keywords: dict[str, Any], /, **arrays: Batch) -> da.Array:
        number: _blocks.Number = np.float64 if self.field == "real" else np.complex128
        loaded = {name: _blocks.load(name, array, 2, number) for name, array in arrays.items()}
        for name, array in loaded.items():
            _blocks.require_core(name, array, self._shapes.get(name, (self.n, self.k)))
        settings = {"name": method, "of": describe(self._manifold), "keywords": keywords}
        return map_records(method_block, loaded, layout, settings, number)


def method_block(
    *blocks: NDArray[np.float64],
    origin: tuple[int, ...],
    dtype: np.dtype[Any],
    name: str,
    version: str,
    of: Description,
    keywords: dict[str, Any],
) -> NDArray[Any]:
    """Run a method of a manifold on one block."""
    manifold = rebuild(of)
    return filled(lambda: getattr(manifold, name)(*blocks, **keywords), blocks[0].shape[:-2], origin, dtype, version)
