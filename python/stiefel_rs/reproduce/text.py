"""How methods are written in tables and legends, and the tables themselves: Markdown, LaTeX and CSV."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

from tabulate import tabulate  # type: ignore[import-untyped]

LABELS: Final = {
    "gcp": "GCP",
    "reference": "reference",
    "initial_point_ivp": "initial-point IVP",
    "initial_point_bvp": "initial-point BVP",
    "midpoint_ivp": "mid-point IVP",
    "midpoint_bvp": "mid-point BVP",
    "splitting_2": "splitting 2 IVP",
    "splitting_4": "splitting 4 IVP",
    "splitting_6": "splitting 6 IVP",
    "splitting_8": "splitting 8 IVP",
    "exact_bvp": "exact cubic BVP",
}
MAP_LABELS: Final = {"initial_point": "initial-point", "midpoint": "mid-point"}
# The paper's names of its three curves; it finds both integrators' curves by shooting.
PAPER_LABELS: Final = {"gcp": "GCP", "initial_point_bvp": "Retraction", "midpoint_bvp": "Mid-point Retraction"}


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> Path:
    """Write one table; floats keep every digit."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)
    return path


def table(header: Sequence[str], rows: Sequence[Sequence[object]], left: int = 1, style: str = "pipe") -> str:
    """Return a table whose first `left` columns are aligned to the left and the others to the right."""
    align = ["left"] * left + ["right"] * (len(header) - left)
    return str(tabulate(rows, header, tablefmt=style, disable_numparse=True, colalign=align if rows else None))


def percent(x: float, digits: int = 3) -> str:
    """``100 x`` with some significant digits."""
    return f"{100 * x:.{digits}g} %"


def number(x: float, digits: int = 2) -> str:
    """Return some significant digits, and an exponent only for small and very large numbers."""
    return f"{float(f'{x:.{digits}g}'):g}"


def between(values: Iterable[float], digits: int = 2) -> str:
    """Return the smallest and the largest value; one number where both are written alike."""
    found = sorted(values)
    low, high = number(found[0], digits), number(found[-1], digits)
    return low if low == high else f"{low} to {high}"


def milliseconds(seconds: float) -> str:
    """Return a time in milliseconds with three digits."""
    return f"{1e3 * seconds:.3g} ms"
