"""The two challenges that the paper leaves to retraction maps: a single chart, and implicit equations.

Answered by the same maps with changes of chart (`Chart.integrate_across`) and by explicit splittings that need no chart
(`integrate_cubic`): errors where the curve meets the pole of the chart, and times at equal error.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

import numpy as np

from .._core import integrate_cubic, integrate_embedded
from ..errors import ConvergenceError, OutsideDomainError
from . import experiments
from .experiments import EXPERIMENTS, Array, Experiment
from .text import milliseconds, table

METHODS: Final = {
    "one_chart": "chart method",
    "across": "chart method with changes of chart",
    "splitting": "explicit splitting",
}
# The method in the embedding has order 2 only.
EMBEDDED: Final = "embedded"
LABELS: Final = METHODS | {EMBEDDED: "embedded method"}
# Angle between the pole of the chart and the point of the curve at t = 1/2; None for the paper's curve as it stands.
ANGLES: Final = (None, 0.05, 0.02, 0.0)
STEPS: Final = 100
# Mean errors to be reached by order.
TARGETS: Final = {2: 1e-5, 4: 1e-8}
LEAST_STEPS: Final = 2
HEADER: Final = ["manifold", "curve", "method", "order", "N", "mean_error", "seconds"]

Initial = tuple[Array, Array, Array, Array]


def turn(a: Array, b: Array) -> Array:
    """Rotation of space, shape ``(3, 3)``, that takes the unit vector `a` to `b` in their plane; not opposite ones."""
    x, y, z = np.cross(a, b)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + K + K @ K / (1.0 + a @ b))


def rotation(experiment: Experiment, angle: float | None) -> Array:
    """Rotation that brings the paper's curve to `angle` from the pole of the chart at ``t = 1/2``."""
    if angle is None:
        return np.eye(3)
    middle = experiments.points(experiment, experiments.reference(experiment, 2))[1][:, 0]
    return turn(middle, np.array([math.sin(angle), 0.0, math.cos(angle)]))


def solve(experiment: Experiment, method: str, initial: Initial, steps: int, order: int) -> Array:
    """Points of one discrete trajectory, shape ``(steps + 1, 3, k)``.

    Raises
    ------
    ConvergenceError, OutsideDomainError
        The method fails at the pole of its chart.
    """
    chart = experiment.chart
    if method == "splitting":
        return integrate_cubic(*initial, steps, order=order).point
    if method == EMBEDDED:
        return integrate_embedded(*initial, steps).point
    composed: dict[str, Any] = {"map": "midpoint", "order": None if order == 2 else order}
    if method == "across":
        return chart.integrate_across(*initial, steps, **composed).point
    return experiments.points(experiment, chart.integrate(chart.state(*initial), steps, **composed))


@dataclass(frozen=True)
class Row:
    """One method on one curve: the mean error and the shortest time; both None where the method fails."""

    experiment: Experiment
    angle: float | None
    method: str
    order: int
    steps: int
    error: float | None
    seconds: float | None


def initial_data(experiment: Experiment, angle: float | None) -> Initial:
    """Point, velocity, covariant acceleration and jerk at the start of the paper's curve, turned to `angle`."""
    R = rotation(experiment, angle)
    S, V, A, J = (R @ x for x in experiment.chart.covariant(experiments.initial_state(experiment)))
    return S, V, A, J


def _error(experiment: Experiment, method: str, angle: float | None, steps: int, order: int) -> float:
    exact = rotation(experiment, angle) @ experiments.points(experiment, experiments.reference(experiment, steps))
    found = solve(experiment, method, initial_data(experiment, angle), steps, order)
    return float(experiments.distances(found, exact).mean())


def methods(order: int) -> tuple[str, ...]:
    """Return the methods that have the given order."""
    return tuple(LABELS) if order == 2 else tuple(METHODS)


def steps_for(error: Callable[[int], float], order: int, target: float) -> int:
    """Smallest number of steps with at most the error `target`, for a method of known order.

    The order predicts it from the last error; the number then moves by single steps to the first that is enough.
    """
    n = STEPS
    for _ in range(3):
        n = max(LEAST_STEPS, math.ceil(n * (error(n) / target) ** (1 / order)))
    while n > LEAST_STEPS and error(n - 1) <= target:
        n -= 1
    while error(n) > target:
        n += 1
    return n


def times(calls: Sequence[Callable[[], object]], repetitions: int) -> list[float]:
    """Shortest time of each call; interleaved, so that a machine that slows down slows all alike."""
    shortest = [math.inf] * len(calls)
    for round_number in range(repetitions + 1):
        for i, call in enumerate(calls):
            begin = time.perf_counter()
            call()
            if round_number:
                shortest[i] = min(shortest[i], time.perf_counter() - begin)
    return shortest


