"""A body frame that moves in time."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]
from mpl_toolkits.mplot3d.art3d import Line3DCollection  # type: ignore[import-untyped]
from mpl_toolkits.mplot3d.proj3d import proj_transform  # type: ignore[import-untyped]
from numpy.typing import ArrayLike

from .._core import Curve
from ..errors import InvalidInputError
from ..figure_style import DPI, PAGE, SMALL_FONT
from ..palette import BODY_AXES, GREY
from ._axes import MARKS, legend, spatial, time_label
from ._samples import Array, Drawable, Samples, count, finite, number, samples

# A figure for a row, in inches: its width, its greatest height, and margins with room for legend and times.
WIDTH, MAX_HEIGHT = PAGE, 3.5
SIDE, TOP, BOTTOM = 0.4, 0.35, 0.3
# Times stand so far below their triads, in lengths of an axis.
BELOW: Final = 1.25


def _right_handed(found: Samples) -> Array:
    """Columns of St(3,2) with their cross product as the third, those of St(3,3) as they are."""
    points = found.points
    if points.shape[1:] == (3, 3):
        return points
    if points.shape[1:] != (3, 2):
        raise InvalidInputError(f"curve: St(3,2) or St(3,3) expected, found {found.manifold}")
    third = np.cross(points[:, :, 0], points[:, :, 1])
    return np.concatenate([points, third[:, :, None]], axis=2)


def _shown(curve: Drawable, num: int) -> Samples:
    """Take `num` samples of a curve; of points, at the most `num` of them, spread evenly."""
    if isinstance(curve, Curve) and curve.field == "real":
        t = np.linspace(*curve.t_span, num)
        return Samples(t, curve(t), True, t[:0], t[:0])
    found = samples(curve, num)
    keep = np.unique(np.round(np.linspace(0, len(found.t) - 1, min(num, len(found.t)))).astype(int))
    return Samples(found.t[keep], found.points[keep], found.timed, found.knot_times, found.knots, found.is_complex)


def body_frame(
    curve: Drawable,
    *,
    ax: Axes3D | None = None,
    num: int = 11,
    positions: ArrayLike | None = None,
    size: float | None = None,
) -> Axes3D:
    """Draw a curve on St(3,2) or St(3,3) as small triads of red, green and blue axes, one for each of `num` times.

    Parameters
    ----------
    curve : Curve, CubicTrajectory, ChartTrajectory, or array_like of shape (T, 3, 2) or (T, 3, 3)
        Its columns are the axes of the body; on St(3,2) the third is their cross product.
    ax : Axes3D, optional
        Axes with ``projection="3d"``; by default new ones with a legend, for a row as high as its triads.
    num : int, default 11
        Triads drawn: a curve at equidistant times; of points at the most so many, spread evenly.
    positions : array_like, shape (num, 3), optional
        Where the triads stand. By default they are in a row, from the left to the right in time.
    size : float, optional
        Length of the axes of a triad; by default a little less than half of the distance of neighbours.

    Returns
    -------
    Axes3D

    Raises
    ------
    InvalidInputError
        `curve` is not on St(3,2) or St(3,3), `ax` is flat, `positions` do not match, `size` is not positive.
    """
    found = _shown(curve, count(num))
    triads = _right_handed(found)
    if positions is not None:
        places = finite(positions, "positions", 2)
        if places.shape != (len(triads), 3):
            raise InvalidInputError(f"positions: shape {(len(triads), 3)} expected, found {places.shape}")
    else:
        places = np.zeros((len(triads), 3))
        places[:, 0] = np.arange(len(triads))
    row, new = positions is None, ax is None
    length = _length(places) if size is None else number(size, "size", "a positive number", lambda x: x > 0)
    ax = _square() if row and new else spatial(ax)
    _draw(ax, places, triads, length)
    if row:
        _lay_out(ax, found, length)
    if row and new:
        low = places - [0.0, 0.0, BELOW * length]
        _cut(ax, np.concatenate([places, low, *(places + length * triads[:, :, i] for i in range(3))]))
        legend(ax, loc="upper right", bbox_to_anchor=(1.0, 1.0), bbox_transform=ax.figure.transFigure)
    elif new:
        legend(ax)
    return ax


def _length(places: Array) -> float:
    """Length of the axes of a triad: less than half a step between neighbours; 1 where they stand in one place."""
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    typical = float(np.median(steps)) if len(steps) else 0.0
    return 0.45 * typical if typical > 0 else 1.0


def _draw(ax: Axes3D, places: Array, triads: Array, length: float) -> None:
    ax.plot(*places.T, color=GREY, linewidth=0.8, linestyle=(0, (2, 2)))
    for column, (colour, mark) in enumerate(zip(BODY_AXES, MARKS, strict=True)):
        tips = places + length * triads[:, :, column]
        segments = np.stack([places, tips], axis=1)
        ax.add_collection3d(Line3DCollection(segments, colors=colour, linewidths=1.6, label=f"axis {column + 1}"))
        ax.plot(*tips.T, linestyle="none", marker=mark, markersize=3.0, color=colour)
    low = np.min(places, axis=0) - length
    high = np.max(places, axis=0) + length
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    ax.set_box_aspect(tuple(high - low), zoom=0.9)


def _lay_out(ax: Axes3D, found: Samples, length: float) -> None:
    """Triads in a row: seen from the front and a little above, with their times below."""
    ax.set_proj_type("ortho")
    ax.view_init(elev=18.0, azim=-80.0)
    ax.set_axis_off()
    # Axes are square: in a flat row their background would hide what is above and below.
    ax.patch.set_visible(False)
    ends: dict[int, Any] = {0: found.t[0], len(found.t) // 2: found.t[len(found.t) // 2], len(found.t) - 1: found.t[-1]}
    for place, t in ends.items():
        text = f"{time_label(found.timed)} = {t:.3g}"
        ax.text(place, 0.0, -BELOW * length, text, ha="center", va="top", color=GREY, fontsize=SMALL_FONT)


def _square() -> Axes3D:
    """Make the axes of a row as they must be, square; `_cut` fits their figure to what is drawn."""
    made = Figure(figsize=(WIDTH, WIDTH), dpi=DPI)
    FigureCanvasAgg(made)
    return made.add_axes((0.0, 0.0, 1.0, 1.0), projection="3d")


def _inches(ax: Axes3D, points: Array) -> Array:
    """Where points of shape ``(N, 3)`` are in the figure, shape ``(N, 2)``."""
    x, y, _ = proj_transform(*points.T, ax.get_proj())
    return np.asarray(ax.transData.transform(np.column_stack([x, y])) / ax.figure.dpi)


def _cut(ax: Axes3D, points: Array) -> None:
    """Let points fill the width of their figure, as far as its height allows, and cut off what stays empty."""
    aspect = tuple(np.ptp([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()], axis=1))
    ax.set_box_aspect(aspect)
    placed = _inches(ax, points)
    wide, high = 2 * np.abs(placed[:, 0] - WIDTH / 2).max(), np.ptp(placed[:, 1])
    # The projection is parallel, so the picture grows with the zoom, from its middle.
    ax.set_box_aspect(aspect, zoom=min((WIDTH - 2 * SIDE) / wide, (MAX_HEIGHT - TOP - BOTTOM) / high))
    placed = _inches(ax, points)
    low, high = placed[:, 1].min(), np.ptp(placed[:, 1])
    height = high + TOP + BOTTOM
    ax.figure.set_size_inches(WIDTH, height)
    ax.set_position((0.0, (BOTTOM - low) / height, 1.0, WIDTH / height))
