"""``stiefel-rs explore``: a page on which boundary velocities are dragged and the curves follow.

The page (``page.html``, ``page.css``, ``page.js``) is one file with plotly.js inside and needs no network. Either a
small server of this machine computes the curves (`server`), or they were computed before, on a grid (`grid`).
"""

from __future__ import annotations

from .command import add_parser, run

__all__ = ["add_parser", "run"]
