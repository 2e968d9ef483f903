"""Errors of computed exponentials and logarithms compared with exact ones, and the promised bounds."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import mpmath
import numpy as np

from benchmarks.accuracy.cases import BITS
from benchmarks.accuracy.complex_cases import Unitary
from benchmarks.accuracy.fixed_point import Array, FixedPoint, Integers, Matrix, embedded, restricted

UNIT = 1e-15

# Spacing of doubles near zero: the smallest possible error.
TINY = 5e-324


@dataclass(frozen=True)
class ExpErrors:
    """Errors of an exponential; `page.md` explains each."""

    forward: float
    off_diagonal: float
    defect: float

    @staticmethod
    def bounds(A: Matrix) -> ExpErrors:
        """The promised bounds: a relative error of eps in A moves `e^A` by `eps |A|_2`; a few of these are allowed."""
        m, norm = len(A), float(np.linalg.norm(A, 2))
        # Below 1e-308 doubles have an absolute spacing.
        off_diagonal = m * UNIT * max(1.0, norm) + m * (TINY / _size(A))
        return ExpErrors(UNIT * max(1.0, norm), off_diagonal, m * UNIT)

    def above(self, bounds: ExpErrors) -> list[str]:
        """Names of the errors above their bounds."""
        return [f.name for f in fields(self) if not getattr(self, f.name) <= getattr(bounds, f.name)]


@dataclass(frozen=True)
class LogErrors:
    """Errors of a logarithm; `page.md` explains each."""

    forward: float
    absolute: float
    condition: float
    size: float
    backward: float
    skewness: float
    real: bool

    def bounds(self, m: int) -> LogErrors:
        """The promised bounds for this size and condition: a few eps of backward error, and its consequences."""
        forward = m * UNIT * self.condition
        return LogErrors(forward, forward * max(1.0, self.size), self.condition, self.size, m * UNIT, 0.0, real=True)

    def above(self, bounds: LogErrors) -> list[str]:
        """Names of the errors above their bounds."""
        names = ("forward", "absolute", "backward", "skewness")
        return [name for name in names if not getattr(self, name) <= getattr(bounds, name)]


def arithmetic(A: Array) -> FixedPoint:
    """Arithmetic with enough digits for a result of the size of A's smallest column."""
    entries = np.abs(A[A != 0])
    return FixedPoint(BITS + max(0, -math.floor(math.log2(entries.min()))) if entries.size else BITS)


def _scale(A: Matrix) -> float:
    """Ratio of Frobenius norms of the embedded matrix and of the matrix itself."""
    return math.sqrt(2) if np.iscomplexobj(A) else 1.0


def exp_reference(A: Matrix) -> tuple[FixedPoint, Integers]:
    """Exponential of a matrix of doubles, embedded if it is complex."""
    real = embedded(A)
    F = arithmetic(real)
    return F, F.expm(F.exact(real))


def exp_errors(R: Matrix, A: Matrix, reference: tuple[FixedPoint, Integers]) -> ExpErrors:
    """Errors of a computed exponential."""
    F, exact = reference
    X = F.exact(embedded(R))
    error = X - exact
    off = error.copy()
    np.fill_diagonal(off, 0)
    defect = F.norm(F.multiply(X.T, X) - F.identity(len(X))) / _scale(A)
    return ExpErrors(F.norm(error) / math.sqrt(len(X)), F.norm(off) / _scale(A) / _size(A), defect)


def _size(A: Matrix) -> float:
    """Frobenius norm, at most 1 and never 0."""
    real = embedded(A)
    largest = max(float(np.abs(real).max()), TINY)
    # Squares of the entries themselves would underflow.
    return max(TINY, min(1.0, float(np.linalg.norm(real / largest)) / _scale(A) * largest))


def log_reference(Q: Array) -> tuple[FixedPoint, Integers]:
    """Logarithm of the rotation nearest to a matrix of doubles."""
    off = Q.copy()
    np.fill_diagonal(off, 0)
    F = arithmetic(off)
    return F, F.logm_rotation(F.exact(Q))


def unitary_log_reference(case: Unitary) -> tuple[FixedPoint, Integers]:
    """Logarithm of the unitary matrix nearest to a matrix of doubles, embedded."""
    if case.log_over_pi is None:
        return log_reference(embedded(case.matrix))
    F = FixedPoint(BITS)
    with mpmath.workprec(BITS + 64):
        pi = int(mpmath.nint(mpmath.pi * mpmath.mpf(2) ** BITS))
    return F, (F.exact(embedded(case.log_over_pi)) * pi) >> BITS


def unitary_log_errors(L: Matrix, case: Unitary, reference: tuple[FixedPoint, Integers]) -> LogErrors:
    """Errors of a computed logarithm of a unitary matrix."""
    F, exact = reference
    X = F.exact(embedded(L))
    size, error, backward = (
        F.norm(each) / math.sqrt(2) for each in (exact, X - exact, F.expm(X) - F.exact(embedded(case.matrix)))
    )
    angles = np.linalg.eigvalsh(-1j * restricted(F.rounded(exact)))
    skewness = float(np.abs(L + L.conj().T).max())
    forward = error / size if size > 0 else error
    return LogErrors(forward, error, _condition(angles), size, backward, skewness, real=False)


def _condition(angles: Matrix) -> float:
    """Largest quotient of an arc between two eigenvalues, not passing -1, and its chord."""
    arcs = np.ptp(angles)
    return float(arcs / 2 / np.sin(arcs / 2)) if arcs > 0 else 1.0


def log_errors(L: Matrix, Q: Array, reference: tuple[FixedPoint, Integers]) -> LogErrors:
    """Errors of the real part of a computed logarithm."""
    F, exact = reference
    X = F.exact(np.real(L))
    size = F.norm(exact)
    error = F.norm(X - exact)
    # For a skew matrix: its spectral norm.
    angle = float(np.linalg.norm(F.rounded(exact), 2))
    # Doubles are too coarse to represent pi - 1e-14 accurately; the angle itself is accurate to 1e-15.
    condition = angle / math.sin(angle) if angle > 0 else 1.0
    backward = F.norm(F.expm(X) - F.exact(Q))
    skewness = float(np.abs(np.real(L) + np.real(L).T).max())
    forward = error / size if size > 0 else error
    return LogErrors(forward, error, condition, size, backward, skewness, bool(np.isrealobj(L)))
