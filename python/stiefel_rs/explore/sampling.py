"""Curves at the times at which the page draws them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from .._core import Curve, PiecewiseCurve, Stiefel
from ..errors import StiefelError

Array = NDArray[np.float64]
# Samples of a curve: as many as keep its chords below 0.05, even if it is quickest between those that are counted from.
CHORD: Final = 0.045
COARSE: Final = 500
MIN_SAMPLES: Final = 101
MAX_SAMPLES: Final = 2001
PROFILE: Final = 65
# Part of a curve's duration by which times of a graph differ from a knot, if they are not that knot.
SAME_TIME: Final = 1e-9
# Of Gauss's rule of two points on 40 parts of a piece, for its length. The parts are small, since the speed has a kink
# where it is zero.
PLACES: Final = ((np.arange(40)[:, None] + 0.5 + np.array([-1, 1]) / np.sqrt(12)) / 40).ravel()


@dataclass(frozen=True)
class Sampled:
    """One curve at the times of the page.

    Attributes
    ----------
    points : ndarray, shape (T, 3, k)
        At the times of the path.
    speed : ndarray, shape (P,)
        Canonical length of the velocity, in rad/s, at the times of the profiles.
    acceleration : ndarray, shape (P,), or None
        Canonical length of the covariant acceleration, in rad/s^2; None for a curve whose velocity jumps.
    cost : float or None
        Integral of the squared acceleration, in rad^2/s^3; None where it is infinite.
    length : float
        In rad.
    """

    points: Array
    speed: Array
    acceleration: Array | None
    cost: float | None
    length: float


class Sampler(Protocol):
    """A curve that can be drawn."""

    def points(self, t: Array) -> Array:
        """Return its points at times in ascending order, shape ``(T, 3, k)``."""

    def sampled(self, path: Array, profile: Array) -> Sampled:
        """Return all that is drawn of it: points at the first times, lengths of derivatives at the second."""


@dataclass(frozen=True)
class Smooth:
    """A curve of the library."""

    curve: Curve

    def points(self, t: Array) -> Array:
        """Return its points."""
        return np.asarray(self.curve(t))

    def sampled(self, path: Array, profile: Array) -> Sampled:
        """Return points, lengths of the derivatives, cost and length."""
        curve = self.curve
        acceleration = self._norm(profile, curve.acceleration(profile))
        return Sampled(self.points(path), self._speed(profile), acceleration, curve.cost(), self._length())

    def _norm(self, t: Array, V: Array) -> Array:
        return np.asarray(Stiefel(self.curve.n, self.curve.k).norm(self.points(t), V))

    def _speed(self, t: Array) -> Array:
        return self._norm(t, self.curve.velocity(t))

    def _length(self) -> float:
        """Return the length by Gauss's rule on small parts: `arc_length` takes longer than all the rest."""
        curve = self.curve
        knots = curve.t if isinstance(curve, PiecewiseCurve) else np.array(curve.t_span)
        steps = np.diff(knots)[:, None]
        t = knots[:-1, None] + steps * PLACES
        return float(np.sum(steps * self._speed(t.ravel()).reshape(t.shape)) / len(PLACES))


Found = dict[str, Sampler | StiefelError]
Drawn = dict[str, Sampled | StiefelError]


def _between(knots: Array, count: int) -> Array:
    """Return those of `count` equidistant times that are no knots, but for round-off."""
    even = np.linspace(knots[0], knots[-1], count)
    nearest = np.abs(even[:, None] - knots).min(axis=1)
    return np.asarray(even[nearest > SAME_TIME * (knots[-1] - knots[0])])


def profile_times(knots: Array) -> Array:
    """Return times for graphs of speed and acceleration, from the first knot to the last.

    Inner knots stand there twice: what jumps has its value before the knot at the first of them. The acceleration takes
    most of the time of an answer, so that there are fewer of these than times of a path.
    """
    return np.sort(np.concatenate([_between(knots, PROFILE), knots[[0, -1]], np.repeat(knots[1:-1], 2)]))


def path_times(found: Found, knots: Array) -> Array:
    """Return equidistant times and the knots, as close as the quickest of the curves needs."""
    coarse = np.linspace(knots[0], knots[-1], COARSE + 1)
    chords = [
        np.linalg.norm(np.diff(curve.points(coarse), axis=0), axis=1).max()
        for curve in found.values()
        if not isinstance(curve, StiefelError)
    ]
    count = int(np.clip(np.ceil(max(chords, default=0.0) * COARSE / CHORD) + 1, MIN_SAMPLES, MAX_SAMPLES))
    return np.sort(np.concatenate([_between(knots, count), knots]))


def sample(found: Found, path: Array, profile: Array) -> Drawn:
    """Return the curves at the given times; errors stay."""
    return {
        name: curve if isinstance(curve, StiefelError) else curve.sampled(path, profile)
        for name, curve in found.items()
    }


def apart(found: Drawn) -> Array | None:
    """Angle in rad between the two curves, at the times of the path; None if one of them is missing.

    Between points on the sphere it is their distance, between frames that of the rotation that takes one to the other.
    """
    drawn = [curve for curve in found.values() if isinstance(curve, Sampled)]
    if len(drawn) < 2:
        return None
    difference = _whole(drawn[0].points) - _whole(drawn[1].points)
    # |R - Q| = 2 sqrt(2) sin(angle / 2) for rotations, 2 sin(angle / 2) for points.
    longest = 2.0 if difference.shape[-1] == 1 else 2 * np.sqrt(2)
    return np.asarray(2 * np.arcsin(np.clip(np.linalg.norm(difference, axis=(1, 2)) / longest, 0, 1)))


def _whole(points: Array) -> Array:
    """Give frames of two columns their third, the cross product."""
    if points.shape[-1] != 2:
        return points
    return np.concatenate([points, np.cross(points[..., 0], points[..., 1])[..., None]], axis=-1)
