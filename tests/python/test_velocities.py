"""Velocities from points: SciPy's formulas on the circle, Hermite curves from them, bad input."""

import numpy as np
import pytest
from scipy.interpolate import Akima1DInterpolator
from scipy.interpolate import CubicSpline as Flat

from stiefel_rs import CubicHermite, InvalidInputError, OutsideDomainError, Stiefel, estimate_velocities

METHODS = ["catmull-rom", "akima", "natural"]
T = np.array([0.0, 0.4, 1.5, 2.1, 3.0, 3.3, 4.4])
ANGLES = np.array([0.1, 0.9, 1.2, 0.3, -1.3, -2.2, -3.9])

# Angles of size 4, slopes of size 10.
ROUND_OFF = 1e-13


def circle(angle):
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)[..., None]


def rates(t, angle, method, **ask):
    """Angular velocities."""
    S = circle(angle)
    V = estimate_velocities(t, S, method, **ask)
    assert V.shape == S.shape
    assert np.abs((V * S).sum(axis=(1, 2))).max() < ROUND_OFF
    return V[:, 1, 0] * S[:, 0, 0] - V[:, 0, 0] * S[:, 1, 0]


def three_points(t, angle):
    """Derivatives of the parabolas through three neighbours."""
    places = [min(max(i - 1, 0), len(t) - 3) for i in range(len(t))]
    fits = [np.polyfit(t[p : p + 3] - t[i], angle[p : p + 3], 2) for i, p in enumerate(places)]
    return np.array([fit[1] for fit in fits])


@pytest.mark.parametrize("count", [3, 4, 7])
def test_on_the_circle_they_are_those_of_the_angle(count):
    t, angle = T[:count], ANGLES[:count]
    akima = Akima1DInterpolator(t, angle, method="makima")(t, 1)
    assert np.abs(rates(t, angle, "akima") - akima).max() < ROUND_OFF
    natural = Flat(t, angle, bc_type="natural")(t, 1)
    assert np.abs(rates(t, angle, "natural") - natural).max() < ROUND_OFF
    assert np.abs(rates(t, angle, "catmull-rom") - three_points(t, angle)).max() < 10 * ROUND_OFF


@pytest.mark.parametrize("method", METHODS)
def test_two_points_have_the_slope_between_them(method):
    assert np.abs(rates(T[:2], ANGLES[:2], method) - 2.0).max() < ROUND_OFF


def test_closed_curves():
    angle = np.append(ANGLES[:6], ANGLES[0])
    periodic = Flat(T, angle, bc_type="periodic")(T, 1)
    assert np.abs(rates(T, angle, "natural", closed=True) - periodic).max() < ROUND_OFF
    for method in METHODS:
        found = rates(T, angle, method, closed=True)
        assert abs(found[0] - found[-1]) < ROUND_OFF
    with pytest.raises(InvalidInputError) as caught:
        estimate_velocities(T, circle(ANGLES), closed=True)
    assert caught.value.knot == 6


@pytest.mark.parametrize("kind", ["riemannian", "geometric"])
@pytest.mark.parametrize("method", METHODS)
def test_hermite_curves_take_the_name_of_a_method(method, kind):
    manifold, rng = Stiefel(4, 2), np.random.default_rng(2)
    S = [manifold.random_point(rng)]
    for _ in range(4):
        V = manifold.random_tangent(S[-1], rng)
        S.append(manifold.exp(S[-1], 0.6 * V / manifold.norm(S[-1], V)))
    t = [0, 1, 1.5, 3, 4]
    V = estimate_velocities(t, S, method)
    curve = CubicHermite(t, S, method, kind)
    assert np.array_equal(curve.velocities, V)
    assert np.array_equal(CubicHermite(t, S, V, kind)(2.0), curve(2.0))
    assert np.abs(curve.velocity(t) - V).max() < 1e-11


def test_bad_input():
    S = circle(ANGLES)
    for method in ["makima", "", "Natural"]:
        with pytest.raises(InvalidInputError, match="catmull-rom"):
            estimate_velocities(T, S, method)
        with pytest.raises(InvalidInputError, match="catmull-rom"):
            CubicHermite(T, S, method)
    with pytest.raises(InvalidInputError):
        estimate_velocities(T[:3], S)
    with pytest.raises(InvalidInputError) as caught:
        estimate_velocities(T[::-1], S)
    assert caught.value.knot == 1
    with pytest.raises(TypeError, match="seconds"):
        estimate_velocities(T.astype("timedelta64[s]"), S)
    S[3] = -S[2]
    with pytest.raises(OutsideDomainError) as caught:
        estimate_velocities(T, S)
    assert caught.value.knot == 2
