"""Seeded inputs, generated with NumPy alone, so that every process works on the same numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
# Of real or complex entries.
Frames = NDArray[Any]
Field = Literal["real", "complex"]

SMALL_EXP = (3, 6, 12, 30)
LARGE = (100, 300, 1000)
SMALL_LOG = (3, 12, 30)
COMPLEX = (4, 16, 64, 256)
CURVES = ((3, 1), (3, 2), (50, 5), (300, 10))
# Index of the one of 1000 points on which the n x n formulas are timed.
FORMULA_POINT = 333
TALL = (1_000_000, 4)
TALL_POINTS = 64
LOGS = ((4, 2), (50, 5), (200, 20), (1000, 50))
SUBSPACES = ((50, 5), (1000, 50))
DISTANCES = {"0.5": 0.5, "0.9pi": 0.9 * np.pi}
BATCH = 10_000


def _rng(*key: int) -> np.random.Generator:
    return np.random.default_rng([20240419, *key])


def skew(m: int, batch: tuple[int, ...] = ()) -> Array:
    """Skew matrices of spectral norm 1."""
    A = _rng(1, m).standard_normal((*batch, m, m))
    A = A - np.swapaxes(A, -1, -2)
    return np.asarray(A / np.linalg.norm(A, 2, axis=(-2, -1), keepdims=True))


def rotation(m: int, batch: tuple[int, ...] = ()) -> Array:
    """Uniformly distributed rotations."""
    Q, R = np.linalg.qr(_rng(2, m).standard_normal((*batch, m, m)))
    Q = Q * np.sign(np.diagonal(R, axis1=-2, axis2=-1))[..., None, :]
    Q[..., 0] *= np.linalg.det(Q)[..., None].round()
    return np.asarray(Q)


def skew_hermitian(m: int) -> ComplexArray:
    """A skew-Hermitian matrix of spectral norm 1."""
    A = _rng(8, m).standard_normal((m, m)) + 1j * _rng(9, m).standard_normal((m, m))
    A = A - A.conj().T
    return np.asarray(A / np.linalg.norm(A, 2))


def unitary(m: int) -> ComplexArray:
    """A unitary matrix with angles spread around the circle."""
    Z = _rng(10, m).standard_normal((m, m)) + 1j * _rng(11, m).standard_normal((m, m))
    return np.asarray(np.linalg.qr(Z)[0])


def adjoint(A: Frames) -> Frames:
    """Conjugate transposes."""
    return np.asarray(np.conj(np.swapaxes(A, -1, -2)))


def _normal(shape: tuple[int, ...], field: Field, *key: int) -> Frames:
    """Independent normally distributed entries; the real parts of complex ones are the real matrix of the same key."""
    Z = _rng(*key).standard_normal(shape)
    return Z if field == "real" else Z + 1j * _rng(12, *key).standard_normal(shape)


def point(n: int, k: int, key: int = 0, batch: tuple[int, ...] = (), field: Field = "real") -> Frames:
    """Points of St(n, k)."""
    return np.asarray(np.linalg.qr(_normal((*batch, n, k), field, 3, n, k, key))[0])


def tangent(S: Frames, length: float, key: int = 0) -> Frames:
    """Tangent vectors of given canonical length, one at each point."""
    Z = _normal(S.shape, "complex" if np.iscomplexobj(S) else "real", 4, *S.shape[-2:], key)
    A = adjoint(S) @ Z
    V = Z - S @ ((A + adjoint(A)) / 2)
    omega = adjoint(S) @ V
    square = np.sum((V * V.conj()).real, axis=(-2, -1)) - np.sum((omega * omega.conj()).real, axis=(-2, -1)) / 2
    return np.asarray(V * (length / np.sqrt(square))[..., None, None])


def geodesic_end(S: Frames, V: Frames) -> Frames:
    """End of the canonical geodesic from S with velocity V: `[S Q] exp([[Omega, -R^H], [R, 0]]) [I; 0]`."""
    k = S.shape[-1]
    omega = adjoint(S) @ V
    Q, sigma, Wh = np.linalg.svd(V - S @ omega, full_matrices=False)
    R = sigma[:, None] * Wh
    generator = np.block([[(omega - adjoint(omega)) / 2, -adjoint(R)], [R, np.zeros((len(R), len(R)))]])
    # A skew matrix times i is Hermitian.
    angles, basis = np.linalg.eigh(1j * generator)
    exponential = (basis * np.exp(-1j * angles)) @ adjoint(basis)
    if not np.iscomplexobj(S):
        exponential = exponential.real
    return np.asarray(np.hstack([S, Q]) @ exponential[:, :k])


@dataclass(frozen=True)
class Boundary:
    """End points and end velocities of a curve."""

    S0: Frames
    V0: Frames
    S1: Frames
    V1: Frames


def boundary(n: int, k: int, *, field: Field = "real") -> Boundary:
    """Points at canonical distance 0.7 and velocities of length 0.5."""
    S0 = point(n, k, field=field)
    S1 = geodesic_end(S0, tangent(S0, 0.7, 1))
    return Boundary(S0, tangent(S0, 0.5, 2), S1, tangent(S1, 0.5, 3))


def parameters(count: int) -> Array:
    """Curve parameters, both ends excluded."""
    return np.linspace(0.0, 1.0, count + 2)[1:-1]


def log_problem(n: int, k: int, distance: str, field: Field = "real") -> tuple[Frames, Frames, Frames]:
    """Two points and the velocity `V` of a geodesic between them, of the given length: (S0, S1, V)."""
    S0 = point(n, k, 5, field=field)
    V = tangent(S0, DISTANCES[distance], 6)
    return S0, geodesic_end(S0, V), V


def subspace_problem(n: int, k: int) -> tuple[Array, Array, Array]:
    """Points of Gr(n, k) at principal angles up to 1.2, and the velocity of the geodesic between them: (Y0, Y1, V)."""
    Y0 = point(n, k, 9)
    Z = _rng(10, n, k).standard_normal((n, k))
    Q, _, Wt = np.linalg.svd(Z - Y0 @ (Y0.T @ Z), full_matrices=False)
    theta = np.linspace(0.1, 1.2, k)
    Y1 = (Y0 @ Wt.T * np.cos(theta) + Q * np.sin(theta)) @ Wt
    turn = np.linalg.qr(_rng(11, k).standard_normal((k, k)))[0]
    return Y0, np.asarray(Y1 @ turn), np.asarray((Q * theta) @ Wt)


def tangent_batch(n: int, k: int) -> tuple[Array, Array]:
    """A batch of points with tangent vectors of length 1/2."""
    S = point(n, k, 7, (BATCH,))
    return S, tangent(S, 0.5, 8)
