"""Complex frames in NumPy: formulas, random data, and the embedding in real frames."""

import numpy as np
from scipy.linalg import expm

from stiefel_rs import Stiefel

EPS = np.finfo(float).eps
SHAPES = [(1, 1), (2, 1), (3, 1), (2, 2), (3, 2), (3, 3), (4, 2), (4, 4), (5, 3), (9, 2)]
# Parameter of the metric, and its weight of |Omega|^2.
METRICS = {"canonical": 0.5, "euclidean": 1.0, 1.5: 0.2, -0.8: 2.5}


def H(A):
    """The conjugate transpose."""
    return np.swapaxes(A, -1, -2).conj()


def skew(A):
    return (A - H(A)) / 2


def split(S, V):
    """K and Omega of V = S Omega + K."""
    return V - S @ (H(S) @ V), skew(H(S) @ V)


def inner(S, V, W, w=0.5):
    """Re(<K_V, K_W> + w <Omega_V, Omega_W>)."""
    (K, A), (L, B) = split(S, V), split(S, W)
    return float(np.sum(K.conj() * L).real + w * np.sum(A.conj() * B).real)


def norm(S, V, w=0.5):
    return np.sqrt(inner(S, V, V, w))


def exp(S, V, w=0.5):
    """Geodesic of the metric of weight w, with full-size matrices."""
    K, A = split(S, V)
    return expm(K @ H(S) - S @ H(K) + 2 * w * S @ A @ H(S)) @ S @ expm((1 - 2 * w) * A)


def embed(S):
    """The real frames with which the library computes."""
    return np.block([[S.real, -S.imag], [S.imag, S.real]])


def restrict(R):
    n, k = R.shape[-2] // 2, R.shape[-1] // 2
    return R[..., :n, :k] + 1j * R[..., n:, :k]


def normal(rng, *shape):
    return rng.standard_normal(shape) + 1j * rng.standard_normal(shape)


def unitary(rng, m):
    Q, R = np.linalg.qr(normal(rng, m, m))
    return Q * (np.diag(R) / np.abs(np.diag(R)))


def tangents(M, S, rng, count, length=0.7):
    """Tangent vectors at S of a given length, canonical metric."""
    vectors = (M.random_tangent(S, rng) for _ in range(count))
    return [V * (length / norm(S, V)) for V in vectors]


def walk(n, k, count, seed=0, step=0.5):
    """Times, points and velocities of a random walk."""
    M, rng = Stiefel(n, k, field="complex"), np.random.default_rng(seed + n + 100 * k)
    points = [M.random_point(rng)]
    for _ in range(count - 1):
        points.append(exp(points[-1], tangents(M, points[-1], rng, 1, step)[0]))
    t, S = np.cumsum(rng.uniform(0.5, 1.5, count)), np.stack(points)
    return t, S, np.stack([tangents(M, x, rng, 1, 0.3)[0] for x in S])


def assert_close(measured, exact, bound, what):
    error = np.max(np.abs(np.asarray(measured) - exact), initial=0.0)
    assert error <= bound, f"{what}: error {error:.3e} exceeds {bound:.3e}"
