"""Riemannian cubics by a general solver: `D_t^3 S' + R(D_t S', S') S' = 0` as first-order equations, and shooting.

On the sphere in the ambient space, with covariant derivatives `v, a, j` of a point `x` (`D_t w = w' + <w, x'> x`):

    x' = v,  v' = a - |v|^2 x,  a' = j - <a, v> x,  j' = <a, v> v - |v|^2 a - <j, v> x

On St(n, k) by a rotation `g` whose first columns are the point, its velocity `x` in the complement `m` of so(n - k):

    g' = g x,  x''' = [x'', x]_m - [[x, x']_h, x]
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.integrate
import scipy.optimize

from benchmarks.compare.cubic_problems import straight_guess, tangent_basis
from benchmarks.problems import Array, Boundary

# Tolerance of initial value problems: DOP853 gains nothing below it, since it is round-off. Of shooting: an error of
# 2e-13 for the paper's curve on the sphere.
FINEST, SHOOTING = 1e-13, 1e-12


Field = Callable[[float, Array], Array | list[float]]


def sphere_field(_: float, y: Array) -> Array:
    """Right-hand side on a sphere, for `y` of shape (4 n,) or (4 n, m)."""
    x, v, a, j = np.split(y, 4)
    vv, av, jv = (np.sum(w * v, axis=0) for w in (v, a, j))
    return np.concatenate([v, a - vv * x, j - av * x, av * v - vv * a - jv * x])


def sphere_field_scalar(_: float, y: Array) -> list[float]:
    """The same on S^2 with Python floats: faster than NumPy for 12 numbers."""
    x0, x1, x2, v0, v1, v2, a0, a1, a2, j0, j1, j2 = y.tolist()
    vv = v0 * v0 + v1 * v1 + v2 * v2
    av = a0 * v0 + a1 * v1 + a2 * v2
    jv = j0 * v0 + j1 * v1 + j2 * v2
    return [
        *(v0, v1, v2),
        *(a0 - vv * x0, a1 - vv * x1, a2 - vv * x2),
        *(j0 - av * x0, j1 - av * x1, j2 - av * x2),
        *(av * v0 - vv * a0 - jv * x0, av * v1 - vv * a1 - jv * x1, av * v2 - vv * a2 - jv * x2),
    ]


def solve(
    field: Callable[[float, Array], Array | list[float]], start: Array, end: float = 1.0, tol: float = SHOOTING
) -> Array:
    """DOP853 from 0 to `end`."""
    solution = scipy.integrate.solve_ivp(field, (0.0, end), start, method="DOP853", rtol=tol, atol=tol)
    return np.asarray(solution.y[:, -1])


@dataclass(frozen=True)
class SphereShooting:
    """Boundary data on S^2, solved for the initial acceleration and jerk with `scipy.optimize.root`."""

    b: Boundary

    def solve(self) -> Array:
        """State at the start."""
        b = self.b
        B0, B1 = tangent_basis(b.S0), tangent_basis(b.S1)
        known, wanted = np.vstack([b.S0, b.V0])[:, 0], np.vstack([b.S1, b.V1])[:, 0]

        def start(c: Array) -> Array:
            return np.concatenate([known, *(B0 @ half for half in np.split(c, 2))])

        def defect(c: Array) -> Array:
            D = solve(sphere_field_scalar, start(c))[: len(wanted)] - wanted
            return np.concatenate([B1.T @ half for half in np.split(D, 2)])

        return start(_root(defect, np.concatenate([B0.T @ w[:, 0] for w in straight_guess(b)])))

    def at(self, start: Array, t: float) -> Array:
        """Point and velocity at a time, each (n, 1)."""
        return solve(sphere_field_scalar, start, t)[: 2 * len(self.b.S0)].reshape(2, -1, 1)


@dataclass(frozen=True)
class GroupShooting:
    """The same on St(n, k), with the equation on SO(n)."""

    b: Boundary

    @property
    def shape(self) -> tuple[int, int]:
        """Sizes n, k."""
        n, k = self.b.S0.shape
        return n, k

    def field(self, _: float, y: Array) -> Array:
        """Right-hand side."""
        n, k = self.shape
        g, x, dx, ddx = y.reshape(4, n, n)
        inner = x @ dx - dx @ x
        inner[:, :k] = inner[:k] = 0
        dddx = ddx @ x - x @ ddx
        dddx[k:, k:] = 0
        return np.stack([g @ x, dx, ddx, dddx - (inner @ x - x @ inner)]).ravel()

    def horizontal(self, W: Array) -> Array:
        """The element of m whose first columns are W."""
        n, k = self.shape
        x = np.zeros((n, n))
        x[:k, :k] = (W[:k] - W[:k].T) / 2
        x[k:, :k], x[:k, k:] = W[k:], -W[k:].T
        return x

    def solve(self) -> Array:
        """State at the start."""
        b, (n, k) = self.b, self.shape
        g0, g1 = (np.hstack([S, tangent_basis(S)]) for S in (b.S0, b.S1))
        # Coordinates of m: below the diagonal, in the first columns.
        rows, columns = np.tril_indices(n, -1, k)
        first = self.horizontal(g0.T @ b.V0)

        def start(c: Array) -> Array:
            a, j = np.zeros((2, n, n))
            a[rows, columns], j[rows, columns] = np.split(c, 2)
            a, j = a - a.T, j - j.T
            turn = first @ a - a @ first
            turn[k:, k:] = 0
            return np.stack([g0, first, a, j - turn / 2]).ravel()

        def defect(c: Array) -> Array:
            S, V = self._point(solve(self.field, start(c)))
            return np.concatenate([self.horizontal(g1.T @ D)[rows, columns] for D in (S - b.S1, V - b.V1)])

        guess = [self.horizontal(g0.T @ w)[rows, columns] for w in straight_guess(b)]
        return start(_root(defect, np.concatenate(guess)))

    def at(self, start: Array, t: float) -> Array:
        """Point and velocity at a time."""
        return np.stack(self._point(solve(self.field, start, t)))

    def _point(self, y: Array) -> tuple[Array, Array]:
        n, k = self.shape
        g, x = y.reshape(4, n, n)[:2]
        return g[:, :k], (g @ x)[:, :k]


def _root(defect: Callable[[Array], Array], guess: Array) -> Array:
    found = scipy.optimize.root(defect, guess, method="hybr", options={"xtol": 1e-13})
    # Below the tolerance it may report that it makes no further progress.
    if not np.linalg.norm(defect(found.x)) < 1e-10:
        raise ArithmeticError(found.message)
    return np.asarray(found.x)


def sphere_collocation(b: Boundary, tolerance: float) -> Callable[[float], Array]:
    """The boundary problem on the sphere by `scipy.integrate.solve_bvp`; position and velocity of the solution."""
    ends = np.vstack([b.S0, b.V0, b.S1, b.V1])[:, 0]
    half = len(ends) // 2
    t = np.linspace(0.0, 1.0, 11)
    a, j = straight_guess(b)
    x = b.S0 + t * b.V0 + t**2 / 2 * a + t**3 / 6 * j
    guess = np.vstack([x, b.V0 + t * a + t**2 / 2 * j, a + t * j, np.repeat(j, len(t), axis=1)])

    def boundary(start: Array, end: Array) -> Array:
        return np.asarray(np.concatenate([start[:half], end[:half]]) - ends)

    found = scipy.integrate.solve_bvp(sphere_field, boundary, t, guess, tol=tolerance, max_nodes=20_000)
    if not found.success:
        raise ArithmeticError(found.message)
    return lambda time: np.asarray(found.sol(time)[:half].reshape(2, -1, 1))
