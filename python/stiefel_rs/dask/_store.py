"""Sweeps as Zarr groups: one array per field, a manifest, and a checksum for each complete block."""

from __future__ import annotations

import functools
import hashlib
import json
import math
import os
import uuid
from collections.abc import Mapping, Sequence
from typing import Any
from urllib.request import url2pathname

import dask
import dask.array as da
import numpy as np
import zarr
from dask.delayed import Delayed
from numpy.typing import NDArray

import stiefel_rs
from stiefel_rs.errors import InvalidInputError

from . import _blocks

FORMAT = "stiefel_rs sweep"
VERSION = 1
_MANIFEST = "stiefel_rs"
# For each block 0, or a checksum of its records once they are written.
_DONE = "complete"
# Entries of the manifest that a sweep must share with a store to resume it, and their names in messages.
_COMPARED = {
    "format": "format",
    "version": "version of the format",
    "stiefel_rs": "version of stiefel_rs",
    "sweep": "options",
    "fields": "fields",
    "chunks": "blocks",
    "inputs": "inputs",
}


def writing(path: str, work: _blocks.Work, records: da.Array, resume: bool, keywords: Mapping[str, Any]) -> Delayed:
    """Create a store, or find its missing blocks; return a delayed object that solves and writes these."""
    if not resume and _something_at(path):
        raise InvalidInputError(f"{path}: already exists; use resume=True to continue a sweep")
    _require_regular(records.chunks)
    manifest = _manifest(work, records, _digest(work, keywords))
    if _something_at(path):
        missing = _missing(path, manifest, keywords)
    else:
        _begin(path, records, manifest)
        missing = list(np.ndindex(records.numblocks))
    blocks = records.to_delayed()
    write = dask.delayed(write_block, pure=False)
    starts = [np.cumsum((0, *widths))[:-1].tolist() for widths in records.chunks]
    run = uuid.uuid4().hex
    counts = [
        write(blocks[block], path, run, block, [axis[i] for axis, i in zip(starts, block, strict=True)])
        for block in missing
    ]
    return dask.delayed(count, pure=False)(counts)


def address(store: str | os.PathLike[str]) -> str:
    """Return the address in a form that workers in any folder can use."""
    path = os.fsdecode(store)
    if path.startswith("file://"):
        # fsspec does not create folders for file addresses.
        path = url2pathname(path.removeprefix("file://"))
    return path if "://" in path else os.path.abspath(path)


def from_zarr(store: str | os.PathLike[str], *, check: bool = True) -> dict[str, da.Array]:
    """Load the fields of a sweep that was written by ``to_zarr``, as dask arrays.

    Parameters
    ----------
    store : str or os.PathLike
        Address of the store.
    check : bool, default True
        If True, read everything once, in tasks, and compare checksums.

    Returns
    -------
    dict of str to dask array
        Fields by name, in the blocks in which they were written.

    Raises
    ------
    InvalidInputError
        The store does not exist, is not a sweep of this package, has another version, is incomplete, or is damaged. The
        message names the store.
    """
    path = address(store)
    group, manifest = _open(path)
    marks = _marks(path, group, manifest)
    if open_blocks := int((marks == 0).sum()):
        raise InvalidInputError(
            f"{path}: {open_blocks} of {marks.size} blocks are incomplete; continue with to_zarr(..., resume=True)"
        )
    if check:
        _verify(path, marks, manifest, {})
    return {name: da.from_array(group[name], chunks=group[name].chunks) for name in manifest["fields"]}


def _require_regular(chunks: _blocks.Chunks) -> None:
    """Raise unless all blocks except the last have equal sizes: two tasks must not write to the same Zarr chunk."""
    for axis, widths in enumerate(chunks):
        if len(set(widths[:-1])) > 1 or (len(widths) > 1 and widths[-1] > widths[0]):
            raise InvalidInputError(f"axis {axis} has blocks of sizes {widths}, Zarr needs equal sizes: pass chunk=")


