"""Figures of the conjecture: errors as multiples of the mid-point method's. Importing this module imports matplotlib.

Ratios, since the errors themselves lie on each other for orders of magnitude.
"""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from .. import figure_style
from ..palette import BACKGROUND, BLUE, GREY, INK, VERMILION
from .conjecture import Outcome, outcomes
from .experiments import EXPERIMENTS, Experiment
from .retractions import COORDINATES, EXPONENTIAL, ORDERS, PAPER, PROBLEMS, RANDOM_STEPS, STEPS, Study, retractions

STYLES: Final[dict[str, dict[str, Any]]] = {
    "quasi-geodesic": {"color": VERMILION, "linestyle": (0, (1, 1.2)), "marker": "s"},
    "Cayley": {"color": BLUE, "linestyle": (0, (5, 2)), "marker": "D"},
    EXPONENTIAL: {"color": INK, "linestyle": "-", "marker": "^"},
}
LINE: Final[dict[str, Any]] = {"color": GREY, "linewidth": 1.0, "zorder": 1}
PERCENTILES: Final = (10, 90)


def _ratio_axis(ax: Axes, which: str) -> None:
    axis = getattr(ax, f"{which}axis")
    getattr(ax, f"set_{which}scale")("log")
    axis.set_major_locator(LogLocator(10, subs=(1.0, 2.0, 5.0), numticks=12))
    axis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axis.set_minor_locator(NullLocator())
    ax.grid(**figure_style.GRID)


def draw_paper(found: list[Outcome], *, ax: Axes) -> None:
    """Draw the ratios on the paper's curve against ``N``; a line at 1 is the mid-point method."""
    ax.axhline(1.0, **LINE)
    for outcome in found:
        ax.plot(
            STEPS, outcome.ratios, markerfacecolor=BACKGROUND, label=outcome.retraction, **STYLES[outcome.retraction]
        )
    _ratio_axis(ax, "y")
    ax.set_xscale("log")
    ax.set_xticks(STEPS, [str(n) for n in STEPS])
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_ylim(0.02, 1.5)
    ax.set_xlabel("steps N")


