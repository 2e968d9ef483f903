"""Bounds of the rates of splines of rotations, against dense samples; and neighbours nearly half a turn apart."""

import numpy as np
import pytest
from rotation_problems import AXIS, about, product, random_quaternion, same, turned, wander
from scipy.interpolate import CubicSpline as Flat

from stiefel_rs import OutsideDomainError, PoseSpline, RotationSpline, Stiefel
from stiefel_rs.rotation_input import matrices_of

# Bounds exceed the largest norms by at most 1e-3, or by 1e-4 of a smaller order where that is more.
LOOSE = 2e-3
EPS = np.finfo(float).eps


def spline_of(name):
    t, q = wander(6, seed=3)
    match name:
        case "smoothing":
            return RotationSpline.smoothing(t, q, lam=1e-2)
        case "hermite":
            return RotationSpline.hermite(t, q, np.random.default_rng(0).standard_normal((6, 3)))
        case "tension":
            return RotationSpline(t, q, tension=2.0)
        case "poses":
            return PoseSpline(t, (q, np.zeros((6, 3)))).rotation_spline
        case _:
            return RotationSpline(t, q, name)


@pytest.mark.parametrize("name", ["natural", "clamped", "tension", "smoothing", "hermite", "poses"])
def test_bounds_are_those_of_dense_rates(name):
    spline = spline_of(name)
    bounds = spline.curve.derivative_bounds()
    assert bounds.guarantee == "enclosure"
    x = np.linspace(*spline.t_span, 5001)
    w, a, jerk = (spline(x, order) for order in (1, 2, 3))
    # The covariant jerk differs from the derivative of the body acceleration.
    for bound, vectors in [
        (bounds.velocity, w),
        (bounds.acceleration, a),
        (bounds.jerk, jerk + np.cross(w, a) / 2),
    ]:
        largest = np.linalg.norm(vectors, axis=1).max()
        assert largest * (1 - 1e-12) <= bound <= largest * (1 + LOOSE), (bound, largest)


def test_norms_of_the_curve_are_those_of_the_rates():
    # The canonical norm; the norm of the matrices, of Frobenius, is sqrt(2) times as large.
    spline, x, M = spline_of("natural"), 2.0, Stiefel(3, 3)
    S = spline.curve(x)
    for order, V in enumerate((spline.curve.velocity(x), spline.curve.acceleration(x)), 1):
        length = np.linalg.norm(spline(x, order))
        assert M.norm(S, V) == pytest.approx(length, rel=1e-12)
        assert np.linalg.norm(V) == pytest.approx(np.sqrt(2) * length, rel=1e-12)


# Largest error of rotations nearly half a turn apart: entries of matrices.
NEAR_PI = 64 * EPS


def about_pi(short, seed=0):
    """Angles about one axis, whose first two are pi less `short` apart, and the rotations."""
    angle = np.array([0.0, np.pi - short, np.pi - short + 0.3])
    return angle, product(random_quaternion(seed), turned(angle))


@pytest.mark.parametrize("short", [1e-3, 1e-6, 1e-9, 1e-12, 1e-14])
@pytest.mark.parametrize("kind", ["quaternions", "matrices"])
@pytest.mark.parametrize("seed", [0, 1])
def test_neighbours_nearly_half_a_turn_apart(short, kind, seed):
    angle, q = about_pi(short, seed)
    t, x = np.array([0.0, 1.0, 2.5]), np.linspace(0, 2.5, 26)
    spline = RotationSpline(t, q if kind == "quaternions" else matrices_of(q))
    # The short way, by the spline of the angle.
    flat = Flat(t, angle, bc_type="natural")
    wanted = matrices_of(product(random_quaternion(seed), turned(flat(x))))
    same(spline(x) if kind == "matrices" else matrices_of(spline(x)), wanted, NEAR_PI)
    same(spline(x, 1), flat(x, 1)[:, None] * AXIS, NEAR_PI)
    # At lam = 0, smoothing interpolates, to its tolerance of 1e-11.
    near = RotationSpline.smoothing(t, q, lam=0)
    same(matrices_of(near(x)), wanted, 1e-10)


CALLS = {
    "spline": RotationSpline,
    "matrices": lambda t, q: RotationSpline(t, matrices_of(q)),
    "poses": lambda t, q: PoseSpline(t, (q, np.zeros((len(t), 3)))),
    "smoothing": RotationSpline.smoothing,
    "smoothing, lam": lambda t, q: RotationSpline.smoothing(t, q, lam=1e-3),
    "smoothing, lam = 0": lambda t, q: RotationSpline.smoothing(t, q, lam=0.0),
    "smoothing, lam = inf": lambda t, q: RotationSpline.smoothing(t, q, lam=np.inf),
}


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("axis", ["z", "other"])
def test_neighbours_half_a_turn_apart(call, axis):
    # The second pair.
    half = np.array([0, 0, 1.0, 0]) if axis == "z" else np.array([*AXIS, 0])
    first = np.array([0, 0, 0, 1.0]) if axis == "z" else random_quaternion(2)
    middle = product(first, about(np.array([0.1, 0.2, -0.3])))
    q = np.stack([first, middle, product(middle, half), product(product(middle, half), turned(0.2))])
    with pytest.raises(OutsideDomainError, match=r"knots 1 and 2: .*pi to working precision") as caught:
        CALLS[call](np.arange(4.0), q)
    assert caught.value.knot == 1
    # Refused within 12 EPS of pi.
    assert abs(caught.value.angle - np.pi) <= 12 * EPS
