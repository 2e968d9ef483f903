"""Error at the end against the time of one solve, and the time of one step against the size."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from statistics import median
from typing import Any, Literal

import numpy as np

from benchmarks.problems import Array
from benchmarks.study import equations
from benchmarks.study.cases import Case, Data, random_data
from benchmarks.study.equations import FirstOrder
from stiefel_rs import Chart, RiemannianCubic, integrate_cubic, integrate_embedded

# Minimal duration of a sample: the clock has a resolution of 1e-7 s.
SAMPLE_SECONDS = 1e-3
Map = Literal["initial_point", "midpoint", "exponential_midpoint", "cayley_midpoint"]
Order = Literal[1, 2, 4, 6, 8]

SPLITTING_STEPS = {
    2: (10, 30, 100, 300, 1000, 3000),
    4: (5, 10, 20, 50, 100, 200),
    6: (3, 5, 10, 20, 40),
    8: (2, 4, 8, 16),
}
EMBEDDED = "embedded, midpoint"
EMBEDDED_STEPS = (10, 30, 100, 300, 1000)
TAYLOR_TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13, 1e-15, 1e-17)
CHART_METHODS: dict[str, tuple[Map, Order, tuple[int, ...]]] = {
    "chart, initial point": ("initial_point", 1, (10, 100, 1000)),
    "chart, midpoint": ("midpoint", 2, (10, 30, 100, 300, 1000)),
    "chart, exponential midpoint": ("exponential_midpoint", 2, (10, 30, 100, 300)),
    "chart, midpoint, order 4": ("midpoint", 4, (5, 10, 30, 100)),
    "chart, midpoint, order 6": ("midpoint", 6, (5, 10, 20, 40)),
    "chart, midpoint, order 8": ("midpoint", 8, (3, 5, 10, 20)),
}
PEER_TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13)
HEYOKA_TOLERANCES = (1e-4, 1e-8, 1e-12, 1e-16)
# Methods are compared by the time to get below this error.
ACCURATE = 1e-10
COST_SIZES = (
    (3, 1), (3, 2), (4, 2), (5, 2), (6, 3), (10, 3), (20, 5), (50, 5), (1000, 5), (300, 10), (1000, 20),
)  # fmt: skip

# Two lengths, whose difference excludes the cost of starting.
TAYLOR_SPAN = (0.5, 8.0)


@dataclass
class Solve:
    """One way of computing the end of a curve."""

    case: str
    method: str
    parameter: str
    run: Callable[[], Array]
    error: float
    compile_seconds: float = 0.0
    times: list[float] = field(default_factory=list)

    @property
    def best(self) -> float:
        """Shortest time."""
        return min(self.times)

    @property
    def median(self) -> float:
        """Median time."""
        return median(self.times)


def sample(run: Callable[[], object], seconds: float = SAMPLE_SECONDS) -> float:
    """Processor time of one call, averaged over as many calls as the clock needs."""
    calls, elapsed = 0, 0.0
    start = time.process_time()
    while elapsed < seconds:
        run()
        calls += 1
        elapsed = time.process_time() - start
    return elapsed / calls


def interleave(solves: list[Solve], rounds: int) -> None:
    """Sample all participants in turn, so that slowdowns affect all equally."""
    for _ in range(rounds):
        for solve in solves:
            solve.times.append(sample(solve.run))


def taylor(data: Data, t_end: float, tol: float = TAYLOR_TOLERANCES[-1]) -> Any:
    """The cubic by the Taylor method."""
    # Its stub forbids calling the class, which mypy takes for its only signature.
    made: Any = RiemannianCubic
    return made.from_initial(*data, t_end, tol=tol)


def _taylor_end(data: Data, tol: float) -> Array:
    return np.asarray(taylor(data, 1.0, tol)(1.0))


def _splitting_end(data: Data, steps: int, order: int) -> Array:
    return np.asarray(integrate_cubic(*data, steps, order=order).point[-1])


def _embedded_end(data: Data, steps: int) -> Array:
    return np.asarray(integrate_embedded(*data, steps).point[-1])


def _chart_end(chart: Chart, state: Array, steps: int, map_: Map, order: Order) -> Array:
    return chart.embed(chart.integrate(state, steps, map=map_, order=order)[-1][: chart.d])


def _ours(case: Case) -> list[tuple[str, str, Callable[[], Array]]]:
    found: list[tuple[str, str, Callable[[], Array]]] = [
        ("Taylor", f"tol {tol:.0e}", partial(_taylor_end, case.data, tol)) for tol in TAYLOR_TOLERANCES
    ]
    for order, counts in SPLITTING_STEPS.items():
        found += [
            (f"splitting, order {order}", f"{n} steps", partial(_splitting_end, case.data, n, order)) for n in counts
        ]
    found += [(EMBEDDED, f"{n} steps", partial(_embedded_end, case.data, n)) for n in EMBEDDED_STEPS]
    if case.chart is not None and case.state is not None:
        for name, (map_, chart_order, counts) in CHART_METHODS.items():
            found += [
                (name, f"{n} steps", partial(_chart_end, case.chart, case.state, n, map_, chart_order)) for n in counts
            ]
    return found


def solves(case: Case, *, peers: bool) -> list[Solve]:
    """All methods on one curve, with errors computed and times still missing."""
    found = [Solve(case.name, *way, case.error(way[2]())) for way in _ours(case)]
    if not peers:
        return found
    system = FirstOrder(*case.shape)
    y0 = system.initial(case.data)
    for tol in PEER_TOLERANCES:
        run = equations.dop853(system, y0, tol)
        found.append(Solve(case.name, "SciPy DOP853", f"rtol {tol:.0e}", run, case.error(run())))
    for tol in HEYOKA_TOLERANCES:
        start = time.process_time()
        try:
            run = equations.heyoka(system, y0, tol)
        except ImportError:
            break
        compiled = time.process_time() - start
        found.append(Solve(case.name, "heyoka", f"tol {tol:.0e}", run, case.error(run()), compiled))
    return found


def fastest_below(found: list[Solve], bound: float) -> dict[str, Solve]:
    """For each method, its fastest solve with an error below the bound."""
    best: dict[str, Solve] = {}
    for solve in found:
        if solve.error <= bound and (solve.method not in best or solve.best < best[solve.method].best):
            best[solve.method] = solve
    return best


@dataclass(frozen=True)
class Cost:
    """Times of one step at one size, in seconds, by method."""

    n: int
    k: int
    step: dict[str, float]

    @property
    def rows(self) -> int:
        """Number of rows of the data in the basis of its span."""
        return min(self.n, 4 * self.k)


def _step_times(n: int, k: int, rounds: int) -> Cost:
    data = random_data(n, k)
    # A step of small matrices takes less time than the call, so many are needed.
    few, many = (20, 1020) if n * k <= 100 else (4, 24)
    runs: dict[str, Callable[[], object]] = {}
    for order in SPLITTING_STEPS:
        for steps in (few, many):
            runs[f"{order}:{steps}"] = partial(integrate_cubic, *data, steps, order=order)
    for steps in (few, many):
        runs[f"{EMBEDDED}:{steps}"] = partial(integrate_embedded, *data, steps)
    runs["Taylor:1"] = partial(taylor, data, TAYLOR_SPAN[0])
    runs["Taylor:2"] = partial(taylor, data, TAYLOR_SPAN[1])
    best = dict.fromkeys(runs, float("inf"))
    for _ in range(rounds):
        for name, run in runs.items():
            best[name] = min(best[name], sample(run))
    step = {
        f"splitting, order {order}": (best[f"{order}:{many}"] - best[f"{order}:{few}"]) / (many - few)
        for order in SPLITTING_STEPS
    }
    step[EMBEDDED] = (best[f"{EMBEDDED}:{many}"] - best[f"{EMBEDDED}:{few}"]) / (many - few)
    short, long = (taylor(data, t).steps for t in TAYLOR_SPAN)
    step["Taylor"] = (best["Taylor:2"] - best["Taylor:1"]) / (long - short)
    return Cost(n, k, step)


def costs(sizes: tuple[tuple[int, int], ...], rounds: int) -> list[Cost]:
    """Times of one step at all sizes, by the number of rows in the span of the data, which determines the work."""
    return sorted((_step_times(n, k, rounds) for n, k in sizes), key=lambda cost: (cost.rows, cost.n))
