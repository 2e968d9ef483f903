"""Style of the figures of this package: sizes, fonts, margins, axes and output.

Importing this module imports matplotlib, so the rest of the package imports it only to draw figures. Figures
are instances of `matplotlib.figure.Figure`, made without pyplot or global state.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import matplotlib
import numpy as np
from cycler import cycler
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.ticker import FuncFormatter, NullLocator

from . import figure_svg, palette

# Widths in inches of a column and of a page in print.
COLUMN: Final = 3.4
PAGE: Final = 7.0
DPI: Final = figure_svg.DPI
FONT_SIZE: Final = 9
SMALL_FONT: Final = 8
GRID: Final[dict[str, Any]] = {"visible": True, "which": "major", "color": palette.GRID_GREY, "linewidth": 0.6}
SETTINGS: Final[Any] = {
    "font.size": FONT_SIZE,
    "legend.fontsize": SMALL_FONT,
    "xtick.labelsize": SMALL_FONT,
    "ytick.labelsize": SMALL_FONT,
    "axes.titlesize": FONT_SIZE,
    "axes.linewidth": 0.8,
    "lines.markersize": 4.5,
    "lines.linewidth": 1.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.prop_cycle": cycler(color=palette.CURVES),
} | dict.fromkeys(("text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color"), palette.INK)


@contextmanager
def context() -> Iterator[None]:
    """Use matplotlib's defaults with the sizes of this module, independent of the user's settings."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(SETTINGS)
        yield


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of the given size in inches."""
    # Margins are set in inches: an automatic layout would draw every figure three more times.
    figure = Figure(figsize=(width, height), dpi=DPI)
    FigureCanvasAgg(figure)
    return figure


def grid(figure: Figure, rows: int, columns: int, margins: tuple[float, ...], **options: Any) -> GridSpec:
    """Return a grid of panels within `margins`: left, right, bottom, top, in inches."""
    width, height = figure.get_size_inches()
    left, right, bottom, top = margins
    edges = {"left": left / width, "right": 1 - right / width, "bottom": bottom / height, "top": 1 - top / height}
    return figure.add_gridspec(rows, columns, **edges, **options)


def power_of_ten(value: float, _position: int) -> str:
    """Return the power of ten nearest to `value` in plain text, as a formatter of matplotlib."""
    return "10" + str(round(np.log10(value))).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def log_axis(axis: Axis) -> None:
    """Label the decades in plain text, which is faster than mathematical text and saves a font in each PDF."""
    axis.set_major_formatter(FuncFormatter(power_of_ten))
    axis.set_minor_locator(NullLocator())


def write(figure: Figure, path: Path) -> None:
    """Write a figure in the format of the file's name: SVG for light and dark pages, PNG at 200 dpi, PDF; no dates."""
    if path.suffix.lower() == ".svg":
        figure_svg.write_svg(figure, path)
    elif path.suffix.lower() == ".pdf":
        figure.savefig(path, metadata={"CreationDate": None})
    else:
        figure.savefig(path, dpi=DPI)


def save(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write ``name.png``, ``name.svg`` and ``name.pdf``; return their paths."""
    paths = [folder / f"{name}.{suffix}" for suffix in ("png", "svg", "pdf")]
    for path in paths:
        write(figure, path)
    return paths
