"""Figures of the two experiments that are not in the paper: all methods, and invariants of the discrete flows.

Importing this module imports matplotlib.
"""

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
from . import experiments, flows
from .experiments import ALL_METHODS, EXPERIMENTS, MAPS, SPHERE, STIEFEL_3_2, ErrorRow, Experiment
from .paper_figures import step_axis
from .styles import STYLES, TIME_LABEL
from .text import LABELS, MAP_LABELS
from .trajectories import trajectory_figure

# Curves of one order lie near each other: these are shown once more, larger.
ZOOMED: Final = ("midpoint_ivp", "midpoint_bvp", "splitting_2")


def draw_error(rows: list[ErrorRow], methods: tuple[str, ...] = ALL_METHODS, *, ax: Axes) -> None:
    """Draw mean error against the step, log-log, fitted slopes in the legend entries."""
    h = [r.h for r in rows]
    for method in methods:
        order = experiments.slope(rows, method)
        label = LABELS[method] if order is None else f"{LABELS[method]}, slope {order:.2f}"
        ax.loglog(h, [r.errors[method] for r in rows], label=label, markerfacecolor=BACKGROUND, **STYLES[method])
    ax.grid(**figure_style.GRID)


def draw_zoom(rows: list[ErrorRow], *, ax: Axes) -> None:
    """Draw the curves of order 2 between two neighbouring steps in the middle."""
    middle = len(rows) // 2
    shown = rows[middle - 1 : middle + 1]
    draw_error(shown, ZOOMED, ax=ax)
    ax.set_title("zoom: order 2", fontsize=figure_style.FONT_SIZE - 1)
    ax.set_xlim(shown[1].h * 0.9, shown[0].h * 1.1)
    ax.set_xticks([r.h for r in shown], [f"{r.h:.3g}" for r in shown])
    ax.xaxis.set_minor_locator(NullLocator())
    figure_style.log_axis(ax.yaxis)


def error_figure(experiment: Experiment, rows: list[ErrorRow]) -> Figure:
    """Log-log figure of the mean errors of every method on one experiment."""
    figure = figure_style.new_figure(figure_style.PAGE, 5.2)
    grid = figure_style.grid(figure, 1, 1, (0.8, 2.35, 0.6, 0.35))
    ax = figure.add_subplot(grid[0, 0])
    draw_error(rows, ax=ax)
    step_axis([r.h for r in rows], ax=ax)
    ax.set_ylabel("mean Frobenius error (dimensionless)")
    ax.set_title(experiment.title)
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False)
    if len(rows) > 1:
        draw_zoom(rows, ax=figure.add_axes((0.76, 0.115, 0.2, 0.27)))
    return figure


def _flow_figure(draw: Callable[[Axes, Experiment, flows.Drift, dict[str, Any]], None], top: float) -> Figure:
    """Two panels, one for each manifold; `draw` draws one discrete flow into one panel."""
    figure = figure_style.new_figure(figure_style.PAGE, 3.9)
    grid = figure_style.grid(figure, 1, 2, (0.9, 0.2, 1.05, top), wspace=0.12)
    left = figure.add_subplot(grid[0, 0])
    right = figure.add_subplot(grid[0, 1], sharey=left)
    right.tick_params(labelleft=False)
    for ax, experiment in zip((left, right), EXPERIMENTS, strict=True):
        for step_map in MAPS:
            for steps, dashes in zip(flows.FLOW_STEPS, ((0, (4, 2)), "-"), strict=True):
                style = STYLES[f"{step_map}_ivp"] | {"linestyle": dashes, "markerfacecolor": BACKGROUND}
                style |= {"label": f"{MAP_LABELS[step_map]}, N = {steps}", "markevery": max(1, steps // 10)}
                if steps == flows.FLOW_STEPS[-1]:
                    style["markerfacecolor"] = style["color"]
                draw(ax, experiment, flows.drift(experiment, step_map, steps), style)
        ax.set_yscale("log")
        figure_style.log_axis(ax.yaxis)
        ax.set(xlabel=TIME_LABEL, title=experiment.title, xlim=(0, 1.02))
        ax.grid(**figure_style.GRID)
    figure.legend(*left.get_legend_handles_labels(), loc="lower center", ncols=2, frameon=False)
    return figure


def energy_figure() -> Figure:
    """Energy error along the discrete flows."""

    def draw(ax: Axes, _experiment: Experiment, drift: flows.Drift, style: dict[str, Any]) -> None:
        ax.plot(drift.t[1:], np.abs(drift.energy[1:]), **style)

    figure = _flow_figure(draw, 0.3)
    figure.axes[0].set_ylabel("energy error |H(zₙ) − H(z₀)|\n(dimensionless)")  # noqa: RUF001
    return figure


def momentum_figure() -> Figure:
    """Deviation of the momentum of rotations along the discrete flows."""
    largest: dict[str, dict[str, float]] = {e.title: {} for e in EXPERIMENTS}

    def draw(ax: Axes, experiment: Experiment, drift: flows.Drift, style: dict[str, Any]) -> None:
        ax.plot(drift.t[1:], drift.other[1:], **style)
        for name, values in drift.cyclic.items():
            found = largest[experiment.title]
            found[name] = max(found.get(name, 0.0), float(values.max()))

    figure = _flow_figure(draw, 0.5)
    for ax, (title, found) in zip(figure.axes, largest.items(), strict=True):
        cyclic = ", ".join(f"p_{'φ' if name == 'phi' else 'ψ'}: {value:.1g}" for name, value in found.items())
        ax.set_title(f"{title}\nlargest change of {cyclic}")
    figure.axes[0].set_ylabel("change of the momentum\nabout x₁ and x₂ (dimensionless)")
    return figure


def write_all(folder: Path, rows: dict[str, list[ErrorRow]], progress: Callable[[], None]) -> list[Path]:
    """Write every figure into `folder`, which must exist; `progress` is called after each."""
    makers: dict[str, Callable[[], Figure]] = {
        "trajectory_sphere": lambda: trajectory_figure(SPHERE),
        "trajectory_stiefel_3_2": lambda: trajectory_figure(STIEFEL_3_2),
        "error_sphere": lambda: error_figure(SPHERE, rows[SPHERE.name]),
        "error_stiefel_3_2": lambda: error_figure(STIEFEL_3_2, rows[STIEFEL_3_2.name]),
        "energy": energy_figure,
        "momentum": momentum_figure,
    }
    paths = []
    for name, make in makers.items():
        with figure_style.context():
            paths += figure_style.save(make(), folder, name)
        progress()
    return paths
