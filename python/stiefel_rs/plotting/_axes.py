"""Axes: made here without pyplot, or checked."""

from __future__ import annotations

from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]

from ..errors import InvalidInputError

# Okabe and Ito: they differ for colour-blind readers too.
COLOURS: Final = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
DASHES: Final[tuple[Any, ...]] = ("-", (0, (5, 1.5)), (0, (1, 1)), "-.", (0, (3, 1, 1, 1, 1, 1)), (0, (8, 2)))
GREY: Final = "#555555"
GRID: Final[dict[str, Any]] = {"visible": True, "which": "major", "color": "#DDDDDD", "linewidth": 0.6}
TIME_LABEL: Final = "time t"
STEP_LABEL: Final = "step"


def new_figure(width: float, height: float) -> Figure:
    """Make a figure that pyplot does not know of."""
    made = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(made)
    return made


def flat(ax: Any) -> Axes:
    """Return `ax`, or new axes of two dimensions."""
    if ax is None:
        return new_figure(6.4, 4.2).add_subplot()
    if not isinstance(ax, Axes) or isinstance(ax, Axes3D):
        raise InvalidInputError(f"ax: axes of two dimensions expected, found {type(ax).__name__}")
    return ax


def spatial(ax: Any) -> Axes3D:
    """Return `ax`, or new axes of three dimensions."""
    if ax is None:
        return new_figure(5.2, 5.2).add_subplot(projection="3d")
    if not isinstance(ax, Axes3D):
        raise InvalidInputError(f'ax: axes with projection="3d" expected, found {type(ax).__name__}')
    return ax


def banner() -> Axes3D:
    """Make axes of three dimensions for a row: they are square, so larger than their figure."""
    width, height = 9.0, 2.6
    made = Figure(figsize=(width, height))
    FigureCanvasAgg(made)
    tall = width / height
    return made.add_axes((0.0, 0.5 - tall / 2, 1.0, tall), projection="3d")


def column_style(column: int, style: dict[str, Any]) -> dict[str, Any]:
    """Colour, dashes and name of a column; `style` of the caller comes first."""
    own = {"color": COLOURS[column % len(COLOURS)], "linestyle": DASHES[column % len(DASHES)]}
    named = dict(style)
    if style.get("label") is not None:
        named["label"] = f"{style['label']}, column {column + 1}"
    for short, name in (("c", "color"), ("ls", "linestyle"), ("lw", "linewidth")):
        if short in named:
            named[name] = named.pop(short)
    return own | {"label": f"column {column + 1}"} | named


def time_label(timed: bool) -> str:
    """Label of an axis of times."""
    return TIME_LABEL if timed else STEP_LABEL
