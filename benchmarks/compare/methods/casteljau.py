"""Adjusted de Casteljau in NumPy: thin and vectorised over the parameter, and by the paper's n x n formulas.

Anahory Simoes, Colombo, Silva Leite, arXiv 2404.19407; Krakowski, Machado, Silva Leite, Batista (2017).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

Array = NDArray[np.float64]


def retract(S: Array, V: Array) -> Array:
    """Quasi-geodesic step `e^X S e^Omega`, thin."""
    omega = S.T @ V
    Q, sigma, Wt = np.linalg.svd(V - S @ omega, full_matrices=False)
    turned = (S @ Wt.T * np.cos(sigma) + Q * np.sin(sigma)) @ Wt
    return np.asarray(turned @ scipy.linalg.expm((omega - omega.T) / 2))


def control_points(S0: Array, V0: Array, S3: Array, V3: Array) -> Array:
    """The four control points of the curve with given ends and end velocities, shape (4, n, k)."""
    return np.stack([S0, retract(S0, V0 / 3), retract(S3, -V3 / 3), S3])


def _transposed(A: Array) -> Array:
    return np.swapaxes(A, -1, -2)


def _rotation_power(R: Array, t: Array) -> Array:
    """`R^t` for rotations with distinct eigenvalues, (..., k, k)."""
    if R.shape[-1] == 1:
        return np.ones_like(R)
    values, basis = np.linalg.eig(R.astype(complex))
    powers = np.exp(1j * t[:, None] * np.angle(values))
    return np.asarray(((basis * powers[..., None, :]) @ np.linalg.inv(basis)).real)


def quasi_geodesic(S0: Array, S1: Array, t: Array) -> Array:
    """Points of quasi-geodesics, one parameter each: slerp in every principal direction, (T, n, k)."""
    U, cosine, Zt = np.linalg.svd(_transposed(S0) @ S1)
    a, b = S0 @ U, S1 @ _transposed(Zt)
    sine = np.linalg.norm(b - a * cosine[..., None, :], axis=-2)
    angle = np.arctan2(sine, cosine)
    safe = np.where(sine > 0, sine, 1.0)
    s, one = t[:, None], 1 - t[:, None]
    left = np.where(sine > 0, np.sin(one * angle) / safe, one)
    right = np.where(sine > 0, np.sin(s * angle) / safe, s)
    turned = a * left[:, None, :] + b * right[:, None, :]
    return np.asarray(turned @ _transposed(U) @ _rotation_power(U @ Zt, t))


def casteljau(points: Array, t: Array) -> Array:
    """The adjusted de Casteljau curve at all parameters at once, (T, n, k)."""
    level = [np.broadcast_to(P, (len(t), *P.shape)) for P in points]
    while len(level) > 1:
        level = [quasi_geodesic(a, b, t) for a, b in pairwise(level)]
    return np.asarray(level[0])


def _leg(S0: Array, S1: Array) -> tuple[Array, Array]:
    """The pair `(X, Omega)` by the paper's formulas: a logarithm of a product of reflections, n x n."""
    eye = np.eye(len(S0))
    X = scipy.linalg.logm((eye - 2 * S1 @ S1.T) @ (eye - 2 * S0 @ S0.T)).real / 2
    omega = scipy.linalg.logm(S0.T @ scipy.linalg.expm(-X) @ S1).real
    return X, np.atleast_2d(omega)


def formulas(points: Array, t: float) -> Array:
    """One point of the same curve by the paper's n x n formulas with SciPy's expm and logm."""
    level = list(points)
    while len(level) > 1:
        legs = [(a, *_leg(a, b)) for a, b in pairwise(level)]
        level = [scipy.linalg.expm(t * X) @ S @ scipy.linalg.expm(t * omega) for S, X, omega in legs]
    return np.asarray(level[0])
