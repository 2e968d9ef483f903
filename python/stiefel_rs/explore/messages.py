"""Why a curve is missing, in words for somebody who drags it: no names of types, no numbers of a solver."""

from __future__ import annotations

from typing import Final

from ..errors import ConvergenceError, InvalidInputError, OutsideDomainError, StiefelError

NAMES: Final = {
    "cubic": "exact cubic",
    "gcp": "geometric cubic",
    "spline": "cubic spline",
    "slerp": "shortest ways",
}


def plain(curve: str, error: StiefelError) -> str:
    """Return one or two sentences on a curve of the page that does not exist."""
    name = NAMES[curve]
    if curve in {"spline", "slerp"} and error.knot is not None and isinstance(error, OutsideDomainError):
        one = error.knot + 1
        return f"No {name}: keyframes {one} and {one + 1} are opposite, and every way round is as short. Move one."
    if isinstance(error, OutsideDomainError):
        return f"No {name}: it joins points that are opposite here, and every way round is as short. Change an arrow."
    if isinstance(error, InvalidInputError):
        return f"No {name}: a velocity is too long for it. Shorten an arrow."
    if isinstance(error, ConvergenceError):
        advice = "Move a keyframe, or give it more time." if curve == "spline" else "Try shorter arrows."
        return f"No {name} was found here. {advice}"
    return f"No {name} here."
