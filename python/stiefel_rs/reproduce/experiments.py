"""The two experiments of arXiv 2404.19407 and their measurements.

Curves, integrators, shooting and the reference solution are those of the compiled module; computed here are means,
slopes and differences.

Time is dimensionless, the curves run over ``0 <= t <= 1`` and ``h = 1 / N``.
A state is ``z = (q, qdot, p_q, p_qdot)``, shape ``(4 d,)``, with ``d`` the dimension of the manifold.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from .._core import Chart, GeometricCubic, RiemannianCubic, integrate_cubic

Array = NDArray[np.float64]
Map = Literal["initial_point", "midpoint"]

MAPS: Final[tuple[Map, ...]] = ("initial_point", "midpoint")
METHODS: Final = ("gcp", "initial_point_ivp", "initial_point_bvp", "midpoint_ivp", "midpoint_bvp")
# Without charts: splittings of the initial value problem, and the exact cubic with the boundary data of GCP.
SPLITTING_ORDERS: Final = {f"splitting_{order}": order for order in (2, 4, 6, 8)}
CHART_FREE_METHODS: Final = (*SPLITTING_ORDERS, "exact_bvp")
ALL_METHODS: Final = (*METHODS, *CHART_FREE_METHODS)
TIMED_METHODS: Final = ("gcp", "reference", *ALL_METHODS[1:])
# The residual that shooting for the exact cubic stops at. Newton squares it: one more step is at round-off.
BOUNDARY_TOLERANCE: Final = 1e-13
# Below, round-off of a mean error (a few 1e-16) shows in the slope of its logarithm.
SLOPE_FLOOR: Final = 1e-14
DEFAULT_STEPS: Final = (5, 10, 20, 50, 100, 200, 500, 1000)
QUICK_STEPS: Final = (5, 10, 20, 50, 100)


@dataclass(frozen=True)
class Experiment:
    """One experiment of the paper.

    Attributes
    ----------
    name, title : str
        The stem of its files, and how it is written in text.
    chart : Chart
        The chart that the paper computes in.
    q, qdot, qddot, qdddot : tuple of float, length d
        Chart coordinates at ``t = 0`` and their derivatives (radians).
    diameter : float
        Largest Frobenius distance of two points, ``2 sqrt(k)``, between ``S`` and ``-S``.
    paper_error : float
        The relative mean error of GCP that the paper reports.
    independent : mapping of int to tuple of float
        Mean errors by ``N``, in the order of `METHODS`: an independent recomputation (NumPy/mpmath).
    """

    name: str
    title: str
    chart: Chart
    q: tuple[float, ...]
    qdot: tuple[float, ...]
    qddot: tuple[float, ...]
    qdddot: tuple[float, ...]
    diameter: float
    paper_error: float
    independent: Mapping[int, tuple[float, ...]] = field(repr=False)


SPHERE: Final = Experiment(
    name="sphere",
    title="sphere",
    chart=Chart.sphere(),
    q=(math.pi / 2, math.pi),
    qdot=(0.1, 0.2),
    qddot=(1.0, 0.5),
    qdddot=(0.1, 0.2),
    diameter=2.0,
    paper_error=0.00080,
    independent={
        10: (9.8759e-5, 2.9143e-2, 5.4414e-3, 3.9581e-4, 4.5591e-4),
        20: (1.0347e-4, 1.4644e-2, 2.8290e-3, 9.4350e-5, 1.2061e-4),
        50: (1.0651e-4, 5.8764e-3, 1.1856e-3, 1.4640e-5, 1.9921e-5),
        100: (1.0757e-4, 2.9414e-3, 6.0440e-4, 3.6215e-6, 5.0316e-6),
    },
)
STIEFEL_3_2: Final = Experiment(
    name="stiefel_3_2",
    title="St(3,2)",
    chart=Chart.frame(),
    q=(math.pi / 4, math.pi, math.pi),
    qdot=(0.1, 0.1, 0.05),
    qddot=(1.0, 0.3, 0.5),
    qdddot=(0.1, 0.1, 0.05),
    diameter=2.0 * math.sqrt(2.0),
    paper_error=0.0045,
    independent={
        10: (4.1506e-3, 4.0638e-2, 6.2603e-3, 3.3569e-4, 2.5034e-4),
        20: (4.3486e-3, 2.0380e-2, 3.1081e-3, 8.1022e-5, 6.6040e-5),
        50: (4.4766e-3, 8.1680e-3, 1.2745e-3, 1.2682e-5, 1.0899e-5),
        100: (4.5209e-3, 4.0867e-3, 6.4583e-4, 3.1470e-6, 2.7527e-6),
    },
)
EXPERIMENTS: Final = (SPHERE, STIEFEL_3_2)


def initial_state(experiment: Experiment) -> Array:
    """State at ``t = 0``, shape ``(4 d,)``, from the paper's coordinate derivatives."""
    e = experiment
    return np.concatenate([e.q, e.qdot, *e.chart.momenta(e.q, e.qdot, e.qddot, e.qdddot)])


def time_grid(steps: int) -> Array:
    """Return the ``steps + 1`` times ``n / steps``, shape ``(steps + 1,)``."""
    return np.arange(steps + 1) / steps


def reference(experiment: Experiment, steps: int) -> Array:
    """States of the reference solution on the grid, shape ``(steps + 1, 4 d)``, error at most 1e-13."""
    return experiment.chart.reference(initial_state(experiment), time_grid(steps))