def measure_poles() -> list[Row]:
    """Errors of order 2 at `STEPS` on the paper's curves, unchanged and turned towards the pole of the chart."""
    rows = []
    for e in EXPERIMENTS:
        for angle in ANGLES:
            for method in METHODS:
                try:
                    error = _error(e, method, angle, STEPS, 2)
                except (ConvergenceError, OutsideDomainError):
                    error = None
                rows.append(Row(e, angle, method, 2, STEPS, error, None))
    return rows


def measure_equal_errors(repetitions: int) -> list[Row]:
    """Measure the steps and times that each method needs for the errors of `TARGETS` on the paper's curves."""
    rows = []
    for e in EXPERIMENTS:
        initial = initial_data(e, None)
        for order, target in TARGETS.items():
            errors = {m: partial(_error, e, m, None, order=order) for m in methods(order)}
            sizes = {m: steps_for(error, order, target) for m, error in errors.items()}
            calls = [partial(solve, e, m, initial, n, order) for m, n in sizes.items()]
            for (m, n), seconds in zip(sizes.items(), times(calls, repetitions), strict=True):
                rows.append(Row(e, None, m, order, n, errors[m](n), seconds))
    return rows


@dataclass(frozen=True)
class Challenges:
    """Rows of both challenges: `measure_poles` and `measure_equal_errors`."""

    poles: list[Row]
    equal: list[Row]


def measure(repetitions: int) -> Challenges:
    """Measure both challenges."""
    return Challenges(measure_poles(), measure_equal_errors(repetitions))


def of(rows: list[Row], experiment: Experiment, method: str, **values: object) -> Row:
    """Return the row of one method with the given values of other fields."""
    own = (r for r in rows if r.experiment is experiment and r.method == method)
    return next(r for r in own if all(getattr(r, name) == value for name, value in values.items()))


def speed_up(rows: list[Row], method: str) -> list[float]:
    """Return times of a method over the splitting's at equal error, for every manifold and order that it has."""
    seconds = {(r.experiment.name, r.order, r.method): r.seconds or math.nan for r in rows}
    return [
        seconds[e.name, order, method] / seconds[e.name, order, "splitting"]
        for e in EXPERIMENTS
        for order in TARGETS
        if method in methods(order)
    ]


def curve_name(angle: float | None) -> str:
    """How a curve is written in the tables."""
    return "as in the paper" if angle is None else f"turned, {angle:g} from the pole"


def chart_section(rows: list[Row]) -> str:
    """Text of the section of ``summary.md`` on the first challenge."""
    cells = []
    for e in EXPERIMENTS:
        for angle in ANGLES:
            errors = [of(rows, e, m, angle=angle).error for m in METHODS]
            shown = ["fails" if error is None else f"{error:.2e}" for error in errors]
            cells.append([e.title, curve_name(angle), *shown])
    return f"""### The chart challenge

The paper: the methods "are only suitable to integrate Riemannian cubic polynomials on a single chart". The paper's
curves with initial values, N = {STEPS}, order 2: unchanged, and turned by a rotation of space so that at t = 1/2
they are at a given angle from the pole of the chart. A rotation is an isometry, so the turned curves are cubics too.
Mean errors:

{table(["manifold", "curve", *METHODS.values()], cells, 2)}

The chart method is the paper's mid-point method. With changes of chart (`Chart.integrate_across`) a rotation of space
keeps each step away from the poles, carried over to the momenta by its cotangent lift. The explicit splitting
(`integrate_cubic`) uses no chart. The times of all three at equal error are in the next section.
"""


def implicit_section(rows: list[Row]) -> str:
    """Text of the section of ``summary.md`` on the second challenge, with the times at equal error."""
    cells = []
    for e in EXPERIMENTS:
        for order, target in TARGETS.items():
            least = of(rows, e, "splitting", order=order).seconds or math.nan
            for m in methods(order):
                r = of(rows, e, m, order=order)
                seconds = r.seconds or math.nan
                numbers = [str(r.steps), f"{r.error:.1e}", milliseconds(seconds), f"{seconds / least:.3g}"]
                cells.append([e.title, str(order), f"{target:g}", LABELS[m], *numbers])
    header = ["manifold", "order", "error asked for", "method", "N", "mean error", "time", "splitting = 1"]
    return f"""### The challenge of implicit equations

The paper: the approach "involves solving several implicit algebraic equations, which makes it very slow and subject to
numerical errors". The paper's curves with initial values; each method with the smallest N that reaches the mean error
asked for, and its time. Order 2 is the mid-point method, order 4 its composition; the splittings have the same orders
and do not solve equations; the embedded method, of the next section, has order 2:

{table(header, cells, 4)}

Times are the shortest of rounds that alternate between the methods, one thread.
"""


def csv_table(rows: Challenges) -> tuple[list[str], list[tuple[object, ...]]]:
    """Return header and rows of ``challenges.csv``; empty cells where a method fails or no time was taken."""
    found = [
        (r.experiment.name, curve_name(r.angle), r.method, r.order, r.steps, r.error, r.seconds)
        for r in (*rows.poles, *rows.equal)
    ]
    return HEADER, [tuple("" if cell is None else cell for cell in row) for row in found]
