"""The figure of `control_points`: mean error and cost against the degree. Imports matplotlib."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from matplotlib.axes import Axes

from .. import figure_style
from ..palette import BACKGROUND, BLUE, GREEN, PURPLE
from .control_points import DEGREES, Row
from .experiments import EXPERIMENTS, Experiment

# Costs are right to 1e-12, relative: a smaller excess is round-off, and is drawn here with a note.
SMALLEST_EXCESS: Final = 1e-12
STYLES: Final[dict[str, dict[str, Any]]] = {
    "minimal cost": {"color": BLUE, "linestyle": "-", "marker": "o"},
    "quintic, exact end accelerations": {"color": GREEN, "linestyle": "", "marker": "D"},
    "cubic with geodesics": {"color": PURPLE, "linestyle": "", "marker": "v"},
}


def _draw(experiment: Experiment, rows: list[Row], quantity: str, *, ax: Axes) -> None:
    by_method = {r.method: getattr(r, quantity) for r in rows if r.experiment.name == experiment.name}
    series = {
        "minimal cost": [(3, by_method["gcp"])] + [(m, by_method[f"minimal_cost_{m}"]) for m in DEGREES],
        "quintic, exact end accelerations": [(5, by_method["quintic"])],
        "cubic with geodesics": [(3, by_method["geodesic_cubic"])],
    }
    for label, pairs in series.items():
        places, values = zip(*pairs, strict=True)
        shown = [max(y, SMALLEST_EXCESS) for y in values]
        ax.semilogy(places, shown, label=label, markerfacecolor=BACKGROUND, **STYLES[label])
        for m, y in pairs:
            if y < SMALLEST_EXCESS:
                note = f"round-off, below {figure_style.power_of_ten(SMALLEST_EXCESS, 0)}"
                offset: dict[str, Any] = {"xytext": (-9, 0), "textcoords": "offset points"}
                offset |= {"ha": "right", "va": "center"}
                ax.annotate(note, (m, SMALLEST_EXCESS), fontsize=figure_style.FONT_SIZE - 2, **offset)
    ax.set_xticks([3, *DEGREES], ["3\n(GCP)", *map(str, DEGREES)])
    ax.set_xlim(2.7, DEGREES[-1] + 0.3)
    figure_style.log_axis(ax.yaxis)
    ax.grid(**figure_style.GRID)


def write(folder: Path, rows: list[Row], progress: Callable[[], None]) -> list[Path]:
    """Write ``control_points.png`` and ``.pdf`` into `folder`, one column of panels for each manifold; their paths."""
    with figure_style.context():
        figure = figure_style.new_figure(figure_style.PAGE, 5.6)
        grid = figure_style.grid(figure, 2, 2, (0.95, 0.15, 1.05, 0.35), hspace=0.12, wspace=0.25)
        for column, experiment in enumerate(EXPERIMENTS):
            upper, lower = (figure.add_subplot(grid[i, column]) for i in range(2))
            _draw(experiment, rows, "error", ax=upper)
            _draw(experiment, rows, "excess", ax=lower)
            upper.set_title(experiment.title)
            upper.tick_params(labelbottom=False)
            lower.set_xlabel("degree")
            if column == 0:
                upper.set_ylabel("mean Frobenius error\n(dimensionless)")
                lower.set_ylabel("relative excess of the cost\nover the exact cubic")
        figure.legend(*upper.get_legend_handles_labels(), loc="lower center", ncols=3, frameon=False)
        paths = figure_style.save(figure, folder, "control_points")
    progress()
    return paths
