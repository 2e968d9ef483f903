"""Section 2.1 of arXiv 2404.19407 as printed: the functional, equations (1) to (5), projections of rank k."""

import numpy as np
import pytest
from formulas import bracket, christoffel
from paper import EPS, POINTS, SHAPES, VELOCITIES, assert_close, inner, pair, point, velocity
from scipy.linalg import null_space

from stiefel_rs import GeometricCubic, QuasiGeodesic, RiemannianCubic, Stiefel


@pytest.fixture(params=SHAPES, ids=str)
def M(request):
    return Stiefel(*request.param)


@pytest.fixture(params=POINTS)
def S(request, M, rng):
    return point(M, request.param, rng)


@pytest.fixture(params=VELOCITIES)
def V(request, M, S, rng):
    return velocity(M, S, request.param, rng)


def functional(curve):
    """The paper's J, with the covariant acceleration from ambient derivatives, by Gauss-Legendre quadrature."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    total = 0.0
    for t, w in zip((nodes + 1) / 2, weights / 2, strict=True):
        S, A = curve(t), curve(t, 2) + christoffel(curve(t), curve(t, 1), curve(t, 1))
        total += w * inner(S, A, A)
    return total


def test_functional_of_a_curve(M, S, rng):
    V0 = velocity(M, S, "both parts", rng)
    S1 = M.retract(S, velocity(M, S, "both parts", rng))
    V1 = velocity(M, S1, "both parts", rng)
    for curve in (GeometricCubic(S, V0, S1, V1), RiemannianCubic.from_boundary(S, V0, S1, V1)):
        exact = functional(curve)
        # Both quadratures see values of about |A|^2 with errors of a few n eps each.
        assert_close(curve.cost(), exact, 256 * M.n * EPS * max(1.0, exact), "J")


def test_functional_of_a_curve_at_rest_and_of_a_geodesic(M, S, rng):
    for kind in ("zero", "X = 0", "Omega = 0"):
        curve = QuasiGeodesic.from_velocity(S, velocity(M, S, kind, rng))
        for J in (curve.cost(), functional(curve)):
            # The square of an acceleration that is zero up to n eps.
            assert_close(J, 0.0, (32 * M.n * EPS) ** 2, f"J of a geodesic, {kind}")


def test_eq_1_points(M, S):
    assert_close(S.T @ S, np.eye(M.k), 8 * M.n * EPS, "S^T S = I")
    M.check_point(S, atol=8 * M.n * EPS)
    assert 1 <= M.k <= M.n


def test_projections_of_rank_k(M, S):
    P = S @ S.T
    assert_close(P, P.T, 0.0, "P = P^T")
    assert_close(P @ P, P, 16 * M.n * EPS, "P^2 = P")
    assert np.linalg.matrix_rank(P) == M.k


def test_generators_at_a_projection(M, S, V):
    X, _ = M.decompose(S, V)
    P, bound = S @ S.T, 32 * M.n * EPS
    assert_close(X, -X.T, 0.0, "X is skew")
    assert_close(X @ P + P @ X, X, bound, "X P + P X = X")
    # [X, P] is the velocity of P = S S^T.
    assert_close(bracket(X, P), V @ S.T + S @ V.T, bound, "[X, P] against the derivative of S S^T")


def test_eq_2_tangent_space(M, S, V):
    assert_close(V.T @ S + S.T @ V, 0.0, 16 * M.n * EPS, "V^T S + S^T V = 0")
    M.check_tangent(S, V, atol=16 * M.n * EPS)


def test_eq_2_dimension(M, S):
    basis = np.eye(M.n * M.k).reshape(-1, M.n, M.k)
    equations = np.stack([(E.T @ S + S.T @ E).ravel() for E in basis], axis=1)
    assert null_space(equations, rcond=1e-10).shape[1] == M.dim


def test_eq_3_every_pair_gives_a_tangent_vector(M, S, rng):
    P, A, B = S @ S.T, *rng.standard_normal((2, M.n, M.n))
    Q = np.eye(M.n) - P
    # The part of a skew matrix with X P + P X = X.
    X = P @ (A - A.T) @ Q + Q @ (A - A.T) @ P
    Omega = (B - B.T)[: M.k, : M.k]
    V, bound = X @ S + S @ Omega, 64 * M.n * EPS
    assert_close(V.T @ S + S.T @ V, 0.0, bound, "X S + S Omega is tangent")
    assert_close(M.compose(S, X, Omega), V, bound, "compose")
    for found, exact, name in zip(M.decompose(S, V), (X, Omega), ("X", "Omega"), strict=True):
        assert_close(found, exact, bound, f"{name} comes back")
    assert M.k * (M.n - M.k) + M.k * (M.k - 1) // 2 == M.dim


def test_eq_4_pair_of_a_tangent_vector(M, S, V):
    X, Omega = pair(S, V)
    bound = 32 * M.n * EPS
    for found, exact, name in zip(M.decompose(S, V), (X, Omega), ("X", "Omega"), strict=True):
        assert_close(found, exact, bound, name)
    assert_close(X @ S + S @ Omega, V, bound, "V = X S + S Omega")


def test_eq_5_metric(M, S, V, rng):
    W = velocity(M, S, "both parts", rng)
    bound = 16 * M.n * M.k * EPS
    assert_close(M.inner(S, V, W), inner(S, V, W), bound, "inner product")
    # Squares, since the square root of a round-off zero is not round-off.
    assert_close(M.norm(S, V) ** 2, inner(S, V, V), bound, "norm")


def test_eq_5_is_the_canonical_metric(M):
    canonical = Stiefel(M.n, M.k, metric="canonical")
    assert canonical == M
    assert canonical.alpha == 0.0
