"""Compiled curves of a spline of rotations: a single one, or an array."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ._core import _check_unmasked
from .array_input import Array, finite_array, flag, real_array, times_within
from .errors import InvalidInputError, StiefelError

if TYPE_CHECKING:
    from ._core import RotationCurve

Curve = TypeVar("Curve")

# Arguments of a batch that all members share.
SHARED: Final = ("lam", "weights", "tol", "tension", "max_iterations", "num_threads")


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
        out = np.empty((*self.t.shape, 4))
        rows = out.reshape(len(self.members), *out.shape[-2:])
        for row, member in zip(rows, self.members, strict=True):
            row[...] = member.quaternions(member.t)
        return out

    def quaternions(self, t: ArrayLike) -> Array:
        """Return unit quaternions at times of shape T, shape ``(...) + T + (4,)``."""
        return self._sampled(t, 4, lambda member, times: member.quaternions(times))

    def rates(self, t: ArrayLike, order: int) -> Array:
        """Return body rates in rad/s^order at times of shape T, shape ``(...) + T + (3,)``."""
        return self._sampled(t, 3, lambda member, times: member.rates(times, order))

    def _sampled(self, t: ArrayLike, width: int, sample: Callable[[RotationCurve, Array], Array]) -> Array:
        times = finite_array(t, "t")
        flat, shape = times.reshape(-1), (*self.shape, *times.shape, width)
        if not self.shape:
            member = self.members[0]
            return sample(member, self._inside(member, flat)).reshape(shape)
        out = np.empty((len(self.members), flat.size, width))
        for row, member in zip(out, self.members, strict=True):
            row[...] = sample(member, self._inside(member, flat))
        return out.reshape(shape)

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
    """Return times, shape (N,) or (M, N), and quaternions, shape (M, N, 4), of a batch.

    Times are validated where they are used, where integers that are not exactly floats raise.

    Raises
    ------
    InvalidInputError
        The times have a wrong shape, or are masked.
    """
    shape = quaternions.shape[:-1]
    members = quaternions.reshape(math.prod(shape[:-1]), shape[-1], 4)
    if np.ndim(t) < 2:
        return t, members
    _check_unmasked("t", t)
    times = np.asarray(t)
    if times.shape != shape:
        raise InvalidInputError(f"t: expected shape ({shape[-1]},) or {shape}, found {times.shape}")
    return times.reshape(members.shape[:-1]), members


def each_member(t: ArrayLike, quaternions: Array, *vectors: Array) -> list[tuple[Any, ...]]:
    """Return times, shape (N,), quaternions, shape (N, 4), and vectors, shape (N, 3), of each spline.

    A single spline counts as one. A batch without members gives one spline of equal rotations, whose construction
    validates the times and the options; `each_curve` drops its curve.
    """
    if quaternions.ndim == 2:
        return [(t, quaternions, *vectors)]
    times, members = flat_batch(t, quaternions)
    count, knots, _ = members.shape
    if not count:
        return [_equal_rotations(t, knots, len(vectors))]
    others = [each.reshape(count, knots, 3) for each in vectors]
    rows = times if np.ndim(times) > 1 else [times] * count
    return list(zip(rows, members, *others, strict=True))


def _equal_rotations(t: ArrayLike, knots: int, vectors: int) -> tuple[Any, ...]:
    """Return times, equal rotations and zero vectors, for a batch without members."""
    if np.ndim(t) > 1:
        # There are no times, only their type.
        real_array(t, "t")
        t = np.arange(float(knots))
    return t, np.tile([0.0, 0.0, 0.0, 1.0], (knots, 1)), *(np.zeros((knots, 3)) for _ in range(vectors))


def each_curve(make: Callable[..., Curve], members: Sequence[tuple[Any, ...]], shape: tuple[int, ...]) -> list[Curve]:
    """Return the curve of every spline of a batch of a given shape, one after another.

    `members` are those of `each_member`. Errors name the member, except errors of arguments that all members share.
    """
    shared = SHARED if len({id(times) for times, *_ in members}) > 1 else (*SHARED, "t")
    curves = []
    for i, member in enumerate(members):
        try:
            curves.append(make(*member))
        except StiefelError as error:
            if shape and argument_of(error) not in shared:
                error.args = (f"{error.args[0]} (batch member {i})", *error.args[1:])
            raise
    return curves[: math.prod(shape)]


def argument_of(error: StiefelError) -> str:
    """Return the name of the argument that an error is about, which follows the knot in its message."""
    first, *rest = str(error).split(":")
    return rest[0].strip() if rest and error.knot is not None else first
