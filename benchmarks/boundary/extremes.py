"""Data at the limits: very fast, between opposite points, at uneven, long or short times; how long answers take."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from tabulate import tabulate  # type: ignore[import-untyped]

from benchmarks.boundary.random_problems import Cubics
from benchmarks.problems import Array
from stiefel_rs import CubicSpline, Stiefel, StiefelError

COUNT = 20
HEADERS = ("data", "solved", "refused", "largest defect", "longest", "at most")

PREAMBLE = """## Data at the limits

Each line is {count} problems; `RiemannianCubic.from_boundary` between random points, and natural `CubicSpline`s
through eight random rotations up to 1.2 rad apart. A refusal is an exception; its reason is that of the report.
The defect is the distance of the end, and of the end velocity relative to it if that is above 1, or the largest
distance from a knot.
"""

Call = Callable[[], float]


@dataclass(frozen=True)
class Limit:
    """Problems of one kind, and the seconds within which each must be answered."""

    title: str
    seconds: float
    problem: Callable[[np.random.Generator], Call]

    def cells(self, count: int) -> tuple[tuple[str, ...], bool]:
        """Its line of the table, and whether every answer came in time."""
        rng = np.random.default_rng([20240419, *map(ord, self.title)])
        refused: Counter[str] = Counter()
        longest, defects = 0.0, [0.0]
        for _ in range(count):
            call = self.problem(rng)
            start = time.perf_counter()
            try:
                defects.append(call())
            except StiefelError as error:
                report = getattr(error, "report", None)
                refused[report.reason if report is not None else type(error).__name__] += 1
            longest = max(longest, time.perf_counter() - start)
        solved = count - sum(refused.values())
        reasons = ", ".join(f"{number} {reason}" for reason, number in refused.most_common())
        defect = f"{max(defects):.1e}" if solved else ""
        line = (self.title, str(solved), reasons, defect, f"{longest:.2f} s", f"{self.seconds} s")
        return line, longest <= self.seconds


def fast(n: int, k: int, speed: float) -> Callable[[np.random.Generator], Call]:
    """Boundary problems between random points with the given speed at both ends."""
    M = Stiefel(n, k)

    def problem(rng: np.random.Generator) -> Call:
        ends = [M.random_point(rng) for _ in range(2)]
        vectors = [M.project_tangent(S, rng.standard_normal(S.shape)) for S in ends]
        V0, V1 = (V * (speed / M.norm(S, V)) for S, V in zip(ends, vectors, strict=True))
        return lambda: _solve((ends[0], V0, ends[1], V1))

    return problem


def opposite(n: int, k: int, speed: float) -> Callable[[np.random.Generator], Call]:
    """Boundary problems between a point and the one with its first column, or its first two, reversed."""
    M = Stiefel(n, k)

    def problem(rng: np.random.Generator) -> Call:
        S0 = M.random_point(rng)
        S1 = S0 * np.where(np.arange(k) < (2 if k > 1 else 1), -1.0, 1.0)
        vectors = [M.project_tangent(S, rng.standard_normal(S.shape)) for S in (S0, S1)]
        V0, V1 = (V * (speed / M.norm(S, V)) for S, V in zip((S0, S1), vectors, strict=True))
        return lambda: _solve((S0, V0, S1, V1))

    return problem


def spline(times: Callable[[np.random.Generator], Array]) -> Callable[[np.random.Generator], Call]:
    """Splines through eight rotations at given times."""
    M = Stiefel(3, 3)

    def problem(rng: np.random.Generator) -> Call:
        t, points = times(rng), [M.random_point(rng)]
        for _ in t[1:]:
            V = M.project_tangent(points[-1], rng.standard_normal((3, 3)))
            points.append(M.exp(points[-1], V * (rng.uniform(0.1, 1.2) / M.norm(points[-1], V))))
        S = np.array(points)

        def call() -> float:
            return float(np.max(np.linalg.norm(CubicSpline(t, S)(t) - S, axis=(1, 2))))

        return call

    return problem


def _solve(ends: tuple[Array, Array, Array, Array]) -> float:
    curve = Cubics.from_boundary(*ends)
    gaps = [curve(1.0) - ends[2], (curve.velocity(1.0) - ends[3]) / max(1.0, float(np.linalg.norm(ends[3])))]
    return float(np.linalg.norm(gaps))


def _one_short(rng: np.random.Generator) -> Array:
    lengths = np.ones(7)
    lengths[rng.integers(7)] = 1e-6
    return np.concatenate([[0.0], np.cumsum(lengths)])


def _uneven(rng: np.random.Generator) -> Array:
    return np.concatenate([[0.0], np.cumsum(10.0 ** rng.uniform(-6, 0, 7))])


LIMITS = (
    *(Limit(f"speeds of 1000, St({n},{k})", 0.5, fast(n, k, 1e3)) for n, k in ((3, 1), (3, 2), (4, 2), (10, 3))),
    *(Limit(f"speeds of 10^6, St({n},{k})", 0.5, fast(n, k, 1e6)) for n, k in ((3, 1), (4, 2))),
    *(
        Limit(f"opposite points, speeds of 10^-8, St({n},{k})", 2.0, opposite(n, k, 1e-8))
        for n, k in ((3, 1), (4, 2), (6, 3), (10, 3), (16, 4))
    ),
    Limit("spline, one interval of 10^-6", 0.5, spline(_one_short)),
    Limit("spline, intervals between 10^-6 and 1", 0.5, spline(_uneven)),
    Limit("spline, intervals of 10^9", 0.5, spline(lambda rng: 1e9 * np.arange(8.0))),
    Limit("spline, intervals of 10^-9", 0.5, spline(lambda rng: 1e-9 * np.arange(8.0))),
)


def section(count: int = COUNT) -> tuple[str, list[str]]:
    """The section of the page, and a line for each kind that was not answered in time."""
    lines, missed = [], []
    for limit in LIMITS:
        line, in_time = limit.cells(count)
        lines.append(line)
        if not in_time:
            missed.append(f"missed: {limit.title}, at most {limit.seconds} s")
    table = tabulate(lines, headers=HEADERS, tablefmt="github", disable_numparse=True)
    return f"{PREAMBLE.format(count=count)}\n{table}\n", missed
