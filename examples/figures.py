"""What the examples have in common: figures, the command line, bases of one subspace."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stiefel_rs import figure_style
from stiefel_rs.palette import BODY_AXES, ORANGE

Array = NDArray[np.float64]
FIGURES = Path(__file__).resolve().parent.parent / "docs" / "figures" / "gallery"
# Where the viewer of triads is.
AZIMUTH, ELEVATION = np.radians([-60.0, 25.0])


def nearest_turn(U: Array, W: Array) -> Array:
    """The orthogonal `R` for which the basis `U R` is nearest to the basis `W`; of many pairs as well."""
    left, _, right = np.linalg.svd(np.swapaxes(U, -1, -2) @ W)
    return np.asarray(left @ right)


def new_figure(height: float = 3.2, width: float = figure_style.PAGE) -> Figure:
    """A figure of that many inches, as wide as a page, in the style of the package whatever the user's settings are."""
    matplotlib.rcdefaults()
    matplotlib.rcParams.update(figure_style.SETTINGS)
    matplotlib.rcParams.update(
        {"axes.grid": True, "legend.frameon": False, "legend.handlelength": 2.4}
        | {f"grid.{name}": figure_style.GRID[name] for name in ("color", "linewidth")}
    )
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def keyframe_lines(ax: Axes, times: Array) -> None:
    """Thin lines at the times of keyframes, behind the curves."""
    for time in times:
        ax.axvline(time, color=ORANGE, linewidth=0.8, alpha=0.7, zorder=0)


def draw_triads(ax: Axes, places: Array, triads: Array, length: float) -> None:
    """Axes of bodies in red, green and blue, seen from the front; `length` in inches, `places` on the axis below."""
    right = np.array([-np.sin(AZIMUTH), np.cos(AZIMUTH), 0.0])
    up = np.array([-np.cos(AZIMUTH) * np.sin(ELEVATION), -np.sin(AZIMUTH) * np.sin(ELEVATION), np.cos(ELEVATION)])
    for place, triad in zip(places, triads, strict=True):
        towards = triad.T @ np.cross(right, up)
        for axis in np.argsort(towards):
            tip = length * 72 * np.array([triad[:, axis] @ right, triad[:, axis] @ up])
            arrow = {"arrowstyle": "<|-,head_width=0.15,head_length=0.25", "color": BODY_AXES[axis], "linewidth": 1.3}
            arrow |= {"shrinkA": 0, "shrinkB": 0}
            ax.annotate("", place, tip, textcoords="offset points", arrowprops=arrow, annotation_clip=False)


def save(figure: Figure, out: Path) -> None:
    """Write the figure in the format of its name, without dates."""
    out.parent.mkdir(parents=True, exist_ok=True)
    figure_style.write(figure, out)


def command_line(main: Callable[..., dict[str, Any]], name: str) -> None:
    """Run an example: `--out FILE`, `--quick`; its numbers are printed as JSON."""
    parser = argparse.ArgumentParser(description=(main.__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=FIGURES / f"{name}.svg", help="figure to write")
    parser.add_argument("--quick", action="store_true", help="a small problem, to see that it runs")
    options = parser.parse_args()
    print(json.dumps(main(options.out, quick=options.quick), indent=1))
