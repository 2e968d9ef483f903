"""Other control points for the de Casteljau curve: distance to the Riemannian cubic, and time of construction.

The paper suggests "an alternative choice of control points" for its geometric cubic. Measured here on its two boundary
problems: inner control points of least cost in degrees 4 to 7, the quintic with the cubic's end accelerations, and
geodesics in place of quasi-geodesics. All have the end points and end velocities of the cubic. It has a row of its
own: a curve that only comes near it has to be quicker, or to be wanted in closed form.
"""

from __future__ import annotations

import itertools
import time
from dataclasses import dataclass
from typing import Final

import numpy as np

from .._core import Curve, GeometricCubic, GeometricPolynomial, RiemannianCubic
from . import experiments
from .experiments import EXPERIMENTS, Array, Experiment
from .text import between, table

DEGREES: Final = (4, 5, 6, 7)
LABELS: Final = {
    "gcp": "GCP",
    "geodesic_cubic": "cubic with geodesics",
    "quintic": "quintic, exact end accelerations",
    **{f"minimal_cost_{m}": "minimal cost" for m in DEGREES},
    "exact": "none: the exact cubic",
}
POLYNOMIALS: Final = tuple(m for m in LABELS if m != "exact")
STEPS: Final = 100
REPETITIONS: Final = 5
BUILDS: Final = 20
POINTS: Final = 1000
HEADER: Final = ["manifold", "method", "degree", "free_numbers", "mean_error", "gcp_error_ratio", "cost", "cost_excess"]


@dataclass(frozen=True)
class Problem:
    """The boundary problem of one experiment and its exact solution.

    Attributes
    ----------
    ends : tuple of ndarray
        ``S0, V0, S1, V1``.
    accelerations : tuple of ndarray
        Covariant accelerations of the cubic at both ends.
    points : ndarray, shape (STEPS + 1, 3, k)
        The cubic on the grid.
    cost : float
        Its cost.
    """

    experiment: Experiment
    ends: tuple[Array, Array, Array, Array]
    accelerations: tuple[Array, Array]
    points: Array
    cost: float


def boundary_problem(experiment: Experiment) -> Problem:
    """Boundary data of one experiment, and the exact cubic from them alone: its points, accelerations and cost."""
    start, end = experiments.reference(experiment, 1)
    cubic = experiments.exact_cubic(experiment, start, end)
    return Problem(
        experiment,
        experiments.boundary_data(experiment, start, end),
        (cubic.acceleration(0.0), cubic.acceleration(1.0)),
        cubic(experiments.time_grid(STEPS)),
        cubic.cost(),
    )


def build(problem: Problem, method: str) -> Curve:
    """Build the curve of one of the methods of `LABELS` for the boundary data of the problem."""
    s0, v0, s1, v1 = problem.ends
    if method == "exact":
        return RiemannianCubic.from_boundary(s0, v0, s1, v1, tol=experiments.BOUNDARY_TOLERANCE)
    if method == "gcp":
        return GeometricCubic(s0, v0, s1, v1)
    if method == "geodesic_cubic":
        return GeometricCubic(s0, v0, s1, v1, pieces="geodesic")
    if method == "quintic":
        a0, a1 = problem.accelerations
        return GeometricPolynomial.quintic(s0, v0, a0, s1, v1, a1)
    return GeometricPolynomial.minimal_cost(s0, v0, s1, v1, degree=degree(method))


def degree(method: str) -> int:
    """Degree of the curve of one of `POLYNOMIALS`."""
    fixed = {"gcp": 3, "geodesic_cubic": 3, "quintic": 5}
    return fixed[method] if method in fixed else int(method.rsplit("_", 1)[1])


@dataclass(frozen=True)
class Row:
    """One method on one problem.

    Attributes
    ----------
    free : int
        Free numbers that the method chooses.
    error : float
        Mean Frobenius distance to the exact cubic over the ``STEPS + 1`` grid points; zero for that curve itself.
    cost, excess : float
        The cost, and its relative excess over the exact cubic's.
    build_seconds, point_seconds : float
        Shortest times of the construction, and of a point of `POINTS` at once on one thread.
    """

    experiment: Experiment
    method: str
    free: int
    error: float
    cost: float
    excess: float
    build_seconds: float
    point_seconds: float


def measure() -> list[Row]:
    """All methods on both problems; times interleaved, so that a machine that slows down slows all alike."""
    problems = [boundary_problem(e) for e in EXPERIMENTS]
    cases = [(p, m) for p in problems for m in LABELS]
    builds: dict[tuple[str, str], list[float]] = {(p.experiment.name, m): [] for p, m in cases}
    samples: dict[tuple[str, str], list[float]] = {key: [] for key in builds}
    t = np.linspace(0.0, 1.0, POINTS)
    for round_number in range(REPETITIONS + 1):
        for problem, method in cases:
            begin = time.perf_counter()
            for _ in range(BUILDS):
                curve = build(problem, method)
            middle = time.perf_counter()
            curve(t, num_threads=1)
            if round_number:
                key = (problem.experiment.name, method)
                builds[key].append((middle - begin) / BUILDS)
                samples[key].append((time.perf_counter() - middle) / POINTS)
    rows = []
    for problem, method in cases:
        curve, e = build(problem, method), problem.experiment
        free = (degree(method) - 3) * e.chart.d if method.startswith("minimal_cost") else 0
        error = float(experiments.distances(curve(experiments.time_grid(STEPS)), problem.points).mean())
        cost, key = curve.cost(), (e.name, method)
        excess = cost / problem.cost - 1
        times = (min(builds[key]), min(samples[key]))
        rows.append(Row(e, method, free, error, cost, excess, *times))
    return rows


