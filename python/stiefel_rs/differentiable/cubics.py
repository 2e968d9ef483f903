"""Riemannian cubics with given boundary data or initial data, with derivatives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from .._core import RiemannianCubic
from .arguments import Array, Frame, Plain, Shape, Tangent, inner_products
from .operation import Operation
from .solved import Solved, core_shape, numbers_of_cubic


def _points(first: Shape, *others: Shape) -> Shape:
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


def _boundary_pullback(data: Sequence[Array], w: Array) -> Sequence[Array]:
    curve, t = _BETWEEN(data[:4]), data[4]
    return (*curve.point_pullback(t, w), inner_products(_along(curve, t), w))


RIEMANNIAN_CUBIC: Final = Operation(
    name="riemannian_cubic",
    arguments=(Frame("S0"), Tangent("V0", at=0), Frame("S1", like=0), Tangent("V1", at=2), Plain("t")),
    axes=(2, 2, 2, 2, 1),
    shape=_points,
    value=_boundary_value,
    variation=_boundary_variation,
    pullback=_boundary_pullback,
)


def _from_initial(s: Array, v: Array, a: Array, j: Array, t: Array) -> RiemannianCubic:
    return RiemannianCubic.from_initial(s, v, a, j, t_end=_end(t))


def _end(t: Array) -> float:
    """Return the time farthest from 0."""
    farthest = float(t[np.argmax(np.abs(t))]) if t.size else 0.0
    return farthest if farthest != 0.0 else 1.0


_INITIAL: Final = Solved(_from_initial, lambda s, *_: 100 * math.prod(core_shape(s)))


def _initial_value(*data: Array) -> Array:
    return _INITIAL(data)(data[4])


def _initial_variation(data: Sequence[Array], moves: Sequence[Array]) -> Array:
    curve, t = _INITIAL(data), data[4]
    moved: Array = curve.initial_point_variation(t, *moves[:4]) + _along(curve, t) * moves[4][:, None, None]
    return moved


def _initial_pullback(data: Sequence[Array], w: Array) -> Sequence[Array]:
    curve, t = _INITIAL(data), data[4]
    return (*curve.initial_point_pullback(t, w), inner_products(_along(curve, t), w))


CUBIC_INITIAL: Final = Operation(
    name="cubic_initial",
    arguments=(Frame("S"), Tangent("V", at=0), Tangent("A", at=0), Tangent("J", at=0), Plain("t")),
    axes=(2, 2, 2, 2, 1),
    shape=_points,
    value=_initial_value,
    variation=_initial_variation,
    pullback=_initial_pullback,
)


def _along(curve: RiemannianCubic, t: Array) -> Array:
    return curve(t, 1)
