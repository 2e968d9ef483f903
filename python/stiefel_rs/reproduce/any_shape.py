"""Exact cubics on other St(n,k): boundary problems without charts, checked by another method, and their times."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np

from .._core import RiemannianCubic, Stiefel, integrate_cubic
from . import experiments
from .experiments import Array
from .text import milliseconds, table
from .timing import shortest

SHAPES: Final = ((3, 1), (3, 2), (4, 2), (5, 3), (6, 6), (10, 3), (20, 4), (100, 5))
SEED: Final = 20240419
# Distance of the two points, and speeds at them, as lengths of tangent vectors.
DISTANCE: Final = 1.0
SPEED: Final = 1.0
# The splitting that checks the cubic: at round-off with as many steps.
CHECK_STEPS: Final = 100
CHECK_ORDER: Final = 8
POINTS: Final = 1000
HEADER: Final = ["n", "k", "dimension", "iterations", "residual", "distance_to_splitting", "defect"]


@dataclass(frozen=True)
class Row:
    """One boundary problem.

    Attributes
    ----------
    iterations, residual : int, float
        Those of the solver.
    distance : float
        Largest distance of the curve and a splitting of order 8 from its initial data.
    defect : float
        Largest entry of ``S^T S - I`` on the curve.
    build_seconds, point_seconds : float
        Shortest times of the solution, and of a point of `POINTS` at once on one thread.
    """

    n: int
    k: int
    iterations: int
    residual: float
    distance: float
    defect: float
    build_seconds: float
    point_seconds: float


def problem(n: int, k: int) -> tuple[Array, Array, Array, Array]:
    """Random ends at `DISTANCE` with velocities of length `SPEED`."""
    manifold, rng = Stiefel(n, k), np.random.default_rng(SEED)
    S0 = manifold.random_point(rng)

    def tangent(S: Array, length: float) -> Array:
        V = manifold.random_tangent(S, rng)
        return np.asarray(length / float(manifold.norm(S, V)) * V)

    S1 = manifold.exp(S0, tangent(S0, DISTANCE))
    return S0, tangent(S0, SPEED), S1, tangent(S1, SPEED)


def measure_shape(n: int, k: int, repetitions: int) -> Row:
    """Solve and check one problem."""
    build = partial(RiemannianCubic.from_boundary, *problem(n, k), tol=experiments.BOUNDARY_TOLERANCE)
    curve = build()
    t = experiments.time_grid(CHECK_STEPS)
    points = curve(t)
    other = integrate_cubic(*curve.initial, CHECK_STEPS, order=CHECK_ORDER).point
    defect = np.abs(np.swapaxes(points, 1, 2) @ points - np.eye(k)).max()
    report = curve.report
    if report is None:
        raise ValueError("a curve from initial data has no boundary problem")
    grid = np.linspace(0.0, 1.0, POINTS)
    times = (shortest(build, repetitions), shortest(partial(curve, grid, num_threads=1), repetitions) / POINTS)
    distance = float(experiments.distances(points, other).max())
    return Row(n, k, report.iterations, report.residual, distance, float(defect), *times)


def measure(repetitions: int) -> list[Row]:
    """Solve and check one problem of each shape."""
    return [measure_shape(n, k, repetitions) for n, k in SHAPES]


def csv_rows(rows: list[Row]) -> list[tuple[object, ...]]:
    """Rows of ``any_shape.csv``, whose header is `HEADER`: results that do not depend on time."""
    return [(r.n, r.k, Stiefel(r.n, r.k).dim, r.iterations, r.residual, r.distance, r.defect) for r in rows]


def section(rows: list[Row]) -> str:
    """Text of the section of ``summary.md``."""
    cells = [
        [
            *(f"St({r.n},{r.k})", str(Stiefel(r.n, r.k).dim), str(r.iterations), f"{r.residual:.1e}"),
            *(f"{r.distance:.1e}", f"{r.defect:.1e}", milliseconds(r.build_seconds), f"{1e9 * r.point_seconds:.3g} ns"),
        ]
        for r in rows
    ]
    header = ["manifold", "dimension", "iterations", "residual", "to the splitting", "defect", "to solve", "a point"]
    return f"""### Exact cubics on any St(n,k)

Boundary problems on other Stiefel manifolds, solved without charts: random ends at distance {DISTANCE:g}, velocities of
length {SPEED:g}. Each curve is compared with a splitting of order {CHECK_ORDER} with {CHECK_STEPS} steps from its
initial data (largest distance); the defect is the largest entry of `S^T S - I`:

{table(header, cells)}

Times are the shortest of a few repetitions; for a point, of {POINTS} at once on one thread.
"""
