"""Splines whose legs turn far, or whose times differ by large factors: on the circle, compared with SciPy's."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline as Flat

from stiefel_rs import CubicSpline, Stiefel

# Defects and jumps of legs of at most 1e-12, in the time of the shortest leg, and round-off of the evaluation.
MET = 1e-11


def circle(angle):
    """Points of St(2, 1)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)[..., None]


def turning(angle, rate):
    """Their velocities."""
    return rate * np.array([[-np.sin(angle)], [np.cos(angle)]])


def bending(flat):
    """The integral of the square of the second derivative of a cubic spline of flat space."""
    second = 6.0 * flat.c[0], 2.0 * flat.c[1]
    h = np.diff(flat.x)
    return np.sum(h * (second[1] ** 2 + second[0] * second[1] * h + second[0] ** 2 * h**2 / 3.0))


def largest_jump(curve, knots):
    """The largest jump of the covariant acceleration, relative to the largest one."""
    inner = np.asarray(knots[1:-1])
    before, after = curve.acceleration(np.nextafter(inner, -np.inf)), curve.acceleration(np.nextafter(inner, np.inf))
    return np.abs(after - before).max() / max(np.abs(before).max(), 1.0)


@pytest.mark.parametrize("rate", [10.0, 50.0])
def test_fast_ends_on_the_circle_are_the_spline_of_the_angle(rate):
    t, angles = np.arange(6.0), np.array([0.0, 0.8, 1.1, 0.7, 1.5, 1.2])
    ends = turning(angles[0], rate), turning(angles[-1], -rate)
    curve = CubicSpline(t, circle(angles), bc_type=tuple((1, v) for v in ends))
    at = np.linspace(0.0, 5.0, 5001)
    x, y = curve(at)[..., 0].T
    # The curve makes full turns between the knots, where these cost less than to brake and to turn back.
    turned = np.unwrap(np.arctan2(y, x))[::1000]
    flat, straight = (Flat(t, x, bc_type=((1, rate), (1, -rate))) for x in (turned, angles))
    # The angle is `rate` times as large.
    np.testing.assert_allclose(curve(at), circle(flat(at)), atol=rate * MET)
    assert curve.cost() == pytest.approx(bending(flat), rel=1e-9)
    assert bending(flat) < 0.5 * bending(straight)


@pytest.mark.parametrize("ratio", [200.0, 1000.0])
def test_times_that_differ_on_the_circle_are_those_of_the_spline_of_the_angle(ratio):
    t = np.cumsum([0.0, 1.0, 1.0 / ratio, 1.0, 1.0, 1.0 / ratio, 1.0])
    angles = np.array([0.0, 0.6, 0.6 + 0.3 / ratio, 1.0, 0.4, 0.4 - 0.2 / ratio, 0.9])
    flat = Flat(t, angles, bc_type="natural")
    curve = CubicSpline(t, circle(angles))
    at = np.linspace(t[0], t[-1], 101)
    np.testing.assert_allclose(curve(at), circle(flat(at)), atol=ratio * MET)


def test_a_closed_chain_of_far_frames_is_closed():
    manifold, rng = Stiefel(5, 3), np.random.default_rng(30)
    first = manifold.random_point(rng)
    directions = [manifold.random_tangent(first, rng) for _ in range(2)]
    u, v = (x / manifold.norm(first, x) for x in directions)
    turn = np.linspace(0.0, 2.0 * np.pi, 7)
    points = np.stack([manifold.exp(first, 1.5 * (np.cos(a) * u + np.sin(a) * v)) for a in turn])
    points[-1] = points[0]
    t = np.arange(7.0)
    curve = CubicSpline(t, points, bc_type="periodic")
    np.testing.assert_allclose(curve(t), points, atol=MET)
    for nu in (1, 2):
        np.testing.assert_allclose(curve(t[0], nu), curve(t[-1], nu), atol=1e-9)
    assert largest_jump(curve, t) < 1e-10


# From 1e6 on, the third derivative of the short leg changes accelerations by 1e-10 between neighbouring floats.
@pytest.mark.parametrize("ratio", [1e3, 1e4])
def test_accelerations_do_not_jump_between_uneven_legs_in_many_dimensions(ratio):
    manifold, rng = Stiefel(5, 3), np.random.default_rng(104)
    points = [manifold.random_point(rng)]
    # The same speed on every leg.
    t = np.array([0.0, 1.0, 1.0 + 1.0 / ratio, 2.0])
    for length in np.diff(t):
        V = manifold.random_tangent(points[-1], rng)
        points.append(manifold.exp(points[-1], length * V / manifold.norm(points[-1], V)))
    curve = CubicSpline(t, np.stack(points))
    assert largest_jump(curve, t) < 1e-10


def test_far_points_with_more_rows_are_joined_by_a_descent():
    # Legs in the embedding do not converge; with frames there are 29 dimensions.
    manifold, rng = Stiefel(16, 2), np.random.default_rng(0)
    points = [manifold.random_point(rng)]
    for _ in range(6):
        v = manifold.random_tangent(points[-1], rng)
        points.append(manifold.exp(points[-1], 1.9 * v / manifold.norm(points[-1], v)))
    t = np.array([0.0, 1.0, 4.0, 5.0, 9.0, 10.0, 14.0])
    curve = CubicSpline(t, np.array(points))
    assert curve.report.strategy == "descent"
    np.testing.assert_allclose(curve(t), points, atol=1e-13)
    assert largest_jump(curve, t) < MET
