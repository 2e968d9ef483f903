"""Matrices for which the exponential and the logarithm are compared with a reference of 60 digits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mpmath
import numpy as np

from benchmarks.accuracy.fixed_point import Array, FixedPoint, Matrix

SIZES = (2, 3, 4, 5, 6, 12, 30, 50)
# Remaining digits after a loss of 28 by the conditioning: angles of pi - 1e-14.
BITS = 260


@dataclass(frozen=True)
class Case:
    """A matrix of doubles and its description."""

    name: str
    matrix: Matrix

    @property
    def m(self) -> int:
        """Size."""
        return len(self.matrix)


def _rng(*key: int) -> np.random.Generator:
    return np.random.default_rng([51, *key])


def random_skew(m: int, norm: float) -> Array:
    """Skew matrix of given spectral norm."""
    A = _rng(m).standard_normal((m, m))
    A = A - A.T
    return np.asarray(A / np.linalg.norm(A, 2) * norm)


def _blocks(*blocks: Array) -> Array:
    """Block diagonal matrix."""
    m = sum(map(len, blocks))
    out, at = np.zeros((m, m)), 0
    for block in blocks:
        out[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    return out


def _generator(angles: Sequence[float], m: int) -> Array:
    """Skew matrix with the given angles in consecutive planes."""
    A = np.zeros((m, m))
    for i, angle in enumerate(angles):
        A[2 * i, 2 * i + 1], A[2 * i + 1, 2 * i] = -angle, angle
    return A


def _in_a_basis(A: Array) -> Array:
    """The same in a random orthonormal basis, exactly skew."""
    B = np.linalg.qr(_rng(len(A), 1).standard_normal(A.shape))[0]
    turned = B @ A @ B.T
    return np.asarray((turned - turned.T) / 2)


def exp_cases() -> list[Case]:
    """Skew matrices."""
    cases = [Case("random, norm 1", random_skew(m, 1.0)) for m in SIZES]
    for m in (3, 6, 12):
        for norm in (1e-300, 1e-150, 1e-16, 1e-8, 1e-3, 3.0, 10.0, 100.0, 1e3):
            cases.append(Case(f"random, norm {norm:g}", random_skew(m, norm)))
    cases += [Case("random, norm 1000", random_skew(m, 1e3)) for m in (2, 4, 30)]
    cases += [
        Case("zero", np.zeros((5, 5))),
        Case("one denormal entry", _generator([5e-324], 4)),
        Case("denormal entries", random_skew(6, 1e-310)),
        Case("denormal beside 1", _generator([1.0, 1e-310], 5)),
        Case("blocks of norm 100 and 1e-8", _blocks(random_skew(3, 100.0), random_skew(3, 1e-8))),
        Case("blocks and zeros", _blocks(random_skew(5, 2.0), np.zeros((7, 7)), random_skew(4, 0.3))),
        Case("rank 2", _in_a_basis(_generator([2.5], 30))),
        Case("equal angles", _in_a_basis(_generator([1.2] * 6, 12))),
        Case("angles 1e-8 apart", _in_a_basis(_generator(list(1.2 + 1e-8 * np.arange(6)), 12))),
        Case("all angles pi - 1e-6", _in_a_basis(_generator([np.pi - 1e-6] * 6, 12))),
        Case("angles at multiples of pi", _in_a_basis(_generator([np.pi, 2 * np.pi, 3 * np.pi], 6))),
    ]
    return cases


def rotation(angles: Sequence[mpmath.mpf | float], m: int, *, bits: int = BITS) -> Array:
    """Rotation by given angles in a random basis, accurate to 60 digits before it is rounded to doubles."""
    F = FixedPoint(bits)
    one = mpmath.mpf(2) ** bits
    D = F.identity(m)
    with mpmath.workprec(bits + 64):
        for i, angle in enumerate(angles):
            c, s = int(mpmath.nint(mpmath.cos(angle) * one)), int(mpmath.nint(mpmath.sin(angle) * one))
            j = 2 * i
            D[j, j], D[j, j + 1], D[j + 1, j], D[j + 1, j + 1] = c, -s, s, c
    B = F.polar(F.exact(_rng(m, 2).standard_normal((m, m))))
    return F.rounded(F.multiply(F.multiply(B, D), B.T))


def below_pi(distance: float) -> mpmath.mpf:
    """Angle at the given distance from pi, to 60 digits: the double nearest to pi is 1e-16 off."""
    with mpmath.workdps(90):
        return mpmath.pi - mpmath.mpf(distance)


def _permutation(*cycles: int) -> Array:
    """Permutation matrix with cycles of the given lengths."""
    return _blocks(*(np.roll(np.eye(length), 1, axis=0) for length in cycles))


def log_cases() -> list[Case]:
    """Rotations."""
    cases = [Case("random", rotation(list(_rng(m, 3).uniform(0, 3.1, m // 2)), m)) for m in SIZES]
    for m in (2, 3, 4, 12):
        for j in range(1, 15):
            angles = [below_pi(10.0**-j), *_rng(m, 4).uniform(0, 2.5, m // 2 - 1)]
            cases.append(Case(f"one angle pi - 1e-{j:02d}", rotation(angles, m)))
    cases += [Case("one angle pi - 1e-10", rotation([below_pi(1e-10), 0.3, 1.7], m)) for m in (6, 30, 50)]
    cases += [Case("all angles pi - 1e-6", rotation([below_pi(1e-6)] * (m // 2), m)) for m in (4, 5, 12, 30)]
    cases += [Case("two angles, pi - 1e-10 and pi - 2e-10", rotation([below_pi(1e-10), below_pi(2e-10)], 4))]
    for m in (4, 6, 12, 30):
        half = m // 2
        cases += [
            Case("all angles 1.2", rotation([1.2] * half, m)),
            Case("angles 1e-8 apart", rotation(list(1.2 + 1e-8 * np.arange(half)), m)),
            Case("angles 1e-8 apart, near 0", rotation(list(1e-8 * np.arange(half)), m)),
            Case("angles 1e-5 apart", rotation(list(2.0 + 1e-5 * np.arange(half)), m)),
        ]
    cases += [
        Case("pairs theta and pi - theta", rotation([0.4, below_pi(0.4), 1.1, below_pi(1.1)], m)) for m in (8, 13)
    ]
    cases += [Case(f"all angles {t:g}", rotation([t] * (m // 2), m)) for t in (1e-3, 1e-8, 1e-12) for m in (3, 6, 12)]
    cases += [Case("identity", np.eye(m)) for m in (2, 3, 7)]
    cases += [Case("most angles 0", rotation([1.0], m)) for m in (5, 30)]
    cases += [Case("cyclic permutation", _permutation(m)) for m in (3, 5, 9, 25)]
    cases += [Case("permutation, cycles 3, 5, 7, 1, 1", _permutation(3, 5, 7, 1, 1))]
    cases += [
        Case("blocks", _blocks(rotation([2.0], 3), np.eye(2), rotation([3.0, 1.0], 4))),
        Case("denormal angle", _tiny(4, 1e-310)),
        Case("angle 1e-300", _tiny(3, 1e-300)),
        Case("angle 1e-300", _tiny(6, 1e-300)),
        Case("denormal beside 1", _blocks(rotation([1.0], 2), _tiny(2, 1e-310))),
    ]
    return cases


def _tiny(m: int, norm: float) -> Array:
    """Identity plus a skew matrix: a rotation to all digits if the norm is below 1e-8."""
    return np.eye(m) + random_skew(m, norm)
