"""Finite input of any size: a finite result or a typed error, never a NaN, a panic, or an endless loop."""

import itertools
import re
import subprocess
import sys
import warnings
from functools import partial

import numpy as np
import pytest
from beside import HANGS
from hypothesis import given, settings
from hypothesis import strategies as st
from public_calls import CALLS, S1, SPHERE, V1, Z0, S, V, flat, replaced

from stiefel_rs import (
    CubicHermite,
    Geodesic,
    GeometricCubic,
    InvalidInputError,
    QuasiGeodesic,
    RiemannianCubic,
    SmoothingSpline,
    StiefelError,
    skew_exp,
)


def finite_or_typed(call):
    """Whether there is a result: finite, without a warning. Otherwise it must be one of the documented exceptions."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            result = call()
        except (StiefelError, TypeError, ValueError) as error:
            assert "nan" not in str(error).lower().replace("found nan", ""), f"a NaN in the message: {error}"
            return False
    for x in flat(result):
        assert np.isfinite(x).all(), f"finite input, result {x}"
    return True


EXTREME = [5e-324, 1e-310, 1e-160, 1e100, 1e155, 1e200, 1e308]


# The reference takes its 100 000 steps before it fails, a minute each; far parameters have a separate test.
QUICK = [call for call in CALLS if call not in ("reference", "jerk")]

# Minimal number of extreme arguments with a result: three quarters of those that have one now. The other functions have
# none: points with scaled entries are invalid, and states of a chart are at its pole.
ACCEPTED = {
    "skew_exp": 6,
    "check_tangent": 8,
    "project": 4,
    "project_tangent": 9,
    "inner": 15,
    "norm": 7,
    "decompose": 8,
    "compose": 12,
    "retract": 8,
    "retract_qr": 7,
    "retract_polar": 7,
    "retract_cayley": 4,
    "transport": 12,
    "curvature": 20,
    "sectional_curvature": 13,
    "gradient_of": 10,
    "hessian_of": 26,
    "Grassmann.check_tangent": 8,
    "Grassmann.project": 4,
    "Grassmann.project_tangent": 10,
    "Grassmann.inner": 15,
    "Grassmann.norm": 7,
    "Grassmann.exp": 8,
    "Grassmann.transport": 15,
    "Grassmann.curvature": 20,
    "Grassmann.sectional_curvature": 13,
    "Grassmann.gradient": 10,
    "Grassmann.hessian": 27,
    "from_velocity": 8,
    "GeometricCubic": 9,
    "from_initial": 15,
    "from_boundary": 9,
    "CubicHermite": 4,
    "CubicHermite.geometric": 4,
    "CubicSpline": 3,
    "CubicSpline.geometric": 3,
    "estimate_velocities": 3,
    "bc_type": 4,
    "exp": 7,
    "Geodesic.from_velocity": 8,
    "curve": 9,
    "embed": 3,
    "embed_velocity": 14,
    "momenta": 27,
    "shoot": 9,
    "guess": 15,
}


@pytest.mark.parametrize("call", QUICK)
def test_extreme_scales(call):
    # |entries| stay below 1.8e308: the input is finite.
    accepted = 0
    for (i, (_, value)), scale in itertools.product(enumerate(CALLS[call][1]), EXTREME):
        scaled = value * (scale / max(1.0, np.abs(value).max()))
        for changed in (scaled, np.full_like(value, scale)):
            accepted += finite_or_typed(partial(replaced, call, i, changed))
    assert accepted >= ACCEPTED.get(call, 0)


@pytest.mark.parametrize("t_end", [1e3, 1e100, 1e308, -1e308])
@pytest.mark.parametrize("name", ["initial_point", "midpoint"])
def test_huge_times(t_end, name):
    finite_or_typed(lambda: SPHERE.integrate(Z0, 3, t_end, name))
    finite_or_typed(lambda: SPHERE.shoot(*Z0.reshape(4, 2)[[0, 1, 0, 1]], 3, name, t_end=t_end).trajectory)


def circle(angles):
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)[..., None]


@pytest.mark.parametrize("unit", [1e-310, 1e-160, 1e-105, 1e100, 1e300])
@pytest.mark.parametrize("kind", ["riemannian", "geometric"])
def test_derivatives_of_splines_in_any_unit_of_time(kind, unit):
    t = np.array([0.0, 1.0, 2.5]) * unit
    curve = CubicHermite(t, circle(np.array([0.0, 0.5, 0.5])), np.zeros((3, 2, 1)), kind)
    for nu in (1, 2, 3):
        finite_or_typed(lambda nu=nu: curve([0.5 * unit, unit, 2.0 * unit], nu))
    # At rest, in any unit.
    assert not curve(2.0 * unit, 2).any()
    with np.errstate(over="ignore"):
        expected = CubicHermite(t / unit, curve.points, np.zeros((3, 2, 1)), kind)(0.5, 1) / unit
    if np.isfinite(expected).all():
        assert np.abs(curve(0.5 * unit, 1) / expected - 1.0).max() < 1e-12
    else:
        with pytest.raises(InvalidInputError, match=r"derivative of a spline: .*too large"):
            curve(0.5 * unit, 1)


@pytest.mark.parametrize("unit", [1e-160, 1e300])
def test_a_chosen_lambda_that_is_no_number(unit):
    angles = np.array([0.0, 0.5, 0.4, 0.9, 1.1, 1.0])
    assert SmoothingSpline(np.arange(6.0), circle(angles)).lam > 0.0
    with pytest.raises(InvalidInputError, match="t: must be in a unit of time"):
        SmoothingSpline(np.arange(6.0) * unit, circle(angles))
    # A curve that exists in one unit need not exist in others.
    assert SmoothingSpline(np.arange(6.0) * unit, circle(angles), lam=0.0).lam == 0.0


def test_variations_too_large_for_a_number():
    curve = RiemannianCubic.from_boundary(S, V, S1, V1)
    zero = 0.0 * V
    finite_or_typed(lambda: curve.point_variation(3.0, zero, zero, zero, 1e300 * V1))
    with pytest.raises(InvalidInputError, match=r"variation of a Riemannian cubic: .*too large"):
        curve.point_variation(3.0, zero, 8e307 * V, zero, zero)
    for size in (1e290, 1e300, 1e306, 8e307):
        finite_or_typed(lambda size=size: curve.initial_variation(zero, size * V, zero, size * V1))


@pytest.mark.parametrize("scale", EXTREME)
@pytest.mark.parametrize("nu", [0, 1, 2, 3])
def test_extreme_curves(scale, nu):
    for call in (
        lambda: QuasiGeodesic.from_velocity(S, V * (scale / 2))([0.0, 0.5, 1.0], nu),
        lambda: QuasiGeodesic(S, S1)([scale, -scale], nu),
        lambda: GeometricCubic(S, V * (scale / 2), S1, V1)([0.0, 0.5, 1.0], nu),
    ):
        assert finite_or_typed(call) or scale > 1.0, "small is not too much"


@pytest.mark.parametrize("method", ["curve({t}, 0)", "curve({t}, 1)", "curve({t}, 3)", "curve.jerk({t})"])
@pytest.mark.parametrize("t", [1e16, 1e155, 1e200, 1e308])
def test_far_parameters_return(t, method):
    # In a separate process: an endless loop in compiled code cannot be stopped from inside.
    code = f"""
