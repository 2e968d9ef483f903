"""Figure of a curve through points: paths of its columns, speed and acceleration.

Importing this module imports matplotlib.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]
from numpy.typing import NDArray

from . import figure_sphere, figure_style, storage
from ._core import Curve, Stiefel
from .palette import BACKGROUND, BLUE, BODY_AXES, GREY, VERMILION

Array = NDArray[np.float64]
DASHES: Final[tuple[Any, ...]] = ("-", (0, (5, 1.5)), (0, (1, 1)))
SAMPLES: Final = 1001
VIEW: Final = np.array([2.0, 1.2, 1.0]) / np.linalg.norm([2.0, 1.2, 1.0])


def _style(column: int) -> dict[str, Any]:
    return {"color": BODY_AXES[column], "linestyle": DASHES[column], "label": f"column {column + 1}"}


def draw_circle(points: Array, knots: Array, *, ax: Axes) -> None:
    """Draw columns in the plane, on circles of different radii so that they do not hide each other."""
    for column in range(points.shape[2]):
        radius = 1 + 0.08 * column
        ax.plot(*(radius * points[:, :, column].T), **_style(column))
        ax.plot(*(radius * knots[:, :, column].T), "o", color=BODY_AXES[column], markerfacecolor=BACKGROUND)
    ax.set(xlabel="first entry", ylabel="second entry", aspect="equal")
    ax.grid(**figure_style.GRID)


def draw_sphere(points: Array, knots: Array, *, ax: Axes3D) -> None:
    """Draw columns on the unit sphere, paler on the far side."""
    figure_sphere.draw_sphere(VIEW, ax=ax)
    for column in range(points.shape[2]):
        path = points[:, :, column]
        front = (path @ VIEW > 0)[:, None]
        style = _style(column)
        ax.plot(*np.where(front, path, np.nan).T, zorder=4, **style)
        ax.plot(*np.where(front, np.nan, path).T, zorder=3, alpha=0.35, **(style | {"label": None}))
        ax.plot(*knots[:, :, column].T, "o", color=style["color"], markerfacecolor=BACKGROUND, markersize=4, zorder=5)


def draw_norms(curve: Curve, t: Array, knots: Array, *, axes: tuple[Axes, Axes]) -> None:
    """Draw the norms of velocity and covariant acceleration in the canonical metric against time."""
    M, S = Stiefel(curve.n, curve.k), curve(t)
    for ax, vectors, label, colour in (
        (axes[0], curve.velocity(t), "velocity", BLUE),
        (axes[1], curve.acceleration(t), "covariant\nacceleration", VERMILION),
    ):
        ax.plot(t, M.norm(S, vectors), color=colour)
        ax.set_ylabel(label)
        ax.set_ylim(bottom=0)
        if len(knots) <= 100:
            ax.plot(knots, np.zeros(len(knots)), "|", color=GREY, markersize=9, clip_on=False)
        ax.grid(**figure_style.GRID)
    axes[0].set_title("norms in the canonical metric")
    axes[0].tick_params(labelbottom=False)
    axes[1].set_xlabel("time t (units of the input; bars: input points)")


def figure(curve: Curve, t: Array, S: Array) -> Figure:
    """Return a figure with the paths of the columns (for n = 2 and 3) and the norms of velocity and acceleration."""
    times = np.unique(np.concatenate([np.linspace(*curve.t_span, SAMPLES), np.asarray(t, dtype=np.float64)]))
    paths, spherical = curve.n in (2, 3), curve.n == 3
    made = figure_style.new_figure(figure_style.PAGE if paths else figure_style.COLUMN, 3.6)
    margins = (0.2 if spherical else 0.8, 0.2, 0.6, 0.4)
    grid = figure_style.grid(made, 2, 2 if paths else 1, margins, hspace=0.12, wspace=0.32)
    if paths:
        points, knots = curve(times), np.asarray(S, dtype=np.float64)
        if spherical:
            left = made.add_subplot(grid[:, 0], projection="3d", computed_zorder=False)
            draw_sphere(points, knots, ax=left)
        else:
            left = made.add_subplot(grid[:, 0])
            draw_circle(points, knots, ax=left)
        below: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, 0.05), "ncols": curve.k}
        left.legend(frameon=False, **(below if spherical else {"loc": "center"}))
    upper = made.add_subplot(grid[0, -1])
    lower = made.add_subplot(grid[1, -1], sharex=upper)
    draw_norms(curve, times, np.asarray(t, dtype=np.float64), axes=(upper, lower))
    return made


def write(path: Path, curve: Curve, t: Array, S: Array) -> None:
    """Write the figure, in the format of the file name's suffix."""
    with storage.replacing(path) as file, figure_style.context():
        figure(curve, t, S).savefig(file, format=path.suffix[1:].lower(), dpi=figure_style.DPI)
