"""Skew-Hermitian and unitary matrices whose exponential and logarithm are compared with 60 digits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mpmath
import numpy as np

from benchmarks.accuracy.cases import BITS, Case, below_pi
from benchmarks.accuracy.fixed_point import FixedPoint, Matrix, embedded, restricted

SIZES = (1, 2, 3, 4, 5, 12, 30)


@dataclass(frozen=True)
class Unitary(Case):
    """A unitary matrix, with its logarithm divided by pi if it has angles of pi."""

    log_over_pi: Matrix | None = None


def _rng(*key: int) -> np.random.Generator:
    return np.random.default_rng([52, *key])


def _normal(m: int, key: int) -> Matrix:
    return _rng(m, key).standard_normal((m, m)) + 1j * _rng(m, key, 1).standard_normal((m, m))


def random_skew_hermitian(m: int, norm: float) -> Matrix:
    """Skew-Hermitian matrix of given spectral norm."""
    A = _normal(m, 0)
    A = A - A.conj().T
    return np.asarray(A / np.linalg.norm(A, 2) * norm)


def _blocks(*blocks: Matrix) -> Matrix:
    """Block diagonal matrix."""
    m = sum(map(len, blocks))
    out, at = np.zeros((m, m), dtype=np.complex128), 0
    for block in blocks:
        out[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    return out


def _in_a_basis(angles: Sequence[float], m: int) -> Matrix:
    """Skew-Hermitian matrix with the given angles, the others 0, in a random orthonormal basis."""
    B = np.linalg.qr(_normal(m, 2))[0][:, : len(angles)]
    A = (B * (1j * np.array(angles))) @ B.conj().T
    return np.asarray((A - A.conj().T) / 2)


def exp_cases() -> list[Case]:
    """Skew-Hermitian matrices."""
    cases = [Case("random, norm 1", random_skew_hermitian(m, 1.0)) for m in SIZES]
    for m in (2, 3, 12):
        for norm in (1e-300, 1e-16, 1e-8, 1e-3, 10.0, 1e3):
            cases.append(Case(f"random, norm {norm:g}", random_skew_hermitian(m, norm)))
    return [
        *cases,
        Case("zero", np.zeros((5, 5), dtype=np.complex128)),
        Case("denormal entries", random_skew_hermitian(4, 1e-310)),
        Case("phases", np.diag(1j * np.array([3.0, -2.0, 1e-8, 0.0, 1e-300]))),
        Case("imaginary, symmetric", 1j * random_skew_hermitian(6, 1.5).imag),
        Case("real, skew", random_skew_hermitian(6, 1.5).real + 0j),
        Case(
            "blocks and zeros", _blocks(random_skew_hermitian(5, 2.0), np.zeros((7, 7)), random_skew_hermitian(4, 0.3))
        ),
        Case("blocks of norm 100 and 1e-8", _blocks(random_skew_hermitian(3, 100.0), random_skew_hermitian(3, 1e-8))),
        Case("rank 1", _in_a_basis([2.5], 30)),
        Case("equal angles", _in_a_basis([1.2] * 6, 12)),
        Case("angles 1e-8 apart", _in_a_basis(list(1.2 + 1e-8 * np.arange(12)), 12)),
        Case("angles pi - 1e-6 and -pi + 1e-6", _in_a_basis([np.pi - 1e-6, 1e-6 - np.pi] * 6, 12)),
        Case("angles at multiples of pi", _in_a_basis([np.pi, -2 * np.pi, 3 * np.pi], 6)),
    ]


def unitary(angles: Sequence[mpmath.mpf | float], m: int, *, bits: int = BITS) -> Matrix:
    """Unitary matrix with given angles in a random basis, accurate to 60 digits before it is rounded to doubles."""
    F = FixedPoint(bits)
    one = mpmath.mpf(2) ** bits
    D = F.identity(2 * m)
    with mpmath.workprec(bits + 64):
        for j, angle in enumerate(angles):
            c, s = int(mpmath.nint(mpmath.cos(angle) * one)), int(mpmath.nint(mpmath.sin(angle) * one))
            D[j, j], D[j, m + j], D[m + j, j], D[m + j, m + j] = c, -s, s, c
    B = F.polar(F.exact(embedded(_normal(m, 3))))
    return restricted(F.rounded(F.multiply(F.multiply(B, D), B.T)))


def _fourth_root(name: str, Q: Matrix) -> Unitary:
    """A matrix with `Q^4 = I`; `Q` and its logarithm over pi are matrices of doubles."""
    powers = [np.linalg.matrix_power(Q, j) for j in range(4)]
    # Projections to the eigenspaces of -1, i and -i, with the angles divided by pi.
    angles = {-1: 1.0, 1j: 0.5, -1j: -0.5}
    log = sum(1j * part * sum(root**-j * powers[j] for j in range(4)) / 4 for root, part in angles.items())
    return Unitary(name, Q, np.asarray(log))


def log_cases(sizes: Sequence[int] = SIZES) -> list[Unitary]:
    """Unitary matrices, random ones of the given sizes."""
    cases = [Unitary("random", unitary(list(_rng(m, 4).uniform(-3.1, 3.1, m)), m)) for m in sizes]
    for m in (1, 2, 3, 12):
        for exponent in (1, 6, 10, 14):
            angles = [below_pi(10.0**-exponent), *_rng(m, 5).uniform(-1, 2.5, m - 1)]
            cases.append(Unitary(f"one angle pi - 1e-{exponent:02d}", unitary(angles, m)))
    cases += [Unitary("all angles pi - 1e-6", unitary([below_pi(1e-6)] * m, m)) for m in (4, 12)]
    for m in (2, 4, 12):
        ends = [below_pi(1e-6), -below_pi(1e-6)] * (m // 2)
        cases.append(Unitary("angles pi - 1e-6 and -pi + 1e-6", unitary(ends, m)))
    for m in (4, 12):
        steps = np.arange(m)
        cases += [
            Unitary("all angles 1.2", unitary([1.2] * m, m)),
            Unitary("angles 1e-8 apart", unitary(list(1.2 + 1e-8 * steps), m)),
            Unitary("angles 1e-8 apart, near 0", unitary(list(1e-8 * steps), m)),
            Unitary("angles 1e-5 apart", unitary(list(2.0 + 1e-5 * steps), m)),
            Unitary("most angles 0", unitary([1.0], m)),
        ]
    cases += [Unitary(f"all angles {t:g}", unitary([t] * m, m)) for t in (1e-3, 1e-8, 1e-12) for m in (2, 3, 12)]
    cases += [Unitary("identity", np.eye(m) + 0j) for m in (2, 7)]
    u = np.array([1, 1j, -1, -1j])
    F = u[np.outer(np.arange(4), np.arange(4)) % 4] / 2
    return [
        *cases,
        _fourth_root("angle pi", np.array([[-1.0 + 0j]])),
        _fourth_root("phases 1, i, -1, -i", np.diag(u)),
        _fourth_root("exchange of two columns", np.roll(np.eye(2), 1, axis=0) + 0j),
        _fourth_root("cyclic permutation", np.roll(np.eye(4), 1, axis=0) + 0j),
        _fourth_root("reflection", np.eye(4) - np.outer(u, u.conj()) / 2),
        _fourth_root("Fourier matrix", F),
        _fourth_root("two Fourier matrices", np.kron(np.eye(2), F)),
        Unitary("angle 1e-300", np.eye(3) + random_skew_hermitian(3, 1e-300)),
    ]
