"""Long calls of every kind: for the tests of Ctrl-C, and for the times of `python -m benchmarks.interrupts`.

Each is a `partial` of compiled code, so that nothing of Python runs between its start and its end.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from stiefel_rs import (
    Chart,
    CubicHermite,
    CubicSpline,
    Geodesic,
    GeometricCubic,
    GeometricPolynomial,
    RiemannianCubic,
    SmoothingSpline,
    Stiefel,
    estimate_velocities,
    integrate_cubic,
    integrate_embedded,
    orthogonal_log,
    skew_exp,
)
from stiefel_rs._core import RotationCurve, interpolated_rotations

Array = NDArray[np.float64]
Call = Callable[[], object]

CHART: Final = Chart.sphere()
# A geodesic along the equator, which never leaves the chart.
EQUATOR: Final = np.array([np.pi / 2, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0])


@cache
def ends(n: int, k: int, length: float = 1.0) -> tuple[Array, Array, Array, Array]:
    """Boundary data on St(n, k): `length` is the norm of the vector between the points, and of the velocities."""
    M, rng = Stiefel(n, k), np.random.default_rng(0)
    S0 = M.random_point(rng)
    V0 = M.random_tangent(S0, rng)
    V0 *= length / M.norm(S0, V0)
    S1 = M.exp(S0, V0)
    V1 = M.random_tangent(S1, rng)
    return S0, V0, S1, V1 * (length / M.norm(S1, V1))


@cache
def walk(count: int) -> tuple[Array, Array]:
    """Times and points on the sphere, shapes (count,) and (count, 3, 1)."""
    a, b = np.cumsum(np.random.default_rng(0).uniform(-0.3, 0.3, (2, count)), axis=1)
    S = np.stack([np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), np.sin(b)], axis=-1)[..., None]
    return np.arange(float(count)), S / np.linalg.norm(S, axis=1, keepdims=True)


def skew(m: int, scale: float) -> Array:
    """Random skew-symmetric matrix."""
    A = np.random.default_rng(0).standard_normal((m, m))
    return np.asarray(scale * (A - A.T))


@cache
def geometric() -> GeometricCubic:
    """A de Casteljau cubic on St(40, 10)."""
    return GeometricCubic(*ends(40, 10))


@cache
def initial() -> tuple[Array, Array, Array, Array]:
    """Initial data of a Riemannian cubic on St(60, 15)."""
    M, S = Stiefel(60, 15), ends(60, 15)[0]
    V, A, J = (M.random_tangent(S, seed) for seed in (1, 2, 3))
    return S, V, A, J


@cache
def cubic() -> RiemannianCubic:
    """The cubic of these data."""
    return RiemannianCubic.from_initial(*initial())


@cache
def slow_start() -> RiemannianCubic:
    """A cubic on the sphere whose data look cheap to integrate."""
    e = np.eye(3)
    return RiemannianCubic.from_initial(e[:, :1], e[:, 1:2], 0 * e[:, :1], 0 * e[:, :1])


@cache
def hermite() -> CubicHermite:
    """A curve of many pieces."""
    return CubicHermite(*walk(10_000), "catmull-rom", "geometric")


def hermite_call(num_threads: int | None) -> Call:
    """A curve of very many pieces."""
    t, S = walk(200_000)
    return partial(CubicHermite, t, S, 0 * S, num_threads=num_threads)


def log_call() -> Call:
    """Many logarithms of large points."""
    M, S = Stiefel(30, 10), ends(30, 10)[0]
    V = Stiefel(30, 10).random_tangent(S, 1)
    many = np.tile(S, (20_000, 1, 1))
    return partial(M.log, many, M.exp(many, V / M.norm(S, V)))


def exp_call() -> Call:
    """Many exponentials on a large manifold."""
    M, (S, V, _, _) = Stiefel(30, 10), ends(30, 10)
    return partial(M.exp, np.tile(S, (40_000, 1, 1)), V)


def periodic_call() -> Call:
    """A closed spline."""
    t, S = walk(30_000)
    return partial(CubicSpline, np.append(t, len(t)), np.concatenate([S, S[:1]]), "periodic")


def transport_call() -> Call:
    """Parallel transport along a geodesic of many turns."""
    M, (S, V, _, _) = Stiefel(60, 50), ends(60, 50)
    return partial(M.transport, S, 2e5 * V, V)


def variation_call() -> Call:
    """Derivatives of very many points."""
    S0, V0, *_ = ends(30, 10)
    curve = RiemannianCubic.from_initial(S0, V0, 0 * V0, V0)
    return partial(curve.point_variation, np.linspace(0, 1, 1_000_000), 0 * V0, V0, 0 * V0, 0 * V0)


@cache
def distant() -> tuple[Array, Array, Array]:
    """Times, points far from one another on St(5, 3), and fast velocities there: few, but the work of a second."""
    M = Stiefel(5, 3)
    S = M.random_point(0, 15)
    V = np.array([8.0 * M.random_tangent(s, seed) for seed, s in enumerate(S)])
    return np.arange(15.0), S, V


def rotations(members: int, count: int) -> tuple[Array, Array]:
    """Uneven times, and rotations far from one another as quaternions: few, but the work of half a second."""
    rng = np.random.default_rng(0)
    quaternions = rng.standard_normal((members, count, 4))
    return np.cumsum(rng.choice([1.0, 30.0], size=count)), quaternions


def rotations_call() -> Call:
    """One spline of rotations, in the calling thread."""
    t, quaternions = rotations(2, 48)
    return partial(RotationCurve, t, quaternions[0], num_threads=1)


# Matrices of a batch: 144 MB.
COUNT: Final = 200

# name -> function that makes the call; each takes some seconds, small ones half a second, or runs forever.
CALLS: Final[dict[str, Callable[[], Call]]] = {
    "integrate": lambda: partial(CHART.integrate, EQUATOR, 4_000_000),
    "integrate_batch": lambda: partial(CHART.integrate, np.tile(EQUATOR, (400, 1)), 10_000),
    "integrate_midpoint": lambda: partial(CHART.integrate, EQUATOR, 4_000_000, 1.0, "midpoint"),
    "shoot": lambda: partial(CHART.shoot, EQUATOR[:2], EQUATOR[2:4], [1.6, 0.1], EQUATOR[2:4], 2_000_000),
    "reference": lambda: partial(CHART.reference, EQUATOR, np.linspace(0, 1, 2_000_000)),
    "reference_far": lambda: partial(CHART.reference, [1.5, 0, 0, 1e3, 0, 0, 0, 0], [30.0]),
    "curve": lambda: partial(geometric(), np.linspace(0, 1, 100_000)),
    "curve_jerk": lambda: partial(geometric().jerk, np.linspace(0, 1, 20_000)),
    "curve_one_thread": lambda: partial(geometric().jerk, np.linspace(0, 1, 20_000), num_threads=1),
    "curve_cost": lambda: partial(GeometricCubic(*ends(240, 100)).cost),
    "skew_exp_batch": lambda: partial(skew_exp, np.tile(skew(300, 10.0), (COUNT, 1, 1))),
    "skew_exp_converted": lambda: partial(skew_exp, np.tile(skew(300, 10.0), (COUNT, 1, 1)).astype(np.float32)),
    "skew_exp_one": lambda: partial(skew_exp, skew(1500, 100.0)),
    "log_batch": lambda: partial(orthogonal_log, np.tile(skew_exp(skew(300, 0.1)), (COUNT, 1, 1))),
    "exponential": exp_call,
    "logarithm": log_call,
    "transport": transport_call,
    "spline": lambda: partial(CubicSpline, *walk(30_000)),
    "spline_large": lambda: partial(CubicSpline, np.arange(1000.0), Stiefel(60, 50).random_point(0, 1000)),
    "spline_geometric": lambda: partial(CubicSpline, *walk(30_000), kind="geometric"),
    "spline_periodic": periodic_call,
    "spline_small": lambda: partial(CubicSpline, *distant()[:2], "clamped"),
    "rotations_one_thread": rotations_call,
    "rotations_batch": lambda: partial(interpolated_rotations, *rotations(6, 16), max_iterations=20_000),
    "hermite": lambda: hermite_call(None),
    "hermite_small": lambda: partial(CubicHermite, *distant()),
    "hermite_one_thread": lambda: hermite_call(1),
    "smoothing": lambda: partial(SmoothingSpline, *walk(30_000), lam=1.0),
    "smoothing_small": lambda: partial(SmoothingSpline, *distant()[:2]),
    "smoothing_chosen": lambda: partial(SmoothingSpline, *walk(30_000)),
    "velocities": lambda: partial(estimate_velocities, *walk(200_000), "natural"),
    "arc_length": lambda: partial(hermite().arc_length),
    "cost": lambda: partial(hermite().cost),
    "derivative_bounds": lambda: partial(hermite().derivative_bounds),
    "resample": lambda: partial(hermite().resample, 10_000_000),
    "boundary": lambda: partial(RiemannianCubic.from_boundary, *ends(120, 30, 3.0)),
    "boundary_small": lambda: partial(RiemannianCubic.from_boundary, *ends(16, 4, 6.0)),
    "all_found": lambda: partial(RiemannianCubic.from_boundary, *ends(30, 10, 3.0), all_found=True),
    "minimal_cost": lambda: partial(GeometricPolynomial.minimal_cost, *ends(12, 10), degree=7),
    "geodesic": lambda: partial(Geodesic, ends(600, 300, 3.0)[0], ends(600, 300, 3.0)[2]),
    "splitting": lambda: partial(integrate_cubic, *ends(400, 40)[:2], *ends(400, 40)[1:2] * 2, 2000, order=8),
    "splitting_steps": lambda: partial(integrate_cubic, *ends(30, 10)[:2], *ends(30, 10)[1:2] * 2, 100_000),
    "embedded": lambda: partial(integrate_embedded, *ends(400, 40)[:2], *ends(400, 40)[1:2] * 2, 2000),
    "from_initial": lambda: partial(RiemannianCubic.from_initial, *initial(), t_end=100.0),
    "beyond": lambda: partial(cubic(), 60.0),
    "beyond_array": lambda: partial(cubic().jerk, np.linspace(0, 60, 200)),
    "restricted": lambda: partial(cubic().restricted, -60.0, 60.0),
    "many_points": lambda: partial(cubic().jerk, np.linspace(0, 1, 100_000)),
    "variation": variation_call,
}

# The arguments alone take a while to read; too large for the tests.
LARGE: Final[dict[str, Callable[[], Call]]] = {
    "skew_exp_large": lambda: partial(skew_exp, np.tile(skew(300, 10.0), (600, 1, 1))),
    "skew_exp_large_float32": lambda: partial(skew_exp, np.tile(skew(300, 10.0).astype(np.float32), (600, 1, 1))),
    "log_large": lambda: partial(orthogonal_log, np.tile(skew_exp(skew(300, 0.1)), (600, 1, 1))),
}
