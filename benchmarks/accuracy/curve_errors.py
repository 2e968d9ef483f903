"""Errors of cubics and splines: of their equation, their points, their accelerations at knots and their cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.accuracy.curve_cases import Problem
from benchmarks.accuracy.fixed_point import Array, Matrix
from benchmarks.accuracy.frame_cases import Manifold
from stiefel_rs import CubicSpline, Curve, Grassmann, RiemannianCubic, Stiefel

# Type checkers do not see static methods of a class whose constructor never returns.
Cubics: Any = RiemannianCubic
# Gauss nodes of a piece.
NODES = 32


def H(A: Matrix) -> Matrix:
    """Conjugate transposes."""
    return np.asarray(np.conj(np.swapaxes(A, -1, -2)))


def connection(M: Manifold, S: Matrix, V: Matrix, W: Matrix) -> Matrix:
    """The difference of the covariant derivative of `W` along `V` and of `W'`."""
    if isinstance(M, Grassmann):
        return np.asarray(S @ (H(V) @ W))
    K, L = V - S @ (H(S) @ V), W - S @ (H(S) @ W)
    return np.asarray((V @ H(W) + W @ H(V)) @ S / 2 + S @ (H(K) @ L + H(L) @ K) / 2)


def curvature(M: Manifold, S: Matrix, A: Matrix, V: Matrix) -> Matrix:
    """`R(A, V) V` in the canonical metric."""
    if isinstance(M, Grassmann):
        return np.asarray(A @ H(V) @ V - V @ H(A) @ V + V @ (H(V) @ A - H(A) @ V))
    x, y = _split(S, A), _split(S, V)
    terms = _levi_civita(x, _levi_civita(y, y)), _levi_civita(y, _levi_civita(x, y)), _levi_civita(_bracket(x, y), y)
    omega, K = (first - second - third for first, second, third in zip(*terms, strict=True))
    # The part of the bracket in h.
    lower = y[1] @ H(x[1]) - x[1] @ H(y[1])
    return np.asarray(S @ omega + K - lower @ y[1])


def _split(S: Matrix, V: Matrix) -> tuple[Matrix, Matrix]:
    """`Omega` and `K` of `V = S Omega + K`."""
    omega = H(S) @ V
    return omega, V - S @ omega


def _bracket(x: tuple[Matrix, Matrix], y: tuple[Matrix, Matrix]) -> tuple[Matrix, Matrix]:
    """The part of the bracket in m."""
    (A, B), (C, D) = x, y
    return A @ C - C @ A - H(B) @ D + H(D) @ B, B @ C - D @ A


def _levi_civita(x: tuple[Matrix, Matrix], y: tuple[Matrix, Matrix]) -> tuple[Matrix, Matrix]:
    """Half of the part of the bracket in m: the manifold is naturally reductive."""
    omega, K = _bracket(x, y)
    return omega / 2, K / 2


def norm(M: Manifold, S: Matrix, V: Matrix) -> Array:
    """Norms of tangent vectors in the canonical metric."""
    squares = np.sum(np.abs(V) ** 2, axis=(-2, -1))
    if isinstance(M, Stiefel):
        squares = squares - np.sum(np.abs(H(S) @ V) ** 2, axis=(-2, -1)) / 2
    return np.asarray(np.sqrt(np.maximum(squares, 0)))


def _nodes() -> tuple[Array, Array, Array]:
    """Gauss nodes of [0, 1], their weights, and the matrix that integrates values there from 0 to every node."""
    x, weights = np.polynomial.legendre.leggauss(NODES)
    values = np.polynomial.legendre.legvander(x, NODES - 1)
    integrals = np.stack([np.polynomial.legendre.legint(row, lbnd=-1) for row in np.eye(NODES)], axis=1)
    upto = np.polynomial.legendre.legval(x, integrals).T
    return (x + 1) / 2, weights / 2, upto @ np.linalg.inv(values) / 2


def equation(M: Manifold, piece: Curve) -> float:
    """Largest defect of the integrated equations of a cubic on [0, 1], relative to the sizes of its derivatives."""
    t, _, upto = _nodes()
    states = [piece(t), piece.velocity(t), piece.acceleration(t), piece.jerk(t)]
    S, V, A, J = states
    covariant = V, A, J, -curvature(M, S, A, V)
    slopes = [V, *(D - connection(M, S, V, W) for D, W in zip(covariant[1:], (V, A, J), strict=True))]
    size = max(1.0, *(float(np.linalg.norm(X, axis=(1, 2)).max()) for X in states[1:]))
    defects = []
    for X, slope in zip(states, slopes, strict=True):
        change = X - np.tensordot(upto, slope, axes=1)
        defects.append(float(np.linalg.norm(change - change[0], axis=(1, 2)).max()))
    return max(defects) / size


@dataclass(frozen=True)
class CurveErrors:
    """Errors of a cubic or spline, None if there is no such error; `page.md` explains each."""

    equation: float
    given: float
    points: float | None
    jump: float | None
    cost: float

    @staticmethod
    def bounds() -> CurveErrors:
        """The promised bounds; the solvers' tolerance, for the ends of pieces and for accelerations, is 1e-12."""
        return CurveErrors(1e-11, 2e-12, 1e-11, 1e-11, 1e-12)

    def above(self, bounds: CurveErrors) -> list[str]:
        """Names of the errors above their bounds."""
        found: dict[str, Any] = vars(self)
        return [name for name, value in found.items() if value is not None and not value <= getattr(bounds, name)]


