"""Riemannian cubics to compute: the paper's two, with 40-digit solutions, and random boundary data."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np

from benchmarks.environment import ROOT
from benchmarks.problems import Array, Boundary, Field, geodesic_end, point, tangent

PAPER = {"sphere": "paper-sphere", "frame": "paper-stiefel-3-2"}
RANDOM = ((10, 3), (50, 5), (1000, 5))
LENGTH = 1.5
STATE = ("point", "velocity", "acceleration", "jerk")


@dataclass(frozen=True)
class Cubic:
    """A cubic of the paper: position and covariant derivatives at the times 0, 1/2 and 1, each `(n, k)`."""

    initial: tuple[Array, ...]
    middle: tuple[Array, ...]
    end: tuple[Array, ...]

    @property
    def boundary(self) -> Boundary:
        """Its ends."""
        return Boundary(*self.initial[:2], *self.end[:2])


def paper(name: str) -> Cubic:
    """The cubic of one of the paper's experiments, rounded from 40 digits."""
    entries = json.loads((ROOT / "tests" / "data" / "cubics.json").read_text())
    entry = next(each for each in entries if each.get("name") == PAPER[name])
    states = (entry["initial"], entry["at"]["0.5"], entry["at"]["1.0"])
    return Cubic(*(tuple(np.array(state[key], dtype=np.float64) for key in STATE) for state in states))


def random_boundary(n: int, k: int, *, field: Field = "real") -> Boundary:
    """Points at canonical distance 1.5 and velocities of length 1.5."""
    S0 = point(n, k, 9, field=field)
    S1 = geodesic_end(S0, tangent(S0, LENGTH, 10))
    return Boundary(S0, tangent(S0, LENGTH, 11), S1, tangent(S1, LENGTH, 12))


def basis(b: Boundary) -> Array:
    """Orthonormal basis of all columns of boundary data."""
    return np.asarray(np.linalg.qr(np.hstack([b.S0, b.V0, b.S1, b.V1]))[0])


def reduced(b: Boundary) -> Boundary:
    """The same data in that basis."""
    E = basis(b)
    return Boundary(E.T @ b.S0, E.T @ b.V0, E.T @ b.S1, E.T @ b.V1)


def tangent_basis(S: Array) -> Array:
    """Orthonormal basis of the vectors normal to the columns of S."""
    return np.asarray(np.linalg.qr(S, mode="complete")[0][:, S.shape[1] :])


def straight_guess(b: Boundary) -> tuple[Array, Array]:
    """Second and third derivative, at the start, of the cubic of flat space."""
    D = b.S1 - b.S0
    return 6 * D - 4 * b.V0 - 2 * b.V1, 6 * (b.V0 + b.V1) - 12 * D
