"""What the examples have in common: figures, the command line, bases of one subspace."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

FIGURES = Path(__file__).resolve().parent.parent / "docs" / "figures" / "gallery"
# Okabe and Ito: they differ for colour-blind readers too.
BLACK, ORANGE, SKY, GREEN, BLUE, VERMILION, PURPLE = (
    "#000000", "#E69F00", "#56B4E9", "#009E73", "#0072B2", "#D55E00", "#CC79A7",
)  # fmt: skip
DPI = 120


def nearest_turn(U: NDArray[np.float64], W: NDArray[np.float64]) -> NDArray[np.float64]:
    """The orthogonal `R` for which the basis `U R` is nearest to the basis `W`; of many pairs as well."""
    left, _, right = np.linalg.svd(np.swapaxes(U, -1, -2) @ W)
    return np.asarray(left @ right)


def new_figure(width: float = 10.0, height: float = 4.6) -> Figure:
    """A figure of that many inches with this module's sizes, whatever the user's settings are."""
    matplotlib.rcdefaults()
    matplotlib.rcParams.update(
        {"font.size": 10, "axes.titlesize": 10, "legend.fontsize": 9, "axes.spines.top": False}
        | {"axes.spines.right": False, "axes.grid": True, "grid.color": "#DDDDDD", "legend.frameon": False}
    )
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, out: Path) -> None:
    """Write the figure with a palette of 96 colours: a third of the bytes."""
    out.parent.mkdir(parents=True, exist_ok=True)
    memory = BytesIO()
    figure.savefig(memory, dpi=DPI, format="png", metadata={"Software": None})
    Image.open(memory).convert("RGB").quantize(96, dither=Image.Dither.NONE).save(out, format="png", optimize=True)


def command_line(main: Callable[..., dict[str, Any]], name: str) -> None:
    """Run an example: `--out FILE`, `--quick`; its numbers are printed as JSON."""
    parser = argparse.ArgumentParser(description=(main.__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=FIGURES / f"{name}.png", help="figure to write")
    parser.add_argument("--quick", action="store_true", help="a small problem, to see that it runs")
    options = parser.parse_args()
    print(json.dumps(main(options.out, quick=options.quick), indent=1))
