"""The figure of the conjecture on retractions. Importing this module imports matplotlib."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from matplotlib.figure import Figure

from .. import figure_style
from .conjecture import COORDINATES, EXPONENTIAL, ORDERS, PROBLEMS, STEPS, Study, retractions
from .experiments import EXPERIMENTS

STYLES: Final[dict[str, dict[str, Any]]] = {
    COORDINATES: {"color": "#E69F00", "marker": "o"},
    "quasi-geodesic": {"color": "#D55E00", "marker": "s"},
    "Cayley": {"color": "#0072B2", "marker": "D"},
    EXPONENTIAL: {"color": "#000000", "marker": "^"},
}
DASHES: Final = {1: (0, (4, 2)), 2: "-"}


def figure(study: Study) -> Figure:
    """Mean error against ``N`` on the paper's curves: one column for each manifold, one row for each problem."""
    new = figure_style.new_figure(7.2, 6.0)
    grid = figure_style.grid(new, 2, 2, (0.8, 0.15, 1.25, 0.35), hspace=0.12, wspace=0.08)
    error = {
        (e.manifold, e.problem, e.order, e.steps, e.retraction): e.error for e in study.errors if e.curve == "paper"
    }
    first = None
    for row, problem in enumerate(PROBLEMS):
        for column, e in enumerate(EXPERIMENTS):
            ax = new.add_subplot(grid[row, column], sharey=first)
            first = first or ax
            for name in retractions(e):
                for order in ORDERS:
                    values = [error[e.name, problem, order, n, name] for n in STEPS]
                    label = f"{name}, order {order}"
                    style = STYLES[name] | {"linestyle": DASHES[order], "markerfacecolor": "white"}
                    ax.loglog(STEPS, values, label=label, **style)
            figure_style.log_axis(ax.yaxis)
            ax.set_xticks(STEPS, [str(n) for n in STEPS] if row else [])
            ax.xaxis.minorticks_off()
            ax.grid(**figure_style.GRID)
            ax.tick_params(labelleft=column == 0)
            if row == 0:
                ax.set_title(e.title)
            else:
                ax.set_xlabel("steps N")
            if column == 0:
                ax.set_ylabel(f"{problem}: mean Frobenius error")
    new.legend(*new.axes[1].get_legend_handles_labels(), loc="lower center", ncols=3, frameon=False, handlelength=3.2)
    return new


def write(folder: Path, study: Study) -> list[Path]:
    """Write ``conjecture.png`` and ``conjecture.pdf`` into `folder`, which must exist; the paths written."""
    with figure_style.context():
        return figure_style.save(figure(study), folder, "conjecture")
