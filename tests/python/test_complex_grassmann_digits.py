"""Complex subspaces compared with their formulas, with 50 digits and complex singular values."""

import itertools

import mpmath
import numpy as np
import pytest
from complex_frames import EPS, assert_close, normal, unitary
from test_complex_grassmann import separated

from stiefel_rs import Grassmann

ANGLES = [1e-300, 1e-170, 1e-160, 1e-8, 1.0, np.pi / 2 - 1e-8]


@pytest.fixture(autouse=True)
def _digits():
    with mpmath.workdps(50):
        yield


def exact(A):
    return mpmath.matrix(np.asarray(A).tolist())


def floats(A):
    return np.array([[complex(x) for x in row] for row in A.tolist()])


def thin_svd(V):
    """`V = Q S W^H`, S as a list."""
    Q, S, Wh = mpmath.svd_c(V, full_matrices=False)
    return Q, list(S), Wh.H


def orthonormal(Y):
    """The orthonormal basis nearest to `Y`: the exact point that the doubles represent."""
    U, _, W = thin_svd(Y)
    return U * W.H


def exp_exact(Y, V):
    Q, S, W = thin_svd(V)
    cos, sin = (mpmath.diag([f(s) for s in S]) for f in (mpmath.cos, mpmath.sin))
    return (Y * W * cos + Q * sin) * W.H


def transport_exact(Y, V, X):
    Q, S, W = thin_svd(V)
    cos, sin = mpmath.diag([mpmath.cos(s) - 1 for s in S]), mpmath.diag([mpmath.sin(s) for s in S])
    return X + (Q * cos - Y * W * sin) * (Q.H * X)


def log_exact(Y0, Y1):
    """Thin decomposition of `(I - Y0 Y0^H) Y1 (Y0^H Y1)^{-1}`, and its arctangents; also the angles."""
    M = Y0.H * Y1
    Q, S, W = thin_svd((Y1 - Y0 * M) * M**-1)
    angles = [mpmath.atan(s) for s in S]
    return Q * mpmath.diag(angles) * W.H, angles


# Unit horizontal vectors at the first columns of the identity, with entries and phases that doubles represent well.
POINTS = {
    "line": np.array([[0.6j], [-0.8]]),
    "one direction": np.array([[0.36 + 0.48j, -0.48 + 0.64j]]),
    "two directions": np.array([[0, 1j], [-1, 0]]),
}


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("name", POINTS)
def test_exp_log_dist_and_transport_with_many_digits(name, angle):
    below = POINTS[name]
    k = below.shape[1]
    n = k + below.shape[0]
    M, Y = Grassmann(n, k, field="complex"), np.eye(n, k, dtype=complex)
    V = np.vstack([np.zeros((k, k)), angle * below])
    end = floats(exp_exact(exact(Y), exact(V)))
    found = M.exp(Y, V)
    assert_close(found, end, 8 * EPS, "exp")
    small, nonzero = end[k:] / angle, below != 0
    assert_close((found[k:] / angle)[nonzero] / small[nonzero], 1.0, 8 * EPS, "small entries, each relatively")
    velocity, angles = log_exact(exact(Y), exact(end))
    # The phases of an angle pi/2 - a are accurate to eps / a.
    loss = 1 / np.cos(angle)
    assert_close(M.log(Y, end) / angle, floats(velocity) / angle, 8 * EPS * loss, "log, relative to its size")
    assert_close(M.dist(Y, end) / float(mpmath.norm(mpmath.matrix(angles))), 1.0, 8 * EPS, "dist, relatively")
    X = np.vstack([np.zeros((k, k)), np.resize([0.3 - 0.2j, -1.2j, 0.7, 0.4 + 1j], below.shape)])
    moved = transport_exact(exact(Y), exact(V), exact(X))
    assert_close(M.transport(Y, V, X), floats(moved), 16 * EPS, "transport")


@pytest.mark.parametrize("order", [*itertools.permutations(range(3))], ids=str)
def test_angles_of_all_sizes_at_once(order, rng):
    """Each to high relative accuracy, with phases, and with the columns in any order."""
    angles = np.array([1.3, 1e-8, 1e-300])
    theta, phases = angles[list(order)], 1j ** rng.integers(0, 4, 3)
    M, Y0 = Grassmann(6, 3, field="complex"), np.eye(6, 3, dtype=complex)
    Y1 = np.vstack([np.diag(np.cos(theta)), np.diag(phases * np.sin(theta))])
    assert_close(M.principal_angles(Y0, Y1) / angles, 1.0, 4 * EPS, "angles")
    V = M.log(Y0, Y1)
    assert_close(np.diag(V[3:]) / (phases * theta), 1.0, 4 * EPS, "each column of the logarithm")
    assert_close(M.exp(Y0, V), Y1, 4 * EPS, "exp of the logarithm")


@pytest.mark.parametrize("shape", [(2, 1), (4, 2), (5, 3), (5, 4), (12, 3)], ids=str)
def test_dense_points_with_many_digits(shape, rng):
    M = Grassmann(*shape, field="complex")
    for angles in [[0.3, 0.7, 1.1], [1e-3, 1e-6], [1.5, 0.2]]:
        Y0, Y1, V, full = separated(M, angles, rng)
        near = orthonormal(exact(Y0))
        velocity, found = log_exact(near, orthonormal(exact(Y1)))
        bound = 5 * M.n * EPS
        assert_close(M.log(Y0, Y1), floats(velocity), bound / np.cos(full.max()), f"log, angles {angles}")
        exact_angles = sorted(map(float, found), reverse=True)
        assert_close(M.principal_angles(Y0, Y1)[: len(found)], exact_angles, bound, f"angles {angles}")
        assert_close(M.exp(Y0, V), floats(exp_exact(near, exact(V))), bound, f"exp, angles {angles}")
        X = M.project_tangent(Y0, normal(rng, *shape))
        moved = floats(transport_exact(near, exact(V), exact(X)))
        assert_close(M.transport(Y0, V, X), moved, bound * np.linalg.norm(X), f"transport, angles {angles}")


@pytest.mark.parametrize("shape", [(2, 1), (4, 2), (12, 3)], ids=str)
def test_bases_do_not_matter_with_many_digits(shape, rng):
    """The exact logarithm of turned bases is the turned logarithm; so is the computed one."""
    M = Grassmann(*shape, field="complex")
    Y0, Y1, _, _ = separated(M, [0.9, 0.4], rng)
    Q0, Q1 = unitary(rng, M.k), unitary(rng, M.k)
    velocity, _ = log_exact(orthonormal(exact(Y0 @ Q0)), orthonormal(exact(Y1 @ Q1)))
    assert_close(M.log(Y0 @ Q0, Y1 @ Q1), floats(velocity), 4 * M.n * EPS, "log")
    assert_close(M.log(Y0, Y1) @ Q0, floats(velocity), 4 * M.n * EPS, "turned log")
