"""Lengths of velocity and covariant acceleration against time."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .._core import Curve, PiecewiseCurve, Stiefel
from ..errors import InvalidInputError
from ..figure_style import GRID
from ..palette import GREY
from ._axes import KNOT_ID, TIME_LABEL, cycled, drawn, flat, label, legend, line_style
from ._samples import Array, times


def _lengths(curve: Curve, t: Array, order: int) -> Array:
    vectors = curve.velocity(t) if order == 1 else curve.acceleration(t)
    return Stiefel(curve.n, curve.k, field=curve.field).norm(curve(t), vectors)


def norms(curve: Curve, *, ax: Axes | None = None, num: int = 200, order: int | None = None, **style: Any) -> Axes:
    """Draw the lengths of velocity and covariant acceleration against time, in the canonical metric.

    Parameters
    ----------
    curve : Curve
        What is drawn. Knots of splines are marked on the axis of times.
    ax : Axes, optional
        Axes to draw into; new ones by default.
    num : int, default 200
        Equidistant times.
    order : {1, 2}, optional
        Velocity alone, or acceleration alone; both by default.
    **style
        For the lines; ``label="a"`` becomes "a, velocity" and "a, acceleration" where both are drawn. Both have a
        legend in new axes.

    Returns
    -------
    Axes

    Raises
    ------
    InvalidInputError
        No curve, another `order`, `num` is not a number from 2, `ax` is not flat, `style` is not that of a line.
    """
    if not isinstance(curve, Curve):
        raise InvalidInputError(f"curve: a Curve expected, found {type(curve).__name__}")
    # Arrays have no truth value, so the type comes first.
    if order is not None and (not isinstance(order, int | np.integer) or order not in (1, 2)):
        raise InvalidInputError(f"order: 1, 2 or None expected, found {order!r}")
    t, style, new = times(curve, num), line_style(style), ax is None
    ax = flat(ax)
    before = drawn(ax)
    for which, name in ((1, "velocity"), (2, "acceleration")):
        if order in (None, which):
            said = label(style, name) if order is None else style.get("label", name)
            own = cycled(before + which - 1) | style | {"label": said}
            ax.plot(t, _lengths(curve, t, which), **own)
    if isinstance(curve, PiecewiseCurve) and len(curve.t) <= 100:
        bars: dict[str, Any] = {"marker": "|", "markersize": 9, "linestyle": "none", "color": GREY, "clip_on": False}
        ax.plot(curve.t, np.zeros(len(curve.t)), gid=KNOT_ID, **bars)
    ax.set_ylim(bottom=0)
    ax.set(xlabel=TIME_LABEL, ylabel={None: "length", 1: "velocity", 2: "acceleration"}[order])
    ax.grid(**GRID)
    if new:
        legend(ax)
    return ax
