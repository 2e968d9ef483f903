"""Style of the figures of this package: sizes, margins, axes and output.

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
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.ticker import FuncFormatter, NullLocator

FONT_SIZE: Final = 10
DPI: Final = 200
GRID: Final[dict[str, Any]] = {"visible": True, "which": "major", "color": "#DDDDDD", "linewidth": 0.6}


@contextmanager
def context() -> Iterator[None]:
    """Use matplotlib's defaults with the sizes of this module, independent of the user's settings."""
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


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of the given size in inches."""
    # Margins are set in inches: an automatic layout would draw every figure three more times.
    figure = Figure(figsize=(width, height))
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


def save(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write ``name.png`` and ``name.pdf`` without dates, and return their paths."""
    png, pdf = folder / f"{name}.png", folder / f"{name}.pdf"
    figure.savefig(png, dpi=DPI)
    figure.savefig(pdf, metadata={"CreationDate": None})
    return [png, pdf]
