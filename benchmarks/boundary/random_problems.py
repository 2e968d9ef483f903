"""Random boundary problems of Riemannian cubics, in families with the same largest distance and speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.problems import Array
from stiefel_rs import RiemannianCubic, Stiefel

# Type checkers do not see static methods of a class whose constructor never returns.
Cubics: Any = RiemannianCubic
RESIDUAL = 1e-12


@dataclass(frozen=True)
class Family:
    """Boundary problems up to a distance and a speed, with their targets."""

    distance: float
    speed: float
    share: float
    steps: int | None

    @property
    def title(self) -> str:
        """The heading of the family."""
        return f"Distance up to {self.distance:g}, speeds up to {self.speed:g}"

    @property
    def target(self) -> str:
        """The targets of the family."""
        steps = f", at most {self.steps} Newton steps" if self.steps is not None else ""
        share = "all" if self.share == 1 else f"at least {self.share:.1%}"
        return f"Target: {share} solved, residual at most {RESIDUAL:g}{steps}."


FAMILIES = (Family(2.0, 2.0, 1.0, 12), Family(3.0, 6.0, 0.998, None))


def problem(M: Stiefel, family: Family, rng: np.random.Generator) -> tuple[Array, Array, Array, Array]:
    """One problem: S0, V0, S1, V1."""

    def tangent(S: Array, most: float) -> Array:
        V = M.project_tangent(S, rng.standard_normal(S.shape))
        return np.asarray(V * (rng.uniform(0.0, most) / M.norm(S, V)))

    S0 = M.random_point(rng)
    S1 = M.exp(S0, tangent(S0, family.distance))
    return S0, tangent(S0, family.speed), S1, tangent(S1, family.speed)
