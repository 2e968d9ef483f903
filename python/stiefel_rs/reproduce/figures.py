"""The figures of the paper's comparison.

Importing this module imports matplotlib. Colours are those of Okabe and Ito; each method has its own line style and
marker too, so that the figures can be read without colour.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]

from .. import figure_style
from ..figure_sphere import draw_sphere
from . import experiments
from .experiments import ALL_METHODS, EXPERIMENTS, MAPS, METHODS, SPHERE, STIEFEL_3_2, Array, ErrorRow, Experiment
from .tables import LABELS, MAP_LABELS

TRAJECTORY_STEPS: Final = 10
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
FINE_STEPS: Final = 200


def draw_error(experiment: Experiment, rows: list[ErrorRow], *, ax: Axes) -> None:
    """Draw mean error against the step, log-log, fitted slopes in the legend entries."""
    h = [r.h for r in rows]
    for method in ALL_METHODS:
        order = experiments.slope(rows, method)
        label = LABELS[method] if order is None else f"{LABELS[method]}, slope {order:.2f}"
        ax.loglog(h, [r.errors[method] for r in rows], label=label, markerfacecolor="white", **STYLES[method])
    figure_style.log_axis(ax.yaxis)
    if h[0] >= 100 * h[-1]:
        figure_style.log_axis(ax.xaxis)
    else:
        shown = h if len(h) <= 8 else [h[0], h[-1]]
        ax.set_xticks(shown, [f"{x:.3g}" for x in shown])
        ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xlabel("step h = 1/N (dimensionless)")
    ax.set_ylabel("mean Frobenius error (dimensionless)")
    ax.set_title(experiment.title)
    ax.grid(**figure_style.GRID)


def error_figure(experiment: Experiment, rows: list[ErrorRow]) -> Figure:
    """Log-log figure of the mean errors of one experiment."""
    figure = figure_style.new_figure(7.2, 5.2)
    grid = figure_style.grid(figure, 1, 1, (0.8, 2.3, 0.6, 0.35))
    ax = figure.add_subplot(grid[0, 0])
    draw_error(experiment, rows, ax=ax)
    ax.legend(loc="center left", bbox_to_anchor=(1.02, 0.5), frameon=False)
    return figure


class Trajectories:
    """The curves of one experiment: reference and GCP on a fine grid, the discrete flows on a coarse one.

    Attributes
    ----------
    reference, tangent : ndarray, shape (FINE_STEPS + 1, 3, k)
        Reference curve and its velocity.
    curves : dict of str to ndarray
        Points by method, of shape ``(FINE_STEPS + 1, 3, k)`` for GCP, else ``(TRAJECTORY_STEPS + 1, 3, k)``.
    """

    def __init__(self, experiment: Experiment) -> None:
        states, d = experiments.reference(experiment, FINE_STEPS), experiment.chart.d
        self.columns = experiment.chart.k
        self.reference = experiments.points(experiment, states)
        self.tangent = experiment.chart.embed_velocity(states[:, :d], states[:, d : 2 * d])
        self.curves = {
            m: experiments.solve(experiment, m, FINE_STEPS if m == "gcp" else TRAJECTORY_STEPS, states[0], states[-1])
            for m in METHODS
        }

    def _plot(self, method: str, ax: Axes, *values: Array, **options: Any) -> None:
        label = LABELS[method] if method == "gcp" else f"{LABELS[method]}, N = {TRAJECTORY_STEPS}"
        style = STYLES[method] | ({"marker": ""} if method == "gcp" else {"markerfacecolor": "white"})
        ax.plot(*values, label=label, **(style | options))

    def draw_column(
        self, column: int, methods: Iterable[str] = ("gcp", "initial_point_ivp", "midpoint_bvp"), *, ax: Axes3D
    ) -> None:
        """Draw one column of the curves on a sphere, with the start and the end of the reference marked."""
        reference = self.reference[:, :, column]
        middle = reference.mean(axis=0)
        view = middle / np.linalg.norm(middle) + np.array([0.0, 0.0, 0.25])
        view /= np.linalg.norm(view)
        draw_sphere(view, ax=ax)
        ax.plot(*reference.T, zorder=3, **STYLES["reference"])
        for method in methods:
            curve = self.curves[method][:, :, column]
            self._plot(method, ax, *curve.T, zorder=4, linewidth=1.2, markersize=3.5)
        side = np.cross(view, reference[-1] - reference[0])
        side *= 0.2 / np.linalg.norm(side)
        for point, text in ((reference[0], "start"), (reference[-1], "end")):
            ax.plot(*(point + np.outer([0.25, 0.7], side)).T, color="black", linewidth=0.7, zorder=5)
            ax.text(*(point + 1.2 * side), text, ha="center", va="bottom", zorder=6)

    def draw_strip(self, column: int, *, ax: Axes) -> None:
        """Draw one column of the curves in the strip along the reference, stretched across it."""
        reference, velocity = self.reference[:, :, column], self.tangent[:, :, column]
        direction = velocity / np.linalg.norm(velocity, axis=1, keepdims=True)
        normal = np.cross(reference, direction)
        steps = np.linalg.norm(np.diff(reference, axis=0), axis=1)
        length = np.concatenate([[0.0], np.cumsum(steps)])
        ax.plot(length, np.zeros_like(length), label=LABELS["reference"], **STYLES["reference"])
        for method in METHODS:
            points = self.curves[method][:, :, column]
            nearest = np.linalg.norm(points[:, None] - reference, axis=2).argmin(axis=1)
            offset = points - reference[nearest]
            along = length[nearest] + np.sum(offset * direction[nearest], axis=1)
            across = 1e3 * np.sum(offset * normal[nearest], axis=1)
            self._plot(method, ax, along, across)
        ax.set(xlabel="length along the reference (radii)", ylabel="offset across it (1/1000 radius)")
        ax.grid(**figure_style.GRID)

    def draw_distance(self, *, ax: Axes) -> None:
        """Draw the distance of each curve to the reference against time; the common end points are left out."""
        for method in METHODS:
            curve = self.curves[method]
            steps = len(curve) - 1
            distance = experiments.distances(curve, self.reference[:: FINE_STEPS // steps])
            shown = slice(1, None) if method.endswith("ivp") else slice(1, -1)
            self._plot(method, ax, experiments.time_grid(steps)[shown], distance[shown])
        ax.set_yscale("log")
        figure_style.log_axis(ax.yaxis)
        ax.set(xlabel=TIME_LABEL, ylabel="Frobenius distance\nto the reference", xlim=(0, 1.01))
        ax.grid(**figure_style.GRID)


def trajectory_figure(experiment: Experiment) -> Figure:
    """One row for each column of the curves (on the sphere, and the strip around it), then distance against time."""
    trajectories = Trajectories(experiment)
    rows = trajectories.columns + 1
    figure = figure_style.new_figure(7.2, 3.5 * rows)
    heights = [1.25] * (rows - 1) + [1.0]
    grid = figure_style.grid(
        figure, rows, 2, (0.85, 0.15, 1.05, 0.3), height_ratios=heights, width_ratios=[1.3, 1], hspace=0.3
    )
    for column in range(rows - 1):
        sphere = figure.add_subplot(grid[column, 0], projection="3d", computed_zorder=False)
        cell = sphere.get_position()  # A sphere has no tick labels: it can use the margin as well.
        sphere.set_position((0.0, cell.y0, cell.x1, cell.height))
        trajectories.draw_column(column, ax=sphere)
        strip = figure.add_subplot(grid[column, 1])
        trajectories.draw_strip(column, ax=strip)
        if rows > 2:
            strip.set_title(f"column {column + 1}, offset from the reference")
            sphere.set_title(f"column {column + 1}")
    trajectories.draw_distance(ax=figure.add_subplot(grid[-1, :]))
    figure.legend(*strip.get_legend_handles_labels(), loc="lower center", ncols=3, frameon=False)
    return figure


def _flow_figure(draw: Callable[[Axes, Experiment, experiments.Drift, dict[str, Any]], None], top: float) -> Figure:
    """Two panels, one for each manifold; `draw` draws one discrete flow into one panel."""
    figure = figure_style.new_figure(7.2, 3.9)
    grid = figure_style.grid(figure, 1, 2, (0.9, 0.2, 1.05, top), wspace=0.12)
    left = figure.add_subplot(grid[0, 0])
    right = figure.add_subplot(grid[0, 1], sharey=left)
    right.tick_params(labelleft=False)
    for ax, experiment in zip((left, right), EXPERIMENTS, strict=True):
        for step_map in MAPS:
            for steps, dashes in zip(experiments.FLOW_STEPS, ((0, (4, 2)), "-"), strict=True):
                style = STYLES[f"{step_map}_ivp"] | {"linestyle": dashes, "markerfacecolor": "white"}
                style |= {"label": f"{MAP_LABELS[step_map]}, N = {steps}", "markevery": max(1, steps // 10)}
                if steps == experiments.FLOW_STEPS[-1]:
                    style["markerfacecolor"] = style["color"]
                draw(ax, experiment, experiments.drift(experiment, step_map, steps), style)
        ax.set_yscale("log")
        figure_style.log_axis(ax.yaxis)
        ax.set(xlabel=TIME_LABEL, title=experiment.title, xlim=(0, 1.02))
        ax.grid(**figure_style.GRID)
    figure.legend(*left.get_legend_handles_labels(), loc="lower center", ncols=2, frameon=False)
    return figure


def energy_figure() -> Figure:
    """Energy error along the discrete flows."""

    def draw(ax: Axes, _experiment: Experiment, drift: experiments.Drift, style: dict[str, Any]) -> None:
        ax.plot(drift.t[1:], np.abs(drift.energy[1:]), **style)

    figure = _flow_figure(draw, 0.3)
    figure.axes[0].set_ylabel("energy error |H(zₙ) − H(z₀)|\n(dimensionless)")  # noqa: RUF001
    return figure


def momentum_figure() -> Figure:
    """Deviation of the momentum of rotations along the discrete flows."""
    largest: dict[str, dict[str, float]] = {e.title: {} for e in EXPERIMENTS}

    def draw(ax: Axes, experiment: Experiment, drift: experiments.Drift, style: dict[str, Any]) -> None:
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
