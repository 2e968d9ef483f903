"""Sweeps over random boundary problems on a cluster, timed."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import dask
import dask.array as da
import distributed
import numpy as np

from stiefel_rs.dask import Stiefel, solve_boundary

REACH = 2.0
# Inputs are generated in blocks of this size for every block size of the sweep, so that its problems are the same.
GENERATED = 2500


@dataclass(frozen=True)
class Case:
    """One kind of problem on one manifold, and the block sizes to try."""

    kind: Any
    n: int
    k: int
    count: int
    chunks: tuple[int, ...]


@dataclass(frozen=True)
class Sample:
    """Wall and processor seconds of a sweep into memory and into Zarr; number of files and bytes of the latter."""

    memory: float
    memory_processor: float
    stored: float
    stored_processor: float
    files: int
    size: int


def ends(n: int, k: int, count: int) -> list[Any]:
    """Random boundary data as dask arrays."""
    manifold, rng = Stiefel(n, k), da.random.default_rng(20240419)

    def normal() -> Any:
        return rng.standard_normal((count, n, k), chunks=(GENERATED, n, k))

    def tangent(S: Any) -> Any:
        V = manifold.project_tangent(S, normal())
        lengths = REACH * rng.random(count, chunks=GENERATED)
        return V * (lengths / manifold.norm(S, V))[:, None, None]

    S0 = manifold.project(normal())
    S1 = manifold.exp(S0, tangent(S0))
    return [S0, tangent(S0), S1, tangent(S1)]


def alone(case: Case, data: Sequence[Any], count: int) -> float:
    """Processor seconds per problem of a loop in this process, over the first problems."""
    ours = [np.asarray(array[:count].compute()) for array in data]
    sweep = solve_boundary(*ours, kind=case.kind, on_error="mark", chunk=count)
    start = time.process_time()
    dask.compute(sweep.records, scheduler="synchronous")
    return (time.process_time() - start) / count


def worker_seconds(client: Any) -> float:
    """Processor time of all workers since they started."""
    return float(sum(client.run(time.process_time).values()))


def timed(run: Callable[[], Any]) -> float:
    """Wall seconds of a call."""
    start = time.perf_counter()
    run()
    return time.perf_counter() - start


def measure(case: Case, client: Any, made: Sequence[Any], chunk: int) -> Sample:
    """Run the sweep twice: into memory, and into Zarr."""
    data = dask.persist(*[array.rechunk((chunk, case.n, case.k)) for array in made])
    distributed.wait(data)
    sweep = solve_boundary(*data, kind=case.kind, on_error="mark")
    before = worker_seconds(client)
    memory = timed(lambda: distributed.wait(sweep.persist().records))
    between = worker_seconds(client)
    with tempfile.TemporaryDirectory() as folder:
        stored = timed(lambda: sweep.to_zarr(f"{folder}/store"))
        after = worker_seconds(client)
        files = [file for file in Path(folder).rglob("*") if file.is_file()]
        return Sample(memory, between - before, stored, after - between, len(files), size_of(files))


def size_of(files: Sequence[Path]) -> int:
    """Bytes of files."""
    return sum(file.stat().st_size for file in files)
