"""Colours, line styles and markers of the methods; each differs without colour too. Colours are the palette's."""

from __future__ import annotations

from typing import Any, Final

from ..palette import BLUE, GREEN, INK, ORANGE, PURPLE, SKY, VERMILION

STYLES: Final[dict[str, dict[str, Any]]] = {
    "reference": {"color": INK, "linestyle": "-", "linewidth": 2.4},
    "gcp": {"color": VERMILION, "linestyle": (0, (4, 2)), "marker": "s"},
    "initial_point_ivp": {"color": ORANGE, "linestyle": "-.", "marker": "o"},
    "initial_point_bvp": {"color": BLUE, "linestyle": "-", "marker": "D"},
    "midpoint_ivp": {"color": GREEN, "linestyle": (0, (1, 1.2)), "marker": "^"},
    "midpoint_bvp": {"color": PURPLE, "linestyle": (0, (6, 1.5)), "marker": "v"},
    "splitting_2": {"color": SKY, "linestyle": "-", "marker": "<"},
    "splitting_4": {"color": SKY, "linestyle": (0, (4, 2)), "marker": ">"},
    "splitting_6": {"color": SKY, "linestyle": (0, (1, 1.2)), "marker": "p"},
    "splitting_8": {"color": SKY, "linestyle": "-.", "marker": "h"},
    "exact_bvp": {"color": INK, "linestyle": "-", "marker": "x"},
}
TIME_LABEL: Final = "time t (dimensionless)"
