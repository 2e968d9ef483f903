"""Compiled curves of a spline of rotations: a single one, or an array."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ._core import _check_unmasked, sampled_rotations
from .array_input import Array, finite_array, flag, shape_of, times_within
from .errors import InvalidInputError

if TYPE_CHECKING:
    from ._core import RotationCurve


@dataclass(frozen=True)
class RotationCurves:
    """Array of curves of rotations.

    Attributes
    ----------
    members : tuple of RotationCurve
        Curves in C order.
    shape : tuple of int
        Leading axes; without any there is one member, and values are scalars.
    knots : int
        Number of knots of a batch without members.
    extrapolate : bool
        Whether times outside the knots are allowed.
    """

    members: tuple[RotationCurve, ...]
    shape: tuple[int, ...]
    knots: int
    extrapolate: bool

    @property
    def t(self) -> Array:
        """Times of the knots, in s, shape ``(...) + (N,)``.

        Raises
        ------
        InvalidInputError
            The members have different numbers of knots.
        """
        if not self.shape:
            return self.members[0].t
        knots = [member.t for member in self.members]
        if len({len(each) for each in knots}) > 1:
            raise InvalidInputError("t: the members of this batch have different numbers of knots")
        return np.reshape(knots, (*self.shape, len(knots[0]) if knots else self.knots))

    @property
    def t_span(self) -> tuple[Any, Any]:
        """First and last time, in s, each a float or an array of shape ``(...)``."""
        first = self.values(float(member.t[0]) for member in self.members)
        return first, self.values(float(member.t[-1]) for member in self.members)

    def at_knots(self) -> Array:
        """Return quaternions at the knots, shape ``(...) + (N, 4)``."""
        t = self.t
        return sampled_rotations(self.members, t.reshape(-1, t.shape[-1]), 0).reshape(*t.shape, 4)

    def quaternions(self, t: ArrayLike) -> Array:
        """Return unit quaternions at times of shape T, shape ``(...) + T + (4,)``."""
        return self._sampled(t, 0)

    def rates(self, t: ArrayLike, order: int) -> Array:
        """Return body rates in rad/s^order at times of shape T, shape ``(...) + T + (3,)``."""
        return self._sampled(t, order)

    def _sampled(self, t: ArrayLike, order: int) -> Array:
        times = finite_array(t, "t")
        flat = times.reshape(-1)
        if not self.shape:
            member, flat = self.members[0], self._inside(self.members[0], flat)
            values = member.rates(flat, order) if order else member.quaternions(flat)
        else:
            if not self.extrapolate:
                rows = [self._inside(member, flat) for member in self.members]
                flat = np.reshape(rows, (len(rows), flat.size))
            values = sampled_rotations(self.members, flat, order)
        return values.reshape(*self.shape, *times.shape, values.shape[-1])

    def extended(self, extrapolate: bool) -> RotationCurves:
        """Return the same curves, with or without extrapolation."""
        return replace(self, extrapolate=flag("extrapolate", extrapolate))

    def arc_length(self, member: RotationCurve, t0: float | None, t1: float | None) -> float:
        """Return the angle that a member turns between two times, by default its ends."""
        for t in (t0, t1):
            if t is not None and not self.extrapolate:
                times_within(finite_array(t, "t"), float(member.t[0]), float(member.t[-1]), advice="")
        return float(member.curve.arc_length(t0, t1))

    def _inside(self, member: RotationCurve, t: Array) -> Array:
        return t if self.extrapolate else times_within(t, float(member.t[0]), float(member.t[-1]))

    def values(self, numbers: Any) -> Any:
        """Return one number per member as an array of shape ``(...)``, or the number of a single curve."""
        found = list(numbers)
        return np.reshape(found, self.shape) if self.shape else found[0]

    def objects(self, things: Sequence[Any]) -> Any:
        """Return one object per member as an array of shape ``(...)``, or the object of a single curve."""
        if not self.shape:
            return things[0]
        out = np.empty(len(things), dtype=object)
        for i, thing in enumerate(things):
            out[i] = thing
        return out.reshape(self.shape)


def flat_batch(t: ArrayLike, quaternions: Array) -> tuple[Any, Array]:
    """Return times, shape (N,) or (M, N), and quaternions, shape (M, N, 4), of a batch; a single spline counts as one.

    Times are validated where they are used, where integers that are not exactly floats raise.

    Raises
    ------
    InvalidInputError
        The times have a wrong shape, or are masked.
    """
    shape = quaternions.shape[:-1]
    members = quaternions.reshape(math.prod(shape[:-1]), shape[-1], 4)
    found = shape_of(t)
    if found is None or len(found) < 2:
        return t, members
    if len(shape) == 1:
        raise InvalidInputError(f"t: expected shape (N,), found {found}")
    _check_unmasked("t", t)
    times = np.asarray(t)
    if times.shape != shape:
        raise InvalidInputError(f"t: expected shape ({shape[-1]},) or {shape}, found {times.shape}")
    return times.reshape(members.shape[:-1]), members
