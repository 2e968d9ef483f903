"""Exponential, logarithm, cubics and splines of subspaces, with derivatives of the bases that they give."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Final

import numpy as np

from .._core import CubicSpline, Curve, RiemannianCubic
from . import jacobi_fields
from .arguments import Array, Frame, Horizontal, Inside, Knots, Plain, Shape, inner_products, skew_part, transposed
from .cubics import farthest, onwards, points_shape, reversed_by
from .jacobi_fields import manifold_of, split
from .operation import Operation
from .solved import Solved, core_shape, numbers_of_cubic, numbers_of_piece
from .splines import BcType, check_bc_type, closed, spline_shape
from .turning import Turning

# Horizontal variations of the curve at some times, and gradients by the data from cotangents at some times.
Moved = Callable[[Array], Array]
Pulled = Callable[[Array, Array], Sequence[Array]]


def _second(_: Shape, second: Shape) -> Shape:
    return second


EXP: Final = Operation(
    name="exp",
    arguments=(Frame("S"), Horizontal("V", at=0)),
    axes=(2, 2),
    shape=_second,
    value=lambda y, v: manifold_of(y).exp(y, v),
    variation=jacobi_fields.exp_variation,
    pullback=jacobi_fields.exp_pullback,
)

LOG: Final = Operation(
    name="log",
    arguments=(Frame("S0"), Frame("S1", like=0)),
    axes=(2, 2),
    shape=_second,
    value=lambda y0, y1: manifold_of(y0).log(y0, y1),
    variation=jacobi_fields.log_variation,
    pullback=jacobi_fields.log_pullback,
)


def _bases_moved(curve: Curve, breaks: Array, data: tuple[Array, Array, Array], moved: Moved) -> Array:
    """Move the bases at the times `t` where the first basis turns by `turn`, from horizontal variations."""
    t, dt, turn = data
    turning = _turning(curve, breaks, t)
    shifts = moved(np.concatenate([t, turning.nodes]))
    turns = turn + turning.forward(shifts[len(t) :])
    found: Array = shifts[: len(t)] + curve(t) @ turns + curve(t, 1) * dt[:, None, None]
    return found


def _bases_pulled(
    curve: Curve, breaks: Array, t: Array, w: Array, pulled: Pulled
) -> tuple[Sequence[Array], Array, Array]:
    """Transpose `_bases_moved`: gradients by the data, by the turn of the first basis, and by the times."""
    turning, bases = _turning(curve, breaks, t), curve(t)
    inner = transposed(bases) @ w
    turns = skew_part(inner)
    loads = np.concatenate([w - bases @ inner, turning.back(turns)])
    found = pulled(np.concatenate([t, turning.nodes]), loads)
    return found, turns.sum(axis=0), inner_products(curve(t, 1), w)


def _turning(curve: Curve, breaks: Array, t: Array) -> Turning:
    return Turning(lambda times: curve(times, 1), float(breaks[0]), breaks, t)


def _turn_to(bases: Array, others: Array) -> Array:
    """Return the matrices from bases to other ones of the same subspaces."""
    turns: Array = transposed(bases) @ others
    return turns


def _vectors(bases: Array, moves: Array, *vectors: tuple[Array, Array]) -> tuple[Array, Array, list[Array]]:
    """Return the horizontal move of a basis, how it turns, and moves of vectors there beside that turn."""
    shift, turn = split(bases, moves)
    return shift, turn, [dv - v @ turn for v, dv in vectors]


def _by_basis(basis: Array, by_shift: Array, by_turn: Array, *vectors: tuple[Array, Array]) -> Array:
    """Transpose `_vectors`: the gradient by the basis, with the vectors there and their gradients."""
    by_turn = by_turn - sum((skew_part(transposed(v) @ by_v) for v, by_v in vectors), np.zeros_like(by_turn))
    found: Array = by_shift - basis @ (transposed(basis) @ by_shift) + basis @ by_turn
    return found


_ENDS: Final = np.array([0.0])


def _between(y0: Array, v0: Array, y1: Array, v1: Array) -> RiemannianCubic:
    return RiemannianCubic.from_boundary(y0, v0, y1, v1, manifold=manifold_of(y0))


_BETWEEN: Final = Solved(_between, lambda y0, *_: numbers_of_cubic(*core_shape(y0)))


def _boundary_value(*data: Array) -> Array:
    return _BETWEEN(data[:4])(data[4])


def _boundary_variation(data: Sequence[Array], moves: Sequence[Array]) -> Array:
    (y0, v0, y1, v1, t), (dy0, dv0, dy1, dv1, dt) = data, moves
    curve = _BETWEEN(data[:4])
    s0, turn, [w0] = _vectors(y0, dy0, (v0, dv0))
    s1, _, [w1] = _vectors(y1, dy1, (v1, dv1))
    # In terms of the basis of the curve there.
    s1, w1 = (x @ _turn_to(y1, curve(1.0)) for x in (s1, w1))
    return _bases_moved(curve, _ENDS, (t, dt, turn), lambda times: curve.point_variation(times, s0, w0, s1, w1))


def _boundary_pullback(data: Sequence[Array], w: Array) -> Sequence[Array]:
    y0, v0, y1, v1, t = data
    curve = _BETWEEN(data[:4])
    (s0, w0, s1, w1), turn, by_t = _bases_pulled(curve, _ENDS, t, w, curve.point_pullback)
    s1, w1 = (x @ _turn_to(curve(1.0), y1) for x in (s1, w1))
    first, last = _by_basis(y0, s0, turn, (v0, w0)), _by_basis(y1, s1, np.zeros_like(turn), (v1, w1))
    return first, w0, last, w1, by_t


RIEMANNIAN_CUBIC: Final = Operation(
    name="riemannian_cubic",
    arguments=(Frame("S0"), Horizontal("V0", at=0), Frame("S1", like=0), Horizontal("V1", at=2), Plain("t")),
    axes=(2, 2, 2, 2, 1),
    shape=points_shape,
    value=_boundary_value,
    variation=_boundary_variation,
    pullback=_boundary_pullback,
)


def _from_initial(y: Array, v: Array, a: Array, j: Array, t: Array) -> RiemannianCubic:
    return RiemannianCubic.from_initial(y, v, a, j, t_end=farthest(t), manifold=manifold_of(y))


_INITIAL: Final = Solved(_from_initial, lambda y, *_: 100 * math.prod(core_shape(y)))


def _initial_value(*data: Array) -> Array:
    _, onward = onwards(data)
    return _INITIAL(onward)(onward[4])


def _initial_variation(data: Sequence[Array], moves: Sequence[Array]) -> Array:
    sign, onward = onwards(data)
    (y, v, a, j, t), (dy, dv, da, dj, dt) = onward, reversed_by(sign, moves)
    curve = _INITIAL(onward)
    shift, turn, vectors = _vectors(y, dy, (v, dv), (a, da), (j, dj))
    return _bases_moved(
        curve, _ENDS, (t, dt, turn), lambda times: curve.initial_point_variation(times, shift, *vectors)
    )


def _initial_pullback(data: Sequence[Array], w: Array) -> Sequence[Array]:
    sign, onward = onwards(data)
    y, v, a, j, t = onward
    curve = _INITIAL(onward)
    (shift, *vectors), turn, by_t = _bases_pulled(curve, _ENDS, t, w, curve.initial_point_pullback)
    by_basis = _by_basis(y, shift, turn, *zip((v, a, j), vectors, strict=True))
    return reversed_by(sign, (by_basis, *vectors, by_t))


CUBIC_INITIAL: Final = Operation(
    name="cubic_initial",
    arguments=(Frame("S"), *(Horizontal(name, at=0) for name in "VAJ"), Plain("t")),
    axes=(2, 2, 2, 2, 1),
    shape=points_shape,
    value=_initial_value,
    variation=_initial_variation,
    pullback=_initial_pullback,
)


def cubic_spline(bc_type: BcType) -> Operation:
    """Return the spline through subspaces with the given ends, as an operation."""
    check_bc_type(bc_type)
    return _cubic_spline(bc_type)


@cache
def _cubic_spline(bc_type: BcType) -> Operation:
    solved = Solved(
        lambda knots, bases: CubicSpline(knots, bases, bc_type, manifold=manifold_of(bases)),
        lambda _, bases: len(bases) * numbers_of_piece(*core_shape(bases)),
    )
    is_closed = bc_type == "periodic"

    def around(curve: CubicSpline, knots: Array) -> Array:
        return _turn_to(curve(knots[0]), curve(knots[-1]))

    def value(knots: Array, bases: Array, t: Array) -> Array:
        return solved((knots, bases))(t)

    def variation(data: Sequence[Array], moves: Sequence[Array]) -> Array:
        (knots, bases, t), (dknots, dbases, dt) = data, moves
        curve = solved((knots, bases))
        shifts, turns = split(bases, dbases)
        # In terms of the bases of the curve.
        shifts = shifts @ _turn_to(bases, curve(knots))
        shifts = closed(shifts, around(curve, knots)) if is_closed else shifts
        return _bases_moved(curve, knots, (t, dt, turns[0]), lambda times: curve.point_variation(times, shifts, dknots))

    def pullback(data: Sequence[Array], w: Array) -> Sequence[Array]:
        knots, bases, t = data
        curve = solved((knots, bases))
        (by_bases, by_knots), turn, by_t = _bases_pulled(
            curve, knots, t, w, lambda times, loads: curve.point_pullback(times, loads)[:2]
        )
        by_bases = closed(by_bases, around(curve, knots)) if is_closed else by_bases
        by_bases = by_bases @ _turn_to(curve(knots), bases)
        found = by_bases - bases @ (transposed(bases) @ by_bases)
        found[0] += bases[0] @ turn
        return by_knots, found, by_t

    return Operation(
        name="cubic_spline",
        arguments=(Knots("t_knots"), Frame("S"), Inside("t")),
        axes=(1, 3, 1),
        shape=spline_shape,
        value=value,
        variation=variation,
        pullback=pullback,
    )
