"""Exponential of skew matrices and logarithm of rotations, and the projections alone, with derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from .. import _core
from .arguments import Array, Frame, Plain, Shape, SkewMatrix, Tangent
from .operation import Operation


def _same(*shapes: Shape) -> Shape:
    return shapes[-1]


def _skew_exp(a: Array) -> Array:
    return _core.skew_exp(a)


def _orthogonal_log(q: Array) -> Array:
    return _core.orthogonal_log(q)


def _second_alone(data: Sequence[Array], cotangent: Array) -> Sequence[Array]:
    return 0.0 * data[0], cotangent


SKEW_EXP: Final = Operation(
    name="skew_exp",
    arguments=(SkewMatrix("A"),),
    axes=(2,),
    shape=_same,
    value=_skew_exp,
    variation=lambda data, moves: _core.skew_exp_variation(data[0], moves[0]),
    pullback=lambda data, cotangent: (_core.skew_exp_pullback(data[0], cotangent),),
)

ORTHOGONAL_LOG: Final = Operation(
    name="orthogonal_log",
    arguments=(Frame("Q", square=True),),
    axes=(2,),
    shape=_same,
    value=_orthogonal_log,
    variation=lambda data, moves: _core.orthogonal_log_variation(data[0], moves[0]),
    pullback=lambda data, cotangent: (_core.orthogonal_log_pullback(data[0], cotangent),),
)

NEAREST_FRAME: Final = Operation(
    name="nearest_frame",
    arguments=(Frame("S"),),
    axes=(2,),
    shape=_same,
    value=lambda s: s,
    variation=lambda _, moves: moves[0],
    pullback=lambda _, cotangent: (cotangent,),
)


SECOND_FRAME: Final = Operation(
    name="nearest_frame",
    arguments=(Frame("S0"), Frame("S1", like=0)),
    axes=(2, 2),
    shape=_same,
    value=lambda _, s1: s1,
    variation=lambda _, moves: moves[1],
    pullback=_second_alone,
)

NEAREST_TANGENT: Final = Operation(
    name="nearest_tangent",
    arguments=(Frame("S"), Tangent("V", at=0)),
    axes=(2, 2),
    shape=_same,
    value=lambda _, v: v,
    variation=lambda _, moves: moves[1],
    pullback=_second_alone,
)

TIMES: Final = Operation(
    name="times",
    arguments=(Plain("t"),),
    axes=(1,),
    shape=_same,
    value=lambda t: t,
    variation=lambda _, moves: moves[0],
    pullback=lambda _, cotangent: (cotangent,),
)
