"""Curves against time: entries; what suits a shape; a spline with its lengths beside it."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from numpy.typing import ArrayLike, NDArray

from .._core import Curve
from ..errors import InvalidInputError
from ..figure_style import GRID, PAGE
from ..palette import BACKGROUND, CURVES, GREY
from ._axes import (
    GRID_ID,
    KNOT_ID,
    MARKS,
    column_style,
    cycled,
    drawn,
    dressed,
    flat,
    label,
    legend,
    line_style,
    new_figure,
    time_label,
)
from ._norms import norms
from ._overview import LARGE, angles, overview
from ._samples import Array, Drawable, Samples, column_of, samples
from ._sphere import frame, sphere

# Inside of circles nothing is drawn.
INSIDE: Final[dict[str, Any]] = {"loc": "center", "bbox_to_anchor": (0.5, 0.5), "ncols": 1, "frameon": True}
# More names than this do not fit into a legend.
MAX_NAMES: Final = 12


def entries(
    curve: Drawable, *, ax: Axes | None = None, num: int = 200, t: ArrayLike | None = None, **style: Any
) -> Axes:
    """Draw every entry of a curve against time, in the colour of its column; knots of splines as circles.

    Of complex entries real and imaginary parts are drawn.

    A further curve in the same axes has the next colours. A legend comes with new axes, not with those of the caller.

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
        For the lines; ``label="a"`` becomes "a, S[0, 0]", or "a, column 1" where entries are too many to be named.

    Returns
    -------
    Axes

    Raises
    ------
    InvalidInputError
        `curve` has no points, `num` or `t` does not suit it, `ax` is not flat, `style` is not that of a line.
    """
    found, style, new = samples(curve, num, t), line_style(style), ax is None
    ax = flat(ax)
    _, n, k = found.points.shape
    before = drawn(ax) // n
    for column in range(k):
        for row in range(n):
            name = _entry_name(row, column, found)
            own = _entry_style(row, name, (n, k), style) | {"color": CURVES[(before + column) % len(CURVES)]}
            (line,) = ax.plot(found.t, found.points[:, row, column], **(own | style | {"label": own["label"]}))
            if len(found.knots):
                _draw_knots(ax, found.knot_times, found.knots[:, row, column], line.get_color())
    ax.set(xlabel=time_label(found.timed), ylabel="entries")
    ax.grid(**GRID)
    if new:
        legend(ax)
    return ax


def _entry_name(row: int, column: int, found: Samples) -> str:
    """Name of an entry, or of its column where there are many entries."""
    _, rows, k = found.points.shape
    if rows * k > MAX_NAMES:
        return f"column {column + 1}"
    if not found.is_complex:
        return f"S[{row}, {column}]"
    part, row = ("Re", row) if row < rows // 2 else ("Im", row - rows // 2)
    return f"{part} S[{row}, {column}]"


def _entry_style(row: int, name: str, shape: tuple[int, int], style: dict[str, Any]) -> dict[str, Any]:
    """Dashes and name of an entry; many of them are thin, and only their columns have names."""
    n, k = shape
    if n * k <= MAX_NAMES:
        return {"linestyle": cycled(row)["linestyle"], "label": label(style, name)}
    named = row == 0 and k <= MAX_NAMES
    thin = {"linestyle": "-", "linewidth": 1.0, "alpha": max(0.25, min(1.0, 6 / n))}
    return thin | {"label": label(style, name) if named else None}


def _draw_knots(ax: Axes, t: Array, knots: Array, colour: Any) -> None:
    marks: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 4, "markerfacecolor": BACKGROUND}
    ax.plot(t, knots, color=colour, gid=KNOT_ID, **marks)


def _circle(curve: Drawable, ax: Any, num: int, style: dict[str, Any]) -> Axes:
    """Columns of a curve in the plane, each on a circle of its own so that they do not hide each other."""
    found, style = samples(curve, num), line_style(style)
    axes = flat(ax)
    before, columns = drawn(axes), found.points.shape[2]
    for column in range(columns):
        radius = 1 + 0.08 * column
        own = column_style(column, columns, style, before) if columns > 1 else cycled(before) | style
        _draw_circle(axes, radius)
        axes.plot(*(radius * found.points[:, :, column].T), **own)
        knots = radius * column_of(found.knots, column)
        _mark(axes, radius * found.points[:, :, column], knots, own["color"], MARKS[column])
    axes.set(xlabel="first entry", ylabel="second entry", aspect="equal")
    axes.grid(**GRID)
    if ax is None:
        legend(axes, **INSIDE)
    return axes


def _draw_circle(ax: Axes, radius: float) -> None:
    """Draw the circle on which a column moves, unless it is there."""
    if not any(isinstance(patch, Circle) and patch.radius == radius for patch in ax.patches):
        ax.add_patch(Circle((0.0, 0.0), radius, fill=False, color=GREY, linewidth=0.6, gid=GRID_ID))


def _mark(ax: Axes, points: Array, knots: Array, colour: Any, mark: str) -> None:
    """Knots as circles; where there are none, the start full and the end as a ring, as on the sphere."""
    full: dict[str, Any] = {"linestyle": "none", "marker": mark, "markersize": 4.5, "color": colour, "gid": KNOT_ID}
    ring = full | {"markerfacecolor": BACKGROUND}
    if len(knots):
        ax.plot(*knots.T, **ring)
    else:
        ax.plot(*points[:1].T, **full)
        ax.plot(*points[-1:].T, **ring)


def path(curve: Drawable, ax: Any, num: int, style: dict[str, Any]) -> Any:
    """Draw the picture that suits the shape."""
    few = samples(curve, 2)
    shape = few.points.shape[1:]
    match shape:
        case _ if few.is_complex:
            pass
        case (3, 1):
            return sphere(curve, ax=ax, num=num, **style)
        case (3, 2) | (3, 3):
            return frame(curve, ax=ax, num=num, **style)
        case (2, 1) | (2, 2):
            return _circle(curve, ax, num, style)
    if shape[0] * shape[1] <= LARGE:
        return entries(curve, ax=ax, num=num, **style)
    return angles(curve, ax=ax, num=num, **style) if ax is not None else overview(curve, num=num, **style)[0]


def spline(curve: Curve, *, ax: ArrayLike | None = None, num: int = 400) -> NDArray[np.object_]:
    """Draw a curve through points with its knots; the lengths of velocity and covariant acceleration beside it.

    Parameters
    ----------
    curve : Curve
        A `CubicSpline`, `CubicHermite` or `SmoothingSpline`; other curves have no knots and are drawn without.
    ax : sequence of three Axes, optional
        For the path (as `plot` wants it: three-dimensional for real points with n = 3), velocity and acceleration. By
        default all are made, in one figure, the path with a legend.
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
    if ax is None:
        legend(left, **(INSIDE if curve.n == 2 and curve.field == "real" else {}))
    for which in (1, 2):
        norms(curve, ax=axes[which], num=num, order=which, linestyle="-")
    return axes


def _three(curve: Curve) -> NDArray[np.object_]:
    figure, in_space = new_figure(PAGE, 3.6), curve.n == 3 and curve.field == "real"
    grid = figure.add_gridspec(2, 2, width_ratios=[1.1, 1])
    left = figure.add_subplot(grid[:, 0], projection="3d" if in_space else None)
    upper = dressed(figure.add_subplot(grid[0, 1]))
    lower = dressed(figure.add_subplot(grid[1, 1], sharex=upper))
    return np.array([left if in_space else dressed(left), upper, lower], dtype=object)
