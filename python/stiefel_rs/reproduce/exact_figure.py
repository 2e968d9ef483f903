"""The exact cubic compared with the paper's three curves: paths, costs and distances.

Importing this module imports matplotlib.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from .. import figure_style
from ..palette import BACKGROUND, SKY
from . import control_points, experiments
from .exact import COARSE_STEPS, Comparison
from .experiments import Array, Experiment
from .styles import STYLES as METHOD_STYLES
from .styles import TIME_LABEL
from .text import percent
from .trajectories import FINE_STEPS, Trajectories

SHOWN: Final = ("gcp", "initial_point_bvp", "midpoint_bvp")
LABELS: Final = {
    "exact_bvp": "exact cubic",
    "gcp": "GCP",
    "geodesic_cubic": "GCP, geodesic pieces",
    "initial_point_bvp": f"initial-point BVP, N = {COARSE_STEPS}",
    "midpoint_bvp": f"mid-point BVP, N = {COARSE_STEPS}",
}
STYLES: Final[dict[str, dict[str, Any]]] = {
    "exact_bvp": METHOD_STYLES["reference"],
    "gcp": METHOD_STYLES["gcp"] | {"marker": ""},
    "geodesic_cubic": {"color": SKY, "linestyle": (0, (6, 1.5, 1, 1.5)), "marker": ""},
    "initial_point_bvp": METHOD_STYLES["initial_point_bvp"] | {"markerfacecolor": BACKGROUND},
    "midpoint_bvp": METHOD_STYLES["midpoint_bvp"] | {"markerfacecolor": BACKGROUND},
}
BARS: Final = ("initial_point_bvp", "midpoint_bvp", "gcp", "geodesic_cubic")


def _curves(experiment: Experiment) -> dict[str, tuple[Array, Array]]:
    """Points of each curve and of the exact cubic at the same times; for the exact cubic, points of the reference."""
    problem = control_points.boundary_problem(experiment)
    start, end = experiments.reference(experiment, 1)
    exact = experiments.exact_cubic(experiment, start, end)
    fine, coarse = (experiments.time_grid(n) for n in (FINE_STEPS, COARSE_STEPS))
    found = {"exact_bvp": (exact(fine), experiments.points(experiment, experiment.chart.reference(start, fine)))}
    for method in ("gcp", "geodesic_cubic"):
        found[method] = (control_points.build(problem, method)(fine), exact(fine))
    for method in ("initial_point_bvp", "midpoint_bvp"):
        found[method] = (experiments.solve(experiment, method, COARSE_STEPS, start, end), exact(coarse))
    return found


def _farthest(curves: dict[str, tuple[Array, Array]], column: int) -> float:
    """Largest distance on one sphere between the curves that are shown there and the exact cubic."""
    return max(float(np.linalg.norm((a - b)[:, :, column], axis=1).max()) for a, b in (curves[m] for m in SHOWN))


def draw_distance(curves: dict[str, tuple[Array, Array]], *, ax: Axes) -> None:
    """Draw the distances to the exact cubic against time, and of the exact cubic to the reference in the chart."""
    for method, (points, exact) in curves.items():
        distance = experiments.distances(points, exact)[1:-1]
        t = experiments.time_grid(len(points) - 1)[1:-1]
        # Zero has no place on the axis: equal to the last bit is drawn as half a unit of the last digit.
        ax.semilogy(t, np.maximum(distance, np.finfo(float).eps / 2), **STYLES[method])
    figure_style.log_axis(ax.yaxis)
    ax.set(xlabel=TIME_LABEL, xlim=(0, 1.01), ylabel="Frobenius distance\nto the exact cubic")
    ax.set_title("distance to the exact cubic; black: the exact cubic to the reference in the chart")
    ax.grid(**figure_style.GRID)


def draw_costs(comparison: Comparison, *, ax: Axes) -> None:
    """Draw the excess of the cost of each curve as a bar from the left, with its numbers at the end."""
    for place, method in enumerate(reversed(BARS)):
        row = comparison.of(method, COARSE_STEPS if method.endswith("bvp") else None)
        excess = 100 * abs(row.excess)
        ax.barh(place, excess, height=0.55, color=STYLES[method]["color"])
        sign = "" if row.excess >= 0 else "−"  # noqa: RUF001
        text = f" J = {row.cost:.6f}, {sign}{percent(abs(row.excess))}"
        ax.text(excess, place, text, va="center", fontsize=figure_style.FONT_SIZE - 1)
    ax.set_xscale("log")
    ax.set_xlim(1e-6, 1e5)
    figure_style.log_axis(ax.xaxis)
    ax.set_xticks([1e-6, 1e-4, 1e-2, 1, 100])
    ax.set_yticks(range(len(BARS)), [LABELS[m].replace(", ", "\n") for m in reversed(BARS)])
    ax.set_xlabel(f"excess of J over the exact cubic's (%); for N = {COARSE_STEPS}, J is a sum over the points")
    ax.set_title(f"cost J given away; exact cubic: J = {comparison.of('exact').cost:.6f}")


def figure(comparison: Comparison) -> Figure:
    """Columns of the curves on spheres, then costs, then distance against time."""
    experiment = comparison.experiment
    curves = _curves(experiment)
    trajectories = Trajectories(experiment)
    columns = trajectories.columns
    new = figure_style.new_figure(figure_style.PAGE, 8.8)
    grid = figure_style.grid(new, 3, columns, (1.5, 0.2, 1.2, 0.3), height_ratios=[1.2, 0.75, 1.0], hspace=0.48)
    for column in range(columns):
        sphere = new.add_subplot(grid[0, column], projection="3d", computed_zorder=False)
        cell = sphere.get_position()  # A sphere has no tick labels: it can use the margin as well.
        sphere.set_position((column / columns, cell.y0 - 0.03, 1 / columns, cell.height + 0.03))
        trajectories.draw_column(column, SHOWN, ax=sphere)
        # Left of the centre: the label of the axis that points up is there.
        title = experiment.title if columns == 1 else f"{experiment.title}, column {column + 1}"
        new.text((column + 0.06) / columns, 0.975, title, va="top")
        # Less than the marks are wide: the spheres cannot show it.
        note = f"all curves within {_farthest(curves, column):.1g} radii of the exact cubic"
        new.text((column + 0.5) / columns, cell.y0 - 0.038, note, ha="center", fontsize=figure_style.FONT_SIZE - 1)
    draw_costs(comparison, ax=new.add_subplot(grid[1, :]))
    labels = dict(LABELS)
    if comparison.same_pieces:
        # One curve, drawn once.
        del curves["geodesic_cubic"], labels["geodesic_cubic"]
        labels["gcp"] += ", geodesic pieces as well"
    draw_distance(curves, ax=new.add_subplot(grid[2, :]))
    handles = [Line2D([], [], label=label, **STYLES[m]) for m, label in labels.items()]
    new.legend(handles=handles, loc="lower center", ncols=3, frameon=False, handlelength=3.2)
    return new


def write(folder: Path, found: list[Comparison], progress: Callable[[], None]) -> list[Path]:
    """Write ``exact_<manifold>.png`` and ``.pdf`` into `folder`, which must exist; return the paths."""
    paths = []
    for comparison in found:
        with figure_style.context():
            paths += figure_style.save(figure(comparison), folder, f"exact_{comparison.experiment.name}")
        progress()
    return paths
