"""Section 3 of arXiv 2404.19407 as printed: Problem 1, (8) to (10), X_0 .. X_5, Omega_0 .. Omega_5, Theorem 1."""

import numpy as np
import pytest
from paper import EPS, POINTS, SHAPES, VELOCITIES, Theorem1, assert_close, difference, point, velocity

from stiefel_rs import GeometricCubic, QuasiGeodesic, Stiefel

TIMES = [0.0, 0.25, 0.6, 1.0]
# The first point, and the part that both velocities lack.
CASES = [(POINTS[0], VELOCITIES[0]), *((POINTS[1], kind) for kind in VELOCITIES)]


@pytest.fixture(params=SHAPES, ids=str)
def M(request):
    return Stiefel(*request.param)


@pytest.fixture(params=CASES, ids=", ".join)
def data(request, M, rng):
    """`S_0, V_0, S_3, V_3`: points at distance 0.7, velocities of length up to 0.6."""
    start, kind = request.param
    S0 = point(M, start, rng)
    S3 = M.retract(S0, velocity(M, S0, "both parts", rng, 0.7))
    return S0, velocity(M, S0, kind, rng, 0.6), S3, velocity(M, S3, kind, rng, 0.6)


@pytest.fixture
def printed(data):
    return Theorem1(*data)


@pytest.fixture
def curve(data):
    return GeometricCubic(*data)


@pytest.fixture
def bound(M):
    """Six logarithms in a row, each exact to a few n eps at these angles."""
    return 32 * M.n * EPS


@pytest.fixture
def assert_pair(M, bound):
    """Check that a printed pair agrees with the library's between two points."""

    def check(ends, pair, what):
        start, end = ends
        found = M.decompose(start, M.inverse_retract(start, end))
        for matrix, exact, name in zip(found, pair, ("X", "Omega"), strict=True):
            assert_close(matrix, exact, bound, f"{name} of {what}")

    return check


def test_eq_8_problem_1(data, curve, bound):
    S0, V0, S3, V3 = data
    ends = [(curve(0.0), S0), (curve(1.0), S3), (curve.velocity(0.0), V0), (curve.velocity(1.0), V3)]
    for (found, exact), name in zip(ends, ("S_0", "S_3", "V_0", "V_3"), strict=True):
        assert_close(found, exact, bound, name)


def test_eq_9_first_control_point(M, data, printed, curve, bound):
    S0, V0 = data[:2]
    for found, exact in zip(M.decompose(S0, V0 / 3), (printed.X0, printed.O0), strict=True):
        assert_close(found, exact, bound, "X_0, Omega_0")
    assert_close(curve.control_points[1], printed.S1, bound, "S_1")


def test_eq_10_second_control_point(M, data, printed, curve, bound):
    S3, V3 = data[2:]
    for found, exact in zip(M.decompose(S3, -V3 / 3), (printed.X2, printed.O2), strict=True):
        assert_close(found, exact, bound, "X_2, Omega_2")
    assert_close(curve.control_points[2], printed.S2, bound, "S_2")


def test_x_1_and_omega_1(printed, curve, assert_pair):
    _, S1, S2, _ = curve.control_points
    assert_pair((S1, S2), (printed.X1, printed.O1), "the middle leg")


@pytest.mark.parametrize("t", TIMES)
def test_x_3_to_omega_5(printed, curve, assert_pair, t):
    S0, S1, S2, S3 = curve.control_points
    X3, O3, X4, O4, X5, O5 = printed.stages(t)
    b01, b12, b23 = (QuasiGeodesic(a, b)(t) for a, b in ((S0, S1), (S1, S2), (S2, S3)))
    assert_pair((b01, b12), (X3, O3), "stage 2, first pair")
    assert_pair((b12, b23), (X4, O4), "stage 2, second pair")
    b012, b123 = QuasiGeodesic(b01, b12)(t), QuasiGeodesic(b12, b23)(t)
    assert_pair((b012, b123), (X5, O5), "stage 3")


@pytest.mark.parametrize("t", TIMES)
def test_eq_11_theorem_1_curve(printed, curve, bound, t):
    assert_close(curve(t), printed(t), bound, f"gamma({t})")


def test_theorem_1_the_printed_curve_solves_problem_1(M, data, printed, bound):
    S0, V0, S3, V3 = data
    assert_close(printed(0.0), S0, bound, "gamma(0) = S_0")
    assert_close(printed(1.0), S3, bound, "gamma(1) = S_3")
    h = 3e-4
    # Truncation h^4 / 30 times the fifth derivative, up to 10^3, below the round-off of the points over h.
    slope = bound / h
    assert_close(difference(printed, 0.0, h), V0, slope, "gamma'(0) = V_0")
    assert_close(difference(printed, 1.0, h), V3, slope, "gamma'(1) = V_3")


def test_theorem_1_equal_points_at_rest(M, rng):
    for kind in POINTS:
        S = point(M, kind, rng)
        rest = np.zeros_like(S)
        for found in (Theorem1(S, rest, S, rest)(0.5), GeometricCubic(S, rest, S, rest)(0.5)):
            assert_close(found, S, 32 * M.n * EPS, "the constant curve")
