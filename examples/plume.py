"""A plume in the wind, for reduced_model.py: the full model, its proper orthogonal decomposition, and reduced models.

On the unit square with concentration 0 at its edges, `u' + w . grad u = D laplace u + f` with a source f in the middle,
a wind w of speed 1 and a diffusivity D of 0.05, from `u = 0` at time 0 to time 1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

Array = NDArray[np.float64]
SIDE, MODES, STEPS = 40, 6, 100
N, DT = SIDE**2, 1 / STEPS
# Wind directions in degrees for which the full model is solved: a quarter of a circle, and all of it.
WINDS = {"quarter": np.linspace(0, 90, 7), "circle": np.linspace(0, 360, 19)}
PERIOD = 360
DIFFUSIVITY, SOURCE_WIDTH = 0.05, 0.06


def operators() -> tuple[sparse.csc_array, sparse.csc_array, sparse.csc_array]:
    """Derivatives with respect to x and y, and the Laplace operator, by central differences on SIDE x SIDE points."""
    ones, h = np.ones(SIDE), 1 / (SIDE + 1)
    first = sparse.diags_array([-ones[1:], ones[1:]], offsets=[-1, 1]) / (2 * h)
    second = sparse.diags_array([ones[1:], -2 * ones, ones[1:]], offsets=[-1, 0, 1]) / h**2
    same = sparse.eye_array(SIDE)
    laplace = sparse.kron(second, same) + sparse.kron(same, second)
    return sparse.csc_array(sparse.kron(first, same)), sparse.csc_array(sparse.kron(same, first)), laplace.tocsc()


DX, DY, LAPLACE = operators()
PLACES = np.arange(1, SIDE + 1) / (SIDE + 1)
BUMP = np.exp(-((PLACES - 0.5) ** 2) / (2 * SOURCE_WIDTH**2))
SOURCE = np.kron(BUMP, BUMP)


def operator(wind: float) -> sparse.csc_array:
    """Matrix A of `u' = -A u + SOURCE` for a wind direction in degrees."""
    angle = np.radians(wind)
    return np.cos(angle) * DX + np.sin(angle) * DY - DIFFUSIVITY * LAPLACE


def solve(wind: float) -> Array:
    """Solution of the full model by the implicit Euler method, shape (N, STEPS)."""
    step = splu(sparse.csc_array(sparse.eye_array(N) + DT * operator(wind)))
    u, found = np.zeros(N), []
    for _ in range(STEPS):
        u = step.solve(u + DT * SOURCE)
        found.append(u)
    return np.stack(found, axis=1)


def reduced(wind: float, U: Array) -> Array:
    """Solution in the span of the orthonormal columns of U by Galerkin's method, shape (N, STEPS)."""
    step = np.linalg.inv(np.eye(U.shape[1]) + DT * U.T @ (operator(wind) @ U))
    z, found = np.zeros(U.shape[1]), []
    for _ in range(STEPS):
        z = step @ (z + DT * U.T @ SOURCE)
        found.append(z)
    return U @ np.stack(found, axis=1)


def modes(solution: Array) -> Array:
    """First left singular vectors of a solution, with the signs that they happen to have; shape (N, MODES)."""
    return np.asarray(np.linalg.svd(solution, full_matrices=False)[0][:, :MODES])


def computed(winds: Array) -> Array:
    """Modes for all wind directions, shape (m, N, MODES)."""
    return np.stack([modes(solve(wind % PERIOD)) for wind in winds])


def relative_error(found: Array, solution: Array) -> float:
    """Relative error of a solution in the Frobenius norm."""
    return float(np.linalg.norm(found - solution) / np.linalg.norm(solution))


def between(winds: Array, parts: int) -> tuple[Array, NDArray[np.bool_]]:
    """Wind directions that divide each interval into parts, and which of them were not computed."""
    found = np.linspace(winds[0], winds[-1], parts * (len(winds) - 1) + 1)
    return found, np.arange(len(found)) % parts != 0
