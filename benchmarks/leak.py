"""Memory of many solves: `python -m benchmarks.leak --solves 1000000`. It must not grow.

Prints the resident memory after every tenth of the solves, with one process per kind of work; the first two tenths are
warm-up. Fails if memory grows by more than 5 MB afterwards.
"""

from __future__ import annotations

import argparse
import gc
import pickle
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from stiefel_rs import (
    Chart,
    CubicSpline,
    Geodesic,
    GeometricCubic,
    RiemannianCubic,
    SmoothingSpline,
    Stiefel,
    StiefelError,
    orthogonal_log,
)

from .memory import resident

Array = NDArray[np.float64]

PARTS: Final = 10
WARM_UP: Final = 2
LIMIT: Final = 5e6
MB: Final = 1e6
# Different problems, so that memory kept for each of them is detected.
PROBLEMS: Final = 64
M: Final = Stiefel(4, 2)
SPHERE: Final = Chart.sphere()
STATE: Final = np.array([1.2, 0.3, 0.2, 0.1, 0.0, 0.1, 0.2, 0.0])


def problems() -> list[tuple[Array, Array, Array, Array]]:
    """Boundary data on St(4, 2): points at distance 0.7, velocities of norm 0.5."""
    rng = np.random.default_rng(20240419)

    def tangent(S: Array, length: float) -> Array:
        V = M.random_tangent(S, rng)
        return np.asarray(V * (length / M.norm(S, V)))

    made = []
    for _ in range(PROBLEMS):
        S0 = M.random_point(rng)
        S1 = M.retract(S0, tangent(S0, 0.7))
        made.append((S0, tangent(S0, 0.5), S1, tangent(S1, 0.5)))
    return made


DATA: Final = problems()
T: Final = np.array([0.0, 1.0, 2.0])


def exact_cubic(i: int) -> None:
    """Boundary problem of a Riemannian cubic, by Newton's method."""
    RiemannianCubic.from_boundary(*DATA[i])(0.5)


def geometric_cubic(i: int) -> None:
    """A geometric cubic and a point of it."""
    GeometricCubic(*DATA[i])(0.5)


def logarithm(i: int) -> None:
    """Riemannian logarithm of one point."""
    S0, _, S1, _ = DATA[i]
    M.log(S0, S1)


def spline(i: int) -> None:
    """Interpolating and smoothing spline through three points."""
    S0, V0, S1, _ = DATA[i]
    S = np.stack([S0, S1, M.exp(S0, V0)])
    CubicSpline(T, S, kind="geometric")(0.5)
    SmoothingSpline(T, S, lam=1.0)(0.5)


def shooting(i: int) -> None:
    """Shooting on the discrete flow in the chart of the sphere."""
    q = STATE[:2] + 1e-3 * i
    _ = SPHERE.shoot(q, STATE[2:4], q + 0.2, STATE[2:4], 10).trajectory


def copies(i: int) -> None:
    """A geodesic, its pickled copy, and an array of its points."""
    S0, _, S1, _ = DATA[i]
    curve = pickle.loads(pickle.dumps(Geodesic(S0, S1)))
    curve(np.linspace(0, 1, 10), 1)


def refused(call: Callable[..., object], *arguments: object, **keywords: object) -> None:
    """Make a call that must fail; RuntimeError if it does not."""
    try:
        call(*arguments, **keywords)
    except (StiefelError, TypeError):
        return
    raise RuntimeError("the call was to fail")


def errors(i: int) -> None:
    """Four errors, each created with its text and numbers."""
    S0, V0, S1, V1 = DATA[i]
    refused(RiemannianCubic.from_boundary, S0, V0, S1, V1, max_iterations=0)
    refused(GeometricCubic, S0, S0, S1, V1)
    refused(orthogonal_log, -np.eye(2))
    refused(M.log, S0, "text")


# The work, and the fraction of the solves it gets: slow ones take long enough with fewer.
WORK: Final[dict[str, tuple[Callable[[int], None], float]]] = {
    "exact_cubic": (exact_cubic, 0.2),
    "geometric_cubic": (geometric_cubic, 1.0),
    "logarithm": (logarithm, 1.0),
    "spline": (spline, 0.05),
    "shooting": (shooting, 0.2),
    "copies": (copies, 1.0),
    "errors": (errors, 1.0),
}


def watch(work: Callable[[int], None], solves: int, tell: Callable[[int], None] = lambda value: None) -> list[int]:
    """Resident memory in bytes after each tenth of the solves; `tell` is called with each value."""
    found = []
    for part in range(PARTS):
        for i in range(part * solves // PARTS, (part + 1) * solves // PARTS):
            work(i % PROBLEMS)
        gc.collect()
        found.append(resident("VmRSS"))
        tell(found[-1])
    return found


def growth(found: list[int]) -> int:
    """Growth of memory after the warm-up: the last value, or the largest, minus the first one."""
    return max(found[WARM_UP:]) - found[WARM_UP - 1]


def single(name: str, solves: int) -> int:
    """Do one kind of work in this process and print its line; return the exit code."""
    work, part = WORK[name]
    count = max(PARTS, round(part * solves))
    start = time.perf_counter()
    print(f"| {name} | {count}", end="", flush=True)
    found = watch(work, count, lambda value: print(f" | {value / MB:.1f}", end="", flush=True))
    grown = growth(found)
    print(f" | {grown / MB:+.1f} | {time.perf_counter() - start:.0f} |", flush=True)
    return 1 if grown > LIMIT else 0


def main(arguments: list[str] | None = None) -> int:
    """Print the table; return 1 if memory grew."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.leak", description="Memory during many solves.")
    parser.add_argument("--solves", type=int, default=1_000_000, help="of each kind, fewer of the slow ones")
    parser.add_argument("--only", choices=sorted(WORK), action="append", help="this kind of work alone")
    parser.add_argument("--here", choices=sorted(WORK), help="in this process, without the head of the table")
    options = parser.parse_args(arguments)
    if options.here:
        return single(options.here, options.solves)
    head = " | ".join(f"{100 * (part + 1) // PARTS} %" for part in range(PARTS))
    print(f"Resident memory in MB; growth is that after the first {100 * WARM_UP // PARTS} %.\n")
    print(f"| work | solves | {head} | growth | seconds |")
    print("|" + " --- |" * (PARTS + 4), flush=True)
    failed = []
    for name in options.only or WORK:
        words = [sys.executable, "-m", "benchmarks.leak", "--here", name, "--solves", str(options.solves)]
        if subprocess.run(words, check=False).returncode:
            failed.append(name)
    if failed:
        print(f"\nmemory grew by more than {LIMIT / MB:.0f} MB: {', '.join(failed)}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
