"""Errors near the initial point: the integrators' and GCP's, for initial and for boundary values.

The paper calls the integrators "ideal to simulate dynamics near the initial point of the trajectories, at any desired
error order", and GCP not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from . import experiments
from .experiments import EXPERIMENTS, METHODS, SPLITTING_ORDERS, Experiment
from .text import LABELS, percent, table

TIME: Final = 0.1
STEPS: Final = (10, 20, 40, 80, 160)
# The mid-point method composed: one implicit mid-point step for each of its substeps.
COMPOSED: Final = {"composed_4": 4, "composed_6": 6}
NAMES: Final = LABELS | {name: f"mid-point composed to order {order}, IVP" for name, order in COMPOSED.items()}
ALL: Final = (*METHODS, *COMPOSED, *(m for m in SPLITTING_ORDERS if m != "splitting_8"))
# Below, round-off of a distance shows in the slope.
FLOOR: Final = 1e-14


@dataclass(frozen=True)
class Row:
    """Errors of one method at ``t = TIME``, and its largest errors over the whole curve, by ``N`` of `STEPS`."""

    experiment: Experiment
    method: str
    near: tuple[float, ...]
    largest: tuple[float, ...]

    @property
    def order(self) -> float | None:
        """Fitted order of the error near the start; None where fewer than two errors are above round-off."""
        pairs = [(np.log(n), np.log(x)) for n, x in zip(STEPS, self.near, strict=True) if x > FLOOR]
        if len(pairs) < 2:
            return None
        x, y = np.transpose(pairs)
        return -float(np.polyfit(x, y, 1)[0])

    @property
    def share(self) -> float:
        """Error near the start over the largest error of the curve, at the largest ``N``."""
        return self.near[-1] / self.largest[-1]


def _errors(experiment: Experiment, method: str, steps: int) -> tuple[float, float]:
    exact = experiments.reference(experiment, steps)
    if method in COMPOSED:
        z = experiment.chart.integrate(exact[0], steps, map="midpoint", order=4 if method == "composed_4" else 6)
        points = experiments.points(experiment, z)
    else:
        points = experiments.solve(experiment, method, steps, exact[0], exact[-1])
    distance = experiments.distances(points, experiments.points(experiment, exact))
    return float(distance[round(TIME * steps)]), float(distance.max())


def measure() -> list[Row]:
    """Measure all methods on both experiments."""
    rows = []
    for e in EXPERIMENTS:
        for method in ALL:
            near, largest = zip(*(_errors(e, method, n) for n in STEPS), strict=True)
            rows.append(Row(e, method, near, largest))
    return rows


def of(rows: list[Row], experiment: Experiment, method: str) -> Row:
    """Return the row of one method."""
    return next(r for r in rows if r.experiment is experiment and r.method == method)


def against_gcp(rows: list[Row], experiment: Experiment, method: str) -> float:
    """Error near the start as a multiple of GCP's, at the largest ``N``."""
    return of(rows, experiment, method).near[-1] / of(rows, experiment, "gcp").near[-1]


def section(rows: list[Row]) -> str:
    """Text of the section of ``summary.md``."""
    cells = []
    for r in rows:
        order = "-" if r.order is None else f"{round(r.order, 2) + 0.0:.2f}"
        numbers = [f"{r.near[-1]:.2e}", f"{r.largest[-1]:.2e}", percent(r.share)]
        ratio = f"{against_gcp(rows, r.experiment, r.method):.3g}"
        cells.append([r.experiment.title, NAMES[r.method], *numbers, ratio, order])
    header = ["manifold", "method", f"error, t = {TIME:g}", "largest error", "share", "GCP = 1", "order"]
    return f"""### Near the initial point

The paper: the integrators are "ideal to simulate dynamics near the initial point of the trajectories, at any desired
error order", and GCP is not. Errors at t = {TIME:g} for N = {STEPS[-1]}, as a share of the largest error of the curve
and as a multiple of the error of GCP; the order is fitted to the errors at t = {TIME:g} above {FLOOR:g} for
N = {", ".join(map(str, STEPS))}:

{table(header, cells, 2)}

IVP: initial values, with the acceleration and the jerk given. BVP: boundary values, met by shooting. GCP meets the
initial point and velocity exactly, so its error is small near the start too, but it does not decrease with the step.
Orders above 2 are compositions and splittings, which the paper does not use.
"""
