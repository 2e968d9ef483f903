"""Section 2.2 of arXiv 2404.19407 as printed: retractions, quasi-geodesics, Proposition 1 and Remark 1."""

import numpy as np
import pytest
from formulas import christoffel
from paper import (
    EPS,
    POINTS,
    SHAPES,
    VELOCITIES,
    assert_close,
    difference,
    expm,
    joining_pair,
    pair,
    point,
    quasi_geodesic,
    velocity,
)

from stiefel_rs import Geodesic, QuasiGeodesic, Stiefel

RETRACTIONS = ["quasi_geodesic", "qr", "polar", "cayley"]
TIMES = [0.0, 0.3, 1.0]


@pytest.fixture(params=SHAPES, ids=str)
def M(request):
    return Stiefel(*request.param)


@pytest.fixture(params=POINTS)
def S(request, M, rng):
    return point(M, request.param, rng)


@pytest.fixture(params=VELOCITIES)
def V(request, M, S, rng):
    return velocity(M, S, request.param, rng)


@pytest.mark.parametrize("kind", RETRACTIONS)
def test_definition_1_retraction(M, S, V, kind):
    assert_close(M.retract(S, 0 * V, kind), S, 8 * M.n * EPS, "(i) R_S(0) = S")
    slope = difference(lambda t: M.retract(S, t * V, kind), 0.0)
    # Truncation h^4 |V|^5 / 30, round-off n eps / h.
    assert_close(slope, V, 1e-12 + 16 * M.n * EPS / 1e-3, "(ii) dR_S(0) = I")


def test_definition_1_exponential(M, S, V):
    assert_close(M.exp(S, 0 * V), S, 8 * M.n * EPS, "(i) R_S(0) = S")
    slope = difference(lambda t: M.exp(S, t * V), 0.0)
    assert_close(slope, V, 1e-12 + 16 * M.n * EPS / 1e-3, "(ii) dR_S(0) = I")


def test_retraction_of_the_paper(M, S, V):
    X, Omega = pair(S, V)
    assert_close(M.retract(S, V), expm(X) @ S @ expm(Omega), 32 * M.n * EPS, "R_S(V) = e^X S e^Omega")


@pytest.mark.parametrize("t", TIMES)
def test_derivatives_of_the_quasi_geodesic(M, S, V, t):
    X, Omega = pair(S, V)
    left, right, bound = expm(t * X), expm(t * Omega), 32 * M.n * EPS
    beta = QuasiGeodesic.from_velocity(S, V)
    assert_close(beta(t), left @ S @ right, bound, "beta")
    assert_close(beta(t, 1), left @ (X @ S + S @ Omega) @ right, bound, "first derivative")
    second = left @ (X @ X @ S + 2 * X @ S @ Omega + S @ Omega @ Omega) @ right
    assert_close(beta(t, 2), second, bound, "second derivative")
    assert_close(beta(0.0), S, bound, "beta(0) = S")
    assert_close(beta.velocity(0.0), V, bound, "beta'(0) = V")


def test_eq_6_proposition_1_velocity(M, S, V):
    S1 = M.retract(S, V)
    X, Omega = joining_pair(S, S1)
    # At these angles, below 0.9 sqrt(2), the logarithm is accurate to a few n eps.
    assert_close(M.inverse_retract(S, S1), X @ S + S @ Omega, 32 * M.n * EPS, "X S_0 + S_0 Omega")
    assert_close(X, pair(S, V)[0], 32 * M.n * EPS, "X is that of the velocity")


@pytest.mark.parametrize("t", TIMES)
def test_eq_7_proposition_1_curve(M, S, V, t):
    S1 = M.retract(S, V)
    beta = QuasiGeodesic(S, S1)
    assert_close(beta(t), quasi_geodesic(S, *joining_pair(S, S1), t), 32 * M.n * EPS, f"beta({t})")
    assert_close(beta(1.0), S1, 32 * M.n * EPS, "beta(1) = S_1")


@pytest.mark.parametrize("length", [1e-12, 1e-6, 1e-2])
def test_remark_1_close_points_are_joined(M, S, rng, length):
    S1 = M.retract(S, velocity(M, S, "both parts", rng, length))
    X, Omega = joining_pair(S, S1)
    bound = 32 * M.n * EPS
    assert_close(expm(X) @ S @ expm(Omega), S1, bound, "the printed pair leads to S_1")
    assert_close(M.retract(S, M.inverse_retract(S, S1)), S1, bound, "the velocity of the library too")


def test_remark_1_one_part_gives_a_geodesic(M, S, rng):
    for kind in ("Omega = 0", "X = 0", "zero"):
        V = velocity(M, S, kind, rng)
        beta, geodesic = QuasiGeodesic.from_velocity(S, V), Geodesic.from_velocity(S, V)
        assert_close(beta(TIMES), geodesic(TIMES), 32 * M.n * EPS, f"{kind}: quasi-geodesic against geodesic")


@pytest.mark.parametrize("shape", [(3, 2), (5, 2)])
def test_remark_1_both_parts_give_no_geodesic_for_two_columns(shape, rng):
    M = Stiefel(*shape)
    S = M.random_point(rng)
    V = velocity(M, S, "both parts", rng)
    beta = QuasiGeodesic.from_velocity(S, V)
    acceleration = beta(0.0, 2) + christoffel(S, V, V)
    Omega = S.T @ V
    K = V - S @ Omega
    # Omega = [[0, -w], [w, 0]] only rotates K and scales it by w = |Omega| / sqrt(2).
    exact = np.linalg.norm(K) * np.linalg.norm(Omega) / np.sqrt(2)
    assert exact > 0.05
    assert_close(np.linalg.norm(acceleration), exact, 32 * M.n * EPS, "|D_t beta'| = |K| |Omega| / sqrt 2")
    apart = np.linalg.norm(beta(1.0) - Geodesic.from_velocity(S, V)(1.0))
    assert apart > 0.005, f"quasi-geodesic and geodesic end {apart:.3e} apart"


@pytest.mark.parametrize("shape", [(3, 1), (6, 1), (3, 3), (4, 4)])
def test_remark_1_spheres_and_rotations_have_geodesics_only(shape, rng):
    M = Stiefel(*shape)
    for kind in POINTS:
        S = point(M, kind, rng)
        V = velocity(M, S, "both parts", rng)
        X, Omega = pair(S, V)
        empty = Omega if M.k == 1 else X
        assert_close(empty, 0.0, 32 * M.n * EPS, "Omega for k = 1, X for k = n")
        beta, geodesic = QuasiGeodesic.from_velocity(S, V), Geodesic.from_velocity(S, V)
        assert_close(beta(TIMES), geodesic(TIMES), 32 * M.n * EPS, "quasi-geodesic against geodesic")
