"""Colours, line styles and markers of the methods; each differs without colour too. Colours are Okabe and Ito's."""

from __future__ import annotations

from typing import Any, Final

STYLES: Final[dict[str, dict[str, Any]]] = {
    "reference": {"color": "#000000", "linestyle": "-", "linewidth": 2.4},
    "gcp": {"color": "#D55E00", "linestyle": (0, (4, 2)), "marker": "s"},
    "initial_point_ivp": {"color": "#E69F00", "linestyle": "-.", "marker": "o"},
    "initial_point_bvp": {"color": "#0072B2", "linestyle": "-", "marker": "D"},
    "midpoint_ivp": {"color": "#009E73", "linestyle": (0, (1, 1.2)), "marker": "^"},
    "midpoint_bvp": {"color": "#CC79A7", "linestyle": (0, (6, 1.5)), "marker": "v"},
    "splitting_2": {"color": "#56B4E9", "linestyle": "-", "marker": "<"},
    "splitting_4": {"color": "#56B4E9", "linestyle": (0, (4, 2)), "marker": ">"},
    "splitting_6": {"color": "#56B4E9", "linestyle": (0, (1, 1.2)), "marker": "p"},
    "splitting_8": {"color": "#56B4E9", "linestyle": "-.", "marker": "h"},
    "exact_bvp": {"color": "#000000", "linestyle": "-", "marker": "x"},
}
TIME_LABEL: Final = "time t (dimensionless)"
