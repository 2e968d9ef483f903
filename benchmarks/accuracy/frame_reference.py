"""Geodesics of frames and subspaces with 60 digits, from their formulas in matrices of size n."""

from __future__ import annotations

import mpmath
import numpy as np

from benchmarks.accuracy.fixed_point import Array, FixedPoint, Integers, Matrix, embedded

# The distance of a computed frame from an exact one is squared by every iteration.
POLAR_ITERATIONS = 5


def orthonormal(F: FixedPoint, S: Matrix) -> Integers:
    """The frame nearest to a matrix of doubles that is one to round-off, embedded: Newton and Schulz's iteration."""
    X = F.exact(embedded(S))
    for _ in range(POLAR_ITERATIONS):
        gram = F.multiply(X.T, X)
        X = (3 * X - F.multiply(X, gram)) >> 1
    return X


def tangent(F: FixedPoint, S: Integers, V: Matrix, *, horizontal: bool) -> Integers:
    """Projection of a matrix of doubles to the tangent space of frames, or to that of subspaces, embedded."""
    X = F.exact(embedded(V))
    inner = F.multiply(S.T, X)
    return np.asarray(X - F.multiply(S, inner if horizontal else (inner + inner.T) >> 1))


def geodesic(F: FixedPoint, S: Integers, V: Integers) -> Integers:
    """End of the geodesic: `e^A S` with `A = U S^T - S U^T`, `U = V - S S^T V / 2`, by the Taylor series.

    Edelman, Arias, Smith (1998), section 2.2.2; with `S^T V = 0` their theorem 2.3 for subspaces.
    """
    U = V - (F.multiply(S, F.multiply(S.T, V)) >> 1)
    total, term, j = S, S, 0
    while np.abs(term).max() > 1:
        j += 1
        term = (F.multiply(U, F.multiply(S.T, term)) - F.multiply(S, F.multiply(U.T, term))) // j
        total = total + term
    return np.asarray(total)


def singular_values(V: Matrix) -> Array:
    """Singular values of a matrix of doubles in decreasing order, from its Gram matrix with 60 or more digits."""
    k = V.shape[1]
    # Squares of the smallest ones are resolved beside those of the largest ones.
    with mpmath.workdps(700):
        rows = mpmath.matrix(V.tolist())
        found = mpmath.eighe(rows.H * rows, eigvals_only=True)
        return np.array([float(mpmath.sqrt(abs(found[k - 1 - i]))) for i in range(k)])
