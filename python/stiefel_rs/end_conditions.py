"""End conditions of splines of rotations and of poses."""

from __future__ import annotations

import operator
from collections.abc import Mapping, Set
from typing import Any, Final, Literal, TypeAlias

import numpy as np

from .array_input import Array, finite_array
from .errors import InvalidInputError

End: TypeAlias = Literal["natural", "clamped"] | tuple[Literal[1, 2], Any]
BcType: TypeAlias = Literal["natural", "clamped", "periodic"] | tuple[End, End]

END_WORDS: Final = ("natural", "clamped")
WORDS: Final = (*END_WORDS, "periodic")


def read_bc_type(bc_type: Any, shape: tuple[int, ...]) -> BcType:
    """Read end conditions whose vectors have the given shape.

    Returns
    -------
    str or tuple
        A word, or two ends: each a word or ``(order, vector)`` with a read-only array.

    Raises
    ------
    InvalidInputError
        Unknown word or order, or a vector with a wrong shape or non-finite entries.
    TypeError
        The conditions are neither a word nor a pair, or an order is not a whole number.
    """
    if isinstance(bc_type, str):
        return _word(bc_type, WORDS, "or a pair")  # type: ignore[return-value]
    first, last = _pair(bc_type, "two end conditions")
    return _end(first, shape), _end(last, shape)


def _word(word: str, words: tuple[str, ...], other: str) -> str:
    if word not in words:
        advice = "; for that of SciPy give estimated rates, ((1, w0), (1, w1))" if word == "not-a-knot" else ""
        raise InvalidInputError(f"bc_type: expected {', '.join(map(repr, words))} {other}, found {word!r}{advice}")
    return word


def _pair(items: Any, what: str) -> tuple[Any, Any]:
    try:
        # The items of these have no order, or no values.
        found = None if isinstance(items, Mapping | Set) else tuple(items)
    except TypeError:
        found = None
    if found is None:
        raise TypeError(f"bc_type: expected a pair ({what}), found {type(items).__name__}")
    if len(found) != 2:
        raise InvalidInputError(f"bc_type: expected a pair ({what}), found {len(found)} items")
    return found


def _end(end: Any, shape: tuple[int, ...]) -> End:
    if isinstance(end, str):
        return _word(end, END_WORDS, "or a pair for one end")  # type: ignore[return-value]
    given, vector = _pair(end, "an order and a vector")
    order = _order(given)
    if order not in (1, 2):
        raise InvalidInputError(
            f"bc_type: the order of an end condition must be 1 (rate) or 2 (acceleration), found {order}"
        )
    array = finite_array(vector, "bc_type")
    if array.shape != shape:
        raise InvalidInputError(f"bc_type: expected a vector of shape {shape}, found {array.shape}")
    return order, _frozen(array)  # type: ignore[return-value]


def _order(given: Any) -> int:
    """Read a whole number, also as a float, as SciPy does."""
    if isinstance(given, float | np.floating) and given.is_integer():
        return int(given)
    try:
        return operator.index(given)
    except TypeError:
        raise TypeError(f"bc_type: the order of an end condition must be 1 or 2, found {given!r}") from None


def _frozen(array: Array) -> Array:
    copy = np.array(array)
    copy.flags.writeable = False
    return copy


def in_body_frame(bc_type: BcType | None, ends: Array) -> BcType | None:
    """Express conditions ``V = R hat(w)`` at both end rotations, shape (2, 3, 3), by body vectors ``w``."""
    if bc_type is None or isinstance(bc_type, str):
        return bc_type
    first, last = (
        end if isinstance(end, str) else (end[0], _frozen(_vee(R.T @ end[1])))
        for end, R in zip(bc_type, ends, strict=True)
    )
    return first, last


def _vee(matrix: Array) -> Array:
    """Return the vector of the skew part of a matrix."""
    skew = (matrix - matrix.T) / 2
    return np.array([skew[2, 1], skew[0, 2], skew[1, 0]])


def part(bc_type: BcType, index: int) -> BcType:
    """Return the conditions for one row of the vectors, which have shape (2, 3)."""
    if isinstance(bc_type, str):
        return bc_type
    first, last = (end if isinstance(end, str) else (end[0], end[1][index]) for end in bc_type)
    return first, last
