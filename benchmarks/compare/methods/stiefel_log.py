"""Riemannian logarithm of St(n, k), canonical metric, by the algebraic method with Sylvester steps.

Zimmermann, Hueper (2022), "Computing the Riemannian logarithm on the Stiefel manifold: metrics, methods, and
performance", SIAM J. Matrix Anal. Appl. 43, algorithm 4 with the correction of section 4.2; the start is that of
Zimmermann (2017). Exponential and logarithm go by real symmetric eigenproblems, without loops in Python.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def rotation_log(Q: Array) -> Array:
    """Principal logarithm of a rotation from LAPACK's real Schur form: angles by atan2, no loop over the blocks."""
    T, Z = scipy.linalg.schur(Q, output="real", check_finite=False)
    first = np.flatnonzero(np.diagonal(T, -1))
    angle = np.arctan2((T[first + 1, first] - T[first, first + 1]) / 2, (T[first, first] + T[first + 1, first + 1]) / 2)
    left, right = Z[:, first], Z[:, first + 1]
    half = (right * angle) @ left.T
    return np.asarray(half - half.T)


def unitary_log(Q: ComplexArray) -> ComplexArray:
    """Principal logarithm of a unitary matrix from LAPACK's complex Schur form, which is diagonal to round-off."""
    T, Z = scipy.linalg.schur(Q, output="complex", check_finite=False)
    return np.asarray((Z * (1j * np.angle(np.diagonal(T)))) @ Z.conj().T)


def cayley_log(V: Array) -> Array:
    """Logarithm of a rotation that is not too close to an angle of pi, by one real symmetric eigenproblem.

    `K = (V + I)^{-1} (V - I)` is skew with angles `tan(theta / 2)`, so the logarithm is `K g(K^T K)` with
    `g(x) = 2 arctan(sqrt x) / sqrt x`. Three times as fast as the Schur form, and as accurate at the sizes here.
    """
    eye = np.eye(len(V))
    K = np.linalg.solve(V + eye, V - eye)
    K = (K - K.T) / 2
    squares, basis = np.linalg.eigh(K.T @ K)
    tangent = np.sqrt(np.maximum(squares, 0))
    factor = np.where(tangent > 0, 2 * np.arctan(tangent) / np.where(tangent > 0, tangent, 1), 2)
    L = K @ ((basis * factor) @ basis.T)
    return np.asarray((L - L.T) / 2)


def symmetric_exp(A: Array) -> Array:
    """Exponential of a skew matrix, `cos(R) + A sin(R) / R` with `R^2 = A^T A`: one real symmetric eigenproblem."""
    squares, basis = np.linalg.eigh(A.T @ A)
    angle = np.sqrt(np.maximum(squares, 0))
    return np.asarray((basis * np.cos(angle)) @ basis.T + A @ ((basis * np.sinc(angle / np.pi)) @ basis.T))


def _start(M: Array, N: Array) -> Array:
    """Rotation whose first columns are [M; N], and whose last block is symmetric and, up to one sign, positive."""
    k = M.shape[1]
    V = np.linalg.qr(np.vstack([M, N]), mode="complete")[0]
    V[:, :k] = np.vstack([M, N])
    left, _, right = np.linalg.svd(V[k:, k:])
    V[:, k:] = V[:, k:] @ (right.T @ left.T)
    if np.linalg.det(V) < 0:
        # The direction of the smallest singular value costs least.
        V[:, k:] -= 2 * np.outer(V[:, k:] @ left[:, -1], left[:, -1])
    return np.asarray(V)


def stiefel_log(S0: Array, S1: Array, *, tolerance: float = 1e-12, max_iterations: int = 200) -> Array:
    """Tangent vector at S0 whose geodesic reaches S1 at t = 1.

    Raises
    ------
    RuntimeError
        If the iteration has not converged.
    """
    k = S0.shape[1]
    M = S0.T @ S1
    Q, N = np.linalg.qr(S1 - S0 @ M)
    V = _start(M, N)
    for _ in range(max_iterations):
        L = cayley_log(V)
        A, B, C = L[:k, :k], L[k:, :k], L[k:, k:]
        if np.linalg.norm(C) <= tolerance:
            return np.asarray(S0 @ A + Q @ B)
        # X Gamma + Gamma X = C in the eigenbasis of the symmetric X = B B^T / 12 - I / 2.
        eigenvalues, basis = np.linalg.eigh(B @ B.T / 12)
        Gamma = basis @ ((basis.T @ C @ basis) / (eigenvalues[:, None] + eigenvalues - 1)) @ basis.T
        V[:, k:] = V[:, k:] @ symmetric_exp((Gamma - Gamma.T) / 2)
    raise RuntimeError(f"|C| = {np.linalg.norm(C):.1e} after {max_iterations} iterations")
