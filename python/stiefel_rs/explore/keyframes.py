"""Keyframes at given times: the cubic spline through them, and the shortest path from each to the next."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .._core import CubicSpline
from ..errors import InvalidInputError, OutsideDomainError, StiefelError
from ..rotation import RotationSpline
from .sampling import Array, Found, Sampled, Sampler, Smooth

# Limits of the page. Times are in s.
DURATION: Final = 6.0
GAP: Final = 0.2
COUNT: Final = (2, 8)
END_CONDITIONS: Final = ("natural", "clamped")
# How far a keyframe may be from length 1, and how near to the opposite of its neighbour, in rad.
UNIT_TOLERANCE: Final = 1e-6
OPPOSITE: Final = 1e-6


@dataclass(frozen=True)
class Keyframes:
    """A scene: keyframes are unit vectors of `size` entries, points of the sphere or quaternions (scalar last)."""

    title: str
    size: int
    t: tuple[float, ...]
    values: tuple[tuple[float, ...], ...]

    def described(self) -> dict[str, Any]:
        """Return the scene as the page wants it."""
        points = self.size == 3
        return {
            "family": "keyframes",
            "title": self.title,
            "columns": 1 if points else 3,
            "t": self.t,
            "values": self.values,
            "duration": DURATION,
            "gap": GAP,
            "count": COUNT,
            "curves": {"spline": "cubic spline", "slerp": "great-circle arcs" if points else "slerp"},
        }


def _unit(*rows: tuple[float, ...]) -> tuple[tuple[float, ...], ...]:
    array = np.array(rows)
    return tuple(map(tuple, (array / np.linalg.norm(array, axis=1, keepdims=True)).tolist()))


KINDS: Final = {
    "points": Keyframes(
        "Points",
        3,
        (0.0, 1.2, 2.6, 4.0, 5.4),
        _unit((0.5, -0.85, -0.2), (0.75, -0.45, 0.62), (0.95, 0.1, -0.35), (0.62, 0.62, 0.5), (0.15, 0.95, -0.15)),
    ),
    "rotations": Keyframes(
        "Rotations",
        4,
        (0.0, 1.4, 2.8, 4.2, 5.6),
        _unit(
            (0.0, 0.0, -0.25, 1.0),
            (0.35, -0.25, 0.35, 0.8),
            (0.15, 0.35, 0.75, 0.55),
            (-0.45, 0.3, 0.8, 0.2),
            (-0.2, -0.15, 0.95, -0.15),
        ),
    ),
}


def read(kind: Keyframes, t: Any, values: Any) -> tuple[Array, Array]:
    """Check the keyframes and return times, shape ``(N,)``, and unit vectors, shape ``(N, size)``.

    Raises
    ------
    InvalidInputError
        There are too few or too many, times do not increase or are out of range, or a value is no unit vector.
    """
    try:
        times, found = np.asarray(t, dtype=np.float64), np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as wrong:
        raise InvalidInputError(f"keyframes: numbers expected ({wrong})") from None
    least, most = COUNT
    if times.ndim != 1 or not least <= len(times) <= most:
        raise InvalidInputError(f"t: {least} to {most} times expected, found shape {times.shape}")
    if found.shape != (len(times), kind.size):
        raise InvalidInputError(f"values: shape {(len(times), kind.size)} expected, found {found.shape}")
    if not (np.isfinite(times).all() and np.isfinite(found).all()):
        raise InvalidInputError("keyframes: not finite")
    if times[0] < 0 or times[-1] > DURATION or (np.diff(times) <= 0).any():
        raise InvalidInputError(f"t: increasing times from 0 to {DURATION:g} expected")
    lengths = np.linalg.norm(found, axis=1)
    if (np.abs(lengths - 1) > UNIT_TOLERANCE).any():
        raise InvalidInputError(f"values: unit vectors expected, found length {lengths[np.argmax(abs(lengths - 1))]:g}")
    return times, found / lengths[:, None]


def find(kind: Keyframes, t: Array, values: Array, end_conditions: str) -> Found:
    """Return spline and shortest paths through the keyframes of `read`, or errors where they do not exist."""
    makers: dict[str, Callable[[], Sampler]] = {
        "spline": lambda: _spline(t, values, end_conditions),
        "slerp": lambda: Slerp(t, values),
    }
    found: Found = {}
    for name, make in makers.items():
        try:
            found[name] = make()
        except StiefelError as error:
            found[name] = error
    return found


def _spline(t: Array, values: Array, end_conditions: Any) -> Smooth:
    if values.shape[1] == 3:
        return Smooth(CubicSpline(t, values[:, :, None], end_conditions))
    return Smooth(RotationSpline(t, values, end_conditions).curve)


class Slerp:
    """Constant speed on the shortest path from each keyframe to the next, on the sphere or for rotations.

    Raises
    ------
    OutsideDomainError
        Two neighbours are opposite points; carries ``knot``, the first of them.
    """

    def __init__(self, t: Array, values: Array) -> None:
        self.t, self.values = t, values
        if values.shape[1] == 4:
            # Quaternions of opposite signs are the same rotation: each takes the sign that is nearer to its neighbour.
            turned = np.sum(values[1:] * values[:-1], axis=1) < 0
            self.values = values * np.cumprod(np.where([False, *turned], -1.0, 1.0))[:, None]
        chord = np.linalg.norm(np.diff(self.values, axis=0), axis=1)
        self.angles = 2 * np.arcsin(np.clip(chord / 2, 0, 1))
        if (opposite := np.flatnonzero(self.angles > np.pi - OPPOSITE)).size:
            error = OutsideDomainError("no unique shortest path joins opposite points", float(self.angles[opposite[0]]))
            error.knot = int(opposite[0])
            raise error
        # A quaternion turns half as fast as its rotation.
        self.turns = self.angles * (2 if values.shape[1] == 4 else 1)

    def _pieces(self, t: Array) -> NDArray[np.intp]:
        """Index of the piece at each time; of two equal times, the first is on the piece before."""
        piece = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, len(self.t) - 2)
        piece[:-1][np.diff(t) == 0] -= 1
        return np.asarray(piece, dtype=np.intp)

    def points(self, t: Array) -> Array:
        """Return points or rotation matrices."""
        piece = self._pieces(t)
        part = ((t - self.t[piece]) / np.diff(self.t)[piece])[:, None]
        angle = self.angles[piece][:, None]
        # sin(p x) / sin(x) by the function sinc, which knows the limit for equal neighbours.
        weight = np.sinc(angle / np.pi)
        one = (1 - part) * np.sinc((1 - part) * angle / np.pi) / weight
        other = part * np.sinc(part * angle / np.pi) / weight
        found = one * self.values[piece] + other * self.values[piece + 1]
        return found[:, :, None] if found.shape[1] == 3 else _matrices(found)

    def sampled(self, path: Array, profile: Array) -> Sampled:
        """Return points and speed; the acceleration is zero but for the jumps of the velocity."""
        speed = (self.turns / np.diff(self.t))[self._pieces(profile)]
        return Sampled(self.points(path), speed, None, None, float(self.turns.sum()))


def _matrices(quaternions: Array) -> Array:
    """Rotation matrices, shape ``(T, 3, 3)``, of unit quaternions, scalar last."""
    x, y, z, w = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)
