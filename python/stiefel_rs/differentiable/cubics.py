"""Riemannian cubics with given boundary data or initial data, with derivatives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from .._core import RiemannianCubic
from .arguments import Array, Frame, Plain, Shape, Tangent, inner_products
from .operation import Gradient, Operation
from .solved import Solved, core_shape, numbers_of_cubic


def points_shape(first: Shape, *others: Shape) -> Shape:
    """Return the shape of points at the times that are the last argument."""
    return (*others[-1], *first)


def _between(s0: Array, v0: Array, s1: Array, v1: Array) -> RiemannianCubic:
    return RiemannianCubic.from_boundary(s0, v0, s1, v1)


_BETWEEN: Final = Solved(_between, lambda s0, *_: numbers_of_cubic(*core_shape(s0)))


def _boundary_value(*data: Array) -> Array:
    return _BETWEEN(data[:4])(data[4])


def _boundary_variation(data: Sequence[Array], moves: Sequence[Array]) -> Array:
    curve, t = _BETWEEN(data[:4]), data[4]
    moved: Array = curve.point_variation(t, *moves[:4]) + _along(curve, t) * moves[4][:, None, None]
    return moved


def _boundary_pullback(data: Sequence[Array], w: Array) -> Sequence[Gradient]:
    curve, t = _BETWEEN(data[:4]), data[4]
    return (*curve.point_pullback(t, w), lambda: inner_products(_along(curve, t), w))


RIEMANNIAN_CUBIC: Final = Operation(
    name="riemannian_cubic",
    arguments=(Frame("S0"), Tangent("V0", at=0), Frame("S1", like=0), Tangent("V1", at=2), Plain("t")),
    axes=(2, 2, 2, 2, 1),
    shape=points_shape,
    value=_boundary_value,
    variation=_boundary_variation,
    pullback=_boundary_pullback,
    has_tangent_gradients=True,
)


def _from_initial(s: Array, v: Array, a: Array, j: Array, t: Array) -> RiemannianCubic:
    return RiemannianCubic.from_initial(s, v, a, j, t_end=farthest(t))


def farthest(t: Array) -> float:
    """Return the latest of times that are not negative, 1 where that is 0."""
    return float(t.max(initial=0.0)) or 1.0


def onwards(data: Sequence[Array]) -> tuple[float, list[Array]]:
    """Return 1 and initial data with times; for negative times -1 and those of the reversed curve.

    Also for variations and gradients, by the sign of the data.
    """
    sign = -1.0 if data[4].min(initial=0.0) < 0.0 else 1.0
    return sign, reversed_by(sign, data)


def reversed_by(sign: float, data: Sequence[Array]) -> list[Array]:
    """Multiply what is odd in the time: velocity, jerk and the times."""
    s, v, a, j, t = data
    return [s, sign * v, a, sign * j, sign * t]


_INITIAL: Final = Solved(_from_initial, lambda s, *_: 100 * math.prod(core_shape(s)))


def _initial_value(*data: Array) -> Array:
    _, onward = onwards(data)
    return _INITIAL(onward)(onward[4])


def _initial_variation(data: Sequence[Array], moves: Sequence[Array]) -> Array:
    sign, onward = onwards(data)
    curve, t, moved = _INITIAL(onward), onward[4], reversed_by(sign, moves)
    found: Array = curve.initial_point_variation(t, *moved[:4]) + _along(curve, t) * moved[4][:, None, None]
    return found


def _initial_pullback(data: Sequence[Array], w: Array) -> Sequence[Array]:
    sign, onward = onwards(data)
    curve, t = _INITIAL(onward), onward[4]
    return reversed_by(sign, (*curve.initial_point_pullback(t, w), inner_products(_along(curve, t), w)))


CUBIC_INITIAL: Final = Operation(
    name="cubic_initial",
    arguments=(Frame("S"), Tangent("V", at=0), Tangent("A", at=0), Tangent("J", at=0), Plain("t")),
    axes=(2, 2, 2, 2, 1),
    shape=points_shape,
    value=_initial_value,
    variation=_initial_variation,
    pullback=_initial_pullback,
    has_tangent_gradients=True,
)


def _along(curve: RiemannianCubic, t: Array) -> Array:
    return curve(t, 1)
