"""Points and tangent vectors of complex frames and of subspaces, whose geodesics are compared with 60 digits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from benchmarks.accuracy.fixed_point import Matrix
from stiefel_rs import Grassmann, Stiefel

Manifold: TypeAlias = Stiefel | Grassmann


def name_of(M: Manifold) -> str:
    """Name of a manifold."""
    letters = "Gr" if isinstance(M, Grassmann) else "St"
    return f"{letters}({M.n},{M.k}{', C' if M.field == 'complex' else ''})"


@dataclass(frozen=True)
class Shot:
    """A point, a tangent vector there, and the factor that turns the basis at the end."""

    name: str
    manifold: Manifold
    point: Matrix
    velocity: Matrix
    turn: Matrix

    @property
    def horizontal(self) -> bool:
        """Whether points are subspaces."""
        return isinstance(self.manifold, Grassmann)

    @property
    def length(self) -> float:
        """Frobenius norm of the velocity."""
        largest = np.abs(self.velocity).max()
        return float(np.linalg.norm(self.velocity / largest) * largest)

    @property
    def has_zeros(self) -> bool:
        """Whether rows of the point are zero."""
        return not self.point.any(axis=1).all()


def random_matrix(M: Manifold, shape: tuple[int, ...], key: int) -> Matrix:
    """Independent normally distributed entries in the field of a manifold."""
    rng = np.random.default_rng([53, M.n, M.k, key])
    Z = rng.standard_normal(shape)
    return Z + 1j * rng.standard_normal(shape) if M.field == "complex" else Z


def orthonormal_columns(M: Manifold, n: int, k: int, key: int) -> Matrix:
    """Random orthonormal columns."""
    return np.asarray(np.linalg.qr(random_matrix(M, (n, k), key))[0])


def frame(name: str, n: int, k: int, length: float) -> Shot:
    """A complex frame and a tangent vector of given length in the canonical metric."""
    M = Stiefel(n, k, field="complex")
    S = orthonormal_columns(M, n, k, 0)
    Z = random_matrix(M, (n, k), 1)
    inner = S.conj().T @ Z
    V = Z - S @ (inner + inner.conj().T) / 2
    omega = S.conj().T @ V
    size = np.sqrt(np.linalg.norm(V) ** 2 - np.linalg.norm(omega) ** 2 / 2)
    return Shot(name, M, S, V * (length / size), np.eye(k))


def subspace(name: str, M: Grassmann, theta: Sequence[float]) -> Shot:
    """A subspace, a horizontal vector with given singular values, the others 0, and another basis at its end."""
    n, k = M.n, M.k
    basis, W = orthonormal_columns(M, n, n if n < 100 else 2 * k, 0), orthonormal_columns(M, k, k, 1)
    count = len(theta)
    V = (basis[:, k : k + count] * np.array(theta)) @ W[:, :count].conj().T
    return Shot(name, M, basis[:, :k], V, orthonormal_columns(M, k, k, 2))


def coordinates(M: Manifold, length: float) -> Shot:
    """The first columns of the identity and a vector with zeros, whose entries and end have few digits to lose."""
    n, k = M.n, M.k
    unit = 0.6 + 0.8j if M.field == "complex" else 1.0
    V = np.zeros((n, k), dtype=np.asarray(unit).dtype)
    for i in range(min(k, n - k)):
        V[k + i, i] = length * unit / 2**i
    if isinstance(M, Stiefel):
        V[k - 1, k - 1] = 1j * length / 4
    # Signs and a permutation: the turned basis has the same entries.
    turn = np.roll(np.diag((-1.0) ** np.arange(k)), 1, axis=0) if isinstance(M, Grassmann) else np.eye(k)
    return Shot(f"coordinate columns, {length:g}", M, np.eye(n, k, dtype=V.dtype), V, turn)


TINY = (1e-300, 1e-16, 1e-8, 1.0)


def frame_cases() -> list[Shot]:
    """Complex frames."""
    shapes = ((1, 1), (2, 1), (3, 1), (2, 2), (4, 2), (4, 4), (10, 3), (50, 5))
    cases = [frame("random, length 0.5", n, k, 0.5) for n, k in shapes]
    for n, k in ((3, 1), (4, 2), (10, 3)):
        cases += [frame(f"random, length {length:g}", n, k, length) for length in (1e-8, 1e-3, 1.5)]
    return cases + [coordinates(Stiefel(n, k, field="complex"), x) for n, k in ((3, 1), (5, 2)) for x in TINY]


def subspace_cases() -> list[Shot]:
    """Real and complex subspaces."""
    cases = []
    for field in ("real", "complex"):
        for n, k in ((2, 1), (4, 2), (5, 3), (10, 3), (50, 5), (200, 6)):
            M = Grassmann(n, k, field=field)
            count = min(k, n - k)
            cases.append(subspace("angles up to 1.2", M, list(np.linspace(1.2, 0.3, count))))
            if (n, k) in ((4, 2), (10, 3)):
                cases += [
                    subspace("all angles 0.7", M, [0.7] * count),
                    subspace("angles 1e-8 apart", M, list(0.7 + 1e-8 * np.arange(count))),
                    subspace("one angle pi/2 - 1e-6", M, [np.pi / 2 - 1e-6, *np.linspace(1.0, 0.2, count - 1)]),
                    subspace("one angle 1e-8", M, [*np.linspace(1.0, 0.2, count - 1), 1e-8]),
                    subspace("all angles 1e-8", M, [1e-8] * count),
                ]
        for n, k in ((3, 1), (5, 2)):
            cases += [coordinates(Grassmann(n, k, field=field), x) for x in TINY]
    return cases
