"""What the page asks, and the curves that it gets.

Arrays go as base64 of little-endian 32-bit floats, 6e-8 of their size from the curves: a fifth of the text and of the
time that numbers of JSON take.
"""

from __future__ import annotations

import base64
import json
import sys
from typing import Any, Final

import numpy as np

from ..errors import InvalidInputError, StiefelError
from . import keyframes, two_ends
from .kinds import KINDS
from .messages import plain
from .sampling import Array, Drawn, Found, Sampled, apart, path_times, profile_times, sample

FIELDS: Final = {two_ends.Ends: {"kind", "angle", "v0", "v1"}, keyframes.Keyframes: {"kind", "t", "values", "ends"}}


def text(array: np.ndarray[Any, Any], dtype: str = "<f4") -> str:
    """Return the entries of an array as base64."""
    return base64.b64encode(array.astype(dtype).tobytes()).decode("ascii")


def _refuse(constant: str) -> float:
    raise InvalidInputError(f"{constant} is no number of JSON")


def parse(body: bytes) -> dict[str, Any]:
    """Read what the page sends.

    Raises
    ------
    InvalidInputError
        It is no JSON, or not the fields that are wanted.
    """
    try:
        found = json.loads(body.decode("utf-8"), parse_constant=_refuse)
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError, ValueError) as error:
        raise InvalidInputError(f"not JSON: {error}") from None
    if not isinstance(found, dict):
        raise InvalidInputError("an object expected")
    if not isinstance(found.get("kind"), str) or found["kind"] not in KINDS:
        raise InvalidInputError(f"kind: {' or '.join(KINDS)} expected")
    fields = FIELDS[type(KINDS[found["kind"]])]
    if set(found) != fields:
        raise InvalidInputError(f"an object with {', '.join(sorted(fields))} expected")
    if "ends" in fields and found["ends"] not in keyframes.END_CONDITIONS:
        raise InvalidInputError(f"ends: {' or '.join(keyframes.END_CONDITIONS)} expected")
    for name in sorted(fields - {"kind", "ends"}):
        _check_numbers(found[name], name, {"angle": 0, "values": 2}.get(name, 1))
    return found


def _check_numbers(value: Any, name: str, depth: int) -> None:
    """Check for numbers in lists of a depth."""
    if depth > 0:
        if not isinstance(value, list):
            raise InvalidInputError(f"{name}: a list of {'lists' if depth > 1 else 'numbers'} expected")
        for member in value:
            _check_numbers(member, name, depth - 1)
    # True is an int, and an int may be too large for a float.
    elif isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= sys.float_info.max:
        raise InvalidInputError(f"{name}: finite numbers expected")


def compute(request: dict[str, Any]) -> tuple[Found, Array]:
    """Curves for a request and their knots.

    Raises
    ------
    InvalidInputError
        A number is out of its range.
    """
    kind = KINDS[request["kind"]]
    if isinstance(kind, two_ends.Ends):
        return two_ends.find(kind, float(request["angle"]), request["v0"], request["v1"]), two_ends.SPAN
    t, values = keyframes.read(kind, request["t"], request["values"])
    return keyframes.find(kind, t, values, request["ends"]), t


def first_request(name: str) -> dict[str, Any]:
    """Return what the page asks when a scene is opened."""
    kind = KINDS[name]
    if isinstance(kind, two_ends.Ends):
        v0, v1 = map(list, kind.velocities)
        return {"kind": name, "angle": kind.angle, "v0": v0, "v1": v1}
    values = [list(value) for value in kind.values]
    return {"kind": name, "t": list(kind.t), "values": values, "ends": keyframes.END_CONDITIONS[0]}


def answer(request: dict[str, Any]) -> dict[str, Any]:
    """Curves for a request, as the page wants them.

    Raises
    ------
    InvalidInputError
        A number is out of its range.
    """
    found, knots = compute(request)
    path, profile = path_times(found, knots), profile_times(knots)
    drawn = sample(found, path, profile)
    reply = {"t": text(path), "profile_t": text(profile), "curves": _curves(drawn), "angle": None}
    if (angle := apart(drawn)) is not None:
        reply |= {"angle": text(angle)}
    kind = KINDS[request["kind"]]
    if isinstance(kind, two_ends.Ends):
        start, end = two_ends.ends(kind, float(request["angle"]))
        reply |= {"start": start.described(), "end": end.described()}
    return reply


def _curves(drawn: Drawn) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, curve in drawn.items():
        if isinstance(curve, Sampled):
            found[name] = {
                "points": text(curve.points),
                "speed": text(curve.speed),
                "acceleration": None if curve.acceleration is None else text(curve.acceleration),
                "cost": curve.cost,
                "length": curve.length,
            }
        else:
            found[name] = {"error": plain(name, curve)}
    return found


def message(error: StiefelError) -> str:
    """Text of an error with the name of its type."""
    return f"{type(error).__name__}: {error}"
