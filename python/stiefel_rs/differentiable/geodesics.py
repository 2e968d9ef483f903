"""Riemannian exponential and logarithm of the canonical metric, with derivatives.

With `U = V - S S^T V / 2` and `A = U S^T - S U^T` the exponential is `exp_S(V) = e^A S`: smooth, also where `V` loses
rank. The logarithm is its inverse by `V`: one dense system of the dimension of St(n,k) per derivative. Cost `O(n^3)`
for the exponential, `O(d n^3)` for the logarithm, with `d` the dimension.

Source: Edelman, Arias, Smith (1998), section 2.4.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from .. import _core
from ..errors import OutsideDomainError
from .arguments import Array, Frame, Shape, Tangent, symmetric_part, transposed
from .operation import Operation

# Ends whose derivative has a smaller share of its largest singular value count as conjugate, as for boundary problems.
SINGULAR = 1e-11


def _second(_: Shape, second: Shape) -> Shape:
    return second


def _half_normal(s: Array, v: Array) -> Array:
    half: Array = v - 0.5 * s @ (s.T @ v)
    return half


def _generator(s: Array, u: Array) -> Array:
    product = u @ s.T
    generator: Array = product - product.T
    return generator


def _exp_variation(data: Sequence[Array], moves: Sequence[Array]) -> Array:
    (s, v), (ds, dv) = data, moves
    u = _half_normal(s, v)
    du = _half_normal(s, dv) - 0.5 * ds @ (s.T @ v) - 0.5 * s @ (ds.T @ v)
    a = _generator(s, u)
    da = _generator(s, du) + u @ ds.T - ds @ u.T
    moved: Array = _core.skew_exp_variation(a, da) @ s + _core.skew_exp(a) @ ds
    return moved


def _exp_pullback(data: Sequence[Array], w: Array) -> tuple[Array, Array]:
    s, v = data
    u = _half_normal(s, v)
    a = _generator(s, u)
    g = _core.skew_exp_pullback(a, w @ s.T)
    by_u = 2.0 * g @ s
    inner = s.T @ by_u
    gs = _core.skew_exp(a).T @ w - 2.0 * g @ u - 0.5 * by_u @ (v.T @ s) - 0.5 * v @ inner.T
    return gs, by_u - 0.5 * s @ inner


def _exp(s: Array, v: Array) -> Array:
    return _core.Stiefel(*s.shape).exp(s, v)


EXP: Final = Operation(
    name="exp",
    arguments=(Frame("S"), Tangent("V", at=0)),
    axes=(2, 2),
    shape=_second,
    value=_exp,
    variation=_exp_variation,
    pullback=_exp_pullback,
)


def _log(s0: Array, s1: Array) -> Array:
    return _core.Stiefel(*s0.shape).log(s0, s1)


def _tangent_basis(s: Array) -> Array:
    """Return an orthonormal basis of the tangent space, shape (d, n, k)."""
    n, k = s.shape
    normal = np.linalg.svd(s)[0][:, k:]
    rows, columns = np.triu_indices(k, 1)
    skew = np.zeros((len(rows), k, k))
    count = np.arange(len(rows))
    skew[count, rows, columns], skew[count, columns, rows] = 0.5**0.5, -(0.5**0.5)
    outer = np.einsum("ni,jl->ijnl", normal, np.eye(k)).reshape(-1, n, k)
    return np.concatenate([s @ skew, outer])


class _Linearised:
    """The derivative of `exp_S0(V) = S1` by `V` in bases of both tangent spaces."""

    def __init__(self, s0: Array, s1: Array) -> None:
        self.data = s0, _log(s0, s1)
        self.bases = _tangent_basis(s0), _tangent_basis(s1)
        still = np.zeros_like(s0)
        columns = [_exp_variation(self.data, (still, e)) for e in self.bases[0]]
        self.matrix = np.einsum("inl,jnl->ij", self.bases[1], np.array(columns).reshape(-1, *s0.shape))
        sizes = np.linalg.svd(self.matrix, compute_uv=False)
        if len(sizes) > 0 and sizes[-1] <= SINGULAR * sizes[0]:
            raise OutsideDomainError(
                f"the ends are conjugate along the geodesic: singular values {sizes[-1]:.3g} and {sizes[0]:.3g} of the "
                "derivative of the exponential; the logarithm does not depend smoothly on them"
            )


def _log_variation(data: Sequence[Array], moves: Sequence[Array]) -> Array:
    (s0, s1), (ds0, ds1) = data, moves
    linear = _Linearised(s0, s1)
    _, v = linear.data
    # As much of the change as keeps the vector tangent.
    carried = -s0 @ symmetric_part(ds0.T @ v)
    missing = ds1 - _exp_variation(linear.data, (ds0, carried))
    change = np.linalg.solve(linear.matrix, np.einsum("inl,nl->i", linear.bases[1], missing))
    moved: Array = carried + np.einsum("j,jnl->nl", change, linear.bases[0])
    return moved


def _log_pullback(data: Sequence[Array], w: Array) -> tuple[Array, Array]:
    s0, s1 = data
    linear = _Linearised(s0, s1)
    _, v = linear.data
    weights = np.linalg.solve(linear.matrix.T, np.einsum("jnl,nl->j", linear.bases[0], w))
    by_end = np.einsum("i,inl->nl", weights, linear.bases[1])
    by_s, by_v = _exp_pullback(linear.data, by_end)
    rest = symmetric_part(s0.T @ (w - by_v))
    return -by_s - v @ transposed(rest), by_end


LOG: Final = Operation(
    name="log",
    arguments=(Frame("S0"), Frame("S1", like=0)),
    axes=(2, 2),
    shape=_second,
    value=_log,
    variation=_log_variation,
    pullback=_log_pullback,
)
