"""Riemannian exponential and logarithm (canonical metric), with derivatives."""

from __future__ import annotations

from typing import Final

from .. import _core
from .arguments import Array, Frame, Shape, Tangent
from .operation import Operation


def _second(_: Shape, second: Shape) -> Shape:
    return second


def _manifold(s: Array) -> _core.Stiefel:
    return _core.Stiefel(*s.shape, field="complex" if s.dtype.kind == "c" else "real")


EXP: Final = Operation(
    name="exp",
    arguments=(Frame("S"), Tangent("V", at=0)),
    axes=(2, 2),
    shape=_second,
    value=lambda s, v: _manifold(s).exp(s, v),
    variation=lambda data, moves: _core.exp_variation(*data, *moves),
    pullback=lambda data, w: _core.exp_pullback(data[0], data[1], w),
)

LOG: Final = Operation(
    name="log",
    arguments=(Frame("S0"), Frame("S1", like=0)),
    axes=(2, 2),
    shape=_second,
    value=lambda s0, s1: _manifold(s0).log(s0, s1),
    variation=lambda data, moves: _core.log_variation(*data, *moves),
    pullback=lambda data, w: _core.log_pullback(data[0], data[1], w),
)
