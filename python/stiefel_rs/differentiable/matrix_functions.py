"""Exponential of skew matrices, logarithm of rotations, and projections, with derivatives."""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np

from .. import _core
from .arguments import Frame, Plain, Shape, SkewMatrix, Tangent
from .operation import Operation


def _same(*shapes: Shape) -> Shape:
    return shapes[-1]


SKEW_EXP: Final = Operation(
    name="skew_exp",
    arguments=(SkewMatrix("A"),),
    axes=(2,),
    shape=_same,
    value=_core.skew_exp,
    variation=lambda data, moves: _core.skew_exp_variation(data[0], moves[0]),
    pullback=lambda data, cotangent: (_core.skew_exp_pullback(data[0], cotangent),),
    is_batched=True,
)

ORTHOGONAL_LOG: Final = Operation(
    name="orthogonal_log",
    arguments=(Frame("Q", square=True),),
    axes=(2,),
    shape=_same,
    value=_core.orthogonal_log,
    variation=lambda data, moves: _core.orthogonal_log_variation(data[0], moves[0]),
    pullback=lambda data, cotangent: (_core.orthogonal_log_pullback(data[0], cotangent),),
    is_batched=True,
)

TIMES: Final = Operation(
    name="times",
    arguments=(Plain("t"),),
    axes=(1,),
    shape=_same,
    value=lambda t: t,
    variation=lambda _, moves: moves[0],
    pullback=lambda _, cotangent: (cotangent,),
    is_batched=True,
)


@cache
def nearest_frame(name: str) -> Operation:
    """Return the projection of an argument to the nearest frame."""
    return Operation(
        name="nearest_frame",
        arguments=(Frame(name),),
        axes=(2,),
        shape=_same,
        value=lambda s: s,
        variation=lambda _, moves: moves[0],
        pullback=lambda _, cotangent: (cotangent,),
        is_batched=True,
    )


@cache
def nearest_tangent(frame: str, name: str) -> Operation:
    """Return the projection of an argument to the tangent space at the frame before it."""
    return Operation(
        name="nearest_tangent",
        arguments=(Frame(frame), Tangent(name, at=0)),
        axes=(2, 2),
        shape=_same,
        value=lambda _, v: v,
        variation=lambda _, moves: moves[1],
        pullback=lambda data, cotangent: (np.zeros_like(data[0]), cotangent),
        is_batched=True,
    )
