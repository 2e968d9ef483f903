"""The figures of the paper's comparison.

Importing this module imports matplotlib, so nothing else of the package imports it. Figures are built on
`matplotlib.figure.Figure` directly: no pyplot, no global state. Colours are those of Okabe and Ito; each method has its
own line style and marker too, so that the figures can be read without colour.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.ticker import FuncFormatter, NullLocator
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]

from . import paper
from .paper import ALL_METHODS, EXPERIMENTS, MAPS, METHODS, SPHERE, STIEFEL_3_2, Array, ErrorRow, Experiment
from .report import LABELS, MAP_LABELS

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
FONT_SIZE: Final = 10
DPI: Final = 200
SPHERE_COLOURS: Final = ("#A8A8A8", "#E6E6E6")
GRID: Final[dict[str, Any]] = {"visible": True, "which": "major", "color": "#DDDDDD", "linewidth": 0.6}
FINE_STEPS: Final = 200


@contextmanager
def _style() -> Iterator[None]:
    """Use matplotlib's defaults with this module's sizes, whatever the user's own settings are."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(
            {
                "font.size": FONT_SIZE,
                "legend.fontsize": FONT_SIZE - 1,
                "axes.titlesize": FONT_SIZE,
                "lines.markersize": 5.5,
                "lines.linewidth": 1.6,
                "axes.spines.top": False,
                "axes.spines.right": False,
                "svg.hashsalt": "stiefel-rs",
            }
        )
        yield


def _new_figure(width: float, height: float) -> Figure:
    # Margins are given by hand in inches: an automatic layout draws every figure three times more.
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    return figure


def _grid(figure: Figure, rows: int, columns: int, margins: tuple[float, ...], **options: Any) -> GridSpec:
    """Return a grid of panels inside of `margins`: left, right, bottom, top, in inches."""
    width, height = figure.get_size_inches()
    left, right, bottom, top = margins
    edges = {"left": left / width, "right": 1 - right / width, "bottom": bottom / height, "top": 1 - top / height}
    return figure.add_gridspec(rows, columns, **edges, **options)


def _power_of_ten(value: float, _position: int) -> str:
    return "10" + str(round(np.log10(value))).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def _log_axis(axis: Axis) -> None:
    """Label the decades in plain text: quicker than mathematical text, and one font less in each PDF."""
    axis.set_major_formatter(FuncFormatter(_power_of_ten))
    axis.set_minor_locator(NullLocator())


