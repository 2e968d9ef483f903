"""Figures 1 and 3 of the paper, with its three curves, its names and shooting. Imports matplotlib."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from .. import figure_style
from ..palette import BACKGROUND
from . import experiments
from .experiments import SPHERE, Array, ErrorRow, Experiment
from .paper_tables import PANELS
from .styles import STYLES
from .text import LABELS, PAPER_LABELS
from .trajectories import FINE_STEPS, TRAJECTORY_STEPS, Trajectories

# Two kinds of dashes look alike in grey.
PAPER_STYLES: Final = STYLES | {"midpoint_bvp": STYLES["midpoint_bvp"] | {"linestyle": "-."}}
# Half widths of the two zooms, as multiples of the distance from the reference at t = 1/2 of the named curve.
ZOOMS: Final = {"initial_point_bvp": 1.4, "midpoint_bvp": 1.5}


def draw_errors(experiment: Experiment, rows: list[ErrorRow], *, ax: Axes) -> None:
    """Draw the paper's three mean errors against the step, log-log, with the fitted slopes in the labels."""
    h = [r.h for r in rows]
    for method, name in PAPER_LABELS.items():
        order = experiments.slope(rows, method)
        label = name if order is None else f"{name}, slope {order:.2f}"
        ax.loglog(h, [r.errors[method] for r in rows], label=label, markerfacecolor=BACKGROUND, **PAPER_STYLES[method])
    step_axis(h, ax=ax)
    ax.set_ylabel("mean Frobenius error (dimensionless)")
    ax.set_title(experiment.title)


def step_axis(h: list[float], *, ax: Axes) -> None:
    """Label the steps and the decades of the errors."""
    figure_style.log_axis(ax.yaxis)
    if h[0] >= 100 * h[-1]:
        figure_style.log_axis(ax.xaxis)
    else:
        shown = h if len(h) <= 8 else [h[0], h[-1]]
        ax.set_xticks(shown, [f"{x:.3g}" for x in shown])
        ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xlabel("step h = 1/N (dimensionless)")
    ax.grid(**figure_style.GRID)


def error_figure(experiment: Experiment, rows: list[ErrorRow]) -> Figure:
    """Figure 3a or 3b."""
    figure = figure_style.new_figure(figure_style.COLUMN, 3.6)
    grid = figure_style.grid(figure, 1, 1, (0.62, 0.08, 1.05, 0.25))
    ax = figure.add_subplot(grid[0, 0])
    draw_errors(experiment, rows, ax=ax)
    figure.legend(*ax.get_legend_handles_labels(), loc="lower center", frameon=False)
    return figure


def _curves(trajectories: Trajectories) -> dict[str, Array]:
    names = ("gcp", "initial_point_bvp", "midpoint_bvp")
    return {"reference": trajectories.reference} | {m: trajectories.curves[m] for m in names}


def _style(method: str) -> dict[str, Any]:
    return PAPER_STYLES[method] | {"marker": "", "linewidth": 2.4 if method == "reference" else 1.6}


def draw_zoom(trajectories: Trajectories, half_width: float, *, ax: Axes) -> None:
    """Draw the curves around the reference at t = 1/2 in its tangent plane; the points at t = 1/2 are marked."""
    centre = trajectories.reference[FINE_STEPS // 2, :, 0]
    direction = trajectories.tangent[FINE_STEPS // 2, :, 0]
    direction = direction / np.linalg.norm(direction)
    plane = np.stack([direction, np.cross(centre, direction)], axis=1)
    for method, curve in _curves(trajectories).items():
        places = 1e3 * (curve[:, :, 0] - centre) @ plane
        style = _style(method)
        ax.plot(*places.T, **style)
        marker = STYLES[method].get("marker", "o")
        ax.plot(*places[len(curve) // 2], marker=marker, color=style["color"], markerfacecolor=BACKGROUND, linestyle="")
    ax.set(xlim=np.array([-1e3, 1e3]) * half_width, ylim=np.array([-1e3, 1e3]) * half_width, aspect="equal")
    ax.grid(**figure_style.GRID)


def trajectory_figure() -> Figure:
    """Figure 1: the curves on the sphere, and two zooms at their middle, where they lie on each other."""
    trajectories = Trajectories(SPHERE)
    figure = figure_style.new_figure(figure_style.PAGE, 3.5)
    sphere = figure.add_axes((0.0, 0.12, 0.44, 0.80), projection="3d", computed_zorder=False)
    trajectories.draw_column(0, tuple(PAPER_LABELS), ax=sphere)
    curves = _curves(trajectories)
    middle = curves["reference"][FINE_STEPS // 2]
    for left, (method, factor) in zip((0.56, 0.81), ZOOMS.items(), strict=True):
        ax = figure.add_axes((left, 0.27, 0.175, 0.57))
        distance = float(np.linalg.norm(curves[method][len(curves[method]) // 2] - middle))
        draw_zoom(trajectories, factor * distance, ax=ax)
        ax.set_title("zoom at t = 1/2" if left < 0.6 else "closer")
        ax.set_xlabel("along")
        if left < 0.6:
            ax.set_ylabel("across (1/1000 radius)", labelpad=1)
    handles = []
    for method in curves:
        style = PAPER_STYLES[method] | {"markerfacecolor": BACKGROUND, "marker": STYLES[method].get("marker", "o")}
        label = LABELS[method] if method == "reference" else PAPER_LABELS[method]
        label += f", N = {TRAJECTORY_STEPS}" if method.endswith("bvp") else ""
        handles += ax.plot([], [], label=label, **style)
    figure.legend(handles=handles, loc="lower center", ncols=4, frameon=False)
    return figure


def write_all(folder: Path, rows: dict[str, list[ErrorRow]], progress: Callable[[], None]) -> list[Path]:
    """Write the paper's figures into `folder`, which must exist; `progress` is called after each."""
    makers: dict[str, Callable[[], Figure]] = {"figure_1": trajectory_figure}
    for panel, experiment in PANELS.items():
        makers[f"figure_3{panel}"] = lambda e=experiment: error_figure(e, rows[e.name])  # type: ignore[misc]
    paths = []
    for name, make in makers.items():
        with figure_style.context():
            paths += figure_style.save(make(), folder, name)
        progress()
    return paths
