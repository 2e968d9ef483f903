"""Features that users of SciPy's interpolators expect: `extrapolate`, `derivative`, rounding at the ends, `w`."""

import numpy as np
import pytest

from stiefel_rs import (
    CubicHermite,
    CubicSpline,
    CurveDerivative,
    GeometricCubic,
    InvalidInputError,
    PoseSpline,
    RiemannianCubic,
    RotationSpline,
    SmoothingSpline,
    Stiefel,
    load,
)

M = Stiefel(5, 2)
S = M.random_point(rng=0)
V = 0.3 * M.random_tangent(S, rng=1)
POINTS = np.stack([S, M.exp(S, V), M.exp(S, 2 * V), M.exp(S, 2.5 * V)])
KNOTS = np.array([0.1, 0.2, 0.5, 0.7])
BEYOND = [0.05, 0.75]
SPLINES = {
    "CubicSpline": lambda **kw: CubicSpline(KNOTS, POINTS, **kw),
    "geometric": lambda **kw: CubicSpline(KNOTS, POINTS, kind="geometric", **kw),
    "CubicHermite": lambda **kw: CubicHermite(KNOTS, POINTS, "akima", **kw),
    "SmoothingSpline": lambda **kw: SmoothingSpline(KNOTS, POINTS, lam=1e-6, **kw),
}
CUBIC = RiemannianCubic.from_boundary(S, V, POINTS[1], 0 * V)


@pytest.mark.parametrize("name", SPLINES)
def test_extrapolation_is_chosen_for_the_curve_or_for_a_call(name):
    within, beyond = SPLINES[name](), SPLINES[name](extrapolate=True)
    for t in BEYOND:
        with pytest.raises(InvalidInputError, match=f"found {t}"):
            within(t)
        with pytest.raises(InvalidInputError, match=f"found {t}"):
            beyond(t, extrapolate=False)
        np.testing.assert_array_equal(within(t, extrapolate=True), beyond(t))
        for method in ("velocity", "acceleration", "jerk"):
            found = getattr(within, method)(t, extrapolate=True)
            np.testing.assert_array_equal(found, getattr(beyond, method)(t))
            with pytest.raises(InvalidInputError):
                getattr(beyond, method)(t, extrapolate=False)
    inside = np.linspace(*within.t_span, 9)
    for choice in (None, True, False):
        np.testing.assert_array_equal(within(inside, extrapolate=choice), beyond(inside))
    assert not within.extrapolate and beyond.extrapolate


def test_curves_that_go_on_can_be_held_to_their_interval():
    for curve in (CUBIC, GeometricCubic(S, V, POINTS[1], 0 * V)):
        np.testing.assert_array_equal(curve(1.01, extrapolate=True), curve(1.01))
        with pytest.raises(InvalidInputError, match=r"between 0 and 1 unless extrapolate=True, found 1\.01"):
            curve([0.5, 1.01], extrapolate=False)


@pytest.mark.parametrize("name", SPLINES)
def test_a_few_units_beyond_an_end_count_as_the_end(name):
    curve = SPLINES[name]()
    first, last = curve.t_span
    for end, away in ((first, -np.inf), (last, np.inf)):
        t = end
        for _ in range(3):
            t = np.nextafter(t, away)
        for nu in range(3):
            np.testing.assert_array_equal(curve(t, nu), curve(end, nu))
        np.testing.assert_array_equal(curve([0.3, t], extrapolate=False), curve([0.3, end]))
    # The last time is larger than the last knot.
    times = np.arange(0.1, 0.75, 0.1)
    assert times[-1] > last
    assert curve(times).shape == (7, 5, 2)
    with pytest.raises(InvalidInputError):
        curve(last + 1e-13)


def test_derivative_is_a_function():
    velocity = CUBIC.derivative()
    assert isinstance(velocity, CurveDerivative) and velocity.t_span == (0.0, 1.0)
    t = np.array([0.2, 0.9])
    np.testing.assert_array_equal(velocity(t), CUBIC(t, 1))
    np.testing.assert_array_equal(velocity(t, 1), CUBIC(t, 2))
    np.testing.assert_array_equal(velocity.derivative()(t), CUBIC(t, 2))
    np.testing.assert_array_equal(CUBIC.derivative(3)(t), CUBIC(t, 3))
    np.testing.assert_array_equal(CUBIC.derivative(0)(t), CUBIC(t))
    with pytest.raises(InvalidInputError, match="extrapolate"):
        velocity(1.5, extrapolate=False)
    for wrong in (lambda: CUBIC.derivative(4), lambda: velocity(t, 3), lambda: CUBIC.derivative(-1)):
        with pytest.raises(InvalidInputError, match="order must be from 0 to 3"):
            wrong()


def test_weights_have_scipys_name_too():
    weights = np.array([1.0, 2.0, 1.0, 3.0])
    one, other = (SmoothingSpline(KNOTS, POINTS, lam=1e-3, **{name: weights}) for name in ("weights", "w"))
    np.testing.assert_array_equal(one(0.3), other(0.3))
    assert np.abs(one(0.3) - SmoothingSpline(KNOTS, POINTS, lam=1e-3)(0.3)).max() > 1e-9
    with pytest.raises(TypeError, match="not both"):
        SmoothingSpline(KNOTS, POINTS, weights, w=weights)


def test_a_saved_spline_goes_on_where_it_is_asked_to(tmp_path):
    curve = SPLINES["CubicSpline"]()
    curve.save(tmp_path / "curve.npz")
    np.testing.assert_array_equal(load(tmp_path / "curve.npz")(0.8, extrapolate=True), curve(0.8, extrapolate=True))


def test_reprs_say_what_a_curve_is():
    assert repr(SPLINES["geometric"]()) == "<CubicSpline on St(5, 2), geometric, 4 knots, t_span (0.1, 0.7)>"
    words = "<GeometricCubic on St(5, 2), degree 3 of quasi_geodesic pieces, t_span (0.0, 1.0)>"
    assert repr(GeometricCubic(S, V, POINTS[1], 0 * V)) == words


def test_splines_of_rotations_and_poses_have_these_arguments_too(rng):
    t = np.linspace(0.0, 3.0, 6)
    q, p = [0, 0, 0, 1] + 0.2 * rng.normal(size=(6, 4)), rng.normal(size=(6, 3))
    for make, data in ((RotationSpline, q), (PoseSpline, (q, p))):
        within, beyond = make(t, data, extrapolate=False), make(t, data)
        for wrong in (lambda within=within: within(3.5), lambda beyond=beyond: beyond(3.5, extrapolate=False)):
            with pytest.raises(InvalidInputError, match=r"found 3\.5"):
                wrong()
        for one, other in zip(within(3.5, extrapolate=True), beyond(3.5), strict=True):
            np.testing.assert_array_equal(one, other)
        with pytest.raises(InvalidInputError, match=r"found 3\.5"):
            within(3.5)
        weights = np.linspace(1.0, 2.0, 6)
        smooth = make.smoothing(t, data, lam=1e-3, w=weights)
        for one, other in zip(smooth(1.3), make.smoothing(t, data, lam=1e-3, weights=weights)(1.3), strict=True):
            np.testing.assert_array_equal(one, other)
        with pytest.raises(TypeError, match="either weights or w"):
            make.smoothing(t, data, w=weights, weights=weights)
    np.testing.assert_array_equal(
        RotationSpline(t, q, extrapolate=False)(3.5, 1, extrapolate=True), RotationSpline(t, q)(3.5, 1)
    )
