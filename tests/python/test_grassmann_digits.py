"""The Grassmann manifold compared with its formulas, with at least 50 digits."""

import itertools

import mpmath
import numpy as np
import pytest
import scipy.linalg
from test_grassmann import CURVED, EPS, assert_close, separated

from stiefel_rs import Grassmann

# 2 n columns contain any two of these subspaces.
ANGLES = [1e-300, 1e-160, 1e-8, 1.0, np.pi / 2 - 1e-8]


def exact(A):
    return mpmath.matrix(np.asarray(A).tolist())


def floats(A):
    return np.array([[float(x) for x in row] for row in A.tolist()])


def thin_svd(V):
    """`V = Q S W^T` with 50 digits, S as a list."""
    Q, S, Wt = mpmath.svd_r(V, full_matrices=False)
    return Q, list(S), Wt.T


def diag(values):
    return mpmath.diag(values)


def orthonormal(Y):
    """The orthonormal basis of the span of `Y` nearest to it, with 50 digits: the exact point that floats represent."""
    U, _, Vt = mpmath.svd_r(Y, full_matrices=False)
    return U * Vt


def exp_exact(Y, V):
    Q, S, W = thin_svd(V)
    return (Y * W * diag([mpmath.cos(s) for s in S]) + Q * diag([mpmath.sin(s) for s in S])) * W.T


def transport_exact(Y, V, X):
    Q, S, W = thin_svd(V)
    turned = Q * diag([mpmath.cos(s) - 1 for s in S]) - Y * W * diag([mpmath.sin(s) for s in S])
    return X + turned * (Q.T * X)


def log_exact(Y0, Y1):
    """Thin decomposition of `(I - Y0 Y0^T) Y1 (Y0^T Y1)^{-1}`, and its arctangents."""
    M = Y0.T * Y1
    Q, S, W = thin_svd((Y1 - Y0 * M) * M**-1)
    return Q * diag([mpmath.atan(s) for s in S]) * W.T


@pytest.fixture
def digits():
    # Enough for squares of 1e-300, and for quotients of numbers near 1 by them.
    with mpmath.workdps(700):
        yield


POINTS = {
    "line": (np.array([[1.0], [0], [0]]), np.array([[0.0], [0.6], [0.8]])),
    "columns": (np.eye(4, 2), np.eye(4, 2, -2)),
    "more": (np.eye(3, 2), np.array([[0.0, 0.0], [0.0, 0.0], [0.6, 0.8]])),
}


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("name", POINTS)
def test_exp_log_dist_and_transport_with_many_digits(name, angle, digits):
    Y, N = POINTS[name]
    M = Grassmann(*Y.shape)
    V = angle * N
    end = exp_exact(exact(Y), exact(V))
    assert_close(M.exp(Y, V), floats(end), 4 * EPS, "exp")
    # Each number to high relative accuracy, including those of size 1e-300.
    relative = np.abs(M.exp(Y, V) - floats(end)) / np.maximum(np.abs(floats(end)), 1e-320)
    assert relative[N != 0].max() <= 8 * EPS, f"{relative[N != 0].max():.3e}"
    Y1 = floats(end)
    velocity = floats(log_exact(exact(Y), exact(Y1)))
    # An angle of pi/2 - a is accurate to eps, and so is its direction, unless there are two: then it is accurate to eps
    # / a.
    loss = 1 / np.cos(angle) if name == "columns" else 1.0
    assert_close(M.log(Y, Y1), velocity, 8 * EPS * angle * loss, "log, relative to its size")
    length = float(mpmath.norm(log_exact(exact(Y), exact(Y1))))
    assert_close(M.dist(Y, Y1), length, 8 * EPS * length, "dist, relative to its size")
    X = np.array([[0.0, 0.0], [0.0, 0.0], [0.3, -1.2], [0.7, 0.4]])[: M.n, : M.k] * (M.n == 4)
    X = X if M.n == 4 else M.project_tangent(Y, np.array([[0.2], [-0.5], [0.9]]) * np.ones((1, M.k)))
    assert_close(M.transport(Y, V, X), floats(transport_exact(exact(Y), exact(V), exact(X))), 16 * EPS, "transport")


@pytest.mark.parametrize("angle", ANGLES[:4])
def test_small_angles_in_dense_bases(angle, digits, rng):
    # The bases differ by exact rotations: signed permutations and 3-4-5 triangles.
    for n, k in [(4, 2), (6, 3), (5, 3)]:
        M, count = Grassmann(n, k), min(k, n - k)
        Y0, N = np.eye(n, k), np.eye(n, k, -k) * (np.arange(k) < count)
        turn = scipy.linalg.block_diag([[0.6, 0.8], [-0.8, 0.6]], np.eye(k - 2))[:, rng.permutation(k)]
        Y1 = floats(exp_exact(exact(Y0), exact(angle * N))) @ turn
        velocity = floats(log_exact(exact(Y0), exact(Y1)))
        assert_close(M.log(Y0, Y1), velocity, 16 * EPS * angle, "log")
        assert_close(M.principal_angles(Y0, Y1)[:count], angle, 16 * EPS * angle, "angles")


def test_angles_of_all_sizes_at_once(digits):
    """Each to high relative accuracy."""
    angles = np.array([np.pi / 2 - 1e-8, 1.0, 1e-8, 1e-160, 1e-300])
    for order in itertools.permutations(range(5), 5):
        if order[0] not in (0, 4):
            continue
        theta = angles[list(order)]
        Y0, Y1 = np.eye(10, 5), np.vstack([np.diag(np.cos(theta)), np.diag(np.sin(theta))])
        M = Grassmann(10, 5)
        measured = M.principal_angles(Y0, Y1)
        assert np.abs(measured / angles - 1).max() <= 4 * EPS, f"{measured}"
        V = M.log(Y0, Y1)
        assert_close(np.diag(V[5:]) / theta, 1.0, 4 * EPS, "each column of the logarithm")
        assert_close(M.dist(Y0, Y1), np.linalg.norm(angles), 4 * EPS, "dist")
        assert_close(M.exp(Y0, V), Y1, 4 * EPS, "exp of the logarithm")


@pytest.mark.parametrize("shape", CURVED, ids=str)
def test_log_of_dense_points_with_many_digits(shape, digits, rng):
    curved = Grassmann(*shape)
    for angles in [[0.3, 0.7, 1.1, 1.3], [1e-3, 1e-6], [0.5], [1.5, 0.2]]:
        Y0, Y1, _, full = separated(curved, angles, rng)
        velocity = log_exact(orthonormal(exact(Y0)), orthonormal(exact(Y1)))
        bound = 20 * curved.n * EPS / np.cos(full.max())
        assert_close(curved.log(Y0, Y1), floats(velocity), bound, f"angles {angles}")
