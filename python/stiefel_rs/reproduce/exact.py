"""The exact cubic compared with the curves of the paper: the cost of each curve, and its excess.

The exact cubic is the chart-free solution of the boundary value problem that GCP and the shooting methods solve too:
end points and end velocities of the paper's curve.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from .._core import RiemannianCubic, Stiefel, integrate_cubic
from . import control_points, experiments
from .experiments import EXPERIMENTS, SLOPE_FLOOR, SPLITTING_ORDERS, Array, ErrorRow, Experiment, Map
from .text import LABELS as ERROR_LABELS
from .text import percent, table

COARSE_STEPS: Final = 10
FINE_STEPS: Final = 100
COST_STEPS: Final = (COARSE_STEPS, FINE_STEPS)
# The curve found counts as the paper's up to this distance, well above the errors of both (1e-13).
SAME_CURVE: Final = 1e-12
# Two excesses are called equal up to this relative difference, the round-off in their costs.
SAME_EXCESS: Final = 1e-6
LABELS: Final = {
    "exact": "exact cubic",
    "gcp": "GCP",
    "geodesic_cubic": "GCP with geodesic pieces",
    "exact_sum": "exact cubic, by the sum",
    "initial_point_bvp": "initial-point BVP",
    "midpoint_bvp": "mid-point BVP",
    "initial_point_ivp": "initial-point IVP",
    "midpoint_ivp": "mid-point IVP",
    "splitting_2": "splitting 2 IVP",
    "splitting_4": "splitting 4 IVP",
    "splitting_6": "splitting 6 IVP",
    "splitting_8": "splitting 8 IVP",
}
HEADER: Final = ["manifold", "curve", "N", "mean_error", "cost", "cost_excess"]


@dataclass(frozen=True)
class Cost:
    """Cost of one curve.

    Attributes
    ----------
    steps : int or None
        ``N`` of a discrete trajectory, whose cost is the trapezoidal sum of ``|D_t S'|^2``; None for a curve, whose
        cost is the integral.
    error : float
        Mean Frobenius distance to the exact cubic, over the points of the trajectory or ``FINE_STEPS + 1`` points.
    cost, excess : float
        The cost, and its relative excess over the exact cubic's.
    """

    method: str
    steps: int | None
    error: float
    cost: float
    excess: float


@dataclass(frozen=True)
class Agreement:
    """The chart-free boundary solution compared with the paper's curve in its chart: largest Frobenius distances.

    Attributes
    ----------
    iterations, residual : int, float
        Those of the shooting.
    point : float
        Of the points, at ``FINE_STEPS + 1`` times.
    acceleration, jerk : float
        Of the initial covariant acceleration and jerk, which the boundary problem leaves unknown.
    """

    iterations: int
    residual: float
    point: float
    acceleration: float
    jerk: float


@dataclass(frozen=True)
class Comparison:
    """Everything measured on one experiment."""

    experiment: Experiment
    agreement: Agreement
    costs: list[Cost]

    @property
    def same_pieces(self) -> bool:
        """Whether geodesics and quasi-geodesics as pieces give the same curve, by its cost."""
        gcp, geodesic = self.of("gcp"), self.of("geodesic_cubic")
        return abs(geodesic.excess - gcp.excess) <= SAME_EXCESS * abs(gcp.excess)

    def of(self, method: str, steps: int | None = None) -> Cost:
        """Return the row of one method and ``N``."""
        return next(c for c in self.costs if (c.method, c.steps) == (method, steps))


def squared_acceleration(experiment: Experiment, z: Array) -> Array:
    """``|D_t S'|^2 = p_qdot^T g^-1 p_qdot``, shape ``(m,)``, of the states `z`, shape ``(m, 4 d)``.

    ``p_qdot`` is the covector of the covariant acceleration, and the Hamiltonian has the inverse metric.
    """
    d = experiment.chart.d
    p, inverse = z[:, 3 * d :], experiment.chart.hessian(z)[:, 3 * d :, 3 * d :]
    return np.asarray(np.einsum("mi,mij,mj->m", p, inverse, p))


def trapezoid(values: Array) -> float:
    """Trapezoidal sum over ``0 <= t <= 1`` of equidistant values."""
    return float((values.sum() - (values[0] + values[-1]) / 2) / (len(values) - 1))


def _discrete(experiment: Experiment, start: Array, end: Array, steps: int) -> Iterator[tuple[str, Array, Array]]:
    """Yield method, points and ``|D_t S'|^2`` of each discrete trajectory with ``steps`` steps."""
    chart, d = experiment.chart, experiment.chart.d
    states = {"exact_sum": chart.reference(start, experiments.time_grid(steps))}
    maps: tuple[Map, ...] = experiments.MAPS
    for m in maps:
        shot = chart.shoot(start[:d], start[d : 2 * d], end[:d], end[d : 2 * d], steps, m)
        states[f"{m}_bvp"] = shot.trajectory
    for m in maps:
        states[f"{m}_ivp"] = chart.integrate(start, steps, map=m)
    for name, z in states.items():
        yield name, experiments.points(experiment, z), squared_acceleration(experiment, z)
    manifold, initial = Stiefel(3, chart.k), chart.covariant(start)
    for name, order in SPLITTING_ORDERS.items():
        found = integrate_cubic(*initial, steps, order=order)
        yield name, found.point, manifold.norm(found.point, found.acceleration) ** 2


