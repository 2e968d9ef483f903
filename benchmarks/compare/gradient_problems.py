"""Functions of solutions whose gradients are compared: sums of products of points with fixed numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.compare import spline_problems
from benchmarks.problems import Array, Boundary, geodesic_end, point, tangent

SHAPES = ((3, 1), (5, 2), (12, 3), (20, 5))
# Shapes for which the unrolled solver takes at most some hundred megabytes.
UNROLLED = SHAPES[:3]
# Number of equal parts of the interval of a boundary problem, the steps of the unrolled solver.
PARTS = 32
KEYFRAMES = 200
# Number of equal parts of every leg of the spline: 991 times in total, with inner knots counted twice.
LEG_PARTS = 5


def boundary(n: int, k: int) -> Boundary:
    """Ends at distance 0.5 and speeds of 0.5 and 0.6."""
    S0 = point(n, k, 19)
    S1 = geodesic_end(S0, tangent(S0, 0.5, 20))
    return Boundary(S0, tangent(S0, 0.5, 21), S1, tangent(S1, 0.6, 22))


def boundary_weights(n: int, k: int) -> tuple[Array, Array]:
    """Times, and the numbers by which points there are multiplied."""
    t = np.linspace(0.0, 1.0, PARTS + 1)
    return t, np.random.default_rng([20240419, 19]).standard_normal((len(t), n, k))


@dataclass(frozen=True)
class SplineProblem:
    """Keyframes as matrices, times `(N - 1, LEG_PARTS + 1)` by legs, and numbers for the points there."""

    t: Array
    R: Array
    times: Array
    weights: Array


def spline() -> SplineProblem:
    """A problem with 200 keyframes 0.3 to 1.2 rad apart."""
    knots = spline_problems.keyframes(KEYFRAMES)
    parts = np.linspace(0.0, 1.0, LEG_PARTS + 1)
    times = knots.t[:-1, None] + np.diff(knots.t)[:, None] * parts
    weights = np.random.default_rng([20240419, 20]).standard_normal((*times.shape, 3, 3))
    return SplineProblem(knots.t, knots.S, times, weights)


def along(S: Array, G: Array) -> Array:
    """The part of a gradient that matters along the manifold, `G - S sym(S^T G)`."""
    inner = np.swapaxes(S, -1, -2) @ G
    return np.asarray(G - S @ (inner + np.swapaxes(inner, -1, -2)) / 2)
