"""The curves of one experiment, drawn on spheres, in the strip along the reference, and by their distance to it.

Importing this module imports matplotlib.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]

from .. import figure_style
from ..figure_sphere import draw_sphere
from ..palette import BACKGROUND, INK
from . import experiments
from .experiments import METHODS, Array, Experiment
from .styles import STYLES, TIME_LABEL
from .text import LABELS

TRAJECTORY_STEPS: Final = 10
FINE_STEPS: Final = 200


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
        style = STYLES[method] | ({"marker": ""} if method == "gcp" else {"markerfacecolor": BACKGROUND})
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
            ax.plot(*(point + np.outer([0.25, 0.7], side)).T, color=INK, linewidth=0.7, zorder=5)
            ax.text(*(point + 1.2 * side), text, ha="center", va="bottom", zorder=6)

    def draw_strip(self, column: int, *, ax: Axes) -> None:
        """Draw one column of the curves in the strip along the reference, stretched across it."""
        reference, velocity = self.reference[:, :, column], self.tangent[:, :, column]
        direction = velocity / np.linalg.norm(velocity, axis=1, keepdims=True)
        normal = np.cross(reference, direction)
        steps = np.linalg.norm(np.diff(reference, axis=0), axis=1)
        length = np.concatenate([[0.0], np.cumsum(steps)])
        ax.plot(length, np.zeros_like(length), label=LABELS["reference"], **STYLES["reference"])
        offsets = {}
        for method in METHODS:
            points = self.curves[method][:, :, column]
            nearest = np.linalg.norm(points[:, None] - reference, axis=2).argmin(axis=1)
            offset = points - reference[nearest]
            along = length[nearest] + np.sum(offset * direction[nearest], axis=1)
            offsets[method] = (along, 1e3 * np.sum(offset * normal[nearest], axis=1))
            self._plot(method, ax, *offsets[method])
        self._draw_zoom(offsets, float(length[-1]), ax=ax)
        ax.set(xlabel="length along the reference (radii)", ylabel="offset across it (1/1000 radius)")
        ax.grid(**figure_style.GRID)

    def _draw_zoom(self, offsets: dict[str, tuple[Array, Array]], length: float, *, ax: Axes) -> None:
        """Draw the mid-point curves, which lie on the reference, once more where the panel is empty."""
        low = offsets["initial_point_ivp"][1][-1] < 0
        inset = ax.inset_axes((0.2, 0.06 if low else 0.62, 0.38, 0.26))
        inset.plot([0.0, length], [0.0, 0.0], **STYLES["reference"])
        for method in ("midpoint_ivp", "midpoint_bvp"):
            self._plot(method, inset, *offsets[method], linewidth=1.2, markersize=3.5)
        inset.set(xticks=[], title="zoom: mid-point")
        inset.title.set_fontsize(figure_style.FONT_SIZE - 2)
        inset.tick_params(labelsize=figure_style.FONT_SIZE - 2)

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
    figure = figure_style.new_figure(figure_style.PAGE, 3.5 * rows)
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
            sphere.set_title(f"column {column + 1}", loc="left")
    trajectories.draw_distance(ax=figure.add_subplot(grid[-1, :]))
    figure.legend(*strip.get_legend_handles_labels(), loc="lower center", ncols=3, frameon=False)
    return figure
