"""Sweeps on a local cluster of processes: block size against overhead and throughput.

``python -m benchmarks.cluster`` writes ``docs/dask_measured.md``; ``--quick`` is a look, ``--long 1000000`` runs one
sweep of that many problems instead, and writes what came of it to the end of the page.
"""

from __future__ import annotations

import argparse
import os
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
ROUNDS = 2
LONG = "## A long sweep"
FACTS = ("", "this run")
HEADERS = (
    "problems per task",
    "tasks",
    "time",
    "problems per second",
    "processor time per problem",
    "over one process",
)
STORED = ("files", "size")

PREAMBLE = """# Sweeps on a cluster, measured

Written by `python -m benchmarks.cluster`. A `LocalCluster` of {workers} processes with one thread each, the scheduler
and the client, on the machine told at the end. Problems are random: distances and speeds uniform up to {reach:g}, in
the canonical metric. Their data are in the memory of the workers before the clock starts. All fields but, for geometric
cubics, `cost`; no `points`. Times are the shorter of {rounds} runs, from the call to the last result.

Processor time is that of the workers, for everything they do. One process is a loop over the first {sample} problems
without Dask, the least of {samples} samples: "over one process" is what a worker spends on top of it, serialisation and
bookkeeping, and what the processor does slower when other programs run beside it. Files and size are those of the Zarr
group.
"""


@dataclass(frozen=True)
class Case:
    """One kind of problem on one manifold, and the sizes of blocks to try."""

    kind: Any
    n: int
    k: int
    count: int
    chunks: tuple[int, ...]


@dataclass(frozen=True)
class Sample:
    """Wall and processor seconds of a sweep into memory and into Zarr; files and bytes of the latter."""

    memory: float
    memory_processor: float
    stored: float
    stored_processor: float
    files: int
    size: int


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


def line(case: Case, chunk: int, wall: float, spent: float, single: float) -> list[Any]:
    """Cells of one size of blocks: seconds by the clock and of the processors."""
    each = spent / case.count
    return [
        chunk, -(-case.count // chunk), f"{wall:.1f} s", f"{case.count / wall:.0f}", f"{each * 1e6:.0f} us",
        f"{each / single - 1:+.0%}",
    ]  # fmt: skip


def into_memory(case: Case, samples: dict[int, list[Sample]], single: float) -> str:
    """Table with a line for each size of blocks: the least of each figure."""
    rows = []
    for chunk, taken in samples.items():
        wall, spent = min(sample.memory for sample in taken), min(sample.memory_processor for sample in taken)
        rows.append(line(case, chunk, wall, spent, single))
    return str(tabulate(rows, HEADERS, tablefmt="github", disable_numparse=True))


def into_zarr(case: Case, samples: dict[int, list[Sample]], single: float) -> str:
    """The same, with files and their size."""
    rows = []
    for chunk, taken in samples.items():
        wall, spent = min(sample.stored for sample in taken), min(sample.stored_processor for sample in taken)
        size = [taken[0].files, f"{taken[0].size / 1e6:.1f} MB"]
        rows.append(line(case, chunk, wall, spent, single) + size)
    return str(tabulate(rows, HEADERS + STORED, tablefmt="github", disable_numparse=True))


def section(case: Case, client: Any, sample: int) -> str:
    """Both tables of one case."""
    made = dask.persist(*ends(case.n, case.k, case.count))
    distributed.wait(made)
    single = alone(case, made, min(sample, case.count))
    # What is loaded with the first task is not timed.
    solve_boundary(*[array[:WORKERS] for array in made], kind=case.kind, chunk=1).records.compute()
    samples: dict[int, list[Sample]] = {chunk: [] for chunk in case.chunks}
    turns = [chunk for _ in range(ROUNDS) for chunk in case.chunks]
    for chunk in tqdm(turns, desc=f"{case.kind} St({case.n},{case.k})"):
        samples[chunk].append(measure(case, client, made, chunk))
        single = min(single, alone(case, made, min(sample, case.count)))
    return (
        f"## {case.count} {case.kind.capitalize()} cubics on St({case.n},{case.k})\n\n"
        f"One process: {single * 1e6:.0f} us per problem.\n\nInto memory:\n\n{into_memory(case, samples, single)}\n\n"
        f"Into Zarr:\n\n{into_zarr(case, samples, single)}\n"
    )


def long_sweep(count: int) -> str:
    """One sweep of exact cubics, its data generated by the workers, into Zarr; a section about it."""
    chunk, facts = 2500, machine()
    sweep: Sweep = solve_boundary(*ends(3, 2, count), chunk=chunk, on_error="mark")
    stored: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        wall = timed(lambda: stored.update(sweep.to_zarr(f"{folder}/store", retries=2)))
        solved, steps = dask.compute((stored["code"] == 0).sum(), stored["iterations"].mean())
        size = size_of([file for file in Path(folder).rglob("*") if file.is_file()])
    facts["processes that wanted to run, at the end"] = load()
    return (
        f"{LONG}\n\n{count} Riemannian cubics on St(3,2), {chunk} per task, data generated by the workers, into Zarr: "
        f"{wall / 60:.1f} minutes, {count / wall:.0f} problems per second; {int(solved)} solved, {float(steps):.2f} "
        f"Newton steps on average, {size / 1e6:.0f} MB.\n\n{tabulate(facts.items(), FACTS, tablefmt='github')}\n"
    )


def _preamble(cases: Sequence[Case], sample: int) -> str:
    samples = 1 + ROUNDS * min(len(case.chunks) for case in cases)
    return PREAMBLE.format(workers=WORKERS, reach=REACH, rounds=ROUNDS, sample=sample, samples=samples)


def tables(cases: Sequence[Case], client: Any, sample: int) -> str:
    """All tables, and the machine."""
    facts, start = machine(), time.perf_counter()
    versions = {"stiefel_rs": stiefel_rs, "dask": dask, "distributed": distributed, "zarr": zarr, "numpy": np}
    facts["versions"] = ", ".join(f"{name} {module.__version__}" for name, module in versions.items())
    parts = [_preamble(cases, sample)]
    parts += [section(case, client, sample) for case in cases]
    facts["processes that wanted to run, at the end"] = load()
    facts["duration"] = f"{time.perf_counter() - start:.0f} s"
    return "\n".join([*parts, "## The run\n", tabulate(facts.items(), FACTS, tablefmt="github"), ""])


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.cluster", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "dask_measured.md", help="page to write")
    parser.add_argument("--quick", action="store_true", help="few problems, few sizes")
    parser.add_argument("--long", type=int, metavar="COUNT", help="only one sweep, of so many problems")
    options = parser.parse_args(arguments)
    # Workers share the cores: batches of the manifold's methods shall not use threads of their own.
    os.environ["RAYON_NUM_THREADS"] = "1"
    written = options.out.read_text() if options.out.exists() else ""
    first, found, last = written.partition(f"\n{LONG}")
    with (
        distributed.LocalCluster(n_workers=WORKERS, threads_per_worker=1, dashboard_address=":0") as cluster,
        distributed.Client(cluster) as client,
    ):
        if options.long:
            page = f"{first}\n{long_sweep(options.long)}"
        else:
            page = tables(QUICK if options.quick else FULL, client, 200 if options.quick else 1000) + found + last
    options.out.write_text(page)
    print(f"{page}\nwritten to {options.out}")


if __name__ == "__main__":
    main()
