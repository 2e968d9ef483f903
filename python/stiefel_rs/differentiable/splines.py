"""Splines through frames and through rotations, with derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Literal

import numpy as np

from .._core import CubicSpline
from ..errors import InvalidInputError
from ..rotation import RotationSpline
from ..rotation_input import unit
from .arguments import Array, Frame, Inside, Knots, Plain, Shape, inner_products, transposed
from .operation import Gradient, Operation
from .solved import Solved, core_shape, numbers_of_piece

BcType = Literal["natural", "clamped", "periodic"]
_BC_TYPES = ("natural", "clamped", "periodic")


def spline_shape(knots: Shape, points: Shape, t: Shape) -> Shape:
    """Return the shape of points of a spline at the given times."""
    if knots[0] != points[0]:
        raise InvalidInputError(f"t_knots: expected one time for each of the {points[0]} knots, found {knots[0]}")
    return (*t, *points[1:])


def _along(curve: CubicSpline, t: Array) -> Array:
    return curve(t, 1)


def closed(moves: Array, turn: Array | None = None) -> Array:
    """Replace moves of the first and the last point of a closed curve by their mean; symmetric.

    ``turn`` is from the first basis to the last one of the same point.
    """
    last = moves[-1] if turn is None else moves[-1] @ transposed(turn)
    mean = 0.5 * (moves[0] + last)
    found: Array = np.concatenate([mean[None], moves[1:-1], (mean if turn is None else mean @ turn)[None]])
    return found


def check_bc_type(bc_type: object) -> None:
    """Check that the ends are of a kind without vectors."""
    if not isinstance(bc_type, str) or bc_type not in _BC_TYPES:
        raise InvalidInputError(f"bc_type: expected one of {', '.join(_BC_TYPES)}, found {bc_type!r}")


def cubic_spline(bc_type: BcType) -> Operation:
    """Return the spline through frames with the given end conditions, as an operation."""
    check_bc_type(bc_type)
    return _cubic_spline(bc_type)


def rotation_spline(bc_type: BcType) -> Operation:
    """Return the spline through rotations with the given end conditions, as an operation on quaternions."""
    check_bc_type(bc_type)
    return _rotation_spline(bc_type)


@cache
def _cubic_spline(bc_type: BcType) -> Operation:
    solved = Solved(
        lambda knots, points: CubicSpline(knots, points, bc_type),
        lambda _, points: len(points) * numbers_of_piece(*core_shape(points)),
    )
    is_closed = bc_type == "periodic"

    def value(knots: Array, points: Array, t: Array) -> Array:
        return solved((knots, points))(t)

    def variation(data: Sequence[Array], moves: Sequence[Array]) -> Array:
        curve, t = solved(data[:2]), data[2]
        shifts = closed(moves[1]) if is_closed else moves[1]
        moved: Array = curve.point_variation(t, shifts, moves[0]) + _along(curve, t) * moves[2][:, None, None]
        return moved

    def pullback(data: Sequence[Array], w: Array) -> Sequence[Gradient]:
        curve, t = solved(data[:2]), data[2]
        by_points, by_knots, _ = curve.point_pullback(t, w)
        by_points = closed(by_points) if is_closed else by_points
        return by_knots, by_points, lambda: inner_products(_along(curve, t), w)

    return Operation(
        name="cubic_spline",
        arguments=(Knots("t_knots"), Frame("S"), Inside("t")),
        axes=(1, 3, 1),
        shape=spline_shape,
        value=value,
        variation=variation,
        pullback=pullback,
        has_tangent_gradients=True,
    )


@cache
def _rotation_spline(bc_type: BcType) -> Operation:
    """Return the spline of quaternions, differentiated as a curve of matrices.

    Where `R` changes by `R hat(w)`, the quaternion `q` changes by `q (w, 0) / 2`.
    """
    solved = Solved(
        lambda knots, q: RotationSpline(knots, q, bc_type, extrapolate=False),
        lambda _, q: len(q) * numbers_of_piece(3, 3),
    )
    is_closed = bc_type == "periodic"

    def value(knots: Array, q: Array, t: Array) -> Array:
        found: Array = solved((knots, q))(t)
        return found

    def variation(data: Sequence[Array], moves: Sequence[Array]) -> Array:
        knots, q, t = data
        spline, points = solved((knots, q)), _matrices(unit(q))
        turned: Array = spline(t)
        turns = _turns(q, moves[1])
        turns = closed(turns) if is_closed else turns
        moved = spline.curve.point_variation(t, points @ _hat(turns), moves[0])
        rates = _vee(transposed(_matrices(turned)) @ moved) + spline(t, 1) * moves[2][:, None]
        change: Array = _turned(turned, rates)
        return change

    def pullback(data: Sequence[Array], w: Array) -> Sequence[Gradient]:
        knots, q, t = data
        spline, points = solved((knots, q)), _matrices(unit(q))
        turned: Array = spline(t)
        # <w, q (r, 0) / 2> = <r, rates>, and for a skew matrix <hat(a), hat(b)> = 2 <a, b>.
        rates = _turned_back(turned, w)
        by_points, by_knots, _ = spline.curve.point_pullback(t, _matrices(turned) @ _hat(0.5 * rates))
        inner = transposed(points) @ by_points
        by_turns = _vee(inner - transposed(inner))
        by_turns = closed(by_turns) if is_closed else by_turns
        return by_knots, _turns_back(q, by_turns), lambda: (rates * spline(t, 1)).sum(axis=-1)

    return Operation(
        name="rotation_spline",
        arguments=(Knots("t_knots"), Plain("quaternions", columns=4), Inside("t")),
        axes=(1, 2, 1),
        shape=spline_shape,
        value=value,
        variation=variation,
        pullback=pullback,
    )


def _scale(q: Array) -> Array:
    """Return the largest absolute entries of quaternions, whose squares may overflow or underflow."""
    scale: Array = np.abs(q).max(axis=-1, keepdims=True)
    return scale


def _matrices(q: Array) -> Array:
    x, y, z, w = np.moveaxis(q, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def _hat(w: Array) -> Array:
    x, y, z = np.moveaxis(w, -1, 0)
    zero = np.zeros_like(x)
    return np.moveaxis(np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]), (0, 1), (-2, -1))


def _vee(matrix: Array) -> Array:
    """Return the axis of the skew part."""
    skew = 0.5 * (matrix - transposed(matrix))
    return np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=-1)


def _product(p: Array, q: Array) -> Array:
    (a, s), (b, r) = (p[..., :3], p[..., 3:]), (q[..., :3], q[..., 3:])
    vector = s * b + r * a + np.cross(a, b)
    scalar = s * r - (a * b).sum(axis=-1, keepdims=True)
    return np.concatenate([vector, scalar], axis=-1)


def _conjugate(q: Array) -> Array:
    return np.concatenate([-q[..., :3], q[..., 3:]], axis=-1)


def _turned(q: Array, rates: Array) -> Array:
    """Return `q (w, 0) / 2`."""
    pure = np.concatenate([0.5 * rates, np.zeros_like(rates[..., :1])], axis=-1)
    return _product(q, pure)


def _turned_back(q: Array, cotangent: Array) -> Array:
    back: Array = 0.5 * _product(_conjugate(q), cotangent)[..., :3]
    return back


def _turns(q: Array, move: Array) -> Array:
    """Return the body-frame rotations caused by variations of quaternions of any length."""
    scale = _scale(q)
    q, move = q / scale, move / scale
    turns: Array = 2.0 * _product(_conjugate(q), move)[..., :3] / (q * q).sum(axis=-1, keepdims=True)
    return turns


def _turns_back(q: Array, cotangent: Array) -> Array:
    pure = np.concatenate([2.0 * cotangent, np.zeros_like(cotangent[..., :1])], axis=-1)
    scale = _scale(q)
    q = q / scale
    back: Array = _product(q, pure) / (q * q).sum(axis=-1, keepdims=True) / scale
    return back
