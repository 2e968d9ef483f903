"""The protocol of a timed process: it creates tasks by name and answers requests, one JSON object per line.

Requests are `{"do": "info" | "prepare" | "sample" | "measure" | "drop", "name": ...}`. `prepare` runs a task once and
saves its result for comparison; `sample` times a few runs; `measure` returns one number. Without requests
(`python -m benchmarks.compare.peers.scipy --only skew_exp`) the process times all of its tasks without a harness.
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import hashlib
import importlib.metadata
import json
import os
import platform
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

# Minimal duration of a sample: reading the clock takes 1e-7 s.
SAMPLE_SECONDS = 4e-3
MAX_CALLS = 20_000


@dataclass(frozen=True)
class Task:
    """Work that can be repeated.

    Attributes
    ----------
    run : callable
        One call; its return value is compared with the other libraries' results, unless `result` is given.
    units : int
        Number of points or problems per call, by which times are divided.
    result : callable or None
        Returns the array to compare instead of the return value of `run`.
    setup : float
        Seconds of preceding compilation, listed separately from the figure.
    note : callable or None
        Returns a remark on the result.
    """

    run: Callable[[], Any]
    units: int = 1
    result: Callable[[], Any] | None = None
    setup: float = 0.0
    note: Callable[[], str] | None = None


Tasks = dict[str, Callable[[], Task]]
Measures = dict[str, Callable[[], float]]


class Server:
    """Tasks and measurements of one library."""

    def __init__(self, tasks: Tasks, measures: Measures, packages: tuple[str, ...]) -> None:
        self._makers, self._measures, self._packages = tasks, measures, packages
        self._ready: dict[str, tuple[Task, int]] = {}

    def info(self, _: dict[str, Any]) -> dict[str, Any]:
        """Names, versions, BLAS."""
        return {
            "tasks": list(self._makers),
            "measures": list(self._measures),
            "python": platform.python_version(),
            "versions": {name: importlib.metadata.version(name) for name in self._packages},
            "blas": blas_kernels(),
        }

    def prepare(self, request: dict[str, Any]) -> dict[str, Any]:
        """Create a task, run it once, save its result."""
        name = request["name"]
        task = self._makers[name]()
        value = task.run()
        result = np.ascontiguousarray(value if task.result is None else task.result(), dtype=np.float64)
        del value
        start = time.perf_counter()
        task.run()
        once = time.perf_counter() - start
        self._ready[name] = (task, max(1, min(MAX_CALLS, round(SAMPLE_SECONDS / max(once, 1e-9)))))
        if "save" in request:
            np.save(request["save"], result)
        digest = hashlib.sha256(result.tobytes()).hexdigest()
        note = "" if task.note is None else task.note()
        return {"seconds": once, "shape": result.shape, "sha256": digest, "setup": task.setup, "note": note}

    def sample(self, request: dict[str, Any]) -> dict[str, Any]:
        """Wall seconds and seconds of this process's clock, per unit of work."""
        task, calls = self._ready[request["name"]]
        run = task.run
        gc.collect()
        gc.disable()
        cpu, wall = time.process_time(), time.perf_counter()
        for _ in range(calls):
            run()
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        gc.enable()
        units = calls * task.units
        return {"wall": wall / units, "cpu": cpu / units, "elapsed": wall}

    def measure(self, request: dict[str, Any]) -> dict[str, Any]:
        """One number that is not a time."""
        return {"value": float(self._measures[request["name"]]())}

    def drop(self, request: dict[str, Any]) -> dict[str, Any]:
        """Forget a task and its data."""
        self._ready.pop(request["name"], None)
        return {}

    def answer(self, request: dict[str, Any]) -> dict[str, Any]:
        """Outcome of one request; a failure is an answer too."""
        try:
            return {"ok": True, **getattr(self, request["do"])(request)}
        except NotImplementedError as error:
            return {"ok": False, "error": str(error)}
        except Exception as error:
            return {"ok": False, "error": f"{type(error).__name__}: {error}"}


def blas_kernels() -> list[str]:
    """BLAS libraries in use: name, version, kernel, threads. Empty without threadpoolctl."""
    try:
        import threadpoolctl  # noqa: PLC0415
    except ImportError:
        return []
    pools = [pool for pool in threadpoolctl.threadpool_info() if pool["user_api"] == "blas"]
    names = (
        f"{pool['internal_api']} {pool['version']}, kernel {pool.get('architecture', '?')}, "
        f"{pool['num_threads']} thread(s)"
        for pool in pools
    )
    return sorted(set(names))


@contextlib.contextmanager
def _own_output() -> Iterator[Any]:
    """Reserve the standard output for answers: other output of libraries goes to the standard error."""
    with os.fdopen(os.dup(1), "w", buffering=1) as channel:
        os.dup2(2, 1)
        yield channel


def _alone(server: Server, only: str, seconds: float) -> dict[str, Any]:
    """Times of all tasks whose name contains `only`, without a harness."""
    report: dict[str, Any] = {}
    for name in server.info({})["tasks"]:
        if only not in name:
            continue
        report[name] = server.answer({"do": "prepare", "name": name})
        if not report[name]["ok"]:
            continue
        samples: list[float] = []
        spent = 0.0
        while spent < seconds or not samples:
            sample = server.sample({"name": name})
            samples.append(sample["wall"])
            spent += sample["elapsed"]
        report[name] |= {"best": min(samples), "median": float(np.median(samples)), "samples": len(samples)}
        server.drop({"name": name})
    return report


def serve(tasks: Tasks, measures: Measures | None = None, packages: tuple[str, ...] = ()) -> None:
    """Answer requests (`--serve`), or time the tasks and print the times as JSON."""
    parser = argparse.ArgumentParser(description=f"Tasks of {Path(sys.argv[0]).stem}, timed.")
    parser.add_argument("--serve", action="store_true", help="answer requests from the standard input")
    parser.add_argument("--only", default="", help="tasks whose name contains this")
    parser.add_argument("--seconds", type=float, default=0.3, help="time for each task")
    arguments = parser.parse_args()
    server = Server(tasks, measures or {}, packages)
    with _own_output() as channel:
        if not arguments.serve:
            json.dump(_alone(server, arguments.only, arguments.seconds), channel, indent=1)
            channel.write("\n")
            return
        for line in sys.stdin:
            channel.write(json.dumps(server.answer(json.loads(line))) + "\n")
