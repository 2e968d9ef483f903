"""Positions of poses along time, by SciPy's splines."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from .array_input import Array, at_knot, finite_array
from .end_conditions import BcType
from .errors import InvalidInputError
from .rotation_input import scipy_module

# Largest gap of a closed curve, in units of its largest coordinate, that is taken for round-off.
CLOSED: Final = 1e-9
# As many data as scipy.interpolate.make_smoothing_spline needs.
SMOOTHED_AT_LEAST: Final = 5
USE: Final = "PoseSpline"


def interpolating(t: Array, positions: Array, bc_type: BcType) -> Any:
    """Make the cubic spline of positions, a `scipy.interpolate.CubicSpline`.

    Raises
    ------
    InvalidInputError
        Periodic ends whose positions differ.
    ImportError
        SciPy is not installed.
    """
    scipy = scipy_module("scipy.interpolate", USE)
    if bc_type == "periodic":
        positions = _closed(positions)
    try:
        # What overflows is told by the error.
        with np.errstate(all="ignore"):
            spline = scipy.CubicSpline(t, positions, bc_type=bc_type, extrapolate=True)
    except ValueError as error:
        # Of checked arguments only what overflows is left.
        raise InvalidInputError(
            f"positions: too large, or times too far apart or too near, for floats ({error})"
        ) from error
    _check_finite(spline.c)
    return spline


def derivative(spline: Any, t: Array, order: int) -> Array:
    """Return positions, or a derivative of them, at times of shape T, shape T + (3,).

    Raises
    ------
    InvalidInputError
        A number too large for a float.
    """
    with np.errstate(all="ignore"):
        values: Array = spline(t, order)
    _check_finite(values)
    return values


def _check_finite(values: Array) -> None:
    if not np.isfinite(values).all():
        raise InvalidInputError("positions: a derivative is too large for a float; give times in a larger unit")


def _closed(positions: Array) -> Array:
    gap = float(np.abs(positions[-1] - positions[0]).max())
    if gap > CLOSED * float(np.abs(positions).max()):
        raise at_knot(
            f"positions: the last must be the first again (the ends are periodic), found a gap of {gap:.3g}",
            len(positions) - 1,
        )
    closed = positions.copy()
    closed[-1] = closed[0]
    return closed


def smoothing(t: ArrayLike, positions: Array, lam: float | None, weights: ArrayLike | None) -> Any:
    """Make the smoothing spline of positions, a `scipy.interpolate.BSpline`.

    Without `lam`, cross-validation finds one for each coordinate.

    Raises
    ------
    InvalidInputError
        Fewer than 5 positions, times that do not increase, a `lam` that is negative, not finite or so large that its
        products are.
    ImportError
        SciPy is not installed.
    """
    scipy = scipy_module("scipy.interpolate", USE)
    times = _increasing(t, len(positions))
    if lam is not None and not (np.isfinite(lam) and lam >= 0):
        raise InvalidInputError(f"lam: expected a finite number of 0 or more for positions, found {lam}")
    w = None if weights is None else finite_array(weights, "weights")
    # Lines are smoothed to themselves. SciPy's equations lose them where `lam` is large: of 200 positions up to 1 it is
    # off by 0.04 for `lam` a million times the cube of the time.
    with np.errstate(all="ignore"):
        line = _line(times, positions, w)
        _check_finite(line(times))
    rest = (positions - line(times)).T
    try:
        # SciPy before 1.15 takes one coordinate at a time.
        with np.errstate(over="raise"):
            found = [scipy.make_smoothing_spline(times, column, w=w, lam=lam) for column in rest]
    except FloatingPointError as error:
        raise InvalidInputError(f"positions: too large, or lam ({lam}), for floats ({error})") from error
    knots = found[0].t
    # The coefficients of a line are its values at the means of three knots (Greville).
    means = (knots[1:-3] + knots[2:-2] + knots[3:-1]) / 3
    return scipy.BSpline(knots, np.stack([spline.c for spline in found], axis=-1) + line(means), 3)


def _line(times: Array, positions: Array, weights: Array | None) -> Callable[[Array], Array]:
    """Return the straight line that is nearest to positions in the least squares, a function of time."""
    # Products of the largest weights may overflow.
    w = np.ones(len(times)) if weights is None else weights / weights.max()
    middle = np.average(times, weights=w)
    past = times - middle
    start = np.average(positions, axis=0, weights=w)
    rate = (w * past) @ positions / ((w * past) @ past)
    return lambda t: start + (t - middle)[:, None] * rate


def _increasing(t: ArrayLike, count: int) -> Array:
    """Read one time for each position."""
    times = finite_array(t, "t")
    if times.shape != (count,):
        raise InvalidInputError(f"t: expected one time for each of the {count} poses, found shape {times.shape}")
    if count < SMOOTHED_AT_LEAST:
        raise InvalidInputError(f"poses: smoothing needs at least {SMOOTHED_AT_LEAST}, found {count}")
    falls = np.diff(times) <= 0
    if falls.any():
        knot = int(np.argmax(falls)) + 1
        raise at_knot("t: must be greater than the time before it", knot)
    return times
