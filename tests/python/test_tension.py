"""Cubics and splines in tension: closed forms on a circle, SciPy's splines for zero tension, files, errors."""

import copy
import pickle

import numpy as np
import pytest
from scipy.interpolate import CubicSpline as Flat
from spline_problems import walk

from stiefel_rs import (
    CubicSpline,
    InvalidInputError,
    RiemannianCubic,
    Stiefel,
    integrate_cubic,
    load,
)


def circle(angle):
    """Points at angles, shape (..., 2, 1)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)[..., None]


def along(angle):
    """Unit tangent vectors there."""
    return np.stack([-np.sin(angle), np.cos(angle)], axis=-1)[..., None]


def hyperbolic(theta, t):
    """1, t, cosh(theta t), sinh(theta t) and their first three derivatives: shape (4, 4)."""
    c, s = np.cosh(theta * t), np.sinh(theta * t)
    rows = [[1, t, c, s], [0, 1, theta * s, theta * c]]
    return np.array(rows + [[0, 0, theta**n * x, theta**n * y] for n, x, y in ((2, c, s), (3, s, c))])


@pytest.mark.parametrize("theta", [0.3, 2.0, 7.0])
def test_rest_to_rest_on_a_circle(theta):
    conditions = np.stack([*hyperbolic(theta, 0.0)[:2], *hyperbolic(theta, 1.0)[:2]])
    c = np.linalg.solve(conditions, [0.0, 0.0, 2.0, 0.0])
    rest = np.zeros((2, 1))
    curve = RiemannianCubic.from_boundary(circle(0.0), rest, circle(2.0), rest, tension=theta**2)
    assert curve.tension == theta**2
    for t in (0.1, 0.5, 0.8):
        angle, rate, second, third = hyperbolic(theta, t) @ c
        assert np.allclose(curve(t), circle(angle), atol=1e-11)
        assert np.allclose(curve.velocity(t), rate * along(angle), atol=1e-10)
        assert np.allclose(curve.acceleration(t), second * along(angle), atol=1e-9)
        assert np.allclose(curve.jerk(t), third * along(angle), atol=1e-8)


def test_no_tension_is_the_cubic():
    M, rng = Stiefel(5, 2), np.random.default_rng(3)
    S0, S1 = M.random_point(rng, 2)
    V0, V1 = M.random_tangent(S0, rng), M.random_tangent(S1, rng)
    t = np.linspace(0, 1, 7)
    for tension in (0.0, 0):
        curve = RiemannianCubic.from_boundary(S0, V0, S1, V1, tension=tension)
        assert np.array_equal(curve(t), RiemannianCubic.from_boundary(S0, V0, S1, V1)(t))
        assert curve.tension == 0.0
    near = RiemannianCubic.from_boundary(S0, V0, S1, V1, tension=1e-9)
    assert np.allclose(near(t), curve(t), atol=1e-8)


def test_spline_on_a_circle_tends_to_straight_legs():
    t, angle = np.arange(6.0), np.array([0.0, 0.7, 0.2, -0.5, 0.4, 0.1])
    dense = np.linspace(0, 5, 101)

    def angles(tension):
        return np.unwrap(np.arctan2(*CubicSpline(t, circle(angle), tension=tension)(dense)[..., ::-1, 0].T))

    assert np.allclose(angles(0.0), Flat(t, angle, bc_type="natural")(dense), atol=1e-12)
    straight = np.interp(dense, t, angle)
    gaps = [np.abs(angles(tension) - straight).max() for tension in (0.0, 1.0, 10.0, 60.0)]
    assert gaps == sorted(gaps, reverse=True)
    # An infinite polygon with the corner c is rounded by c / (2 theta).
    corner = np.abs(np.diff(angle, 2)).max()
    assert gaps[-1] < corner / (2 * np.sqrt(60))


@pytest.mark.parametrize("shape", [(2, 1), (3, 1), (3, 2), (3, 3), (5, 2), (6, 3)])
def test_splines_up_to_the_largest_tension_are_found(shape):
    t, S = walk(*shape, 7, seed=3)
    longest = np.diff(t).max()
    for leg_tension in (5.0, 9.0, 11.0, 20.0, 35.0, 63.0):
        curve = CubicSpline(t, S, tension=leg_tension / longest**2)
        assert np.abs(curve(t) - S).max() < 1e-11
        before, after = t[1:-1] - 1e-13, t[1:-1]
        # Jerks are at most 100.
        assert np.abs(curve.acceleration(before) - curve.acceleration(after)).max() < 1e-9


@pytest.mark.parametrize("shape", [(3, 2), (6, 3), (4, 4)])
def test_splines_of_the_reversed_knots_and_in_other_units(shape):
    M, rng = Stiefel(*shape), np.random.default_rng(5)
    S = [M.random_point(rng)]
    for _ in range(4):
        V = M.random_tangent(S[-1], rng)
        S.append(M.retract(S[-1], 0.7 * V / M.norm(S[-1], V)))
    S, t = np.array(S), np.array([0.0, 1.0, 1.8, 2.5, 4.0])
    curve = CubicSpline(t, S, tension=3.0)
    x = np.linspace(0, 4, 33)
    assert np.allclose(CubicSpline(4 - t[::-1], S[::-1], tension=3.0)(4 - x), curve(x), atol=1e-11)
    fast = CubicSpline(t / 1000, S, tension=3e6)
    assert np.allclose(fast(x / 1000), curve(x), atol=1e-11)
    Q = np.linalg.qr(rng.standard_normal((M.n, M.n)))[0]
    assert np.allclose(CubicSpline(t, Q @ S, tension=3.0)(x), Q @ curve(x), atol=1e-11)


def test_splitting_meets_the_taylor_method():
    M, rng = Stiefel(4, 2), np.random.default_rng(1)
    S = M.random_point(rng)
    V, A, J = (M.random_tangent(S, rng) for _ in range(3))
    curve = RiemannianCubic.from_initial(S, V, A, J, tension=9.0)
    trajectory = integrate_cubic(S, V, A, J, 200, order=8, tension=9.0)
    assert np.allclose(trajectory.point, curve(trajectory.t), atol=1e-11)
    assert np.allclose(trajectory.energy, curve.energy, rtol=1e-9)
    assert trajectory.momentum_drift < 1e-12


def test_files_and_pickles_keep_tension(tmp_path):
    rest = np.zeros((2, 1))
    curve = RiemannianCubic.from_boundary(circle(0.0), rest, circle(1.0), rest, tension=5.0)
    spline = CubicSpline([0, 1, 2.0], circle(np.array([0, 1, 0.3])), tension=5.0, extrapolate=True)
    for original in (curve, spline):
        original.save(tmp_path / "curve.npz")
        for again in (load(tmp_path / "curve.npz"), pickle.loads(pickle.dumps(original)), copy.copy(original)):
            t = np.linspace(*original.t_span, 9)
            assert np.array_equal(again(t), original(t))
            # Beyond the end, the equation continues with its tension.
            end = original.t_span[1]
            assert np.array_equal(again(end + 0.3), original(end + 0.3))
    # Each piece is parametrised by [0, 1]; the first leg takes 1.
    assert load(tmp_path / "curve.npz").pieces[0].tension == pytest.approx(5.0)


@pytest.mark.parametrize("tension", [-1.0, np.nan, np.inf, -1e-300])
def test_tensions_that_are_none(tension):
    S, V = np.eye(3)[:, :1], np.eye(3)[:, 1:2]
    calls = [
        lambda: RiemannianCubic.from_initial(S, V, V, V, tension=tension),
        lambda: RiemannianCubic.from_boundary(S, V, V, S, tension=tension),
        lambda: CubicSpline([0, 1], [S, V], tension=tension),
        lambda: integrate_cubic(S, V, V, V, 3, tension=tension),
    ]
    for call in calls:
        with pytest.raises(InvalidInputError, match="tension"):
            call()


def test_too_much_tension_says_how_much_may_be():
    S, V = np.eye(3)[:, :1], np.eye(3)[:, 1:2]
    with pytest.raises(InvalidInputError, match=r"tension.*64"):
        RiemannianCubic.from_boundary(S, V, V, S, tension=65.0)
    with pytest.raises(InvalidInputError, match=r"tension.*64"):
        CubicSpline([0, 1, 3], [S, V, S], tension=20.0)
    with pytest.raises(InvalidInputError, match="tension"):
        CubicSpline([0, 1, 3], [S, V, S], kind="geometric", tension=0.1)