def save(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write ``name.png`` and ``name.pdf``, without dates in them; the paths written."""
    png, pdf = folder / f"{name}.png", folder / f"{name}.pdf"
    figure.savefig(png, dpi=DPI)
    figure.savefig(pdf, metadata={"CreationDate": None})
    return [png, pdf]


def draw_error(experiment: Experiment, rows: list[ErrorRow], *, ax: Axes) -> None:
    """Draw mean error against the step, log-log, fitted slopes in the legend entries."""
    h = [r.h for r in rows]
    for method in ALL_METHODS:
        order = paper.slope(rows, method)
        label = LABELS[method] if order is None else f"{LABELS[method]}, slope {order:.2f}"
        ax.loglog(h, [r.errors[method] for r in rows], label=label, markerfacecolor="white", **STYLES[method])
    _log_axis(ax.yaxis)
    if h[0] >= 100 * h[-1]:
        _log_axis(ax.xaxis)
    else:
        shown = h if len(h) <= 8 else [h[0], h[-1]]
        ax.set_xticks(shown, [f"{x:.3g}" for x in shown])
        ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xlabel("step h = 1/N (dimensionless)")
    ax.set_ylabel("mean Frobenius error (dimensionless)")
    ax.set_title(experiment.title)
    ax.grid(**GRID)


def error_figure(experiment: Experiment, rows: list[ErrorRow]) -> Figure:
    """Log-log figure of the mean errors of one experiment."""
    figure = _new_figure(7.2, 5.2)
    grid = _grid(figure, 1, 1, (0.8, 2.3, 0.6, 0.35))
    ax = figure.add_subplot(grid[0, 0])
    draw_error(experiment, rows, ax=ax)
    ax.legend(loc="center left", bbox_to_anchor=(1.02, 0.5), frameon=False)
    return figure


def _circle(centre: Array, u: Array, v: Array) -> Array:
    angle = np.linspace(0.0, 2.0 * np.pi, 181)[:, None]
    return np.asarray(centre + np.cos(angle) * u + np.sin(angle) * v)


def _sphere_lines() -> Iterator[Array]:
    """Parallels and meridians every 30 degrees, each of shape ``(181, 3)``."""
    x, y, z = np.eye(3)
    for latitude in np.radians(np.arange(-60, 61, 30)):
        yield _circle(np.sin(latitude) * z, np.cos(latitude) * x, np.cos(latitude) * y)
    for longitude in np.radians(np.arange(0, 180, 30)):
        yield _circle(np.zeros(3), np.cos(longitude) * x + np.sin(longitude) * y, z)


def draw_sphere(view: Array, *, ax: Axes3D) -> None:
    """Draw the unit sphere seen from the unit direction `view`, shape ``(3,)``; the far half is lighter."""
    for line in _sphere_lines():
        front = (line @ view > 0)[:, None]
        for order, (mask, colour) in enumerate(zip((~front, front), SPHERE_COLOURS[::-1], strict=True)):
            ax.plot(*np.where(mask, line, np.nan).T, color=colour, linewidth=0.6, zorder=order)
    u = np.cross(view, [0.0, 0.0, 1.0])
    u /= np.linalg.norm(u)
    ax.plot(*_circle(np.zeros(3), u, np.cross(view, u)).T, color="#555555", linewidth=0.9, zorder=2)
    for name, axis in zip("₁₂₃", np.eye(3), strict=True):
        side = axis if axis @ view > -0.05 else -axis
        if abs(side @ view) < 0.8:  # An axis that points at the reader would lie on the curve.
            ax.plot(*np.stack([side, 1.1 * side]).T, color="#555555", linewidth=0.9, zorder=2)
            label = f"x{name}" if side is axis else f"−x{name}"  # noqa: RUF001
            ax.text(*(1.25 * side), label, ha="center", va="center", color="#333333")
    ax.set_proj_type("ortho")
    ax.view_init(elev=float(np.degrees(np.arcsin(view[2]))), azim=float(np.degrees(np.arctan2(view[1], view[0]))))
    ax.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-1, 1))
    ax.set_box_aspect((1, 1, 1), zoom=1.42)
    ax.set_axis_off()


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
        states, d = paper.reference(experiment, FINE_STEPS), experiment.chart.d
        self.columns = experiment.chart.k
        self.reference = paper.points(experiment, states)
        self.tangent = experiment.chart.embed_velocity(states[:, :d], states[:, d : 2 * d])
        self.curves = {
            m: paper.solve(experiment, m, FINE_STEPS if m == "gcp" else TRAJECTORY_STEPS, states[0], states[-1])
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
        ax.grid(**GRID)

    def draw_distance(self, *, ax: Axes) -> None:
        """Draw the distance of each curve to the reference against time; the common end points are left out."""
        for method in METHODS:
            curve = self.curves[method]
            steps = len(curve) - 1
            distance = paper.distances(curve, self.reference[:: FINE_STEPS // steps])
            shown = slice(1, None) if method.endswith("ivp") else slice(1, -1)
            self._plot(method, ax, paper.time_grid(steps)[shown], distance[shown])
        ax.set_yscale("log")
        _log_axis(ax.yaxis)
        ax.set(xlabel=TIME_LABEL, ylabel="Frobenius distance\nto the reference", xlim=(0, 1.01))
        ax.grid(**GRID)


def trajectory_figure(experiment: Experiment) -> Figure:
    """One row for each column of the curves (on the sphere, and the strip around it), then distance against time."""
    trajectories = Trajectories(experiment)
    rows = trajectories.columns + 1
    figure = _new_figure(7.2, 3.5 * rows)
    heights = [1.25] * (rows - 1) + [1.0]
    grid = _grid(figure, rows, 2, (0.85, 0.15, 1.05, 0.3), height_ratios=heights, width_ratios=[1.3, 1], hspace=0.3)
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


def _flow_figure(draw: Callable[[Axes, Experiment, paper.Drift, dict[str, Any]], None], top: float) -> Figure:
    """Two panels, one for each manifold; `draw` draws one discrete flow into one panel."""
    figure = _new_figure(7.2, 3.9)
    grid = _grid(figure, 1, 2, (0.9, 0.2, 1.05, top), wspace=0.12)
    left = figure.add_subplot(grid[0, 0])
    right = figure.add_subplot(grid[0, 1], sharey=left)
    right.tick_params(labelleft=False)
    for ax, experiment in zip((left, right), EXPERIMENTS, strict=True):
        for step_map in MAPS:
            for steps, dashes in zip(paper.FLOW_STEPS, ((0, (4, 2)), "-"), strict=True):
                style = STYLES[f"{step_map}_ivp"] | {"linestyle": dashes, "markerfacecolor": "white"}
                style |= {"label": f"{MAP_LABELS[step_map]}, N = {steps}", "markevery": max(1, steps // 10)}
                if steps == paper.FLOW_STEPS[-1]:
                    style["markerfacecolor"] = style["color"]
                draw(ax, experiment, paper.drift(experiment, step_map, steps), style)
        ax.set_yscale("log")
        _log_axis(ax.yaxis)
        ax.set(xlabel=TIME_LABEL, title=experiment.title, xlim=(0, 1.02))
        ax.grid(**GRID)
    figure.legend(*left.get_legend_handles_labels(), loc="lower center", ncols=2, frameon=False)
    return figure


def energy_figure() -> Figure:
    """Energy error along the discrete flows."""

    def draw(ax: Axes, _experiment: Experiment, drift: paper.Drift, style: dict[str, Any]) -> None:
        ax.plot(drift.t[1:], np.abs(drift.energy[1:]), **style)

    figure = _flow_figure(draw, 0.3)
    figure.axes[0].set_ylabel("energy error |H(zₙ) − H(z₀)|\n(dimensionless)")  # noqa: RUF001
    return figure


def momentum_figure() -> Figure:
    """Deviation of the momentum of rotations along the discrete flows."""
    largest: dict[str, dict[str, float]] = {e.title: {} for e in EXPERIMENTS}

    def draw(ax: Axes, experiment: Experiment, drift: paper.Drift, style: dict[str, Any]) -> None:
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
        with _style():
            paths += save(make(), folder, name)
        progress()
    return paths
