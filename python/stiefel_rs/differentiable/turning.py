"""How the bases of a curve of subspaces turn where its data move.

Curves of bases turn as little as possible, `Y^H Y' = 0`, from the first basis on. Let a variation of the data move them
by the horizontal `D`, and the first basis by `Y_0 w_0` besides. Then the bases move by `D + Y w`, where the skew matrix
`w` is

    w(t) = w_0 + int (Y'^H D - D^H Y') ds

(the derivative of `Y^H Y' = 0`). The integrand is replaced by the polynomials through its values at Gauss nodes, on
parts of the curve that are halved until the last coefficients of `Y'` are round-off. Transposed, a cotangent of `w` is
one of `D` at the nodes.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import legendre

from ..errors import InvalidInputError
from .arguments import Array, skew_part, transposed

NODES = 16
# What the last two coefficients of the velocity may be, as a share of the largest.
TAIL = 1e-12
# Halvings of a part: a curve of 4000 rad between two knots needs them.
MOST = 12

_X, _W = legendre.leggauss(NODES)
# Coefficients of the polynomial through values at the nodes.
_COEFFICIENTS = (np.arange(NODES)[:, None] + 0.5) * legendre.legvander(_X, NODES - 1).T * _W
# The same of its integral from the first end of [-1, 1].
_INTEGRAL = legendre.legint(_COEFFICIENTS, lbnd=-1, axis=0)


class Turning:
    """Turning of the bases of a curve at some times; `velocity` gives the derivative of the bases at any times.

    The curve is smooth between the `breaks`, the first of which, `start`, is where the first basis is.
    """

    def __init__(self, velocity: Callable[[Array], Array], start: float, breaks: Array, t: Array) -> None:
        inner = breaks[(breaks > t.min(initial=start)) & (breaks < t.max(initial=start))]
        edges = np.unique(np.concatenate([[start, t.min(initial=start), t.max(initial=start)], inner]))
        left, right = edges[: max(len(edges) - 1, 1)], edges[min(len(edges) - 1, 1) :]
        for halvings in range(MOST + 1):
            rates = velocity(_nodes(left, right).ravel())
            rates = rates.reshape(len(left), NODES, *rates.shape[1:])
            rough = _is_rough(rates, left, right)
            if not rough.any():
                break
            if halvings == MOST:
                raise InvalidInputError(
                    f"t: the curve is too fast for derivatives of its bases, up to {np.abs(rates).max():.3g} per unit "
                    "of time; use point_variation of the curve, whose variations are horizontal"
                )
            left, right = _halved(left, right, rough)
        self._rates = rates
        self._half = 0.5 * (right - left)
        #: Times at which variations are needed.
        self.nodes: Array = _nodes(left, right).ravel()
        self._part = np.clip(np.searchsorted(left, t, side="right") - 1, 0, len(left) - 1)
        self._weights = self._of_part(left, t, self._part)
        self._at_start = np.clip(np.searchsorted(left, start, side="right") - 1, 0, len(left) - 1)
        self._start_weights = self._of_part(left, np.array([start]), np.array([self._at_start]))[0]

    def _of_part(self, left: Array, t: Array, part: Array) -> Array:
        """Return the weights of the values at the nodes of a part in the integral up to a time on it."""
        half = self._half[part]
        # The only part of no length is that of a curve that is asked for at its start alone.
        local = (t - left[part]) / np.where(half > 0.0, half, 1.0) - 1.0
        weights: Array = legendre.legvander(local, NODES) @ _INTEGRAL * half[:, None]
        return weights

    def forward(self, shifts: Array) -> Array:
        """Return `w - w_0` at the times, from the horizontal variations at the nodes."""
        shifts = shifts.reshape(self._rates.shape)
        inner = transposed(self._rates) @ shifts
        slopes = inner - transposed(inner)
        whole = np.einsum("p,g,pgij->pij", self._half, _W, slopes)
        before = np.concatenate([np.zeros_like(whole[:1]), np.cumsum(whole, axis=0)])
        found = before[self._part] + np.einsum("tg,tgij->tij", self._weights, slopes[self._part])
        start = before[self._at_start] + np.einsum("g,gij->ij", self._start_weights, slopes[self._at_start])
        turns: Array = found - start
        return turns

    def back(self, turns: Array) -> Array:
        """Transpose `forward`: cotangents at the nodes."""
        turns = skew_part(turns)
        by_part = np.zeros((len(self._half), *turns.shape[1:]), turns.dtype)
        slopes = np.zeros((len(self._half), NODES, *turns.shape[1:]), turns.dtype)
        np.add.at(by_part, self._part, turns)
        np.add.at(slopes, self._part, np.einsum("tg,tij->tgij", self._weights, turns))
        total = turns.sum(axis=0)
        by_part[self._at_start] -= total
        slopes[self._at_start] -= np.einsum("g,ij->gij", self._start_weights, total)
        # What falls on all parts before that of a time.
        later = np.cumsum(by_part[::-1], axis=0)[::-1] - by_part
        slopes += np.einsum("p,g,pij->pgij", self._half, _W, later)
        cotangents: Array = 2.0 * (self._rates @ slopes)
        return cotangents.reshape(-1, *cotangents.shape[2:])


def _nodes(left: Array, right: Array) -> Array:
    nodes: Array = left[:, None] + 0.5 * (right - left)[:, None] * (_X + 1.0)
    return nodes


def _halved(left: Array, right: Array, which: Array) -> tuple[Array, Array]:
    middle = 0.5 * (left + right)[which]
    left = np.concatenate([left, middle])
    right = np.concatenate([np.where(which, 0.5 * (left[: len(which)] + right), right), right[which]])
    order = np.argsort(left)
    return left[order], right[order]


def _is_rough(rates: Array, left: Array, right: Array) -> Array:
    """Whether the polynomials through the values are not accurate, part by part."""
    duration, latest = right[-1] - left[0], max(abs(left[0]), abs(right[-1]))
    # Below a radian, an error counts by itself: curves that stand still have nothing but round-off.
    sizes = np.abs(np.einsum("cg,pgij->pcij", _COEFFICIENTS, rates)).max(axis=(2, 3), initial=0.0)
    # Rounded times, as those of a Unix clock, change the rates by as much as these change with time.
    half = np.where(right > left, 0.5 * (right - left), 1.0)
    late = NODES * np.finfo(np.float64).eps * latest * sizes[:, 1:].max(axis=1, initial=0.0) / half
    allowed = TAIL * max(1.0, duration * sizes.max(initial=0.0)) + duration * late
    rough: Array = duration * sizes[:, -2:].max(axis=1, initial=0.0) > allowed
    return rough