def _agreement(experiment: Experiment, start: Array, cubic: RiemannianCubic) -> Agreement:
    grid = experiments.time_grid(FINE_STEPS)
    exact = experiments.points(experiment, experiment.chart.reference(start, grid))
    own, known = cubic.initial, experiment.chart.covariant(start)
    acceleration, jerk = (float(np.linalg.norm(own[i] - known[i])) for i in (2, 3))
    point = float(experiments.distances(cubic(grid), exact).max())
    report = cubic.report
    if report is None:
        raise ValueError("a curve from initial data has no boundary problem")
    return Agreement(report.iterations, report.residual, point, acceleration, jerk)


def compare(experiment: Experiment) -> Comparison:
    """Measure one experiment."""
    start, end = experiments.reference(experiment, 1)
    cubic = experiments.exact_cubic(experiment, start, end)
    least, problem = cubic.cost(), control_points.boundary_problem(experiment)
    grid = experiments.time_grid(FINE_STEPS)
    costs = [Cost("exact", None, 0.0, least, 0.0)]
    for method in ("gcp", "geodesic_cubic"):
        curve = control_points.build(problem, method)
        error, cost = float(experiments.distances(curve(grid), cubic(grid)).mean()), curve.cost()
        costs.append(Cost(method, None, error, cost, cost / least - 1))
    for steps in COST_STEPS:
        exact = cubic(experiments.time_grid(steps))
        for method, points, squares in _discrete(experiment, start, end, steps):
            cost = trapezoid(squares)
            costs.append(
                Cost(method, steps, float(experiments.distances(points, exact).mean()), cost, cost / least - 1)
            )
    return Comparison(experiment, _agreement(experiment, start, cubic), costs)


def measure() -> list[Comparison]:
    """Measure both experiments."""
    return [compare(e) for e in EXPERIMENTS]


def _errors(results: dict[str, list[ErrorRow]]) -> str:
    methods = experiments.CHART_FREE_METHODS
    cells = []
    for e in EXPERIMENTS:
        rows = results[e.name]
        for r in rows:
            cells.append([e.title, str(r.steps), *(f"{r.errors[m]:.1e}" for m in methods)])
        slopes = [experiments.slope(rows, m) for m in methods]
        cells.append([e.title, "order", *("-" if s is None else f"{s:.2f}" for s in slopes)])
    return table(["manifold", "N", *(ERROR_LABELS[m] for m in methods)], cells, 1)


