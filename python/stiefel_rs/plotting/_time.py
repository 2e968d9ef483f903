"""Curves against time: entries, lengths of velocity and acceleration, knots."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from .._core import Curve, PiecewiseCurve, Stiefel
from ..errors import InvalidInputError
from ._axes import COLOURS, GREY, GRID, TIME_LABEL, column_style, flat, new_figure, time_label
from ._samples import Array, Drawable, Samples, samples, times
from ._sphere import frame, sphere

# More names than this do not fit into a legend.
MAX_NAMES: Final = 12


def entries(
    curve: Drawable, *, ax: Axes | None = None, num: int = 200, t: ArrayLike | None = None, **style: Any
) -> Axes:
    """Draw every entry of a curve against time, in the colour of its column; knots of splines as circles.

    Parameters
    ----------
    curve : Curve, CubicTrajectory, ChartTrajectory, or array_like of shape (T, n, k)
        What is drawn, any n and k.
    ax : Axes, optional
        Axes to draw into; new ones by default.
    num : int, default 200
        Equidistant times at which a curve is evaluated.
    t : array_like, shape (T,), optional
        Times of points; numbers from zero by default.
    **style
        For the lines.

    Returns
    -------
    Axes

    Raises
    ------
    InvalidInputError
        `curve` has no points, `num` or `t` does not suit it, `ax` is not flat.
    """
    found = samples(curve, num, t)
    ax = flat(ax)
    _, n, k = found.points.shape
    few = n * k <= MAX_NAMES
    for column in range(k):
        for row in range(n):
            own = {"color": COLOURS[column % len(COLOURS)], "linestyle": column_style(row, {})["linestyle"]}
            label = f"S[{row}, {column}]" if few else f"column {column + 1}" if row == 0 and k <= MAX_NAMES else None
            if not few:
                own |= {"linestyle": "-", "linewidth": 1.0, "alpha": max(0.25, min(1.0, 6 / n))}
            ax.plot(found.t, found.points[:, row, column], **(own | {"label": label} | style))
            _draw_knots(ax, found, row, column)
    ax.set(xlabel=time_label(found.timed), ylabel="entries")
    ax.grid(**GRID)
    return ax


def _draw_knots(ax: Axes, found: Samples, row: int, column: int) -> None:
    if len(found.knots):
        marks: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 4, "markerfacecolor": "white"}
        colour = COLOURS[column % len(COLOURS)]
        ax.plot(found.knot_times, found.knots[:, row, column], color=colour, gid="stiefel_rs knots", **marks)


def _circle(curve: Drawable, ax: Any, num: int, style: dict[str, Any]) -> Axes:
    """Columns of a curve in the plane, each on a circle of its own so that they do not hide each other."""
    found = samples(curve, num)
    axes = flat(ax)
    for column in range(found.points.shape[2]):
        radius, own = 1 + 0.08 * column, column_style(column, style)
        axes.plot(*(radius * found.points[:, :, column].T), **own)
        if len(found.knots):
            marks = {"linestyle": "none", "marker": "o", "color": own["color"], "markerfacecolor": "white"}
            axes.plot(*(radius * found.knots[:, :, column].T), gid="stiefel_rs knots", **marks)
    axes.set(xlabel="first entry", ylabel="second entry", aspect="equal")
    axes.grid(**GRID)
    return axes


def path(curve: Drawable, ax: Any, num: int, style: dict[str, Any]) -> Any:
    """Draw the picture that suits the shape."""
    shape = (curve.n, curve.k) if isinstance(curve, Curve) else _points_shape(curve)
    match shape:
        case (3, 1):
            return sphere(curve, ax=ax, num=num, **style)
        case (3, 2) | (3, 3):
            return frame(curve, ax=ax, num=num, **style)
        case (2, 1) | (2, 2):
            return _circle(curve, ax, num, style)
    drawn = entries(curve, ax=ax, num=num, **style)
    if drawn.get_legend_handles_labels()[0]:
        drawn.legend(frameon=False, ncols=2, fontsize="small")
    return drawn


def _points_shape(curve: Drawable) -> tuple[int, int]:
    n, k = samples(curve, 2).points.shape[1:]
    return n, k


def _lengths(curve: Curve, t: Array, order: int) -> Array:
    vectors = curve.velocity(t) if order == 1 else curve.acceleration(t)
    return Stiefel(curve.n, curve.k).norm(curve(t), vectors)


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
        For the lines.

    Returns
    -------
    Axes

    Raises
    ------
    InvalidInputError
        No curve, another `order`, `num` is not a number from 2, `ax` is not flat.
    """
    if not isinstance(curve, Curve):
        raise InvalidInputError(f"curve: a Curve expected, found {type(curve).__name__}")
    if order not in (None, 1, 2):
        raise InvalidInputError(f"order: 1, 2 or None expected, found {order!r}")
    t = times(curve, num)
    ax = flat(ax)
    for which, name in ((1, "velocity"), (2, "acceleration")):
        if order in (None, which):
            own = column_style(which - 1, {}) | {"label": name}
            ax.plot(t, _lengths(curve, t, which), **(own | style))
    if isinstance(curve, PiecewiseCurve) and len(curve.t) <= 100:
        bars: dict[str, Any] = {"marker": "|", "markersize": 9, "linestyle": "none", "color": GREY, "clip_on": False}
        ax.plot(curve.t, np.zeros(len(curve.t)), gid="stiefel_rs knots", **bars)
    ax.set_ylim(bottom=0)
    ax.set(xlabel=TIME_LABEL, ylabel={None: "length", 1: "velocity", 2: "acceleration"}[order])
    ax.grid(**GRID)
    return ax


def spline(curve: Curve, *, ax: ArrayLike | None = None, num: int = 400) -> NDArray[np.object_]:
    """Draw a curve through points with its knots; the lengths of velocity and covariant acceleration beside it.

    Parameters
    ----------
    curve : Curve
        A `CubicSpline`, `CubicHermite` or `SmoothingSpline`; other curves have no knots and are drawn without.
    ax : sequence of three Axes, optional
        For the path (as `plot` wants it: three-dimensional where n = 3), velocity and acceleration. By default all are
        made, in one figure.
    num : int, default 400
        Equidistant times; those of the knots are added.

    Returns
    -------
    ndarray of Axes, shape (3,)

    Raises
    ------
    InvalidInputError
        No curve, `num` is not a number from 2, `ax` is not three axes that suit.
    """
    if not isinstance(curve, Curve):
        raise InvalidInputError(f"curve: a Curve expected, found {type(curve).__name__}")
    axes = _three(curve) if ax is None else np.array(ax, dtype=object).ravel()
    if axes.shape != (3,):
        raise InvalidInputError(f"ax: three axes expected, found {len(axes)}")
    left = path(curve, axes[0], num, {})
    if left.get_legend() is None and left.get_legend_handles_labels()[0]:
        left.legend(frameon=False, loc="lower left")
    for which in (1, 2):
        norms(curve, ax=axes[which], num=num, order=which, linestyle="-")
    return axes


def _three(curve: Curve) -> NDArray[np.object_]:
    figure = new_figure(9.6, 4.6)
    grid = figure.add_gridspec(2, 2, width_ratios=[1.1, 1])
    left = figure.add_subplot(grid[:, 0], projection="3d" if curve.n == 3 else None)
    upper = figure.add_subplot(grid[0, 1])
    lower = figure.add_subplot(grid[1, 1], sharex=upper)
    return np.array([left, upper, lower], dtype=object)
