"""The figures of the study: logarithmic axes, the colours of the package, a marker for each method."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.study.long_runs import Drift, Energy
from benchmarks.study.work import Cost, Solve
from stiefel_rs import figure_style
from stiefel_rs.palette import BACKGROUND, BLUE, GREEN, GREY, INK, ORANGE, PURPLE, SKY, VERMILION

DASHED: Final = (0, (4, 2))
DOTTED: Final = (0, (1, 1.3))
STYLES: Final[dict[str, dict[str, Any]]] = {
    "Taylor": {"color": INK, "marker": "*", "markersize": 8},
    "splitting, order 2": {"color": SKY, "marker": "o"},
    "splitting, order 4": {"color": BLUE, "marker": "s"},
    "splitting, order 6": {"color": GREEN, "marker": "D"},
    "splitting, order 8": {"color": PURPLE, "marker": "^"},
    "embedded, midpoint": {"color": GREY, "marker": "X"},
    "chart, initial point": {"color": ORANGE, "marker": "o", "linestyle": DASHED},
    "chart, midpoint": {"color": VERMILION, "marker": "s", "linestyle": DASHED},
    "chart, exponential midpoint": {"color": GREY, "marker": "v", "linestyle": DASHED},
    "chart, Cayley midpoint": {"color": GREEN, "marker": "P", "linestyle": DASHED},
    "chart, midpoint, order 4": {"color": BLUE, "marker": "D", "linestyle": DASHED},
    "chart, midpoint, order 6": {"color": PURPLE, "marker": "^", "linestyle": DASHED},
    "chart, midpoint, order 8": {"color": SKY, "marker": "h", "linestyle": DASHED},
    "SciPy DOP853": {"color": INK, "marker": "x", "linestyle": DOTTED},
    "heyoka": {"color": VERMILION, "marker": "P", "linestyle": DOTTED},
}
SIZE_STYLES: Final = (STYLES["Taylor"], *(STYLES[f"splitting, order {order}"] for order in (4, 6, 8)))
# Errors below this are round-off; zero has no logarithm.
FLOOR: Final = 1e-17


def _panel(ax: Axes, title: str, x: str, y: str, scale: Literal["log", "linear"] = "log") -> None:
    ax.set_xscale(scale)
    ax.set_yscale("log")
    figure_style.log_axis(ax.yaxis)
    if scale == "log":
        figure_style.log_axis(ax.xaxis)
    ax.grid(**figure_style.GRID)
    ax.set_title(title)
    ax.set_xlabel(x)
    ax.set_ylabel(y)


def _draw(ax: Axes, name: str, x: Sequence[float], y: Sequence[float], **style: Any) -> None:
    ax.plot(x, np.maximum(y, FLOOR), label=name, markerfacecolor=BACKGROUND, **style)


def _legend(figure: Figure, columns: int) -> None:
    entries: dict[str, Artist] = {}
    for ax in figure.axes:
        handles, labels = ax.get_legend_handles_labels()
        for handle, label in zip(handles, labels, strict=True):
            entries.setdefault(label, handle)
    handles = list(entries.values())
    figure.legend(handles, list(entries), loc="lower center", ncols=columns, frameon=False, handlelength=3.2)


def work(solves: list[Solve]) -> Figure:
    """Error at the end against the time of a solve, one panel per curve."""
    figure = figure_style.new_figure(figure_style.PAGE, 7.0)
    names = list(dict.fromkeys(solve.case for solve in solves))
    grid = figure_style.grid(figure, 2, 2, (0.65, 0.1, 1.5, 0.3), hspace=0.38, wspace=0.22)
    for i, name in enumerate(names):
        ax = figure.add_subplot(grid[i // 2, i % 2])
        _panel(ax, name, "seconds for one solve", "error at t = 1" if i % 2 == 0 else "")
        for method, style in STYLES.items():
            found = [solve for solve in solves if (solve.case, solve.method) == (name, method)]
            if found:
                _draw(ax, method, [s.best for s in found], [s.error for s in found], **style)
    _legend(figure, 3)
    return figure


def energy(energies: list[Energy]) -> Figure:
    """Relative energy error against time, semilogarithmic, one panel per curve."""
    figure = figure_style.new_figure(figure_style.PAGE, 4.2)
    grid = figure_style.grid(figure, 1, 3, (0.65, 0.1, 1.3, 0.3), wspace=0.32)
    for i, curve in enumerate(dict.fromkeys(e.curve for e in energies)):
        ax = figure.add_subplot(grid[0, i])
        _panel(ax, curve, "time t", "relative energy error" if i == 0 else "", "linear")
        for e in energies:
            if e.curve == curve and not e.refused:
                _draw(ax, e.method, list(e.t), list(e.error), markevery=7, **STYLES[e.method])
    _legend(figure, 3)
    return figure


def drift(drifts: list[Drift]) -> Figure:
    """Drift of the three invariants against the number of steps."""
    figure = figure_style.new_figure(figure_style.PAGE, 3.4)
    grid = figure_style.grid(figure, 1, 3, (0.65, 0.1, 0.85, 0.3), wspace=0.32)
    sizes = list(dict.fromkeys((d.n, d.k) for d in drifts))
    for i, name in enumerate(("momentum", "constraint", "orthonormality")):
        ax = figure.add_subplot(grid[0, i])
        _panel(ax, name, "steps", "drift" if i == 0 else "")
        for (n, k), style in zip(sizes, SIZE_STYLES, strict=False):
            found = [d for d in drifts if (d.n, d.k) == (n, k)]
            values = [getattr(d, name) for d in found]
            # Zero cannot be shown on the axis.
            _draw(ax, f"St({n},{k})", [d.steps for d in found], [value or math.nan for value in values], **style)
        ax.set_ylim(1e-17, 1e-12)
    _legend(figure, 4)
    return figure


def cost(costs: list[Cost]) -> Figure:
    """Time of one step, one position per size, in the order of the list."""
    figure = figure_style.new_figure(figure_style.PAGE, 4.0)
    ax = figure.add_subplot(figure_style.grid(figure, 1, 1, (0.65, 0.1, 1.35, 0.1))[0, 0])
    ax.set_yscale("log")
    figure_style.log_axis(ax.yaxis)
    ax.grid(**figure_style.GRID)
    ax.set_ylabel("seconds for one step")
    places = list(range(len(costs)))
    ax.set_xticks(places, [f"({c.n},{c.k})\nr = {c.rows}" for c in costs])
    ax.set_xlabel("size (n,k), and r = min(n, 4k) rows in the span of the data")
    for method in costs[0].step:
        _draw(ax, method, places, [c.step[method] for c in costs], **STYLES[method])
    _legend(figure, 3)
    return figure


def write(folder: Path, figures: dict[str, Figure]) -> list[Path]:
    """Write SVG files for light and dark pages to `folder`; return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"integrators_{name}.svg" for name in figures]
    for path, figure in zip(paths, figures.values(), strict=True):
        figure_style.write(figure, path)
    return paths