def solve(problem: Problem) -> Curve:
    """The curve by stiefel_rs."""
    found: Curve
    if problem.velocities is None:
        found = CubicSpline(problem.t, problem.points, manifold=problem.manifold)
    else:
        (S0, S1), (V0, V1) = problem.points, problem.velocities
        if problem.initial is None:
            found = Cubics.from_boundary(S0, V0, S1, V1, manifold=problem.manifold)
        else:
            found = Cubics.from_initial(S0, V0, *problem.initial, manifold=problem.manifold)
    return found


def curve_errors(problem: Problem, curve: Curve) -> CurveErrors:
    """Errors of a curve."""
    M, exact = problem.manifold, problem.solution
    pieces = curve.pieces if isinstance(curve, CubicSpline) else [curve]
    cost = _integral(M, curve, problem.t) if exact is None or exact.cost is None else exact.cost
    return CurveErrors(
        equation=max(equation(M, piece) for piece in pieces),
        given=_given(problem, curve),
        points=None if exact is None else _distance(M, exact.points, curve(exact.t)),
        jump=None if problem.velocities is not None else _jump(problem, curve),
        cost=abs(curve.cost() - cost) / cost,
    )


def _distance(M: Manifold, expected: Matrix, found: Matrix) -> float:
    """Largest distance of points; of subspaces, the sines of their principal angles."""
    errors = found - (expected @ (H(expected) @ found) if isinstance(M, Grassmann) else expected)
    return float(np.linalg.norm(errors, axis=(1, 2)).max())


def _given(problem: Problem, curve: Curve) -> float:
    """Largest distance from the given points, and of the velocities at the ends from the given ones."""
    M, found = problem.manifold, curve(problem.t)
    distance = _distance(M, problem.points, found)
    if problem.velocities is None:
        return distance
    turns = H(problem.points) @ found if isinstance(M, Grassmann) else np.eye(M.k)
    excess = curve.velocity(problem.t) - problem.velocities @ turns
    return max(distance, float(np.linalg.norm(excess, axis=(1, 2)).max()))


def _jump(problem: Problem, curve: Curve) -> float:
    """Largest jump of the acceleration, which is 0 outside of a natural spline, relative to its largest norm."""
    M, t, S = problem.manifold, problem.t, curve(problem.t)
    right, left = curve.acceleration(t), curve.acceleration(np.nextafter(t, -np.inf).clip(t[0]))
    jumps = right - left
    jumps[0], jumps[-1] = right[0], left[-1]
    return float(norm(M, S, jumps).max() / norm(M, S, right).max())


def _integral(M: Manifold, curve: Curve, t: Array) -> float:
    """Integral of the squared norm of the covariant acceleration."""
    nodes, weights, _ = _nodes()
    total = 0.0
    for start, width in zip(t[:-1], np.diff(t), strict=True):
        times = start + width * nodes
        total += float(width * weights @ norm(M, curve(times), curve.acceleration(times)) ** 2)
    return total
