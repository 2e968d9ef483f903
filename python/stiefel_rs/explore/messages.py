"""Explain why a curve does not exist, for a person who drags it: no exception names, no solver numbers."""

from __future__ import annotations

from typing import Final

from ..errors import ConvergenceError, InvalidInputError, OutsideDomainError, StiefelError

NAMES: Final = {
    "cubic": "exact cubic",
    "gcp": "geometric cubic",
    "spline": "cubic spline",
    "slerp": "curve of shortest paths",
}


def plain(curve: str, error: StiefelError) -> str:
    """Return one or two sentences about a curve of the page that does not exist."""
    name = NAMES[curve]
    if curve in {"spline", "slerp"} and error.knot is not None and isinstance(error, OutsideDomainError):
        pair = f"keyframes {error.knot + 1} and {error.knot + 2}"
        return f"No {name}: {pair} are half a turn apart, without a unique shortest path. Move one."
    if isinstance(error, OutsideDomainError):
        return f"No {name}: it joins opposite points here, without a unique shortest path. Change an arrow."
    if isinstance(error, InvalidInputError):
        return f"No {name}: a velocity is too long for it. Shorten an arrow."
    if isinstance(error, ConvergenceError):
        advice = "Move a keyframe, or give it more time." if curve == "spline" else "Try shorter arrows."
        return f"No {name} was found here. {advice}"
    return f"No {name} here."
