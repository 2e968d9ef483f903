"""Exponential and logarithm of subspaces, with derivatives: Jacobi fields of the Grassmann manifold in closed form.

A tangent vector at the basis `Y` is horizontal, `Y^H V = 0`. With `V = U diag(theta) W^H`, whose `U` is orthogonal
to `Y`, a vector `D` along the geodesic has the coordinates `A = U^H D W` and `B = D W - U A`, in which the curvature
`R(D, V) V` is diagonal:

    theta_j^2 for B_ij,    (theta_i - theta_j)^2 for (A + A^H)_ij,    (theta_i + theta_j)^2 for (A - A^H)_ij

so that a Jacobi field is `cos(x s) D(0) + sin(x s) / x D'(0)` with the roots `x` of these. Curves of bases turn as
little as possible, `Y^H Y' = 0`: where a horizontal variation `D` moves them, the bases turn by `Y w` with
`w' = Y'^H D - D^H Y'`, whose integral has a closed form along a geodesic.

Source: Edelman, Arias, Smith (1998), "The geometry of algorithms with orthogonality constraints", SIAM J. Matrix Anal.
Appl. 20, 303-353, section 2.5 (geodesics, transport); do Carmo (1992), "Riemannian Geometry", chapter 5.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from .._core import Grassmann
from ..errors import OutsideDomainError
from .arguments import Array, skew_part, transposed

# Distance of the root of a curvature from pi below which the logarithm counts as not differentiable: round-off of the
# angles changes the derivative by a part in 1e4.
SINGULAR = 1e-11

# A factor for each of three kinds of coordinates, as a function of the roots.
Factor = Callable[[Array], Array]


def manifold_of(basis: Array) -> Grassmann:
    """Return the manifold of the subspaces that bases, shape (..., n, k), span."""
    n, k = basis.shape[-2:]
    return Grassmann(n, k, field="complex" if basis.dtype.kind == "c" else "real")


def split(basis: Array, move: Array) -> tuple[Array, Array]:
    """Return the horizontal part of a move of a basis, and the skew matrix by which it turns the basis."""
    turn = transposed(basis) @ move
    horizontal: Array = move - basis @ turn
    return horizontal, skew_part(turn)


@dataclass(frozen=True)
class Vector:
    """Coordinates of a horizontal vector along a geodesic: in the span of it, and outside."""

    inside: Array
    outside: Array

    def plus(self, other: Vector) -> Vector:
        """Add."""
        return Vector(self.inside + other.inside, self.outside + other.outside)


class Geodesic:
    """The geodesic from the basis `y` with the velocity `v`, in unit time."""

    def __init__(self, y: Array, v: Array) -> None:
        k = y.shape[1]
        # Householder's columns are orthonormal, whatever the rank of v.
        q = np.linalg.qr(np.hstack([y, v]))[0][:, k:]
        left, sizes, right = np.linalg.svd(transposed(q) @ v)
        self._count = len(sizes)
        self._angles = np.zeros(k)
        self._angles[: self._count] = sizes
        self._w = transposed(right)
        cosines, sines = np.cos(self._angles), np.sin(self._angles)
        start, up = y @ self._w, q @ left
        end = start * cosines
        end[:, : self._count] += up * sines[: self._count]
        along = up * cosines[: self._count] - start[:, : self._count] * sines[: self._count]
        self._up = [up, along]
        #: The basis at the end.
        self.end: Array = end @ right

    def coordinates(self, vector: Array, at: int) -> Vector:
        """Return those of a horizontal vector at the start, 0, or at the basis that is reached, 1."""
        turned = vector @ self._w
        inside = transposed(self._up[at]) @ turned
        return Vector(inside, turned - self._up[at] @ inside)

    def vector(self, coordinates: Vector, at: int) -> Array:
        """Invert `coordinates`."""
        found: Array = (self._up[at] @ coordinates.inside + coordinates.outside) @ transposed(self._w)
        return found

    def scaled(self, coordinates: Vector, factor: Factor) -> Vector:
        """Multiply each kind of coordinates by a function of the root of the curvature; symmetric."""
        m = self._count
        rows, columns = self._angles[:m, None], self._angles[None, :]
        inside = coordinates.inside * factor(np.broadcast_to(rows, coordinates.inside.shape))
        square = coordinates.inside[:, :m]
        both = square + transposed(square), square - transposed(square)
        roots = rows - columns[:, :m], rows + columns[:, :m]
        inside[:, :m] = 0.5 * sum(part * factor(root) for part, root in zip(both, roots, strict=True))
        return Vector(inside, coordinates.outside * factor(columns))

    def check_smooth(self) -> None:
        """Check that the logarithm is differentiable at the end: where two angles add up to pi, it is not."""
        # One angle counts twice where the skew part of a number may differ from zero.
        is_complex = self.end.dtype.kind == "c"
        largest = np.sort(self._angles)[::-1][: 1 if is_complex else 2]
        total = float(largest.sum()) * (2 if is_complex else 1)
        if total >= np.pi - SINGULAR:
            found = "twice the largest principal angle is" if is_complex else "the largest principal angles add up to"
            raise OutsideDomainError(
                f"the logarithm is not differentiable: {found} {total:.17f} (pi up to 1e-11)", float(largest[-1])
            )

    def turn(self, at_start: Vector, change: Vector) -> Array:
        """Return by how much a Jacobi field with that start and first derivative turns the basis at the end."""
        inside = self.scaled(at_start, sine_ratio).plus(self.scaled(change, versine_ratio)).inside
        return self._twist(inside)

    def turn_back(self, turn: Array) -> tuple[Vector, Vector]:
        """Transpose `turn`."""
        back = self._twist_back(turn)
        return self.scaled(back, sine_ratio), self.scaled(back, versine_ratio)

    def _twist(self, inside: Array) -> Array:
        product = np.zeros((len(self._angles),) * 2, inside.dtype)
        product[: self._count] = self._angles[: self._count, None] * inside
        found: Array = self._w @ (product - transposed(product)) @ transposed(self._w)
        return found

    def _twist_back(self, turn: Array) -> Vector:
        inner = transposed(self._w) @ (turn - transposed(turn)) @ self._w
        inside = self._angles[: self._count, None] * inner[: self._count]
        return Vector(inside, np.zeros((len(self._up[0]), len(self._angles)), inside.dtype))


def sine_ratio(x: Array) -> Array:
    """Return `sin(x) / x`."""
    return np.sinc(x / np.pi)


def versine_ratio(x: Array) -> Array:
    """Return `(1 - cos x) / x^2`."""
    found: Array = 0.5 * sine_ratio(0.5 * x) ** 2
    return found


def _inverse_ratio(x: Array) -> Array:
    found: Array = 1.0 / sine_ratio(x)
    return found


def _minus_cotangent(x: Array) -> Array:
    found: Array = -np.cos(x) / sine_ratio(x)
    return found


def exp_variation(data: Sequence[Array], moves: Sequence[Array]) -> Array:
    """Move the end of the geodesic that starts at the basis `y` with the velocity `v`."""
    (y, v), (dy, dv) = data, moves
    geodesic = Geodesic(y, v)
    shift, turn = split(y, dy)
    # Of the velocity at the basis that is not turned, covariantly.
    change = dv - v @ turn
    change = change - y @ (transposed(y) @ change)
    start, slope = geodesic.coordinates(shift, 0), geodesic.coordinates(change, 0)
    moved = geodesic.scaled(start, np.cos).plus(geodesic.scaled(slope, sine_ratio))
    found: Array = geodesic.vector(moved, 1) + geodesic.end @ (turn + geodesic.turn(start, slope))
    return found


def exp_pullback(data: Sequence[Array], cotangent: Array) -> Sequence[Array]:
    """Transpose `exp_variation`."""
    y, v = data
    geodesic = Geodesic(y, v)
    along = cotangent - geodesic.end @ (transposed(geodesic.end) @ cotangent)
    moved = geodesic.coordinates(along, 1)
    by_turn = skew_part(transposed(geodesic.end) @ cotangent)
    start, slope = geodesic.turn_back(by_turn)
    start = start.plus(geodesic.scaled(moved, np.cos))
    slope = slope.plus(geodesic.scaled(moved, sine_ratio))
    by_shift, by_change = geodesic.vector(start, 0), geodesic.vector(slope, 0)
    by_turn = by_turn - skew_part(transposed(v) @ by_change)
    return by_shift + y @ by_turn, by_change


def log_variation(data: Sequence[Array], moves: Sequence[Array]) -> Array:
    """Move the initial velocity of the shortest geodesic from the basis `y0` to the span of `y1`."""
    (y0, y1), (dy0, dy1) = data, moves
    v, geodesic, match = _between(y0, y1)
    shift, turn = split(y0, dy0)
    arrival, _ = split(y1, dy1)
    start, end = geodesic.coordinates(shift, 0), geodesic.coordinates(arrival @ transposed(match), 1)
    slope = geodesic.scaled(start, _minus_cotangent).plus(geodesic.scaled(end, _inverse_ratio))
    found: Array = geodesic.vector(slope, 0) + v @ turn - y0 @ (transposed(shift) @ v)
    return found


def log_pullback(data: Sequence[Array], cotangent: Array) -> Sequence[Array]:
    """Transpose `log_variation`."""
    y0, y1 = data
    v, geodesic, match = _between(y0, y1)
    low = transposed(y0) @ cotangent
    slope = geodesic.coordinates(cotangent - y0 @ low, 0)
    by_shift = geodesic.vector(geodesic.scaled(slope, _minus_cotangent), 0) - v @ transposed(low)
    by_arrival = geodesic.vector(geodesic.scaled(slope, _inverse_ratio), 1) @ match
    return by_shift + y0 @ skew_part(transposed(v) @ cotangent), by_arrival


def _between(y0: Array, y1: Array) -> tuple[Array, Geodesic, Array]:
    """Return the velocity, the geodesic, and the turn from the basis that it reaches to `y1`."""
    v = manifold_of(y0).log(y0, y1)
    geodesic = Geodesic(y0, v)
    geodesic.check_smooth()
    return v, geodesic, transposed(geodesic.end) @ y1
