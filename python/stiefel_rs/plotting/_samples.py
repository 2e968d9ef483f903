"""What is drawn: points of a curve, of a trajectory, or of an array."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from numbers import Real
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._core import ChartTrajectory, CubicTrajectory, Curve, PiecewiseCurve, _check_unmasked
from ..errors import InvalidInputError

Array = NDArray[np.float64]
Trajectory: TypeAlias = CubicTrajectory | ChartTrajectory
Drawable: TypeAlias = Curve | Trajectory | ArrayLike
MAX_SAMPLES: Final = 1_000_000
LARGEST: Final = float(np.finfo(np.float64).max)


@dataclass(frozen=True)
class Samples:
    """Points and their times; knots only of a curve through points.

    Attributes
    ----------
    t : ndarray, shape (T,)
    points : ndarray, shape (T, n, k)
        For complex points shape (T, 2n, k): the imaginary parts below the real ones.
    timed : bool
        Whether `t` are times; else they are numbers of points.
    knot_times : ndarray, shape (N,)
    knots : ndarray, shape (N, n, k) or (N, 2n, k)
    is_complex : bool
    """

    t: Array
    points: Array
    timed: bool
    knot_times: Array
    knots: Array
    is_complex: bool = False

    @property
    def manifold(self) -> str:
        """The manifold of frames of this shape, as in messages."""
        _, n, k = self.points.shape
        return f"St({n // 2},{k},C)" if self.is_complex else f"St({n},{k})"


def count(num: int) -> int:
    """Check a number of samples."""
    if isinstance(num, bool) or not isinstance(num, int | np.integer) or not 2 <= num <= MAX_SAMPLES:
        raise InvalidInputError(f"num: a whole number from 2 to {MAX_SAMPLES} expected, found {num!r}")
    return int(num)


def times(curve: Curve, num: int) -> Array:
    """Return `num` equidistant times and those of the knots, so that no corner is cut."""
    t = np.linspace(*curve.t_span, count(num))
    return np.union1d(t, curve.t) if isinstance(curve, PiecewiseCurve) else t


def finite(values: ArrayLike, name: str, ndim: int) -> Array:
    """Check an array of numbers that has at least one entry."""
    _check_unmasked(name, values)
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "biuf":
            raise TypeError(f"dtype {array.dtype}")
        array = array.astype(np.float64)
    except (TypeError, ValueError) as wrong:
        raise InvalidInputError(f"{name}: real numbers expected ({wrong})") from None
    if array.ndim != ndim or array.size == 0:
        raise InvalidInputError(f"{name}: {ndim} dimensions and at least one entry expected, found shape {array.shape}")
    if not np.isfinite(array).all():
        raise InvalidInputError(f"{name}: {np.count_nonzero(~np.isfinite(array))} entries are not finite")
    return array


def number(value: Any, name: str, wanted: str, suits: Callable[[float], bool]) -> float:
    """Check a finite number."""
    real = isinstance(value, Real) and not isinstance(value, bool)
    # Python's integers can be too large for a float.
    if real and -LARGEST <= value <= LARGEST and suits(float(value)):
        return float(value)
    raise InvalidInputError(f"{name}: {wanted} expected, found {value!r}")


def column_of(knots: Array, column: int) -> Array:
    """One column of knots, of which there may be none."""
    return knots[:, :, column] if len(knots) else knots


def matching(t: ArrayLike | None, number: int) -> tuple[Array, bool]:
    """Return times for so many points, and whether they were given."""
    if t is None:
        return np.arange(number, dtype=np.float64), False
    found = finite(t, "t", 1)
    if len(found) != number:
        raise InvalidInputError(f"t: {number} times expected, found {len(found)}")
    return found, True


def trajectory_times(trajectory: Trajectory, t: ArrayLike | None) -> tuple[Array, bool]:
    """Return times of a trajectory: its own or, where it has none (`ChartTrajectory`), those given."""
    if t is None and isinstance(trajectory, CubicTrajectory):
        return trajectory.t, True
    if trajectory.energy.ndim != 1:
        raise InvalidInputError(f"trajectory: one row of times expected, found shape {trajectory.energy.shape}")
    return matching(t, len(trajectory.energy))


def samples(curve: Drawable, num: int, t: ArrayLike | None = None) -> Samples:
    """Take samples of whatever has points.

    Raises
    ------
    InvalidInputError
        `curve` is no curve, trajectory or array of shape ``(T, n, k)``; `num` or `t` does not suit it.
    """
    none = np.zeros(0)
    if isinstance(curve, Curve):
        if t is not None:
            raise InvalidInputError("t: goes with points and trajectories, a curve has its own times")
        at, is_complex = times(curve, num), curve.field == "complex"
        points = _real_rows(curve(at))
        if isinstance(curve, PiecewiseCurve):
            return Samples(at, points, True, curve.t, _real_rows(curve.points), is_complex)
        return Samples(at, points, True, none, none, is_complex)
    count(num)
    if isinstance(curve, CubicTrajectory | ChartTrajectory):
        at, timed = trajectory_times(curve, t)
        return Samples(at, _real_rows(curve.point), timed, none, none, np.iscomplexobj(curve.point))
    if isinstance(curve, np.ndarray) and curve.ndim == 3 and np.iscomplexobj(curve):
        points, is_complex = finite(_real_rows(curve), "curve", 3), True
    else:
        points, is_complex = finite(curve, "curve", 3), False
    at, timed = matching(t, len(points))
    return Samples(at, points, timed, none, none, is_complex)


def _real_rows(points: NDArray[Any]) -> Array:
    """Points, with the imaginary parts below the real ones if they are complex."""
    return np.concatenate([points.real, points.imag], axis=1) if np.iscomplexobj(points) else points
