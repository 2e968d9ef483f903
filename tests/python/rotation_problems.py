"""Random walks of rotations at unequal times, for the tests of splines of rotations and of poses."""

import numpy as np
from scipy.spatial.transform import Rotation

from stiefel_rs import Stiefel
from stiefel_rs.rotation_input import matrices_of, quaternions_of

# Angles about an axis at given times.
AXIS = np.array([2.0, -1.0, 2.0]) / 3
T = np.array([0.0, 0.5, 1.7, 2.5, 4.0])
ANGLE = np.array([0.0, 0.7, -0.4, 1.5, 3.2])
# Rates in rad/s and accelerations in rad/s^2 at the ends.
W, A = np.array([0.3, -0.2, 0.5]), np.array([-0.4, 0.1, 0.2])


def wander(count, seed=0, step=0.8):
    """Times, shape (N,), and unit quaternions, shape (N, 4), about `step` from one to the next, with random signs."""
    rng = np.random.default_rng(seed)
    turns = rng.standard_normal((count, 3))
    turns *= step / np.linalg.norm(turns, axis=-1, keepdims=True)
    q = [np.array([0.5, -0.5, 0.1, 0.7])]
    for w in turns[1:]:
        q.append(product(q[-1], about(w)))
    q = np.array(q) / np.linalg.norm(q, axis=-1, keepdims=True)
    return np.cumsum(rng.uniform(0.5, 1.5, count)), q * rng.choice([-1.0, 1.0], (count, 1))


def about(w):
    """Quaternions of rotation vectors, shape (..., 3)."""
    angle = np.linalg.norm(w, axis=-1, keepdims=True)
    return np.concatenate([w * np.sinc(angle / (2 * np.pi)) / 2, np.cos(angle / 2)], axis=-1)


def turned(angle):
    """Rotations about one axis, as quaternions."""
    return about(np.asarray(angle)[..., None] * AXIS)


def product(a, b):
    """Hamilton product, scalar last."""
    u, v, s, t = a[..., :3], b[..., :3], a[..., 3:], b[..., 3:]
    return np.concatenate([s * v + t * u + np.cross(u, v), s * t - np.sum(u * v, axis=-1, keepdims=True)], axis=-1)


def vee(A):
    """The vectors of the skew parts of matrices."""
    A = (A - np.swapaxes(A, -1, -2)) / 2
    return np.stack([A[..., 2, 1], A[..., 0, 2], A[..., 1, 0]], axis=-1)


def slope(f, t, h=1e-3):
    """Derivative of a function of time by central differences of eighth order."""
    weights = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
    return sum(w * (f(t + i * h) - f(t - i * h)) for i, w in enumerate(weights, 1)) / h


def inner(t, count=5):
    """Times inside the pieces, away from the knots."""
    return (t[:-1, None] + np.diff(t)[:, None] * np.linspace(0.1, 0.9, count)).ravel()


def random_quaternion(seed):
    return quaternions_of(positive(Stiefel(3, 3).random_point(seed)))


def positive(S):
    """A point of O(3) if it is a rotation, otherwise its negative."""
    return S * np.sign(np.linalg.det(S))


def same(a, b, bound):
    """Assert that arrays agree; otherwise state their difference."""
    error = np.abs(np.asarray(a) - b).max(initial=0)
    assert error <= bound, f"differ by {error:.2e}, bound {bound:.2e}"


def as_matrices(rotations):
    """Matrices of rotations of any kind."""
    if isinstance(rotations, Rotation):
        return rotations.as_matrix()
    return matrices_of(rotations) if np.shape(rotations)[-1] == 4 else rotations
