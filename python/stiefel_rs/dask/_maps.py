"""Maps of matrices for dask arrays: rotations and their logarithms, and the tasks that maps of manifolds share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import dask.array as da
import numpy as np
from numpy.typing import NDArray

import stiefel_rs
from stiefel_rs.errors import StiefelError

from . import _blocks
from ._blocks import Batch
from ._errors import of_batch
from ._records import require_version

Layout: TypeAlias = list[tuple[str, tuple[int, ...]]]
REPORT = ("converged", "iterations", "residual", "length", "certainly_shortest")
_DEFAULT_CHUNK = 10_000
# Types of fields that are not matrices of the field of the manifold, nor float64 numbers.
_TYPES = {"angles": np.float64, "converged": np.bool_, "iterations": np.int64, "certainly_shortest": np.bool_}


def skew_exp(A: Batch) -> da.Array:
    """Return exponentials of skew-symmetric or skew-Hermitian matrices, shape (..., m, m).

    See :func:`stiefel_rs.skew_exp`.

    Examples
    --------
    >>> import dask.array as da
    >>> from stiefel_rs.dask import orthogonal_log, skew_exp
    >>> A = da.from_array([[[0.0, -0.5], [0.5, 0.0]]] * 4, chunks=(2, 2, 2))
    >>> bool(abs(orthogonal_log(skew_exp(A)) - A).max().compute() < 1e-15)
    True
    """
    return _square("skew_exp", "A", A)


def orthogonal_log(Q: Batch) -> da.Array:
    """Return principal logarithms of rotations or unitary matrices, shape (..., m, m).

    See :func:`stiefel_rs.orthogonal_log`.
    """
    return _square("orthogonal_log", "Q", Q)


def _square(function: str, name: str, array: Batch) -> da.Array:
    arrays, number = _blocks.frames(2, **{name: array})
    m = int(arrays[name].shape[-1])
    _blocks.require_core(name, arrays[name], (m, m))
    return map_records(function_block, arrays, [("value", (m, m))], {"name": function}, number)["value"]


def map_records(
    task: Any,
    arrays: dict[str, _blocks.Loaded],
    layout: Layout,
    settings: dict[str, Any],
    number: _blocks.Number = np.float64,
) -> da.Array:
    """Return the records of a task for arrays of matrices; `layout` has the names and shapes of the fields."""
    chunks = _blocks.leading_chunks({name: (array, 2) for name, array in arrays.items()}, None, _DEFAULT_CHUNK)
    dtype = np.dtype([(field, _TYPES.get(field, number if shape else np.float64), shape) for field, shape in layout])
    aligned = [_blocks.align(array, 2, chunks) for array in arrays.values()]
    settings = {**settings, "version": stiefel_rs.__version__}
    return _blocks.Work(task, aligned, [2] * len(aligned), dtype, settings).records()


def function_block(
    block: NDArray[Any], *, origin: tuple[int, ...], dtype: np.dtype[Any], name: str, version: str
) -> NDArray[Any]:
    """Run a function of matrices on one block."""
    function = getattr(stiefel_rs, name)
    return filled(lambda: function(block, num_threads=1), block.shape[:-2], origin, dtype, version)


def filled(
    call: Callable[[], Any], shape: tuple[int, ...], origin: tuple[int, ...], dtype: np.dtype[Any], version: str
) -> NDArray[Any]:
    """Return the results of a call as records; errors name the member of the whole array."""
    require_version(version)
    records = np.empty(shape, dtype)
    try:
        found = call()
    except StiefelError as error:
        raise of_batch(error, origin, shape) from None
    parts = found if isinstance(found, tuple) else (found,)
    for name in dtype.names or ():
        if name in REPORT:
            records[name] = getattr(parts[-1], name)
    for name, part in zip((name for name in dtype.names or () if name not in REPORT), parts, strict=False):
        records[name] = part
    return records
