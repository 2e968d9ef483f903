"""Cubics and splines of complex frames and of subspaces."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace

import numpy as np
import scipy.interpolate

from benchmarks.accuracy.fixed_point import Array, Matrix
from benchmarks.accuracy.frame_cases import Manifold, orthonormal_columns, random_matrix
from benchmarks.accuracy.torus import Torus
from benchmarks.environment import ROOT
from stiefel_rs import Grassmann, Stiefel

# Number of knots of the splines.
KNOTS = 12
# Distance in the Frobenius norm, about, of consecutive points.
STEP = 0.7


@dataclass(frozen=True)
class Solution:
    """Points of the exact curve at some times, and its cost if that is known."""

    t: Array
    points: Matrix
    cost: float | None = None


@dataclass(frozen=True)
class Problem:
    """Points to interpolate by a natural spline, two ends to join by a cubic, or initial data of a cubic.

    Attributes
    ----------
    name : str
        How the data were chosen.
    manifold : Stiefel or Grassmann
        Where the points lie.
    t : ndarray, shape (N,)
        Times of the points.
    points : ndarray, shape (N, n, k)
        Points; of subspaces, any bases.
    velocities : ndarray or None
        For a cubic, those at both ends.
    initial : ndarray or None
        For a cubic from initial data, its covariant acceleration and jerk at the start.
    solution : Solution or None
        The exact curve if it is known.
    """

    name: str
    manifold: Manifold
    t: Array
    points: Matrix
    velocities: Matrix | None = None
    initial: Matrix | None = None
    solution: Solution | None = None

    @property
    def kind(self) -> str:
        """Kind of curve."""
        if self.velocities is None:
            return "spline"
        return "cubic between ends" if self.initial is None else "cubic from a start"


def _times(M: Manifold) -> Array:
    rng = np.random.default_rng([54, M.n, M.k])
    return np.concatenate([[0.0], np.cumsum(rng.uniform(0.7, 1.3, KNOTS - 1))])


def _tangent(M: Manifold, S: Matrix, length: float, key: int) -> Matrix:
    """Tangent vector of given Frobenius norm."""
    Z = random_matrix(M, (M.n, M.k), key)
    inner = S.conj().T @ Z
    V = Z - S @ (inner if isinstance(M, Grassmann) else (inner + inner.conj().T) / 2)
    return np.asarray(V * (length / np.linalg.norm(V)))


def _next(M: Manifold, S: Matrix, key: int) -> Matrix:
    """A point near the given one: the polar factor of the sum with a tangent vector."""
    U, _, Wh = np.linalg.svd(S + _tangent(M, S, STEP, key), full_matrices=False)
    return np.asarray(U @ Wh)


def _turned(M: Manifold, points: Matrix) -> Matrix:
    """Other bases of all subspaces but the first one; frames as they are."""
    if not isinstance(M, Grassmann):
        return points
    turns = np.stack([orthonormal_columns(M, M.k, M.k, 100 + i) for i in range(1, len(points))])
    return np.concatenate([points[:1], points[1:] @ turns])


def random_cubic(M: Manifold) -> Problem:
    """Random ends."""
    S0 = orthonormal_columns(M, M.n, M.k, 10)
    points = _turned(M, np.stack([S0, _next(M, S0, 11)]))
    velocities = np.stack([_tangent(M, S, STEP, 12 + i) for i, S in enumerate(points)])
    return Problem("random", M, np.array([0.0, 1.0]), points, velocities)


def random_spline(M: Manifold) -> Problem:
    """Points of a random walk."""
    points = [orthonormal_columns(M, M.n, M.k, 20)]
    for i in range(1, KNOTS):
        points.append(_next(M, points[-1], 20 + i))
    return Problem("random", M, _times(M), _turned(M, np.stack(points)))


def torus_cubic(M: Manifold, *, dense: bool) -> Problem:
    """Ends of a curve whose angles are cubic polynomials."""
    torus = Torus.of(M, dense=dense)
    angles, rates = np.random.default_rng([55, M.n, M.k]).uniform(-0.7, 0.7, (2, 2, torus.dim))
    exact = scipy.interpolate.CubicHermiteSpline([0.0, 1.0], angles, rates)
    velocities = torus.velocity(angles, rates)
    if isinstance(M, Grassmann):
        turn = orthonormal_columns(M, M.k, M.k, 101)
        velocities = np.stack([velocities[0], velocities[1] @ turn])
    problem = _of_torus(torus, M, exact, dense=dense)
    return replace(problem, velocities=velocities)


def torus_spline(M: Manifold, *, dense: bool) -> Problem:
    """Points of a curve whose angles are natural cubic splines."""
    torus, t = Torus.of(M, dense=dense), _times(M)
    angles = np.cumsum(np.random.default_rng([56, M.n, M.k]).uniform(-0.5, 0.7, (KNOTS, torus.dim)), axis=0)
    exact = scipy.interpolate.CubicSpline(t, angles, bc_type="natural")
    return _of_torus(torus, M, exact, dense=dense)


def _of_torus(torus: Torus, M: Manifold, exact: scipy.interpolate.PPoly, *, dense: bool) -> Problem:
    name = "flat torus" if dense else "flat torus, coordinate columns"
    t = np.asarray(exact.x)
    checks = np.linspace(t[0], t[-1], 101)
    solution = Solution(checks, torus.at(exact(checks)), torus.cost(exact))
    return Problem(name, M, t, _turned(M, torus.at(exact(t))), solution=solution)


def forty_digits(M: Manifold) -> Problem:
    """A cubic of real frames or lines that is known to 40 digits, moved by unitary matrices."""
    entries = json.loads((ROOT / "tests" / "data" / "cubics.json").read_text())
    entry = next(each for each in entries if (each["n"], each["k"]) == (M.n, M.k))
    left, right = orthonormal_columns(M, M.n, M.n, 30), orthonormal_columns(M, M.k, M.k, 31)

    def read(state: dict[str, list[list[str]]], name: str) -> Matrix:
        return np.asarray(left @ np.array(state[name], dtype=np.float64) @ right)

    start, end = entry["initial"], entry["at"]["1.0"]
    points, velocities = (np.stack([read(state, name) for state in (start, end)]) for name in ("point", "velocity"))
    initial = np.stack([read(start, name) for name in ("acceleration", "jerk")])
    solution = Solution(np.array([0.5]), read(entry["at"]["0.5"], "point")[None])
    return Problem("known to 40 digits", M, np.array([0.0, 1.0]), points, velocities, initial, solution)


def _manifolds(shapes: tuple[tuple[int, int], ...]) -> list[Manifold]:
    subspaces = [Grassmann(n, k, field=field) for field in ("real", "complex") for n, k in shapes]
    return [*(Stiefel(n, k, field="complex") for n, k in shapes), *subspaces]


def curve_cases() -> list[Problem]:
    """All problems."""
    dense, axes = _manifolds(((3, 1), (4, 2), (10, 3), (50, 5))), _manifolds(((3, 1), (5, 2)))
    unitary = [Stiefel(1, 1, field="complex"), Stiefel(3, 3, field="complex")]
    known: list[Manifold] = [Stiefel(5, 2, field="complex"), Stiefel(6, 3, field="complex")]
    known += [Grassmann(3, 1), Grassmann(10, 1), Grassmann(10, 1, field="complex")]
    cases: list[Problem] = []
    for M in dense:
        cases += [random_cubic(M), torus_cubic(M, dense=True), random_spline(M), torus_spline(M, dense=True)]
    for M in axes:
        cases += [torus_cubic(M, dense=False), torus_spline(M, dense=False)]
    for M in unitary:
        cases += [torus_cubic(M, dense=True), torus_spline(M, dense=True)]
    return cases + [forty_digits(M) for M in known]
