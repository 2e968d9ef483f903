"""A sweep: many problems, each of which gives a record; its fields are dask arrays."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from typing import Any, Literal, overload

import dask.array as da
import numpy as np
from dask.delayed import Delayed
from numpy.typing import ArrayLike, NDArray

from stiefel_rs._core import _check_unmasked
from stiefel_rs.errors import InvalidInputError

from . import _blocks, _store


def checked_times(t: ArrayLike) -> NDArray[np.float64]:
    """Return times as an array; raise unless they are finite real numbers."""
    _check_unmasked("t", t)
    given = np.asarray(t)
    if not np.can_cast(given.dtype, np.float64, "same_kind"):
        raise TypeError(f"t: expected real numbers, found an array of dtype {given.dtype}")
    if not np.isfinite(given).all():
        raise InvalidInputError("t: not finite")
    return np.array(given, dtype=np.float64)


class Sweep(Mapping[str, da.Array]):
    """Many problems, one task for each block of them; a mapping from the names of fields to dask arrays.

    Made by :func:`solve_boundary` and :func:`splines`. Fields that are computed together share their tasks:
    ``dask.compute(dict(sweep))``, or ``sweep.persist()`` first. Computed one by one, each solves all problems.

    Attributes
    ----------
    records : dask array of structured dtype, shape (...)
        All fields side by side.
    shape : tuple of int
        Leading axes: the problems.
    """

    def __init__(self, work: _blocks.Work, records: da.Array | None = None) -> None:
        self._work = work
        self.records = work.records() if records is None else records

    @property
    def shape(self) -> tuple[int, ...]:
        """Leading axes: the problems."""
        return tuple(self.records.shape)

    def __getitem__(self, field: str) -> da.Array:
        if field not in (self._work.dtype.names or ()):
            raise KeyError(field)
        values = self.records[field]
        return values.astype(f"U{values.dtype.itemsize}") if values.dtype.kind == "S" else values

    def __iter__(self) -> Iterator[str]:
        return iter(self._work.dtype.names or ())

    def __len__(self) -> int:
        return len(self._work.dtype.names or ())

    def __repr__(self) -> str:
        blocks = self.records.npartitions
        return f"Sweep(shape={self.shape}, {blocks} block(s), fields={tuple(self)})"

    def persist(self, **keywords: Any) -> Sweep:
        """Start all tasks, and keep their records in the memory of the workers (of this process, without a cluster).

        Keywords go to ``dask.array.Array.persist``: ``retries=3`` on a cluster, for example.
        """
        return Sweep(self._work, self.records.persist(**keywords))

    @overload
    def to_zarr(
        self, store: str | os.PathLike[str], *, resume: bool = ..., compute: Literal[True] = ..., **keywords: Any
    ) -> dict[str, da.Array]: ...
    @overload
    def to_zarr(
        self, store: str | os.PathLike[str], *, resume: bool = ..., compute: Literal[False], **keywords: Any
    ) -> Delayed: ...
    def to_zarr(
        self, store: str | os.PathLike[str], *, resume: bool = False, compute: bool = True, **keywords: Any
    ) -> dict[str, da.Array] | Delayed:
        """Solve, and write each block into a Zarr group as soon as it is done.

        One array for each field; an attribute of the group says what was solved, by which version, from which inputs.
        A block counts as done once its checksum is written, which is last: a run that is killed loses the blocks in
        progress, and nothing else.

        Parameters
        ----------
        store : str or os.PathLike
            A folder, or an address that Zarr knows (``"s3://..."``), which all workers can write to.
        resume : bool, default False
            Go on with a store that this sweep has begun: blocks that are complete are checked and kept. A store that is
            not there is begun.
        compute : bool, default True
            Whether to run now. Otherwise what is returned runs when it is computed: ``client.compute(writing)``, for
            ``distributed.progress``.
        **keywords
            To ``dask.compute``: ``retries=3`` on a cluster, ``scheduler="synchronous"`` without one, for example.

        Returns
        -------
        dict of str to dask array, or dask.delayed.Delayed
            The stored fields, as :func:`from_zarr` gives them; with ``compute=False`` a delayed number, the problems
            that were solved.

        Raises
        ------
        InvalidInputError
            There is something at that address and `resume` is False; or it is no store of this sweep: other inputs,
            options, blocks or version, or damaged. Says what differs.

        Notes
        -----
        Inputs are computed twice: for their checksum, which is in the store from the beginning, and to solve. Those
        that take long to compute, or are random without a seed, should be persisted or stored first.
        """
        path = _store.address(store)
        writing = _store.writing(path, self._work, self.records, resume, keywords)
        if not compute:
            return writing
        writing.compute(**keywords)
        return _store.from_zarr(path, check=False)
