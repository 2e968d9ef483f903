"""Riemannian exponential, logarithm, distance and geodesics from Python."""

import copy
import pickle

import numpy as np
import pytest
import scipy.linalg

from stiefel_rs import (
    ConvergenceError,
    Geodesic,
    InvalidInputError,
    LogReport,
    OutsideDomainError,
    Stiefel,
)


def tangent(M, S, length, rng):
    V = M.random_tangent(S, rng)
    return V * (length / M.norm(S, V))[..., None, None]


def reference_exp(S, V):
    """The canonical geodesic at 1 by SciPy's exponential of the n x n generator."""
    omega = S.T @ V
    K = V - S @ omega
    return scipy.linalg.expm(S @ omega @ S.T + K @ S.T - S @ K.T) @ S


def test_exp_against_scipy(manifold, rng):
    S = manifold.random_point(rng)
    for length in [1e-6, 0.5, 3.0]:
        V = tangent(manifold, S, length, rng)
        np.testing.assert_allclose(manifold.exp(S, V), reference_exp(S, V), atol=1e-13)


@pytest.mark.parametrize("metric", ["canonical", "euclidean", 0.5])
def test_log_inverts_exp_in_batches(manifold, rng, metric):
    M = Stiefel(manifold.n, manifold.k, metric=metric)
    S = M.random_point(rng, size=(3, 4))
    V = tangent(M, S, 1.2, rng)
    E = M.exp(S, V)
    assert E.shape == V.shape
    W, report = M.log(S, E, full_output=True)
    np.testing.assert_allclose(W, V, atol=1e-12)
    np.testing.assert_array_equal(W, M.log(S, E))
    np.testing.assert_allclose(M.dist(S, E), 1.2, atol=1e-12)
    for field, kind in [
        ("converged", np.bool_),
        ("iterations", np.int64),
        ("residual", np.float64),
        ("length", np.float64),
        ("certainly_shortest", np.bool_),
    ]:
        values = getattr(report, field)
        assert values.shape == (3, 4)
        assert values.dtype == kind
    assert report.converged.all()
    assert report.iterations.max() <= 10
    assert report.residual.max() < 1e-12
    np.testing.assert_allclose(report.length, 1.2, atol=1e-12)
    single, one = M.log(S[1, 2], E[1, 2], full_output=True)
    np.testing.assert_array_equal(single, W[1, 2])
    assert one.length == report.length[1, 2]


def test_broadcasting(rng):
    M = Stiefel(5, 2)
    S = M.random_point(rng)
    V = tangent(M, np.broadcast_to(S, (6, 5, 2)), 0.7, rng)
    E = M.exp(S, V)
    assert E.shape == (6, 5, 2)
    np.testing.assert_allclose(M.log(S, E), V, atol=1e-13)
    assert M.dist(S, E).shape == (6,)
    assert M.dist(E[:, None], E).shape == (6, 6)
    np.testing.assert_allclose(np.diag(M.dist(E[:, None], E)), 0, atol=1e-13)
    empty = M.log(S, np.zeros((0, 5, 2)))
    assert empty.shape == (0, 5, 2)


def test_report_of_a_single_pair(rng):
    M = Stiefel(6, 3)
    S = M.random_point(rng)
    V = tangent(M, S, 0.5, rng)
    _, report = M.log(S, M.exp(S, V), full_output=True)
    assert isinstance(report, LogReport)
    assert report.converged is True
    assert isinstance(report.iterations, int)
    assert 1 <= report.iterations <= 4
    assert isinstance(report.residual, float)
    assert isinstance(report.length, float)
    assert report.certainly_shortest is True
    for copied in [pickle.loads(pickle.dumps(report)), copy.copy(report)]:
        assert repr(copied) == repr(report)
    assert repr(report).startswith("LogReport(converged=True, iterations=")


def test_certainty_ends_at_the_bound(rng):
    M = Stiefel(50, 5)
    S = M.random_point(rng)
    for length, certain in [(0.89 * np.pi, True), (0.9 * np.pi, False)]:
        V = tangent(M, S, length, rng)
        W, report = M.log(S, M.exp(S, V), full_output=True)
        np.testing.assert_allclose(W, V, atol=1e-11)
        assert report.certainly_shortest is certain


