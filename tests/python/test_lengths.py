"""Arc length, constant speed, bounds of derivatives."""

import copy
import itertools
import pickle

import numpy as np
import pytest
from scipy.integrate import quad

from stiefel_rs import (
    CubicHermite,
    CubicSpline,
    DerivativeBounds,
    Geodesic,
    GeometricCubic,
    InvalidInputError,
    QuasiGeodesic,
    RiemannianCubic,
    Stiefel,
)

M = Stiefel(4, 2)


def points(count, step=0.7, seed=3):
    rng = np.random.default_rng(seed)
    S = [M.random_point(rng)]
    for _ in range(count - 1):
        V = M.random_tangent(S[-1], rng)
        S.append(M.exp(S[-1], step * V / M.norm(S[-1], V)))
    return np.stack(S)


def curves():
    S, rng = points(5), np.random.default_rng(4)
    V = M.random_tangent(S, rng)
    t = [0, 1, 1.5, 3, 4]
    return {
        "quasi_geodesic": QuasiGeodesic(S[0], S[1]),
        "geodesic": Geodesic(S[0], S[1]),
        "geometric": GeometricCubic(S[0], V[0], S[1], V[1]),
        "riemannian": RiemannianCubic.from_initial(S[0], V[0], V[0] * 2, V[0] * -3, t_end=2.0),
        "spline": CubicSpline(t, S),
        "geometric_spline": CubicSpline(t, S, kind="geometric"),
        "hermite": CubicHermite(t, S, "akima"),
    }


CURVES = curves()


def speed(curve, t):
    return float(M.norm(curve(t), curve.velocity(t)))


@pytest.mark.parametrize("name", sorted(CURVES))
def test_lengths_are_integrals_of_the_speed(name):
    curve = CURVES[name]
    start, end = curve.t_span
    knots = getattr(curve, "t", [start, end])
    pieces = [quad(lambda t: speed(curve, t), a, b, epsabs=1e-10)[0] for a, b in itertools.pairwise(knots)]
    assert abs(curve.arc_length() - sum(pieces)) < 1e-9
    middle = start + 0.3 * (end - start)
    assert abs(curve.arc_length(start, middle) + curve.arc_length(middle) - curve.arc_length()) < 1e-12
    assert curve.arc_length(middle, middle) == 0.0


@pytest.mark.parametrize("name", sorted(CURVES))
def test_resampled_curves_have_constant_speed(name):
    curve = CURVES[name]
    t = curve.resample(25)
    assert t.shape == (25,)
    assert (t[0], t[-1]) == curve.t_span
    steps = [curve.arc_length(a, b) for a, b in itertools.pairwise(t)]
    assert np.abs(np.array(steps) - curve.arc_length() / 24).max() < 2e-12 * curve.arc_length()
    assert np.array_equal(t, curve.resample(25, num_threads=1))


@pytest.mark.parametrize("name", sorted(CURVES))
def test_bounds_hold_and_are_tight(name):
    curve = CURVES[name]
    bounds = curve.derivative_bounds()
    exact = name in ("riemannian", "spline", "hermite")
    assert bounds.guarantee == ("enclosure" if exact else "sampling")
    t = np.linspace(*curve.t_span, 4001)
    S, scale = curve(t), 0.0
    for bound, vectors in [
        (bounds.velocity, curve.velocity(t)),
        (bounds.acceleration, curve.acceleration(t)),
        (bounds.jerk, curve.jerk(t)),
    ]:
        largest = M.norm(S, vectors).max()
        assert largest <= bound * (1 + 1e-9) + 1e-11
        # The shortest leg takes half a unit of time.
        scale = largest + 2 * scale
        assert bound <= largest + 0.004 * scale + 1e-11


def test_bounds_can_be_kept():
    bounds = CURVES["riemannian"].derivative_bounds()
    for same in [
        pickle.loads(pickle.dumps(bounds)),
        copy.copy(bounds),
        eval(repr(bounds), {"DerivativeBounds": DerivativeBounds}),
    ]:
        assert repr(same) == repr(bounds)
    with pytest.raises(InvalidInputError):
        DerivativeBounds(1.0, 1.0, 1.0, "perhaps")


def test_lengths_of_more_pieces_than_panels_of_one():
    # Each piece of a great circle is two panels: 80000.
    t = 0.01 * np.arange(40_001)
    S = np.stack([np.cos(t), np.sin(t)], -1)[..., None]
    V = np.stack([-np.sin(t), np.cos(t)], -1)[..., None]
    curve = CubicHermite(t, S, V)
    assert abs(curve.arc_length() - 400.0) < 1e-12 * 400.0
    assert np.abs(curve.resample(5) - np.linspace(0.0, 400.0, 5)).max() < 1e-9


@pytest.mark.parametrize("kind", ["riemannian", "geometric"])
def test_times_far_from_zero(kind):
    # Seconds since 1970, with a spacing of 2.4e-7: lengths are accurate to that times the change of the speed.
    t, S = np.array([0.0, 1.0, 1.5, 3.0, 4.0]), points(5)
    near, far = CubicSpline(t, S, kind=kind), CubicSpline(t + 2.0**30, S, kind=kind)
    assert abs(far.arc_length() - near.arc_length()) < 1e-5
    assert np.abs(far.resample(9) - 2.0**30 - near.resample(9)).max() < 1e-5


def test_bad_input():
    curve = CURVES["geometric"]
    with pytest.raises(InvalidInputError):
        curve.arc_length(0.0, np.nan)
    with pytest.raises(InvalidInputError, match="t1"):
        curve.arc_length(1.0, 0.0)
    for count in [1, 0, -3]:
        with pytest.raises(InvalidInputError, match="count"):
            curve.resample(count)
    with pytest.raises(TypeError):
        curve.resample(2.5)
    with pytest.raises(InvalidInputError, match="extrapolate=True"):
        CURVES["spline"].arc_length(0.0, 5.0)


def test_more_points_than_fit_in_memory_are_refused():
    curve = QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]])
    with pytest.raises(InvalidInputError, match="count: must be small enough"):
        curve.resample(10**15)
