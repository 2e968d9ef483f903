"""Functions of matrices to any number of digits: the reference of the accuracy tables. Complex ones are embedded.

A matrix is an array of Python integers, its entries times `2^bits`: NumPy multiplies those at about 1e7 a second, which
makes the exponential of a 50 x 50 matrix to 60 digits a matter of a second. Doubles are taken as the exact numbers that
they are. `tests/python/test_accuracy.py` holds this file against mpmath.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Real or complex.
Matrix = NDArray[Any]
Integers = NDArray[Any]


def embedded(A: Matrix) -> Array:
    """Real matrix of twice the size in place of a complex one; products, transposes and functions are embedded too."""
    return np.block([[A.real, -A.imag], [A.imag, A.real]]) if np.iscomplexobj(A) else np.asarray(A)


def restricted(R: Array) -> Matrix:
    """The complex matrix that is embedded as `R`."""
    n, k = R.shape[0] // 2, R.shape[1] // 2
    return np.asarray(R[:n, :k] + 1j * R[n:, :k])


class FixedPoint:
    """Arithmetic with an absolute error of about `2^-bits` for each operation."""

    def __init__(self, bits: int) -> None:
        self.bits = bits
        self._half = 1 << (bits - 1)
        self._one = 1 << bits

    def exact(self, A: Array) -> Integers:
        """The exact matrix; digits below `2^-bits` are rounded."""
        entries = [round(Fraction(float(a)) * self._one) for a in A.flat]
        return np.array(entries, dtype=object).reshape(A.shape)

    def rounded(self, A: Integers) -> Array:
        """Nearest doubles."""
        # Fraction's division by a power of two rounds correctly, subnormal results included.
        return np.array([float(Fraction(int(a), self._one)) for a in A.flat]).reshape(A.shape)

    def norm(self, A: Integers) -> float:
        """Frobenius norm."""
        square = sum(int(a) ** 2 for a in A.flat)
        return float(Fraction(math.isqrt(square << 128), self._one << 64))

    def identity(self, m: int) -> Integers:
        """Identity."""
        return np.array([[self._one * (i == j) for j in range(m)] for i in range(m)], dtype=object)

    def multiply(self, A: Integers, B: Integers) -> Integers:
        """Product."""
        return np.asarray((A.dot(B) + self._half) >> self.bits)

    def inverse(self, A: Integers) -> Integers:
        """Inverse by elimination with row exchanges."""
        m = len(A)
        W = np.hstack([A, self.identity(m)])
        for j in range(m):
            pivot = j + int(np.argmax(np.abs(W[j:, j])))
            W[[j, pivot]] = W[[pivot, j]]
            row = (W[j] << self.bits) // W[j, j]
            factors = W[:, j].copy()
            factors[j] = 0
            W = W - ((factors[:, None] * row + self._half) >> self.bits)
            W[j] = row
        return np.asarray(W[:, m:])

    def expm(self, A: Integers) -> Integers:
        """Exponential: scaling, Taylor polynomial, squaring."""
        bound = max(int(row) for row in np.abs(A).sum(axis=1)) if A.size else 0
        squarings = max(0, bound.bit_length() - self.bits + 8)
        # Squaring doubles the absolute error each time.
        inner = FixedPoint(self.bits + squarings + 16)
        scaled = A << 16
        total, term = inner.identity(len(A)) + scaled, scaled
        n = 1
        while term.any():
            n += 1
            term = inner.multiply(term, scaled) // n
            total = total + term
        for _ in range(squarings):
            total = inner.multiply(total, total)
        return np.asarray(total >> (squarings + 16))

    def polar(self, A: Integers, tolerance_bits: int = 8) -> Integers:
        """Nearest orthogonal matrix by Newton's iteration, scaled until it is close."""
        X = A
        done = 1 << tolerance_bits
        for _ in range(400):
            Y = self.inverse(X).T
            size, other = self.norm(X), self.norm(Y)
            # Higham's scaling by Frobenius norms; exactly 1 near the end, where convergence is quadratic.
            scale = (other / size) ** 0.5 if abs(size - other) > 1e-6 * size else 1.0
            ratio = round(scale * 2**60)
            new = ((X * ratio >> 60) + (Y << 60) // ratio) // 2
            change, X = int(np.abs(new - X).max()), new
            if change <= done * len(A):
                return np.asarray(X)
        raise RuntimeError(f"polar factor: no convergence, last change {change / self._one:.1e}")

    def logm_rotation(self, Q: Integers) -> Integers:
        """Principal logarithm of the rotation nearest to Q.

        The square root of a rotation without the eigenvalue -1 is the polar factor of `I + Q`. After enough roots the
        logarithm is `2 artanh(Z)`, `Z = (R - I)(R + I)^{-1}`.
        """
        eye = self.identity(len(Q))
        R, roots = self.polar(Q), 0
        while self.norm(R - eye) > 1 / 16:
            R, roots = self.polar(R + eye), roots + 1
        Z = self.multiply(R - eye, self.inverse(R + eye))
        square, power, total, n = self.multiply(Z, Z), Z, Z, 1
        while power.any():
            n += 2
            power = self.multiply(power, square)
            total = total + power // n
            # Rounding to -1 instead of 0 would keep the power alive forever.
            if int(np.abs(power).max()) <= 1:
                break
        L = total << (roots + 1)
        return np.asarray((L - L.T) // 2)
