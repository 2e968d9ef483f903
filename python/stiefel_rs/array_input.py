"""Arrays of numbers as arguments: values at knots, and times to evaluate at."""

from __future__ import annotations

import numbers
from typing import TYPE_CHECKING, Any, Final, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import _as_numpy, _check_unmasked
from .errors import InvalidInputError

if TYPE_CHECKING:
    from collections.abc import Sequence

Array: TypeAlias = NDArray[np.float64]

# A time outside an interval by at most this many ulp of the larger end counts as that end.
END_ULPS: Final = 4


def at_knot(message: str, knot: int, member: int | None = None) -> InvalidInputError:
    """Return an error about a knot, of a member of a batch if one is given."""
    where = "" if member is None else f" (batch member {member})"
    error = InvalidInputError(f"knot {knot}: {message}{where}")
    error.knot = knot
    return error


def located(flat_index: int, lead: Sequence[int]) -> tuple[int, int | None]:
    """Return the knot and the batch member of an entry of an array with axes ``(..., N)``."""
    member, knot = divmod(int(flat_index), lead[-1])
    return knot, member if len(lead) > 1 else None


def flag(name: str, value: object) -> bool:
    """Read a truth value.

    Raises
    ------
    TypeError
        Anything else, such as the word "False".
    """
    if not isinstance(value, bool | np.bool_):
        raise TypeError(f"{name}: expected True or False, found {value!r}")
    return bool(value)


def shape_of(values: Any) -> tuple[int, ...] | None:
    """Return the shape of an array or of nested lists; None if these are ragged."""
    try:
        found: tuple[int, ...] = np.shape(values)
    except ValueError:
        return None
    return found


def real_array(values: ArrayLike, name: str) -> Array:
    """Read real numbers of any shape as float64.

    Raises
    ------
    TypeError
        Complex numbers, text, dates, objects.
    InvalidInputError
        The array is masked or ragged.
    """
    if type(values) is not np.ndarray:
        _check_unmasked(name, values)
    array: NDArray[Any] = _as_numpy(name, values)
    if array.dtype.kind not in "fiub":
        raise TypeError(f"{name}: expected real numbers, found an array of dtype {array.dtype}")
    return array.astype(np.float64, copy=False)


def check_lam(lam: Any) -> None:
    """Check that the weight of the acceleration of a smoothing spline is a number or None.

    Raises
    ------
    TypeError
        Anything else.
    """
    if lam is None:
        return
    is_number = isinstance(lam, numbers.Real) or (shape_of(lam) == () and np.asarray(lam).dtype.kind in "fiu")
    if not is_number:
        raise TypeError(f"lam: expected a number, or None for cross-validation, found {type(lam).__name__}")


def either(t: ArrayLike | None, times: ArrayLike | None) -> ArrayLike:
    """Return the value of an argument that has two names.

    Raises
    ------
    TypeError
        Both are given.
    """
    if t is not None and times is not None:
        raise TypeError("t: pass either t or times, not both")
    # None raises where the numbers are read.
    return cast("ArrayLike", t if times is None else times)


def either_weights(weights: ArrayLike | None, w: ArrayLike | None) -> ArrayLike | None:
    """Return the weights of measurements, under their own name or that of SciPy.

    Raises
    ------
    TypeError
        Both are given.
    """
    if weights is not None and w is not None:
        raise TypeError("weights: pass either weights or w, not both")
    return w if weights is None else weights


def finite_array(values: ArrayLike, name: str) -> Array:
    """Read finite real numbers of any shape as float64.

    Raises
    ------
    TypeError
        Complex numbers, text, dates, objects.
    InvalidInputError
        The array is masked, ragged or not finite.
    """
    array = real_array(values, name)
    finite = np.isfinite(array)
    if not finite.all():
        raise InvalidInputError(f"{name}: entry {int(np.argmin(finite))} is not finite")
    return array


def vectors_at_knots(values: ArrayLike, name: str, shape: tuple[int, ...]) -> Array:
    """Read one finite vector per knot, shape ``(..., N, 3)``."""
    array = real_array(values, name)
    if array.shape != shape:
        raise InvalidInputError(f"{name}: expected shape {shape}, found {array.shape}")
    check_knots_finite(array, name, 1)
    return array


def check_knots_finite(array: Array, name: str, axes: int) -> None:
    """Raise for the first knot with an entry that is not finite; the last `axes` axes belong to a knot."""
    finite = np.isfinite(array)
    if not finite.all():
        lead = array.shape[: array.ndim - axes]
        each = finite.reshape(*lead, -1).all(axis=-1)
        raise at_knot(f"{name}: not finite", *located(int(np.argmin(each)), lead))


def times_within(t: Array, start: float, end: float, advice: str = " (extrapolate=True continues the curve)") -> Array:
    """Return times, after moving those outside by at most 4 ulp of the larger end to the end.

    Raises
    ------
    InvalidInputError
        A time is outside ``[start, end]``.
    """
    slack = END_ULPS * np.finfo(np.float64).eps * max(abs(start), abs(end))
    outside = (t < start - slack) | (t > end + slack)
    if outside.any():
        found = t[outside][0]
        raise InvalidInputError(
            f"t: must be between the first and the last knot, {start} and {end}{advice}, found {found}"
        )
    return np.clip(t, start, end)
