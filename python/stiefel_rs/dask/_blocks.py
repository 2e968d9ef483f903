"""Preparation of arrays for tasks: validation, broadcasting, and blocks along the leading axes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import dask.array as da
import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiefel_rs._core import _check_unmasked
from stiefel_rs.errors import InvalidInputError

Batch: TypeAlias = ArrayLike | da.Array
Loaded: TypeAlias = NDArray[Any] | da.Array
Number: TypeAlias = type[np.float64] | type[np.complex128]
Chunks: TypeAlias = tuple[tuple[int, ...], ...]


def frames(core: int, least: Number = np.float64, /, **arrays: Batch) -> tuple[dict[str, Loaded], Number]:
    """Read arrays of frames or vectors as `least`, or all as complex128 if one of them is complex.

    Raises
    ------
    InvalidInputError, TypeError
        As for `load`.
    """
    loaded = {name: load(name, array, core, np.complex128) for name, array in arrays.items()}
    number: Number = np.complex128 if any(array.dtype.kind == "c" for array in loaded.values()) else least
    return {name: array if array.dtype == number else array.astype(number) for name, array in loaded.items()}, number


def load(name: str, array: Batch, core: int, largest: Number = np.float64) -> Loaded:
    """Read an array with at least `core` axes as float64, or as complex128 if `largest` allows it.

    Arrays in memory are checked for non-finite entries here, other arrays in the tasks.

    Raises
    ------
    InvalidInputError
        Too few axes, unknown sizes, or an entry that is not finite.
    TypeError
        The numbers are of another type.
    """
    given = array if isinstance(array, da.Array) else _in_memory(name, array)
    if not np.can_cast(given.dtype, largest, "same_kind"):
        wanted = "real" if largest is np.float64 else "real or complex"
        raise TypeError(f"{name}: expected {wanted} numbers, found an array of dtype {given.dtype}")
    if given.ndim < core:
        raise InvalidInputError(f"{name}: expected at least {core} axes, found shape {given.shape}")
    if any(math.isnan(size) for size in given.shape):
        raise InvalidInputError(f"{name}: the sizes of its blocks are unknown; call compute_chunk_sizes()")
    return given.astype(np.complex128 if given.dtype.kind == "c" else np.float64)


def _in_memory(name: str, array: ArrayLike) -> NDArray[Any]:
    _check_unmasked(name, array)
    try:
        dense = np.asarray(array)
    except ValueError as error:
        raise InvalidInputError(f"{name}: {error}") from error
    if np.can_cast(dense.dtype, np.complex128, "same_kind") and not np.isfinite(dense).all():
        index = tuple(int(i) for i in np.argwhere(~np.isfinite(dense))[0])
        raise InvalidInputError(f"{name}: the entry at {index} is not finite")
    return dense


def require_core(name: str, array: Loaded, core: tuple[int | None, ...]) -> None:
    """Raise unless the last axes have the given sizes; `None` stands for any size."""
    found = array.shape[array.ndim - len(core) :]
    if any(size is not None and size != at for size, at in zip(core, found, strict=True)):
        expected = ", ".join("any" if size is None else str(size) for size in core)
        raise InvalidInputError(f"{name}: expected shape (..., {expected}), found {array.shape}")


def leading_chunks(arrays: Mapping[str, tuple[Loaded, int]], chunk: int | None, default: int) -> Chunks:
    """Return blocks of the leading axes after broadcasting.

    With `chunk`, a block has at most that many members; the first axes are split first. Otherwise the blocks are those
    of the first dask array that has all leading axes and more than one block, or have `default` members.
    """
    shapes = {name: array.shape[: array.ndim - core] for name, (array, core) in arrays.items()}
    try:
        shape = np.broadcast_shapes(*shapes.values())
    except ValueError as error:
        told = ", ".join(f"{name} {found}" for name, found in shapes.items())
        raise InvalidInputError(f"leading axes do not broadcast: {told}") from error
    if chunk is None:
        for array, core in arrays.values():
            lead = array.chunks[: array.ndim - core] if isinstance(array, da.Array) else ()
            if array.shape[: array.ndim - core] == shape and any(len(blocks) > 1 for blocks in lead):
                return tuple(lead)
    return _cut(shape, default if chunk is None else positive("chunk", chunk))


def _cut(shape: Sequence[int], limit: int) -> Chunks:
    chunks: list[tuple[int, ...]] = []
    for size in reversed(shape):
        width = max(1, min(size, limit))
        limit = max(1, limit // width)
        whole, rest = divmod(size, width)
        chunks.append((width,) * whole + ((rest,) if rest or not size else ()))
    return tuple(reversed(chunks))


def positive(name: str, number: int) -> int:
    """Return an integer of at least 1; raise for other values."""
    if isinstance(number, bool) or not isinstance(number, (int, np.integer)):
        raise TypeError(f"{name}: expected an integer, found {number!r}")
    if number < 1:
        raise InvalidInputError(f"{name}: expected at least 1, found {number}")
    return int(number)


def align(array: Loaded, core: int, chunks: Chunks) -> da.Array:
    """Broadcast the leading axes and split them into blocks; the last `core` axes form one block."""
    inner = array.shape[array.ndim - core :]
    shape = tuple(sum(blocks) for blocks in chunks) + inner
    whole = (*chunks, *((size,) for size in inner))
    if not isinstance(array, da.Array):
        array = da.from_array(array, chunks=whole if array.shape == shape else -1)
    if array.shape != shape:
        # Axes to be broadcast have one block of size 1 before.
        array = da.broadcast_to(array, shape, chunks=_stretchable(array, whole))
    return array.rechunk(whole)


def _stretchable(array: da.Array, chunks: Chunks) -> Chunks:
    offset = len(chunks) - array.ndim
    return tuple(
        blocks if axis < offset or array.shape[axis - offset] == 1 != sum(blocks) else array.chunks[axis - offset]
        for axis, blocks in enumerate(chunks)
    )


@dataclass(frozen=True)
class Work:
    """A task for the blocks of a batch, which returns a record for each member.

    Attributes
    ----------
    task : callable
        ``task(*blocks, origin=..., dtype=..., **settings)`` returns the records of a block. A function at module level,
        so that only its name is sent to workers.
    arrays : sequence of dask.array.Array
        Arrays with equal leading axes and blocks, and other axes in one block.
    cores : sequence of int
        Numbers of other axes.
    dtype : numpy.dtype
        Type of a record.
    settings : mapping of str to object
        Small objects, which are sent with every task.
    """

    task: Any
    arrays: Sequence[da.Array]
    cores: Sequence[int]
    dtype: np.dtype[Any]
    settings: Mapping[str, Any]

    def records(self) -> da.Array:
        """Return the records of all members, lazily."""
        lead = self.arrays[0].ndim - self.cores[0]
        outer, fresh = tuple(range(lead)), itertools.count(lead)
        pairs: list[Any] = []
        for array, core in zip(self.arrays, self.cores, strict=True):
            pairs += [array, outer + tuple(itertools.islice(fresh, core))]
        for axis, blocks in enumerate(self.arrays[0].chunks[:lead]):
            pairs += [da.arange(sum(blocks), chunks=(blocks,), dtype=np.int64), (axis,)]
        records: da.Array = da.blockwise(
            at_origin,
            outer,
            *pairs,
            task=self.task,
            lead=lead,
            settings={"dtype": self.dtype, **self.settings},
            dtype=self.dtype,
            meta=np.empty((0,) * lead, dtype=self.dtype),
        )
        return records


def at_origin(*blocks: Any, task: Any, lead: int, settings: Mapping[str, Any]) -> NDArray[Any]:
    """Run a task with the position of its block in the leading axes of the whole array."""
    arrays = [_unwrapped(block) for block in blocks]
    numbers = arrays[len(arrays) - lead :]
    origin = tuple(int(axis[0]) if axis.size else 0 for axis in numbers)
    records: NDArray[Any] = task(*arrays[: len(arrays) - lead], origin=origin, **settings)
    return records


def _unwrapped(block: Any) -> NDArray[Any]:
    # Axes that records do not have arrive as lists of their blocks, of length one.
    while isinstance(block, list):
        (block,) = block
    _check_unmasked("block", block)
    return np.asarray(block)
