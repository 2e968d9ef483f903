"""Errors of exponentials, logarithms and principal angles of frames and subspaces, and the promised bounds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.accuracy.errors import UNIT, arithmetic
from benchmarks.accuracy.fixed_point import Array, Integers, Matrix, embedded, restricted
from benchmarks.accuracy.frame_cases import Shot
from benchmarks.accuracy.frame_reference import geodesic, orthonormal, singular_values, tangent
from stiefel_rs import Grassmann


@dataclass(frozen=True)
class ShotErrors:
    """Errors of a geodesic and of its logarithm, None if there is no such error; `page.md` explains each."""

    exp: float
    zeros: float | None
    log: float
    backward: float
    angles: float | None

    @staticmethod
    def bounds(shot: Shot) -> ShotErrors:
        """The promised bounds: a relative error of eps in the subspace turns the logarithm by `eps / cos(theta)`."""
        unit = shot.manifold.n * UNIT
        loss = 1 / math.cos(float(singular_values(shot.velocity)[0])) if shot.horizontal else 1.0
        return ShotErrors(unit, unit, unit * loss, unit, unit)

    def above(self, bounds: ShotErrors) -> list[str]:
        """Names of the errors above their bounds."""
        found: dict[str, Any] = vars(self)
        return [name for name, value in found.items() if value is not None and not value <= getattr(bounds, name)]


class Reference:
    """The exact geodesic of a shot and its end, rounded, in the turned basis."""

    def __init__(self, shot: Shot) -> None:
        self.shot = shot
        self.complex = shot.manifold.field == "complex"
        self.F = arithmetic(embedded(shot.velocity))
        self.point = orthonormal(self.F, shot.point)
        self.velocity = tangent(self.F, self.point, shot.velocity, horizontal=shot.horizontal)
        self.end = geodesic(self.F, self.point, self.velocity)
        self.turn = orthonormal(self.F, shot.turn.astype(shot.point.dtype))
        self.target = self.doubles(self.F.multiply(self.end, self.turn))

    @property
    def size(self) -> float:
        """What errors are relative to: dense points determine velocities to an absolute accuracy only."""
        return min(1.0, self.norm(self.velocity)) if self.shot.has_zeros else 1.0

    def doubles(self, X: Integers) -> Matrix:
        """The matrix of doubles nearest to an embedded one."""
        rounded = self.F.rounded(X)
        return restricted(rounded) if self.complex else rounded

    def norm(self, X: Integers) -> float:
        """Frobenius norm of the matrix that is embedded."""
        return self.F.norm(X) / (math.sqrt(2) if self.complex else 1.0)

    def miss(self, arrived: Integers) -> float:
        """Distance of an end from the given one; for subspaces, the sines of their principal angles."""
        target = self.exact(self.target)
        if not self.shot.horizontal:
            return self.norm(arrived - target)
        Y = orthonormal(self.F, self.target)
        return self.norm(arrived - self.F.multiply(Y, self.F.multiply(Y.T, arrived)))

    def exact(self, A: Matrix) -> Integers:
        """A matrix of doubles, embedded."""
        return self.F.exact(embedded(A))


def measure(reference: Reference) -> ShotErrors:
    """Errors of stiefel_rs: of the end, and of logarithm and angles for the rounded exact end."""
    shot, F = reference.shot, reference.F
    M, S0, S1 = shot.manifold, shot.point, reference.target
    error = reference.exact(M.exp(S0, shot.velocity)) - reference.end
    log = M.log(S0, S1)
    arrived = geodesic(F, reference.point, tangent(F, reference.point, log, horizontal=shot.horizontal))
    return ShotErrors(
        exp=reference.norm(error),
        zeros=_zeros(error, reference) / reference.size if shot.has_zeros else None,
        log=reference.norm(reference.exact(log) - reference.velocity) / reference.size,
        backward=reference.miss(arrived),
        angles=angle_error(M.principal_angles(S0, S1), reference) if isinstance(M, Grassmann) else None,
    )


def angle_error(angles: Array, reference: Reference) -> float:
    """Largest error of principal angles, which are the singular values of the velocity."""
    return float(np.abs(angles - singular_values(reference.shot.velocity)).max() / reference.size)


def _zeros(error: Integers, reference: Reference) -> float:
    """Norm of the rows in which the given point is zero."""
    rows = ~embedded(reference.shot.point).any(axis=1)
    return reference.norm(error[rows])
