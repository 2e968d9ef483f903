"""Large frames: how far they are from their start, how fast they move, and all their entries as a picture."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, to_rgba
from numpy.typing import ArrayLike, NDArray

from .._core import Curve
from ..errors import InvalidInputError
from ..figure_style import GRID, PAGE, SMALL_FONT
from ..palette import BLUE, GREY, INK, VERMILION
from ._axes import cycled, drawn, dressed, flat, label, legend, line_style, new_figure, time_label
from ._norms import norms
from ._samples import Array, Drawable, Samples, samples

# Frames with more entries than this are too large for a line for each.
LARGE: Final = 60
# More columns than this have no names.
MAX_COLUMNS: Final = 12
# Zero is transparent, so that the picture suits light and dark pages; few shades make small files.
SIGNED: Final = LinearSegmentedColormap.from_list(
    "stiefel_rs signed",
    [(0.0, to_rgba(BLUE)), (0.5, to_rgba(BLUE, 0.0)), (0.5, to_rgba(VERMILION, 0.0)), (1.0, to_rgba(VERMILION))],
    N=33,
)
RESAMPLED: Final[dict[str, Any]] = {"interpolation": "antialiased", "interpolation_stage": "data"}
# Few large entries would leave all others pale: beyond this share of them the colour stays.
SHOWN_SHARE: Final = 0.99


def angles(
    curve: Drawable, *, ax: Axes | None = None, num: int = 200, t: ArrayLike | None = None, **style: Any
) -> Axes:
    """Draw the angle of each column to where it was at the start, in degrees, against time.

    Parameters are those of `entries`.

    Returns
    -------
    Axes

    Raises
    ------
    InvalidInputError
        `curve` has no points, `num` or `t` does not suit it, `ax` is not flat, `style` is not that of a line.
    """
    return _draw_angles(samples(curve, num, t), ax, line_style(style))


def _draw_angles(found: Samples, ax: Any, style: dict[str, Any]) -> Axes:
    new, axes = ax is None, flat(ax)
    turned = _turned(found.points)
    columns = turned.shape[1]
    before, named = drawn(axes), columns <= MAX_COLUMNS
    for column in range(columns):
        name = label(style, f"column {column + 1}") if named else None
        own = cycled(before + column) if named else cycled(before) | {"linewidth": 0.8, "alpha": 0.5}
        axes.plot(found.t, turned[:, column], **(own | style | {"label": name}))
    axes.set(xlabel=time_label(found.timed), ylabel="angle to start\n(degrees)")
    axes.grid(**GRID)
    if new:
        legend(axes)
    return axes


def _turned(points: Array) -> Array:
    """Angles of columns to those of the first point in degrees, shape ``(T, k)``; half of one is seen in the chord."""
    chords = np.linalg.norm(points - points[0], axis=1)
    return np.asarray(2 * np.degrees(np.arcsin(np.minimum(chords / 2, 1.0))))


def overview(curve: Drawable, *, ax: ArrayLike | None = None, num: int = 200, **style: Any) -> NDArray[np.object_]:
    """Draw what a large frame does: angles of its columns to their start, speed, acceleration, and all entries.

    The entries are a picture, one column of the frame above the other, blue where negative and red where positive; of a
    complex column the real parts are above the imaginary ones.
    Speed and covariant acceleration are lengths in the canonical metric; points and trajectories have no speed and two
    panels.

    Parameters
    ----------
    curve : Curve, CubicTrajectory, ChartTrajectory, or array_like of shape (T, n, k)
        What is drawn, any n and k.
    ax : sequence of Axes, optional
        Four axes for a `Curve`, two for others: angles, entries, velocity, acceleration. By default all are made.
    num : int, default 200
        Equidistant times at which a curve is evaluated.
    **style
        For the lines of the angles.

    Returns
    -------
    ndarray of Axes, shape (4,) or (2,)

    Raises
    ------
    InvalidInputError
        `curve` has no points, `num` does not suit it, `ax` are not so many axes, `style` is not that of a line.
    """
    found, style = samples(curve, num), line_style(style)
    count = 4 if isinstance(curve, Curve) else 2
    axes = _panels(count) if ax is None else np.array(ax, dtype=object).ravel()
    if axes.shape != (count,):
        raise InvalidInputError(f"ax: {count} axes expected, found {len(axes)}")
    _draw_angles(found, axes[0], style)
    _draw_picture(found, flat(axes[1]))
    if isinstance(curve, Curve):
        for which, below in enumerate(axes[2:], start=1):
            norms(curve, ax=below, num=num, order=which, linestyle="-")
    if ax is None:
        _name(axes, found)
    return axes


def _panels(count: int) -> NDArray[np.object_]:
    figure = new_figure(PAGE, 4.6 if count == 4 else 3.0)
    grid = figure.add_gridspec(count - 1, 2, width_ratios=[1.0, 1.25])
    first = figure.add_subplot(grid[0, 0])
    picture = figure.add_subplot(grid[:, 1])
    others = [figure.add_subplot(grid[row, 0], sharex=first) for row in range(1, count - 1)]
    return np.array([dressed(one) for one in (first, picture, *others)], dtype=object)


def _name(axes: NDArray[np.object_], found: Samples) -> None:
    """Names of columns above all, so that they cover nothing; labels of times only where the times are."""
    if found.points.shape[2] <= MAX_COLUMNS:
        handles, names = axes[0].get_legend_handles_labels()
        look = {"fontsize": SMALL_FONT, "labelcolor": INK, "frameon": False}
        axes[0].figure.legend(handles, names, loc="outside upper center", ncols=min(6, len(names)), **look)
    above = [axes[0], axes[2]] if len(axes) == 4 else []
    for ax in above:
        ax.tick_params(labelbottom=False)
        ax.set_xlabel("")


def _draw_picture(found: Samples, ax: Axes) -> None:
    """Entries against time, the columns of the frame one above the other."""
    count, n, k = found.points.shape
    rows = found.points.transpose(2, 1, 0).reshape(k * n, count)
    # Equidistant times: those of knots would be seen as steps.
    edges = np.linspace(found.t[0], found.t[-1], count)
    nearest = np.searchsorted(found.t, edges).clip(0, count - 1)
    largest = float(np.quantile(np.abs(rows), SHOWN_SHARE)) or 1.0
    extent = (found.t[0], found.t[-1], float(k * n), 0.0)
    shown = ax.imshow(
        rows[:, nearest], aspect="auto", extent=extent, cmap=SIGNED, vmin=-largest, vmax=largest, **RESAMPLED
    )
    step = -(-k // MAX_COLUMNS)
    named = range(0, k, step)
    ax.set_yticks([(column + 0.5) * n for column in named], [f"column {column + 1}" for column in named])
    ax.tick_params(axis="y", length=0)
    for column in range(1, k if k <= MAX_COLUMNS else 0):
        ax.axhline(column * n, color=GREY, linewidth=0.5)
    ax.set(xlabel=time_label(found.timed))
    bar = ax.figure.colorbar(shown, ax=ax, fraction=0.05, pad=0.02, extend="both")
    bar.outline.set_edgecolor(GREY)
    bar.ax.tick_params(labelsize=SMALL_FONT, color=INK, labelcolor=INK)
    bar.set_label("entry", fontsize=SMALL_FONT, color=INK)
