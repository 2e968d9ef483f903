"""Sweeps: many problems with one record each, whose fields are dask arrays."""

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
    """Many problems, solved in blocks; a mapping from names of fields to dask arrays.

    Returned by :func:`solve_boundary` and :func:`splines`. Compute fields together, by ``dask.compute(dict(sweep))`` or
    after ``sweep.persist()``, so that they share their tasks: computing each field separately solves all problems anew.

    Attributes
    ----------
    records : dask array of structured dtype, shape (...)
        Records with all fields.
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
        """Solve all problems, and keep the records in the memory of the workers (or of this process).

        Keywords are passed to ``dask.array.Array.persist``, such as ``retries=3`` on a cluster.
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
        """Solve all problems, and write each block to a Zarr group as soon as it is done.

        The group has one array per field, and an attribute that states the task, the version and a checksum of the
        inputs. A block is complete once its checksum is written, after its records: a run that is killed loses only
        the blocks in progress.

        Parameters
        ----------
        store : str or os.PathLike
            A folder, or an address that Zarr supports (``"s3://..."``), to which all workers can write.
        resume : bool, default False
            If True, continue an unfinished store of this sweep: complete blocks are checked and kept. If there is no
            store, a new one is created.
        compute : bool, default True
            If False, return a delayed object that runs when it is computed, for example by ``client.compute(writing)``
            for ``distributed.progress``.
        **keywords
            Passed to ``dask.compute``, such as ``retries=3`` on a cluster, or ``scheduler="synchronous"`` without one.

        Returns
        -------
        dict of str to dask array, or dask.delayed.Delayed
            The stored fields, as returned by :func:`from_zarr`; with ``compute=False`` a delayed number of solved
            problems.

        Raises
        ------
        InvalidInputError
            The address exists and `resume` is False; or the store is damaged or belongs to another sweep, with other
            inputs, options, blocks or version. The message states the difference.

        Notes
        -----
        Inputs are computed twice: first for their checksum, then to solve. Persist or store inputs first that take long
        to compute, or are random without a seed.
        """
        path = _store.address(store)
        writing = _store.writing(path, self._work, self.records, resume, keywords)
        if not compute:
            return writing
        writing.compute(**keywords)
        return _store.from_zarr(path, check=False)
