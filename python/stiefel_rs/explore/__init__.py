"""``stiefel-rs explore``: a page on which keyframes and velocities are dragged and the curves follow.

The page (``web/``) is one text that needs no network. Either a small server of this machine computes the curves
(`server`), or those between two ends were computed before, on a grid (`grid`).
"""

from __future__ import annotations

from .command import add_parser, run

__all__ = ["add_parser", "run"]
