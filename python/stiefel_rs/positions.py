"""Positions of poses along time, by SciPy's splines."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from .array_input import Array, at_knot, check_lam, finite_array, shape_of
from .end_conditions import BcType
from .errors import InvalidInputError
from .rotation_input import scipy_module

# Largest gap of a closed curve that counts as round-off, relative to its extent.
CLOSED: Final = 1e-9
# Number of data that scipy.interpolate.make_smoothing_spline needs.
SMOOTHED_AT_LEAST: Final = 5
USE: Final = "PoseSpline"


def interpolating(t: Array, positions: Array, bc_type: BcType) -> Any:
    """Make the cubic spline of positions, a `scipy.interpolate.CubicSpline`.

    If the ends are periodic, the last position is the first, as `closed` returns them.

    Raises
    ------
    InvalidInputError
        A value overflows.
    ImportError
        SciPy is not installed.
    """
    scipy = scipy_module("scipy.interpolate", USE)
    try:
        # Overflow is reported by an exception below.
        with np.errstate(all="ignore"):
            spline = scipy.CubicSpline(t, positions, bc_type=bc_type, extrapolate=True)
    except ValueError as error:
        # For validated arguments the only possible error is an overflow.
        raise InvalidInputError(f"positions: too large, or times too far apart or too close ({error})") from error
    _check_finite(spline.c)
    return spline


def derivative(spline: Any, t: Array, order: int) -> Array:
    """Evaluate positions, or a derivative of them, at times of shape T: shape T + (3,).

    Raises
    ------
    InvalidInputError
        The result overflows.
    """
    with np.errstate(all="ignore"):
        values: Array = spline(t, order)
    _check_finite(values)
    return values


def _check_finite(values: Array) -> None:
    if not np.isfinite(values).all():
        raise InvalidInputError("positions: a value overflows; use a smaller unit of time, or a larger unit of length")


def closed(positions: Array) -> Array:
    """Return positions of a closed curve, with the last set to the first; they may differ by round-off.

    Raises
    ------
    InvalidInputError
        They differ by more.
    """
    if not len(positions):
        return positions
    gap = float(np.abs(positions[-1] - positions[0]).max())
    extent = float(np.ptp(positions, axis=0).max())
    round_off = 4 * float(np.finfo(np.float64).eps * np.abs(positions).max())
    if gap > max(CLOSED * extent, round_off):
        raise at_knot(
            f"positions: the last must equal the first (periodic ends), found a gap of {gap:.3g}",
            len(positions) - 1,
        )
    out = positions.copy()
    out[-1] = out[0]
    return out


def check_smoothing(t: ArrayLike, count: int, lam: Any) -> None:
    """Refuse arguments of a smoothing spline that are valid for rotations, but not for positions.

    Raises
    ------
    InvalidInputError
        Fewer than 5 positions, a `lam` that is negative or not finite, times that repeat.
    TypeError
        A `lam` that is not a number.
    """
    if count < SMOOTHED_AT_LEAST:
        raise InvalidInputError(f"poses: smoothing needs at least {SMOOTHED_AT_LEAST} poses, found {count}")
    check_lam(lam)
    if lam is not None and not (np.isfinite(lam) and lam >= 0):
        raise InvalidInputError(f"lam: expected a finite number of at least 0 for positions, found {lam}")
    _check_repeated(t)


def _check_repeated(t: ArrayLike) -> None:
    """Raise for times that repeat; all other invalid times are refused with the rotations."""
    if len(shape_of(t) or ()) != 1:
        return
    times = np.asarray(t)
    if times.dtype.kind in "fiu" and (falls := times[1:] <= times[:-1]).any():
        knot = int(np.argmax(falls)) + 1
        raise at_knot(f"t: must be greater than the time before it, found {times[knot]}", knot)


def smoothing(t: ArrayLike, positions: Array, lam: float | None, weights: ArrayLike | None) -> Any:
    """Make the smoothing spline of positions, a `scipy.interpolate.BSpline`.

    Without `lam`, cross-validation chooses one for each coordinate. `check_smoothing` accepts the arguments.

    Raises
    ------
    InvalidInputError
        A `lam` so large that products overflow, or positions that do.
    ImportError
        SciPy is not installed.
    """
    scipy = scipy_module("scipy.interpolate", USE)
    times = finite_array(t, "t")
    w = None if weights is None else finite_array(weights, "weights")
    # Smoothing leaves lines unchanged. SciPy's equations lose them to rounding if `lam` is large: for 200 positions up
    # to 1, the error is 0.04 for a `lam` of a million times the cube of the duration.
    with np.errstate(all="ignore"):
        line = _line(times, positions, w)
        _check_finite(line(times))
        # SciPy looks for `lam` in a fixed interval: the mean time between poses becomes one, and the mean weight.
        unit = (times[-1] - times[0]) / (len(times) - 1)
        relative = (times - times[0]) / unit
        mean = 1.0 if w is None else float(np.mean(w / w.max()) * w.max())
        share = None if w is None else w / mean
        scaled = None if lam is None else float(lam) / mean / unit / unit / unit
    if scaled is not None and not np.isfinite(scaled):
        raise InvalidInputError(f"lam ({lam}) too large for these times and weights")
    rest = (positions - line(times)).T
    try:
        # SciPy before 1.15 takes one coordinate at a time.
        with np.errstate(over="raise", invalid="raise"):
            found = [scipy.make_smoothing_spline(relative, column, w=share, lam=scaled) for column in rest]
    except (FloatingPointError, ValueError) as error:
        raise InvalidInputError(f"positions: too large, or lam ({lam}) too large ({error})") from error
    knots = np.concatenate([times[:1].repeat(3), times, times[-1:].repeat(3)])
    # The coefficients of a line are its values at the Greville abscissae, means of three knots.
    means = (knots[1:-3] + knots[2:-2] + knots[3:-1]) / 3
    return scipy.BSpline(knots, np.stack([spline.c for spline in found], axis=-1) + line(means), 3)


def _line(times: Array, positions: Array, weights: Array | None) -> Callable[[Array], Array]:
    """Return the least-squares line through positions, as a function of time."""
    # Products of the largest weights may overflow.
    w = np.ones(len(times)) if weights is None else weights / weights.max()
    middle = np.average(times, weights=w)
    past = times - middle
    start = np.average(positions, axis=0, weights=w)
    rate = (w * past) @ positions / ((w * past) @ past)
    return lambda t: start + (t - middle)[:, None] * rate
