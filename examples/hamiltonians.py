"""Hamiltonians of curves of unitary matrices, for quantum_gates.py."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiefel_rs import CubicSpline, Geodesic, Stiefel

Array = NDArray[Any]


def hamiltonian(U: Array, V: Array) -> Array:
    """Return `H = i V U^H`, from `i U' = H U`, at unitary matrices U with derivatives V."""
    return np.asarray(1j * V @ np.swapaxes(U.conj(), -1, -2))


def nearest_phase(U: Array, W: Array) -> Array:
    """Return W times the global phase with which the geodesic from U is shortest.

    That is minus the mean of the phases of the eigenvalues of `U^H W`, where the circle is cut so that they vary least.
    """
    phases = np.sort(np.angle(np.linalg.eigvals(U.conj().T @ W)))
    cuts = [np.concatenate([phases[i:], phases[:i] + 2 * np.pi]) for i in range(len(phases))]
    return np.asarray(W * np.exp(-1j * np.mean(min(cuts, key=lambda each: round(np.var(each), 9)))))


class Spline:
    """The Hamiltonian of a spline through unitary matrices at times 0, 1, ...

    Calls take an array of times of shape (m,), and return an array of shape (m, n, n).
    """

    def __init__(self, points: Array, ends: str) -> None:
        manifold = Stiefel(*points.shape[1:], field="complex")
        self.curve = CubicSpline(np.arange(float(len(points))), points, ends, manifold=manifold)

    def __call__(self, t: Array) -> Array:
        """Return H at times t."""
        return hamiltonian(self.curve(t), self.curve(t, 1))

    def rate(self, t: Array) -> Array:
        """Return `H' = i A U^H` with the covariant acceleration A."""
        return hamiltonian(self.curve(t), self.curve.acceleration(t))


class Geodesics:
    """The Hamiltonian of geodesics between times 0, 1, ...: a constant for each, times a factor of the time since."""

    def __init__(self, points: Array, factor: Callable[[Array], Array], rate: Callable[[Array], Array]) -> None:
        manifold = Stiefel(*points.shape[1:], field="complex")
        legs = [Geodesic(*ends, manifold=manifold) for ends in pairwise(points)]
        self.constants = np.stack([hamiltonian(leg(0.0), leg(0.0, 1)) for leg in legs])
        self.factor, self.factor_rate = factor, rate

    def times(self, t: Array, factor: Callable[[Array], Array]) -> Array:
        """Return the Hamiltonians of the intervals of t, times the factor."""
        i = np.clip(np.floor(t).astype(int), 0, len(self.constants) - 1)
        return np.asarray(self.constants[i] * factor(t - i)[..., None, None])

    def __call__(self, t: Array) -> Array:
        """Return H at times t."""
        return self.times(t, self.factor)

    def rate(self, t: Array) -> Array:
        """Return H' between the points; jumps of H at the points are not in it."""
        return self.times(t, self.factor_rate)