def points(experiment: Experiment, z: Array) -> Array:
    """Points of the manifold, shape ``(..., 3, k)``, of the states `z`, shape ``(..., 4 d)``."""
    return experiment.chart.embed(z[..., : experiment.chart.d])


def boundary_data(experiment: Experiment, start: Array, end: Array) -> tuple[Array, Array, Array, Array]:
    """End points and end velocities ``S0, V0, S1, V1`` of two states, each of shape ``(4 d,)``."""
    chart, d = experiment.chart, experiment.chart.d
    data = [(chart.embed(z[:d]), chart.embed_velocity(z[:d], z[d : 2 * d])) for z in (start, end)]
    return (*data[0], *data[1])


def geometric_cubic(experiment: Experiment, start: Array, end: Array) -> GeometricCubic:
    """GCP with the end points and end velocities of two states, each of shape ``(4 d,)``."""
    return GeometricCubic(*boundary_data(experiment, start, end))


def exact_cubic(experiment: Experiment, start: Array, end: Array) -> RiemannianCubic:
    """Riemannian cubic with the end points and end velocities of two states, found without a chart."""
    return RiemannianCubic.from_boundary(*boundary_data(experiment, start, end), tol=BOUNDARY_TOLERANCE)


def solve(experiment: Experiment, method: str, steps: int, start: Array, end: Array) -> Array:
    """Points of one curve on the grid, by one method.

    Parameters
    ----------
    experiment : Experiment
    method : str
        One of `TIMED_METHODS`.
    steps : int
        Number ``N`` of steps.
    start, end : ndarray, shape (4 d,)
        States of the reference at ``t = 0`` and ``t = 1``. The initial value problems use the whole of `start`
        (the splittings as covariant acceleration and jerk); GCP and the boundary value problems use positions and
        velocities of both.

    Returns
    -------
    ndarray, shape (steps + 1, 3, k)

    Raises
    ------
    ConvergenceError
        Shooting or an implicit step did not converge.
    """
    chart, d = experiment.chart, experiment.chart.d
    if method == "gcp":
        # One thread, as the integrators have: the times of all methods stay comparable.
        return geometric_cubic(experiment, start, end)(time_grid(steps), num_threads=1)
    if method == "exact_bvp":
        return exact_cubic(experiment, start, end)(time_grid(steps), num_threads=1)
    if method in SPLITTING_ORDERS:
        return integrate_cubic(*chart.covariant(start), steps, order=SPLITTING_ORDERS[method]).point
    if method == "reference":
        return points(experiment, chart.reference(start, time_grid(steps)))
    step_map: Map = "initial_point" if method.startswith("initial_point") else "midpoint"
    if method.endswith("_ivp"):
        return points(experiment, chart.integrate(start, steps, map=step_map))
    result = chart.shoot(start[:d], start[d : 2 * d], end[:d], end[d : 2 * d], steps, map=step_map)
    return points(experiment, result.trajectory)


def distances(a: Array, b: Array) -> Array:
    """Frobenius distances, shape ``(m,)``, of the points of two curves, each of shape ``(m, 3, k)``."""
    return np.asarray(np.linalg.norm(a - b, axis=(1, 2)), dtype=np.float64)


@dataclass(frozen=True)
class ErrorRow:
    """Mean Frobenius error over the ``steps + 1`` grid points, by method."""

    steps: int
    errors: Mapping[str, float]

    @property
    def h(self) -> float:
        """The step ``1 / steps``."""
        return 1.0 / self.steps


def mean_errors(experiment: Experiment, steps: int) -> ErrorRow:
    """Mean errors of `ALL_METHODS` for one ``N``."""
    exact = reference(experiment, steps)
    curve = points(experiment, exact)
    found = {m: solve(experiment, m, steps, exact[0], exact[-1]) for m in ALL_METHODS}
    return ErrorRow(steps, {m: float(distances(s, curve).mean()) for m, s in found.items()})


def slope(rows: Iterable[ErrorRow], method: str) -> float | None:
    """Least-squares slope of log error against log ``h``; None for fewer than two ``N``.

    An ``N`` whose error is below `SLOPE_FLOOR` does not count.
    """
    pairs = [(math.log(r.h), math.log(r.errors[method])) for r in rows if r.errors[method] > SLOPE_FLOOR]
    if len(pairs) < 2:
        return None
    x, y = np.array(pairs).T
    x = x - x.mean()
    return float(x @ y / (x @ x))


def overtakes(experiment: Experiment, rows: list[ErrorRow], method: str) -> int | None:
    """Smallest ``N`` at which `method` has a smaller mean error than GCP, up to the largest ``N`` of `rows`.

    None if it is still behind there. Bisection between the last ``N`` of `rows` (in increasing order) that loses and
    the next; it supposes that the order of the two errors changes once in between.
    """

    def wins(row: ErrorRow) -> bool:
        return row.errors[method] < row.errors["gcp"]

    if not rows or not wins(rows[-1]):
        return None
    # With one step shooting has no free momentum left at the end point: nothing below N = 2 can win.
    low = max((row.steps for row in rows if not wins(row)), default=1)
    high = min(row.steps for row in rows if row.steps > low)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if wins(mean_errors(experiment, middle)) else (middle, high)
    return high