def _agreements(found: list[Comparison]) -> str:
    cells = []
    for c in found:
        a = c.agreement
        distances = (f"{x:.1e}" for x in (a.point, a.acceleration, a.jerk))
        cells.append([c.experiment.title, str(a.iterations), f"{a.residual:.1e}", *distances])
    header = ["manifold", "iterations", "residual", "points", "initial acceleration", "initial jerk"]
    return table(header, cells, 1)


def _same(found: list[Comparison]) -> str:
    lines = []
    for c in found:
        verdict = "is the paper's curve" if c.agreement.point < SAME_CURVE else "is another curve than the paper's"
        lines.append(f"- {c.experiment.title}: the cubic found {verdict}.")
    return "\n".join(lines)


def _costs(found: list[Comparison]) -> str:
    cells = []
    for c in found:
        for row in c.costs:
            size = "-" if row.steps is None else str(row.steps)
            numbers = [size, f"{row.error:.2e}" if row.error else "0", f"{row.cost:.8f}", percent(row.excess)]
            cells.append([c.experiment.title, LABELS[row.method], *numbers])
    return table(["manifold", "curve", "N", "mean error", "cost J", "excess over the exact cubic"], cells, 2)


def _given_away(found: list[Comparison]) -> str:
    lines = []
    for c in found:
        gcp, geodesic = c.of("gcp"), c.of("geodesic_cubic")
        if c.same_pieces:
            pieces = "with geodesic pieces it is the same"
        else:
            pieces = f"with geodesic pieces it is {percent(geodesic.excess)}"
        sums = [
            f"{percent(c.of('initial_point_bvp', n).excess)} (initial-point) and "
            f"{percent(c.of('midpoint_bvp', n).excess)} (mid-point) at N = {n}"
            for n in COST_STEPS
        ]
        lines.append(
            f"- {c.experiment.title}: the de Casteljau curve GCP gives away {percent(gcp.excess)} of the cost of the "
            f"exact cubic; {pieces}. The sums of the shooting methods differ from that cost by {', '.join(sums)}; the "
            f"sum along the exact cubic by {' and '.join(percent(c.of('exact_sum', n).excess) for n in COST_STEPS)}."
        )
    return "\n".join(lines)


def section(found: list[Comparison], rows: dict[str, list[ErrorRow]]) -> str:
    """Text of the section of ``summary.md``."""
    return f"""### The exact cubic, without charts

Methods that use no chart: explicit splittings of order 2, 4, 6 and 8 of the initial value problem, and the Riemannian
cubic with the boundary data of GCP, by shooting with a Taylor method. Mean errors against the Taylor reference in the
chart, whose own error is up to 1e-13; their times are below:

{_errors(rows)}

Orders are fitted where the mean error is above {SLOPE_FLOOR:g}; below, it contains round-off; a dash marks
fewer than two remaining N.

A Riemannian cubic with given ends is stationary for the cost, and more than one can exist. The solution found by
shooting, compared with the paper's curve (largest Frobenius distances; the initial acceleration and jerk are unknowns
of the boundary problem):

{_agreements(found)}

{_same(found)}

The cost `J = int |D_t S'|^2 dt` of each curve. GCP, its variant with geodesic pieces and the exact cubic are curves,
and J is the integral. The others are points with momenta, and J is the trapezoidal sum over the N + 1 points of
`|D_t S'|^2 = p_qdot^T g^-1 p_qdot`, with `g` the metric; the splittings have the covariant acceleration itself:

{_costs(found)}

{_given_away(found)}

Only curves with the same ends can be compared by their costs: GCP, geodesic pieces, the BVP methods and the exact
cubic. An IVP method ends elsewhere, because of its error. A sum is not an integral along a curve, so it may be less
than the cost of the exact cubic; the row "by the sum" shows what the trapezoidal rule alone adds.
"""


def csv_rows(found: list[Comparison]) -> list[tuple[object, ...]]:
    """Rows of ``cost.csv``, whose header is `HEADER`."""
    return [
        (c.experiment.name, r.method, "" if r.steps is None else r.steps, r.error, r.cost, r.excess)
        for c in found
        for r in c.costs
    ]
