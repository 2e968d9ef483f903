"""Geometric splines: compared with SciPy on the circle, smooth at the knots, near the spline of least cost."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline as Flat

from stiefel_rs import (
    ConvergenceError,
    CubicSpline,
    GeometricCubic,
    InvalidInputError,
    OutsideDomainError,
    Stiefel,
)

T = np.array([0.0, 0.7, 1.5, 3.0, 3.8, 5.0])
ANGLES = np.array([0.1, 0.5, 1.4, 0.9, 0.3, 0.1])

# Angles of size 5, a system of six unknowns.
ROUND_OFF = 1e-13


def circle(angle):
    """Points of St(2, 1)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)[..., None]


def walk(n, k, count, step=0.6, seed=0):
    """A random walk of points at unequal times."""
    manifold, rng = Stiefel(n, k), np.random.default_rng(seed + n + 100 * k)
    points = [manifold.random_point(rng)]
    for _ in range(count - 1):
        V = manifold.random_tangent(points[-1], rng)
        points.append(manifold.exp(points[-1], step * V / manifold.norm(points[-1], V)))
    return np.cumsum(rng.uniform(0.5, 1.5, count)), np.stack(points)


@pytest.mark.parametrize("bc_type", ["natural", "clamped", "periodic"])
def test_on_the_circle_it_is_scipys_spline_of_the_angle(bc_type):
    curve = CubicSpline(T, circle(ANGLES), bc_type, "geometric")
    flat = Flat(T, ANGLES, bc_type=bc_type)
    t = np.linspace(0, 5, 201)
    assert np.abs(curve(t) - circle(flat(t))).max() < ROUND_OFF
    rate = flat(t, 1)[:, None, None] * np.stack([-np.sin(flat(t)), np.cos(flat(t))], axis=-1)[..., None]
    assert np.abs(curve(t, 1) - rate).max() < 10 * ROUND_OFF


@pytest.mark.parametrize("shape", [(2, 1), (3, 2), (3, 3), (4, 2), (20, 2)])
def test_velocity_and_acceleration_are_continuous(shape):
    t, S = walk(*shape, 8)
    curve = CubicSpline(t, S, kind="geometric")
    assert curve.kind == "geometric"
    assert curve.report.converged
    assert curve.report.residual <= 1e-12
    assert all(type(piece) is GeometricCubic for piece in curve.pieces)
    assert np.abs(curve(t) - S).max() < 1e-12
    for i, (before, after) in enumerate(zip(curve.pieces[:-1], curve.pieces[1:], strict=True)):
        h0, h1 = np.diff(t)[i : i + 2]
        assert np.abs(before.velocity(1.0) / h0 - after.velocity(0.0) / h1).max() < 1e-12
        assert np.abs(before.acceleration(1.0) / h0**2 - after.acceleration(0.0) / h1**2).max() < 1e-10
    assert np.abs(curve.acceleration(t[[0, -1]])).max() < 1e-10


def test_it_is_near_the_spline_of_least_cost():
    t, S = walk(4, 2, 8)
    near, least = CubicSpline(t, S, kind="geometric"), CubicSpline(t, S)
    assert least.cost() <= near.cost() <= 1.1 * least.cost()
    u = np.linspace(t[0], t[-1], 50)
    assert 1e-6 < np.abs(near(u) - least(u)).max() < 0.05


def test_ends_and_extrapolation():
    t, S = walk(3, 2, 5)
    V = 0.5 * Stiefel(3, 2).random_tangent(S[[0, -1]], np.random.default_rng(1))
    curve = CubicSpline(t, S, ((1, V[0]), (2, V[1])), "geometric", extrapolate=True)
    assert np.abs(curve.velocity(t[0]) - V[0]).max() < 1e-12
    assert np.abs(curve.acceleration(t[-1]) - V[1]).max() < 1e-10
    assert np.isfinite(curve(t[-1] + 0.1)).all()
    with pytest.raises(InvalidInputError, match="extrapolate=True"):
        CubicSpline(t, S, kind="geometric")(t[-1] + 0.1)


def test_bad_input():
    t, S = walk(3, 1, 4)
    with pytest.raises(ConvergenceError) as caught:
        CubicSpline(t, S, kind="geometric", max_iterations=1)
    assert caught.value.report.iterations == 1
    S[2] = -S[1]
    with pytest.raises(OutsideDomainError) as caught:
        CubicSpline(t, S, kind="geometric")
    assert caught.value.knot == 1
    with pytest.raises(InvalidInputError, match="kind"):
        CubicSpline(t, S, kind="linear")