def of(rows: list[Row], experiment: Experiment, method: str) -> Row:
    """Return the row of one method."""
    return next(r for r in rows if (r.experiment.name, r.method) == (experiment.name, method))


def _table(rows: list[Row]) -> str:
    cells = []
    for r in rows:
        times = [f"{1e6 * r.build_seconds:.3g} us", f"{1e9 * r.point_seconds:.3g} ns"]
        if r.method == "exact":
            numbers = ["-", "-", "0", "-", f"{r.cost:.10f}", "0"]
        else:
            ratio = of(rows, r.experiment, "gcp").error / r.error
            sizes = [str(degree(r.method)), str(r.free)]
            numbers = [*sizes, f"{r.error:.4e}", f"{ratio:.3g}", f"{r.cost:.10f}", f"{r.excess:.1e}"]
        cells.append([r.experiment.title, LABELS[r.method], *numbers, *times])
    header = [
        "manifold",
        "control points",
        "degree",
        "free numbers",
        f"mean error, N = {STEPS}",
        "GCP's / this",
        "cost J",
        "excess over the exact cubic",
        "time to build",
        f"a point of {POINTS}",
    ]
    return table(header, cells, 2)


def _gains(rows: list[Row]) -> str:
    lines = []
    for e in EXPERIMENTS:
        methods = ["gcp", *(f"minimal_cost_{m}" for m in DEGREES)]
        errors = [of(rows, e, m).error for m in methods]
        falls = [a / b for a, b in itertools.pairwise(errors)]
        quintic, geodesic = of(rows, e, "quintic"), of(rows, e, "geodesic_cubic")
        least = of(rows, e, "minimal_cost_5")
        verb = "lower" if geodesic.error < errors[0] else "raise"
        change = max(geodesic.error / errors[0], errors[0] / geodesic.error)
        pieces = (
            f"{verb} it by a factor of {change:.3g}" if change > 1.0001 else "change nothing: they are the same curves"
        )
        lines.append(
            f"- {e.title}: with each further degree the mean error of the curve of minimal cost falls by a factor of "
            f"{between(falls, 3)}, from {errors[0]:.2e} to {errors[-1]:.2e}. The quintic with exact end accelerations "
            f"has {errors[0] / quintic.error:.3g} times less error than GCP, the one of minimal cost "
            f"{errors[0] / least.error:.3g} times. Geodesics in place of quasi-geodesics {pieces}."
        )
    return "\n".join(lines)


def _times(rows: list[Row]) -> str:
    lines = []
    for e in EXPERIMENTS:
        gcp = of(rows, e, "gcp")
        for method, name in (
            ("geodesic_cubic", "the cubic of geodesics"),
            ("minimal_cost_5", "least cost in degree 5"),
            ("exact", "the exact cubic"),
        ):
            row = of(rows, e, method)
            build, point = row.build_seconds / gcp.build_seconds, row.point_seconds / gcp.point_seconds
            lines.append(
                f"- {e.title}, {name}: {build:.3g} times the time of GCP to build, {point:.3g} times for a point."
            )
    return "\n".join(lines)


def _slower(rows: list[Row]) -> str:
    """Which curves of minimal cost take longer than the exact cubic."""

    def listed(degrees: list[str]) -> str:
        return f"degree {', '.join(degrees)}" if degrees else "no degree"

    lines = []
    for e in EXPERIMENTS:
        exact = of(rows, e, "exact")
        least = [(m, of(rows, e, f"minimal_cost_{m}")) for m in DEGREES]
        build = listed([str(m) for m, r in least if r.build_seconds > exact.build_seconds])
        point = listed([str(m) for m, r in least if r.point_seconds > exact.point_seconds])
        lines.append(
            f"- {e.title}: minimal cost took longer than the exact cubic to build in {build}, for a point in {point}."
        )
    return "\n".join(lines)


def section(rows: list[Row]) -> str:
    """Text of the section of ``summary.md``."""
    return f"""### Other control points

The paper suggests an alternative choice of control points. Curves with the same end points and end velocities as GCP:
inner control points chosen for the least cost `J = int |D_t S'|^2 dt` in degrees {DEGREES[0]} to {DEGREES[-1]}; the
quintic whose end accelerations are those of the exact cubic, in closed form; and the cubic with geodesics instead of
quasi-geodesics.

{_table(rows)}

{_gains(rows)}

{_times(rows)}

{_slower(rows)}

The curves of minimal cost and the cubic of geodesics do not use the exact cubic; the quintic uses its end
accelerations. On the sphere geodesics are quasi-geodesics: `pieces="geodesic"` gives the same curve, but
computes a logarithm for every stage of every point. On St(3,2), the rotations, geodesics have a closed form too. A
polynomial of minimal cost may take longer to build than the exact cubic. If the exact cubic is available, it is the
better curve; the advantage of the others is their closed form.

Times are the shortest of {REPETITIONS} rounds that alternate between all methods, one thread.
"""


def csv_rows(rows: list[Row]) -> list[tuple[object, ...]]:
    """Rows of ``control_points.csv``, whose header is `HEADER`."""
    cells: list[tuple[object, ...]] = []
    for r in rows:
        polynomial = r.method != "exact"
        size = (degree(r.method), r.free) if polynomial else ("", "")
        ratio = of(rows, r.experiment, "gcp").error / r.error if polynomial else ""
        cells.append((r.experiment.name, r.method, *size, r.error, ratio, r.cost, r.excess))
    return cells