def test_distance_on_the_sphere_is_the_angle(rng):
    M = Stiefel(4, 1)
    S = M.random_point(rng, size=50)
    E = M.random_point(rng, size=50)
    angle = np.arccos(np.sum(S * E, axis=(-2, -1)))
    np.testing.assert_allclose(M.dist(S, E), angle, atol=1e-13)


def test_bad_pairs():
    M = Stiefel(4, 1)
    e = np.eye(4)[:, :1]
    with pytest.raises(OutsideDomainError) as caught:
        M.log(e, -e)
    assert caught.value.angle == pytest.approx(np.pi)
    with pytest.raises(OutsideDomainError, match="batch member 1"):
        M.dist(e, np.stack([e, -e]))
    with pytest.raises(OutsideDomainError, match="components"):
        Stiefel(3, 3).log(np.eye(3), np.diag([1.0, 1.0, -1.0]))
    with pytest.raises(OutsideDomainError):
        Geodesic(e, -e)
    square = Stiefel(4, 2)
    S = np.eye(4)[:, :2]
    with pytest.raises(InvalidInputError, match="S1"):
        square.log(S, 1.1 * S)
    with pytest.raises(InvalidInputError, match="not finite"):
        square.log(S * np.nan, S)
    with pytest.raises(InvalidInputError, match="expected shape"):
        square.log(S, np.eye(3)[:, :2])
    with pytest.raises(InvalidInputError, match="not tangent"):
        square.exp(S, S)
    with pytest.raises(TypeError):
        square.exp(S, 1j * S)
    # An angle above the largest floating-point number.
    V = np.zeros((4, 2))
    V[2, 0] = V[3, 0] = 1.7e308
    with pytest.raises(InvalidInputError, match="too large"):
        square.exp(S, V)


def test_random_pairs_are_solved_or_refused(rng):
    """Haar-random pairs, mostly far beyond the injectivity radius: a geodesic between them, or a typed error."""
    M = Stiefel(8, 4)
    solved = 0
    for _ in range(30):
        S, E = M.random_point(rng), M.random_point(rng)
        try:
            V, report = M.log(S, E, full_output=True)
        except (ConvergenceError, OutsideDomainError) as error:
            if isinstance(error, ConvergenceError):
                # The search ran, and its best geodesic misses the end.
                assert error.report.iterations > 0
                assert error.report.residual > 1e-11
                assert not error.report.converged
            continue
        solved += 1
        assert report.converged
        np.testing.assert_allclose(M.exp(S, V), E, atol=1e-11)
        np.testing.assert_allclose(M.norm(S, V), report.length, atol=1e-11)
    assert solved >= 20


def test_geodesic_is_a_curve(boundary, manifold):
    S0, _, S1, _ = boundary
    curve = Geodesic(S0, S1)
    t = np.linspace(0, 1, 7)
    P = curve(t)
    np.testing.assert_allclose(P[0], S0, atol=1e-14)
    np.testing.assert_allclose(P[-1], S1, atol=1e-13)
    np.testing.assert_allclose(curve.acceleration(t), 0, atol=1e-13)
    np.testing.assert_allclose(curve.jerk(t), 0, atol=1e-12)
    speed = manifold.norm(P, curve.velocity(t))
    np.testing.assert_allclose(speed, curve.length, atol=1e-13)
    np.testing.assert_allclose(curve.length, manifold.dist(S0, S1), atol=1e-13)
    assert curve.cost() < 1e-24
    assert curve.t_span == (0.0, 1.0)
    assert repr(curve) == f"<Geodesic on St({manifold.n}, {manifold.k}), t_span (0.0, 1.0)>"


def test_geodesic_from_velocity(manifold, rng):
    S = manifold.random_point(rng)
    V = tangent(manifold, S, 2.0, rng)
    for metric in [None, "canonical", "euclidean", 1.5]:
        curve = Geodesic.from_velocity(S, V, metric=metric)
        M = Stiefel(manifold.n, manifold.k, metric=metric)
        np.testing.assert_allclose(curve(0.0, nu=1), V, atol=1e-14)
        np.testing.assert_allclose(curve(1.0), M.exp(S, V), atol=1e-14)
        np.testing.assert_allclose(curve.length, M.norm(S, V), atol=1e-13)
    with pytest.raises(InvalidInputError, match="metric"):
        Geodesic.from_velocity(S, V, metric="round")