import numpy as np
from stiefel_rs import GeometricCubic, StiefelError
S, V = np.eye(4, 2), np.array([[0, -1], [1, 0], [2, 0], [0, -1.0]])
curve = GeometricCubic(S, V, S, V)
try:
    print(bool(np.isfinite({method.format(t=t)}).all()))
except StiefelError:
    print(True)
"""
    try:
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=HANGS, check=False)
    except subprocess.TimeoutExpired:
        pytest.fail(f"{method.format(t=t)} does not return")
    assert done.stdout == "True\n", f"{method.format(t=t)}: {done.stdout}{done.stderr[-300:]}"


@pytest.mark.parametrize("scale", EXTREME)
def test_extreme_costs(scale):
    curve = QuasiGeodesic.from_velocity(S, V * (scale / 2))
    assert finite_or_typed(curve.cost) or scale > 1.0, "small is not too much"
    if scale >= 1e155:
        with pytest.raises(StiefelError):
            curve.cost()
            pytest.fail(f"the cost is beyond 1e308, returned {curve.cost()}")


@pytest.mark.parametrize("scale", EXTREME)
def test_measures_of_extreme_curves_blame_no_argument_that_nobody_gave(scale):
    curves = [
        QuasiGeodesic.from_velocity(S, V * (scale / 2)),
        QuasiGeodesic(S, S1),
        *(Geodesic.from_velocity(S, V * size) for size in (min(scale / 2, 1e3), 1.0)),
        RiemannianCubic.from_initial(S, V * min(scale, 5e3), 0 * V, 0 * V),
    ]
    for curve in curves:
        for measure in (curve.derivative_bounds, curve.cost, curve.arc_length):
            try:
                measure()
            except StiefelError as error:
                assert not re.match(r"[A-Z][a-z0-9]?: ", str(error)), f"{curve}: {error}"


@pytest.mark.parametrize("m", [2, 3, 4, 5, 9])
@pytest.mark.parametrize("scale", EXTREME)
def test_exponential_of_extreme_matrices_is_a_rotation(m, scale, rng):
    A = rng.standard_normal((m, m))
    A -= A.T
    A = A / np.abs(A).max()
    if scale > 1 and np.linalg.norm(A, 2) > np.finfo(float).max / scale:
        with pytest.raises(InvalidInputError, match="too large"):  # an angle is not finite any more
            skew_exp(A * scale)
        return
    R = skew_exp(A * scale)
    defect = np.linalg.norm(R.T @ R - np.eye(m))
    assert defect <= m * 1e-15, f"orthogonality defect {defect:.3e} at entries of {scale}"


numbers = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False),
    st.sampled_from([0.0, -0.0, 1.0, -1.0, np.pi, np.pi / 2, 1e-16, 1e16]),
    st.floats(-4, 4),
)


@pytest.mark.parametrize(
    "call", [c for c in CALLS if c not in ("random_tangent", "reference", "shoot", "guess", "jerk")]
)
@given(data=st.data())
@settings(deadline=None, max_examples=60)
def test_any_finite_input_gives_a_finite_result_or_a_typed_error(call, data):
    function, args = CALLS[call]
    assert finite_or_typed(lambda: function(*[value for _, value in args])), "good arguments are refused"
    values = []
    for _, value in args:
        noise = np.array(data.draw(st.lists(numbers, min_size=value.size, max_size=value.size))).reshape(value.shape)
        second = np.arange(value.size).reshape(value.shape) == 1
        # Valid values, valid values with one entry replaced, and noise.
        values.append(data.draw(st.sampled_from([value, np.where(second, noise, value), noise])))
    finite_or_typed(lambda: function(*values))


@given(
    st.lists(numbers, min_size=16, max_size=16),
    st.lists(numbers, min_size=4, max_size=4),
    st.sampled_from(["initial_point", "midpoint"]),
    st.sampled_from([1.0, -1.0, 1e-8, 10.0]),
)
@settings(deadline=None, max_examples=100)
def test_shooting_at_anything(entries, guess, name, t_end):
    for points in [entries[:8], np.mod(entries[8:], 3.0)]:
        ends = np.array(points).reshape(4, 2)
        finite_or_typed(lambda ends=ends: SPHERE.shoot(*ends, 4, name, t_end=t_end).trajectory)
        finite_or_typed(lambda ends=ends: SPHERE.shoot(*ends, 4, name, guess=(guess[:2], guess[2:])).trajectory)
