"""Columns of a file of poses: their contents and units."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final, NamedTuple, TypeVar

from .errors import InvalidInputError

T = TypeVar("T")

TUM_NAMES: Final = ("timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw")
CSV_NAMES: Final = ("t", "x", "y", "z", "qx", "qy", "qz", "qw")

_TIMES: Final = (("t",), ("time",), ("timestamp",))
_EUROC: Final = ("q_rs_x", "q_rs_y", "q_rs_z", "q_rs_w")
_QUATERNIONS: Final = (CSV_NAMES[4:], _EUROC)
_POSITIONS: Final = (("x", "y", "z"), ("tx", "ty", "tz"), ("p_rs_r_x", "p_rs_r_y", "p_rs_r_z"))
# Exponents of ten of the units, so that times in nanoseconds are read exactly.
_TIME_UNITS: Final = {"s": 0, "ms": -3, "us": -6, "ns": -9}
# Units per metre: dividing rounds only once.
_LENGTH_UNITS: Final = {"m": 1.0, "cm": 100.0, "mm": 1000.0}
_HEADING: Final = re.compile(r"([^\[(]*?)\s*(?:[\[(]([^\])]*)[\])])?")


class Layout(NamedTuple):
    """Places in a row of the time, the position (if any) and the quaternion, in this order."""

    width: int
    indices: tuple[int, ...]
    names: tuple[str, ...]
    split: Callable[[str], list[str]]
    time_exponent: int = 0
    parts_of_metre: tuple[float, ...] = (1.0, 1.0, 1.0)


TUM: Final = Layout(len(TUM_NAMES), tuple(range(len(TUM_NAMES))), TUM_NAMES, str.split)


def csv_layout(lines: Iterator[tuple[int, str]]) -> Layout:
    """Return the layout in the header of a CSV file; advances `lines` past the header.

    Raises
    ------
    InvalidInputError
        There is no header, or it has a missing or duplicate column or an unknown unit; `knot` is the line number.
    """
    for number, text in lines:
        columns = [_heading(part) for part in _fields(text.lstrip("#"))]
        try:
            return _layout(columns)
        except InvalidInputError as error:
            # The line is a comment, unless it names columns.
            if text.startswith("#") and not {"qw", _EUROC[-1]} & {name for name, _ in columns}:
                continue
            wrong = InvalidInputError(f"{error}; the header is {text[:120]!r}")
            wrong.knot = number
            raise wrong from None
    raise InvalidInputError(f"no header with the names of the columns ({','.join(CSV_NAMES)})")


def _fields(text: str) -> list[str]:
    return [part.strip().strip('"') for part in text.split(",")]


def _heading(text: str) -> tuple[str, str]:
    """Return the name of a column in lower case, and its unit."""
    found = _HEADING.fullmatch(text.strip())
    return (found[1].lower(), (found[2] or "").strip()) if found else ("", "")


def _layout(columns: Sequence[tuple[str, str]]) -> Layout:
    names = [name for name, _ in columns]
    time = _needed("time", _TIMES, names)
    quaternion = _needed("orientation", _QUATERNIONS, names)
    position = _chosen(_POSITIONS, names) or ()
    chosen = (*time, *position, *quaternion)
    for name in chosen:
        if (count := names.count(name)) > 1:
            raise InvalidInputError(f"{count} columns are named {name!r}")
    indices = tuple(names.index(name) for name in chosen)
    units = [columns[index][1] for index in indices]
    # The EuRoC data sets use nanoseconds, whether stated or not.
    exponent = _unit(_TIME_UNITS, units[0] or ("ns" if quaternion == _EUROC else "s"), time[0])
    parts = tuple(_unit(_LENGTH_UNITS, unit or "m", name) for unit, name in zip(units[1:], position, strict=False))
    return Layout(len(columns), indices, chosen, _fields, exponent, parts)


def _needed(what: str, kinds: Sequence[tuple[str, ...]], names: Sequence[str]) -> tuple[str, ...]:
    if (found := _chosen(kinds, names)) is None:
        raise InvalidInputError(f"no columns for the {what} ({' or '.join(' '.join(kind) for kind in kinds)})")
    return found


def _chosen(kinds: Sequence[tuple[str, ...]], names: Sequence[str]) -> tuple[str, ...] | None:
    """Return the names of the columns of the only kind in the header, or None.

    Raises
    ------
    InvalidInputError
        The header has columns of two kinds, or only some columns of one.
    """
    there = [kind for kind in kinds if set(kind) <= set(names)]
    if len(there) > 1:
        raise InvalidInputError(f"expected one of {' '.join(there[0])} and {' '.join(there[1])}, found both")
    if there:
        return there[0]
    for kind in kinds:
        if lacking := [name for name in kind if name not in names]:
            if len(lacking) < len(kind):
                raise InvalidInputError(f"column {' '.join(lacking)} of {' '.join(kind)} is missing")
    return None


def _unit(units: Mapping[str, T], unit: str, name: str) -> T:
    # There are two micro signs in Unicode.
    plain = unit.replace("\N{MICRO SIGN}", "u").replace("\N{GREEK SMALL LETTER MU}", "u")
    if plain not in units:
        raise InvalidInputError(f"expected one of the units {', '.join(units)} for {name}, found {unit!r}")
    return units[plain]