def draw_random(found: list[Outcome], *, ax: Axes) -> None:
    """Draw how many of the random curves have at most a given ratio; left of the line at 1 the conjecture holds."""
    ax.axvline(1.0, **LINE)
    for outcome in found:
        ratios = np.sort(outcome.ratios)
        share = np.arange(1, len(ratios) + 1) / len(ratios)
        every = max(1, len(ratios) // 8)
        style = STYLES[outcome.retraction] | {"markevery": (every // 2, every), "markerfacecolor": BACKGROUND}
        ax.step(ratios, 100 * share, where="post", **style)
    ax.set_xlim(0.01, 4.0)
    _ratio_axis(ax, "x")
    ax.tick_params(axis="x", labelrotation=45)
    ax.set_xlabel("error, mid-point method = 1")


def figure(study: Study) -> Figure:
    """Draw the conjecture as stated: the paper's curves above, the random ones below."""
    found = outcomes(study)
    new = figure_style.new_figure(figure_style.PAGE, 6.4)
    grid = figure_style.grid(new, 2, 2, (0.8, 0.15, 1.15, 0.35), hspace=0.42, wspace=0.12)
    for column, e in enumerate(EXPERIMENTS):
        upper, lower = (new.add_subplot(grid[row, column]) for row in range(2))
        for ax, curves, draw in ((upper, PAPER, draw_paper), (lower, "random", draw_random)):
            draw([x for x in found if (x.manifold, x.curves) == (e.name, curves)], ax=ax)
            ax.tick_params(labelleft=column == 0)
        count = max(x.cases for x in found if (x.manifold, x.curves) == (e.name, "random"))
        upper.set_title(f"{e.title}, the paper's curve")
        lower.set_title(f"{e.title}, {count} random curves, N = {RANDOM_STEPS}")
        if column == 0:
            upper.set_ylabel("error, mid-point method = 1")
            lower.set_ylabel("share of the curves (%)")
    new.legend(*upper.get_legend_handles_labels(), loc="lower center", ncols=3, frameon=False, handlelength=3.2)
    return new


def _ratios(study: Study, experiment: Experiment, problem: str, order: int, name: str, *, paper: bool) -> np.ndarray:
    own = [x for x in study.errors if (x.manifold, x.problem, x.order) == (experiment.name, problem, order)]
    error = {(x.curve, x.steps, x.retraction): x.error for x in own if (x.curve == PAPER) is paper}
    keys = dict.fromkeys(key[:2] for key in error)
    return np.array([error[(*key, name)] / error[(*key, COORDINATES)] for key in keys])


def draw_rows(study: Study, experiment: Experiment, problem: str, order: int, *, ax: Axes) -> None:
    """Draw one row for each retraction: the paper's curve as a mark, the random ones as a median and a bar."""
    names = [name for name in retractions(experiment) if name != COORDINATES]
    ax.axvline(1.0, **LINE)
    for name in names:
        place = len(STYLES) - 1 - list(STYLES).index(name)
        random = _ratios(study, experiment, problem, order, name, paper=False)
        paper = _ratios(study, experiment, problem, order, name, paper=True)
        ax.plot(np.percentile(random, PERCENTILES), [place - 0.15] * 2, color=GREY, linewidth=2.2)
        ax.plot(np.median(random), place - 0.15, marker="o", color=INK, markerfacecolor=BACKGROUND, linestyle="")
        ax.plot(np.exp(np.log(paper).mean()), place + 0.18, marker="D", color=BLUE, linestyle="")
    ax.set_ylim(-0.6, len(STYLES) - 0.4)
    ax.set_xlim((0.25, 3.0) if order == 1 else (0.02, 4.0))
    _ratio_axis(ax, "x")
    if order == 2:
        ticks = (0.1, 0.3, 1, 3)
        ax.set_xticks(ticks, [f"{x:g}" for x in ticks])


def wide_figure(study: Study) -> Figure:
    """Every problem and order: rows of panels for orders, columns for problems and manifolds."""
    new = figure_style.new_figure(figure_style.PAGE, 4.6)
    grid = figure_style.grid(new, 2, 4, (1.2, 0.15, 1.1, 0.55), hspace=0.55, wspace=0.12)
    for row, order in enumerate(ORDERS):
        for column, (e, problem) in enumerate(itertools.product(EXPERIMENTS, PROBLEMS)):
            ax = new.add_subplot(grid[row, column])
            draw_rows(study, e, problem, order, ax=ax)
            ax.set_yticks(range(len(STYLES)), list(reversed(STYLES)) if column == 0 else [])
            ax.set_title(f"{e.title}, {problem}\norder {order}", fontsize=figure_style.FONT_SIZE - 1)
    new.text(0.57, 0.115, "mean error, linear in coordinates (same order) = 1", ha="center")
    marks = [
        *ax.plot([], [], marker="D", color=BLUE, linestyle="", label="the paper's curve, mean over N"),
        *ax.plot([], [], marker="o", color=INK, markerfacecolor=BACKGROUND, linestyle="", label="random: median"),
        *ax.plot([], [], color=GREY, linewidth=2.2, label=f"{PERCENTILES[0]} to {PERCENTILES[1]} % of them"),
    ]
    new.legend(handles=marks, loc="lower center", ncols=3, frameon=False)
    return new


def write(folder: Path, study: Study) -> list[Path]:
    """Write ``conjecture`` and ``retraction_pairs`` as PNG and PDF into `folder`, which must exist; return paths."""
    with figure_style.context():
        paths = figure_style.save(figure(study), folder, "conjecture")
        return paths + figure_style.save(wide_figure(study), folder, "retraction_pairs")
