"""The tables of the paper's Figure 2 (CSV, Markdown, LaTeX), and the wide ones with every method (CSV, Markdown)."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from . import experiments
from .experiments import ALL_METHODS, SPHERE, STIEFEL_3_2, ErrorRow, Experiment
from .text import LABELS, PAPER_LABELS, table, write_csv

# The panels of the paper's Figures 2 and 3.
PANELS: Final[dict[str, Experiment]] = {"a": SPHERE, "b": STIEFEL_3_2}


def slope_text(rows: list[ErrorRow], method: str) -> str:
    """Return the fitted slope with three decimals, or a dash."""
    value = experiments.slope(rows, method)
    return "-" if value is None else f"{value:.3f}"


def paper_table(rows: list[ErrorRow], style: str = "pipe") -> str:
    """Return the step and the errors of the paper's three curves."""
    cells = [[f"{r.h:.4g}", *(f"{r.errors[m]:.4e}" for m in PAPER_LABELS)] for r in rows]
    return table(["h", *PAPER_LABELS.values()], cells, 0, style)


def write_paper_tables(folder: Path, rows: dict[str, list[ErrorRow]]) -> list[Path]:
    """Write ``figure_2a`` and ``figure_2b``, each as ``.csv``, ``.md`` and ``.tex`` (booktabs)."""
    paths = []
    for panel, experiment in PANELS.items():
        own = rows[experiment.name]
        stem = folder / f"figure_2{panel}"
        cells = [(r.h, *(r.errors[m] for m in PAPER_LABELS)) for r in own]
        paths.append(write_csv(stem.with_suffix(".csv"), ["h", *PAPER_LABELS.values()], cells))
        for suffix, style in ((".md", "pipe"), (".tex", "latex_booktabs")):
            path = stem.with_suffix(suffix)
            path.write_text(paper_table(own, style) + "\n", encoding="utf-8")
            paths.append(path)
    return paths


def wide_table(rows: list[ErrorRow]) -> str:
    """Return the mean errors of every method, with the fitted orders in the last row."""
    cells = [[str(r.steps), f"{r.h:.4g}", *(f"{r.errors[m]:.4e}" for m in ALL_METHODS)] for r in rows]
    orders = ["order", "", *(slope_text(rows, m) for m in ALL_METHODS)]
    return table(["N", "h", *(LABELS[m] for m in ALL_METHODS)], [*cells, orders], 0)


def write_wide_tables(folder: Path, rows: dict[str, list[ErrorRow]]) -> list[Path]:
    """Write ``<manifold>.csv`` and ``<manifold>.md``."""
    paths = []
    for name, own in rows.items():
        cells = [(r.steps, r.h, *(r.errors[m] for m in ALL_METHODS)) for r in own]
        paths.append(write_csv(folder / f"{name}.csv", ["N", "h", *ALL_METHODS], cells))
        path = folder / f"{name}.md"
        path.write_text(wide_table(own) + "\n", encoding="utf-8")
        paths.append(path)
    return paths