def _manifest(work: _blocks.Work, records: da.Array, inputs: str) -> dict[str, Any]:
    names = work.dtype.names or ()
    fields = {name: [work.dtype[name].base.str, list(work.dtype[name].shape)] for name in names}
    settings = {
        name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in work.settings.items()
    }
    manifest = {
        "format": FORMAT,
        "version": VERSION,
        "stiefel_rs": stiefel_rs.__version__,
        "numpy": np.__version__,
        "dask": dask.__version__,
        "zarr": zarr.__version__,
        "sweep": {"task": work.task.__name__, **settings},
        "fields": fields,
        "chunks": [list(widths) for widths in records.chunks],
        "inputs": inputs,
    }
    read: dict[str, Any] = json.loads(json.dumps(manifest))
    return read


def _digest(work: _blocks.Work, keywords: Mapping[str, Any]) -> str:
    """Return the SHA-256 of the checksums of all blocks of the inputs."""
    sums = _blocks.Work(input_block, work.arrays, work.cores, np.dtype(np.uint64), {}).records()
    return hashlib.sha256(np.ascontiguousarray(sums.compute(**keywords)).tobytes()).hexdigest()


def input_block(*blocks: NDArray[Any], origin: tuple[int, ...], dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return the checksum of the inputs of a block, for each of its members."""
    return np.full(blocks[0].shape[: len(origin)], _checksum(blocks), dtype=dtype)


def _checksum(arrays: Sequence[NDArray[Any]]) -> int:
    """Return a nonzero checksum of the bits and shapes of arrays."""
    sum_ = hashlib.blake2b(digest_size=8)
    for array in arrays:
        sum_.update(f"{array.shape}{array.dtype.str}".encode())
        sum_.update(np.ascontiguousarray(array).tobytes())
    return int.from_bytes(sum_.digest(), "little") or 1


def _begin(path: str, records: da.Array, manifest: dict[str, Any]) -> None:
    group = zarr.open_group(path, mode="w-")
    for name, (dtype, core) in manifest["fields"].items():
        group.create_array(
            name,
            shape=(*records.shape, *core),
            chunks=tuple(max(1, max(widths, default=1)) for widths in records.chunks) + tuple(core),
            dtype=str if np.dtype(dtype).kind == "S" else dtype,
        )
    blocks = records.numblocks
    group.create_array(_DONE, shape=blocks, chunks=(1,) * len(blocks), dtype="uint64")
    # Written last, so that a store with a manifest has all of its arrays.
    group.attrs[_MANIFEST] = manifest


def _something_at(path: str) -> bool:
    if "://" not in path:
        return os.path.lexists(path)
    try:
        zarr.open(path, mode="r")
    except (FileNotFoundError, KeyError):
        return False
    return True


def _open(path: str) -> tuple[zarr.Group, dict[str, Any]]:
    """Open a store of this package and this version of the format."""
    try:
        group = zarr.open_group(path, mode="r")
        manifest: Any = group.attrs.get(_MANIFEST)
    # Foreign data may raise any exception.
    except Exception as error:
        raise InvalidInputError(f"{path}: cannot read a Zarr group: {error or type(error).__name__}") from error
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        raise InvalidInputError(f"{path}: not a sweep of stiefel_rs, or one that was killed before it started")
    if manifest.get("version") != VERSION:
        raise InvalidInputError(f"{path}: expected version {VERSION} of the format, found {manifest.get('version')}")
    return group, manifest


def _marks(path: str, group: zarr.Group, manifest: dict[str, Any]) -> NDArray[np.uint64]:
    try:
        lead = tuple(sum(widths) for widths in manifest["chunks"])
        for name, (_, core) in manifest["fields"].items():
            if group[name].shape != lead + tuple(core):
                raise InvalidInputError(f"{name}: expected shape {lead + tuple(core)}, found {group[name].shape}")
        marks = np.asarray(group[_DONE][...], dtype=np.uint64)
        blocks = tuple(len(widths) for widths in manifest["chunks"])
        if marks.shape != blocks:
            raise InvalidInputError(f"expected {blocks} blocks, found {marks.shape}")
    except Exception as error:
        raise InvalidInputError(f"{path}: damaged: {error or type(error).__name__}") from error
    return marks


def _missing(path: str, manifest: dict[str, Any], keywords: Mapping[str, Any]) -> list[tuple[int, ...]]:
    """Return the incomplete blocks of a store; raise if it belongs to another sweep."""
    group, found = _open(path)
    differing = [told for key, told in _COMPARED.items() if found.get(key) != manifest[key]]
    if differing:
        raise InvalidInputError(f"{path}: belongs to another sweep, with different {', '.join(differing)}")
    marks = _marks(path, group, found)
    _verify(path, marks, found, keywords)
    return [block for block in np.ndindex(marks.shape) if not marks[block]]


def _verify(path: str, marks: NDArray[np.uint64], manifest: dict[str, Any], keywords: Mapping[str, Any]) -> None:
    """Raise unless the complete blocks match their checksums."""
    complete = [block for block in np.ndindex(marks.shape) if marks[block]]
    bounds = [np.cumsum((0, *widths)).tolist() for widths in manifest["chunks"]]
    places = [tuple((axis[i], axis[i + 1]) for axis, i in zip(bounds, block, strict=True)) for block in complete]
    # One task per thousand problems, not one per block.
    size = max(1, math.ceil(1000 * marks.size / max(1, math.prod(axis[-1] for axis in bounds))))
    checks = [
        dask.delayed(check_blocks, pure=False)(
            path, manifest["fields"], places[i : i + size], [int(marks[b]) for b in complete[i : i + size]]
        )
        for i in range(0, len(complete), size)
    ]
    damaged = [place for found in dask.compute(*checks, **keywords) for place in found]
    if damaged:
        first = ", ".join(f"{a}:{b}" for a, b in damaged[0])
        raise InvalidInputError(
            f"{path}: damaged: {len(damaged)} of {len(complete)} complete blocks differ from their checksums, "
            f"the first holds problems [{first}]"
        )


def check_blocks(
    path: str, fields: Mapping[str, Any], places: Sequence[tuple[tuple[int, int], ...]], marks: Sequence[int]
) -> list[tuple[tuple[int, int], ...]]:
    """Return the blocks whose records do not match their checksums."""
    group = zarr.open_group(path, mode="r")
    return [place for place, mark in zip(places, marks, strict=True) if not _intact(group, fields, place, mark)]


def _intact(group: zarr.Group, fields: Mapping[str, Any], place: tuple[tuple[int, int], ...], mark: int) -> bool:
    region = tuple(slice(a, b) for a, b in place)
    try:
        found = [np.asarray(group[name][region]).astype(np.dtype(dtype)) for name, (dtype, _) in fields.items()]
    # Damaged bytes may raise any exception.
    except Exception:
        return False
    return _checksum(found) == mark


def write_block(records: NDArray[Any], path: str, run: str, block: tuple[int, ...], start: Sequence[int]) -> int:
    """Write the records of a block, then its checksum; return the number of records."""
    names = records.dtype.names or ()
    arrays = _opened(path, run, names)
    region = tuple(slice(a, a + size) for a, size in zip(start, records.shape, strict=True))
    for name in names:
        field = records[name]
        arrays[name][region] = np.char.decode(field, "ascii").astype(object) if field.dtype.kind == "S" else field
    arrays[_DONE][tuple(block)] = np.uint64(_checksum([records[name] for name in names]))
    return int(records.size)


# Opening all arrays takes as long as writing a block. The run is part of the key, since a later store may have the same
# address.
@functools.lru_cache(maxsize=4)
def _opened(path: str, run: str, names: tuple[str, ...]) -> dict[str, zarr.Array]:
    group = zarr.open_group(path, mode="r+")
    return {name: group[name] for name in (*names, _DONE)}


def count(counts: Sequence[int]) -> int:
    """Return the total number of problems written."""
    return sum(counts)
