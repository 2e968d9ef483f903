"""The colours of every figure of this package, and what replaces them on a dark page. Imports nothing.

Curves have the colours of Okabe and Ito, which differ for colour-blind readers too, those first that stand out from
white and from black. Axes of a body are red, green and blue, as in robotics and graphics.
"""

from __future__ import annotations

from typing import Final

BLUE: Final = "#0072B2"
VERMILION: Final = "#D55E00"
GREEN: Final = "#009E73"
PURPLE: Final = "#CC79A7"
ORANGE: Final = "#E69F00"
SKY: Final = "#56B4E9"
CURVES: Final = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)

X_AXIS: Final = "#E03131"
Y_AXIS: Final = "#2F9E44"
Z_AXIS: Final = "#1C6FD6"
BODY_AXES: Final = (X_AXIS, Y_AXIS, Z_AXIS)

# Text, axes and reference curves; marks beside them; lines behind them, near and far; what lies below all.
INK: Final = "#262626"
GREY: Final = "#6B6B6B"
NEAR_GREY: Final = "#A8A8A8"
GRID_GREY: Final = "#DDDDDD"
BACKGROUND: Final = "#FFFFFF"

# On a dark page: the background is that of the site's dark scheme.
DARK: Final = {
    INK: "#E2E4E9",
    "#000000": "#E2E4E9",
    GREY: "#A3A7B0",
    NEAR_GREY: "#6D727D",
    GRID_GREY: "#3B404B",
    BACKGROUND: "#1E2129",
    BLUE: "#3E9BDC",
    Z_AXIS: "#4C94F0",
    X_AXIS: "#F25C5C",
    Y_AXIS: "#43B85C",
}
