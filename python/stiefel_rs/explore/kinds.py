"""The scenes of the page by name, in the order of its tabs."""

from __future__ import annotations

from typing import Any, Final

from . import keyframes, two_ends

KINDS: Final[dict[str, two_ends.Ends | keyframes.Keyframes]] = {**keyframes.KINDS, **two_ends.KINDS}
FIRST: Final = "rotations"


def described() -> dict[str, Any]:
    """Return the scenes as the page wants them."""
    return {name: kind.described() for name, kind in KINDS.items()}
