"""Axes: made here without pyplot, or checked."""

from __future__ import annotations

from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cbook import normalize_kwargs
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]

from ..errors import InvalidInputError
from ..figure_style import COLUMN, DPI, FONT_SIZE, GRID, SMALL_FONT
from ..palette import BODY_AXES, CURVES, INK

DASHES: Final[tuple[Any, ...]] = ("-", (0, (5, 1.5)), (0, (1, 1)), "-.", (0, (3, 1, 1, 1, 1, 1)), (0, (8, 2)))
# Axes of bodies differ by these too.
MARKS: Final = "os^"
# What stands beside the lines of curves has a name, so that those can be counted.
GRID_ID: Final = "stiefel_rs sphere grid"
KNOT_ID: Final = "stiefel_rs knots"
TIME_LABEL: Final = "time t"
STEP_LABEL: Final = "step"


def new_figure(width: float, height: float) -> Figure:
    """Make a figure of that many inches that pyplot does not know of."""
    made = Figure(figsize=(width, height), dpi=DPI, layout="constrained")
    FigureCanvasAgg(made)
    return made


def dressed(ax: Axes) -> Axes:
    """Give new axes the fonts and colours of the package; `rcParams` are left alone."""
    ax.spines[["top", "right"]].set_visible(False)
    for spine in ax.spines.values():
        spine.set(edgecolor=INK, linewidth=0.8)
    ax.tick_params(which="both", labelsize=SMALL_FONT, color=INK, labelcolor=INK)
    for text in (ax.xaxis.label, ax.yaxis.label, ax.title):
        text.set(fontsize=FONT_SIZE, color=INK)
    return ax


def flat(ax: Any) -> Axes:
    """Return `ax`, or new axes of two dimensions."""
    if ax is None:
        return dressed(new_figure(COLUMN, 2.6).add_subplot())
    if not isinstance(ax, Axes) or isinstance(ax, Axes3D):
        raise InvalidInputError(f"ax: axes of two dimensions expected, found {type(ax).__name__}")
    return ax


def spatial(ax: Any) -> Axes3D:
    """Return `ax`, or new axes of three dimensions."""
    if ax is None:
        return new_figure(COLUMN, COLUMN).add_subplot(projection="3d")
    if not isinstance(ax, Axes3D):
        raise InvalidInputError(f'ax: axes with projection="3d" expected, found {type(ax).__name__}')
    return ax


def line_style(style: dict[str, Any]) -> dict[str, Any]:
    """Style of the caller by the long names of its properties, tried on a line that nobody sees."""
    try:
        found = {name: value for name, value in normalize_kwargs(style, Line2D).items() if value is not None}
        Line2D([], [], **found)
    except (AttributeError, TypeError, ValueError) as wrong:
        raise InvalidInputError(f"style: {wrong}") from None
    return found


def drawn(ax: Axes) -> int:
    """Lines of curves that flat axes have already."""
    return sum(line.get_gid() not in (GRID_ID, KNOT_ID) for line in ax.lines)


def cycled(i: int) -> dict[str, Any]:
    """Colour and dashes of line `i`."""
    return {"color": CURVES[i % len(CURVES)], "linestyle": DASHES[i % len(DASHES)]}


def label(style: dict[str, Any], *own: str) -> str:
    """Label of a line: that of the caller, and what tells the line from others of the same curve."""
    return ", ".join(str(part) for part in (style.get("label"), *own) if part)


def column_style(column: int, columns: int, style: dict[str, Any], before: int) -> dict[str, Any]:
    """Colour of a body axis for a column, dashes for a curve after so many lines; `style` of the caller comes first."""
    own = {"color": BODY_AXES[column], "linestyle": DASHES[before // columns % len(DASHES)]}
    return own | style | {"label": label(style, f"column {column + 1}")}


def legend(ax: Axes, **where: Any) -> None:
    """Make a small legend where several lines have names, beside what is drawn: above flat axes, below a sphere."""
    names = ax.get_legend_handles_labels()[1]
    if len(names) < 2:
        return
    place: dict[str, Any] = {"ncols": 3 if len(max(names, key=len)) > 7 else 4, "loc": "lower center"}
    place |= {"bbox_to_anchor": (0.5, 1.0), "columnspacing": 1.2}
    if isinstance(ax, Axes3D):
        # A sphere and its axes fill the square.
        place = {"ncols": len(names), "loc": "upper center", "bbox_to_anchor": (0.5, 0.0)}
    look: dict[str, Any] = {"fontsize": SMALL_FONT, "labelcolor": INK, "edgecolor": GRID["color"], "frameon": False}
    ax.legend(**(look | place | where))


def time_label(timed: bool) -> str:
    """Label of an axis of times."""
    return TIME_LABEL if timed else STEP_LABEL
