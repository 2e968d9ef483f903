"""Half turns between rotations that are interpolated with given rates, which decide the direction."""

from __future__ import annotations

from typing import Final

import numpy as np

from .array_input import Array
from .errors import OutsideDomainError

# Angles this close to pi have no unique shortest path: round-off of the angle, in rad, as for `RotationSpline`.
ROUND_OFF: Final = 12 * float(np.finfo(np.float64).eps)


def check_directions(t: Array, quaternions: Array, rates: Array) -> None:
    """Check that the rates decide the direction of every half turn.

    For angles within `ROUND_OFF` of pi, the turn about the axis at the mean of both rates must exceed
    ``ROUND_OFF * (1 + s)``, where ``s`` is the turn at the mean of their norms, in rad.

    Parameters
    ----------
    t : ndarray, shape (N,)
        Increasing times, in s.
    quaternions : ndarray, shape (N, 4)
        Rotations, scalar last, of length 1.
    rates : ndarray, shape (N, 3)
        Angular rates in the body frame, in rad/s.

    Raises
    ------
    OutsideDomainError
        The direction is undecided; carries ``knot``, the index of the first rotation, and ``angle`` in rad.
    """
    p, q = quaternions[:-1], quaternions[1:]
    # The angle is pi less twice this number, to third order.
    scalar = np.abs(np.sum(p * q, axis=-1))
    half_turns = np.flatnonzero(2 * scalar <= ROUND_OFF)
    if not half_turns.size:
        return
    axes = _axes(p[half_turns], q[half_turns])
    before, after, step = rates[half_turns], rates[half_turns + 1], np.diff(t)[half_turns]
    turn = np.abs(np.sum(axes * (before + after), axis=-1)) * step / 2
    at_norms = (np.linalg.norm(before, axis=-1) + np.linalg.norm(after, axis=-1)) * step / 2
    for knot in half_turns[turn <= ROUND_OFF * (1 + at_norms)][:1]:
        raise _undecided(int(knot), np.pi - 2 * float(scalar[knot]))


def _axes(p: Array, q: Array) -> Array:
    """Return the axes of half turns between unit quaternions, along the axes of either body."""
    axes = p[:, 3:] * q[:, :3] - q[:, 3:] * p[:, :3] - np.cross(p[:, :3], q[:, :3])
    return np.asarray(axes / np.linalg.norm(axes, axis=-1, keepdims=True))


def _undecided(knot: int, angle: float) -> OutsideDomainError:
    error = OutsideDomainError(
        f"knots {knot} and {knot + 1}: a rotation angle is {angle:.17f} (pi to working precision), and the rates do "
        "not decide the direction; add a knot between them",
        angle,
    )
    error.knot = knot
    return error
