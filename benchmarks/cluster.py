"""Sweeps on a local cluster of processes: block size against overhead and throughput.

``python -m benchmarks.cluster`` writes ``docs/dask_measured.md``; ``--quick`` is a look, ``--long 1000000`` adds one
sweep of that many problems.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import dask
import dask.array as da
import distributed
import numpy as np
import zarr
from tabulate import tabulate  # type: ignore[import-untyped]
from tqdm import tqdm  # type: ignore[import-untyped]

import stiefel_rs
from benchmarks.environment import ROOT, load, machine
from stiefel_rs.dask import Stiefel, Sweep, solve_boundary

WORKERS = 2
REACH = 2.0
# Inputs are generated in these blocks, whatever the blocks of the sweep: its problems are the same for each size.
GENERATED = 2500
HEADERS = (
    "problems per task", "tasks", "into memory", "problems per second", "processor time per problem",
    "over one process", "into Zarr", "problems per second", "files", "size",
)  # fmt: skip

PREAMBLE = """# Sweeps on a cluster, measured

Written by `python -m benchmarks.cluster`. A `LocalCluster` of {workers} processes with one thread each, and the
scheduler and the client, on the machine told at the end; times are those of one run each, from the call to the last
result. Problems are random: distances and speeds uniform up to {reach:g}, in the canonical metric. Their data are in
the memory of the workers before the clock starts. All fields but, for geometric cubics, `cost`; no `points`.

Processor time is that of the workers, for everything they do. One process is a loop over the first {sample} problems
without Dask: "over one process" is what a worker spends on top of it, serialisation and bookkeeping, and what the
processor does slower when both cores are busy. Files and size are those of the Zarr group.
"""


@dataclass(frozen=True)
class Case:
    """One kind of problem on one manifold, and the sizes of blocks to try."""

    kind: Any
    n: int
    k: int
    count: int
    chunks: tuple[int, ...]


FULL = (
    Case("riemannian", 5, 2, 10_000, (10, 100, 1000)),
    Case("geometric", 5, 2, 100_000, (100, 1000, 10_000)),
)
QUICK = (Case("geometric", 5, 2, 5000, (100, 1000)), Case("riemannian", 5, 2, 500, (10, 100)))


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
    """Processor time of all workers since they began."""
    return float(sum(client.run(time.process_time).values()))


def timed(run: Callable[[], Any]) -> float:
    """Wall seconds of a call."""
    start = time.perf_counter()
    run()
    return time.perf_counter() - start


def section(case: Case, client: Any, sample: int) -> str:
    """Table of one case, with a line for each size of blocks."""
    made = dask.persist(*ends(case.n, case.k, case.count))
    distributed.wait(made)
    single = alone(case, made, min(sample, case.count))
    found = []
    # What is loaded with the first task is not timed.
    solve_boundary(*[array[:WORKERS] for array in made], kind=case.kind, chunk=1).records.compute()
    for chunk in tqdm(case.chunks, desc=f"{case.kind} St({case.n},{case.k})"):
        data = dask.persist(*[array.rechunk((chunk, case.n, case.k)) for array in made])
        distributed.wait(data)
        sweep = solve_boundary(*data, kind=case.kind, on_error="mark")
        before = worker_seconds(client)
        wall = timed(lambda sweep=sweep: distributed.wait(sweep.persist().records))  # type: ignore[misc]
        each = (worker_seconds(client) - before) / case.count
        with tempfile.TemporaryDirectory() as folder:
            stored = timed(lambda sweep=sweep, at=folder: sweep.to_zarr(f"{at}/store"))  # type: ignore[misc]
            files = [file for file in Path(folder).rglob("*") if file.is_file()]
            size = sum(file.stat().st_size for file in files)
        found.append([
            chunk, sweep.records.npartitions, f"{wall:.1f} s", f"{case.count / wall:.0f}", f"{each * 1e6:.0f} us",
            f"{each / single - 1:+.0%}", f"{stored:.1f} s", f"{case.count / stored:.0f}", len(files),
            f"{size / 1e6:.1f} MB",
        ])  # fmt: skip
    table = tabulate(found, HEADERS, tablefmt="github", disable_numparse=True)
    return (
        f"## {case.count} {case.kind} cubics on St({case.n},{case.k})\n\n"
        f"One process: {single * 1e6:.0f} us per problem.\n\n{table}\n"
    )


def long_sweep(count: int, folder: str) -> str:
    """One sweep of exact cubics, its data generated by the workers, into Zarr; a paragraph about it."""
    chunk = 2500
    sweep: Sweep = solve_boundary(*ends(3, 2, count), chunk=chunk, on_error="mark")
    begun = load()
    stored: dict[str, Any] = {}
    wall = timed(lambda: stored.update(sweep.to_zarr(f"{folder}/long", retries=2)))
    solved, steps = dask.compute((stored["code"] == 0).sum(), stored["iterations"].mean())
    size = sum(file.stat().st_size for file in Path(folder).rglob("*") if file.is_file())
    return (
        f"{count} Riemannian cubics on St(3,2), {chunk} per task, data generated by the workers, into Zarr: "
        f"{wall / 60:.1f} minutes, {count / wall:.0f} problems per second; {int(solved)} solved, "
        f"{float(steps):.2f} Newton steps on average, {size / 1e6:.0f} MB. Processes that wanted to run: {begun} at "
        f"the start, {load()} at the end."
    )


def pages(cases: Sequence[Case], sample: int, long: int) -> Iterator[str]:
    """Everything; the page so far, after each of its parts."""
    facts, start = machine(), time.perf_counter()
    versions = {"stiefel_rs": stiefel_rs, "dask": dask, "distributed": distributed, "zarr": zarr, "numpy": np}
    facts["versions"] = ", ".join(f"{name} {module.__version__}" for name, module in versions.items())
    # Workers share the cores: batches of the manifold's methods shall not use threads of their own.
    os.environ["RAYON_NUM_THREADS"] = "1"
    parts = [PREAMBLE.format(workers=WORKERS, reach=REACH, sample=sample)]

    def page() -> str:
        facts["processes that wanted to run, at the end"] = load()
        facts["duration"] = f"{time.perf_counter() - start:.0f} s"
        return "\n".join([*parts, "## The run\n", tabulate(facts.items(), ["", "this run"], tablefmt="github"), ""])

    with (
        distributed.LocalCluster(n_workers=WORKERS, threads_per_worker=1, dashboard_address=":0") as cluster,
        distributed.Client(cluster) as client,
    ):
        for case in cases:
            parts.append(section(case, client, sample))
            yield page()
        if long:
            with tempfile.TemporaryDirectory() as folder:
                parts.append(f"## A long sweep\n\n{long_sweep(long, folder)}\n")
            yield page()


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.cluster", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "dask_measured.md", help="page to write")
    parser.add_argument("--quick", action="store_true", help="few problems, few sizes")
    parser.add_argument("--long", type=int, default=0, metavar="COUNT", help="one more sweep, of so many problems")
    options = parser.parse_args(arguments)
    for page in pages(QUICK if options.quick else FULL, 200 if options.quick else 1000, options.long):
        options.out.write_text(page)
    print(f"{page}\nwritten to {options.out}")


if __name__ == "__main__":
    main()
