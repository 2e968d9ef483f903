"""The page ``docs/paper.md`` as text."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final

from .comparison import DISCUSSION, EXPERIMENTS, FIGURES
from .curves import DE_CASTELJAU, DISCRETIZATION, HAMILTONIANS
from .manifold import INTRODUCTION, MANIFOLD, RETRACTIONS
from .misprints import MISPRINTS
from .row import Row
from .symbols import SYMBOLS
from .verdicts import VERDICTS

PAGE: Final = Path(__file__).parents[2] / "docs" / "paper.md"
SECTIONS: Final[dict[str, tuple[Row, ...]]] = {
    "1. Introduction": INTRODUCTION,
    "2.1. The manifold": MANIFOLD,
    "2.2. Retractions and quasi-geodesics": RETRACTIONS,
    "3. The adjusted de Casteljau algorithm": DE_CASTELJAU,
    "4. Discretization maps": DISCRETIZATION,
    "4.1. Hamiltonians": HAMILTONIANS,
    "4.2. Numerical methods": EXPERIMENTS,
    "Figures": FIGURES,
    "4.3. Discussion": DISCUSSION,
}
ROWS: Final = tuple(row for rows in SECTIONS.values() for row in rows)

INTRODUCTION_TEXT: Final = """# The paper, item by item

Every numbered formula, definition, proposition, theorem, remark, example and figure of
[arXiv 2404.19407](https://arxiv.org/abs/2404.19407) (Anahory Simoes, Colombo, Silva Leite), and every claim of its
text, with the function that computes it, the test that checks it, and the place that reports the result. Tests named
`test_paper_*` implement the formulas in NumPy as printed, with n x n matrices, and compare them with this library.

Python tests are in `tests/python`. *Summary*, *table* and *figure* refer to output of `stiefel-rs reproduce`: sections
of `tables/summary.md`, files in `tables/` and `figures/`; *verdict* is a row of the [table below](#verdicts).
"""
VERDICTS_TEXT: Final = """## Verdicts

The statements that `stiefel-rs reproduce` checks. `tables/summary.md` and `report.pdf` begin with this table and the
measured numbers. "Much" means a factor of at least 2, in error or time. A star marks verdicts based on times, which
depend on the machine and its load.
"""
MISPRINTS_TEXT: Final = """## Misprints

Sentences and formulas that do not hold as printed. For each, a test shows that the printed form fails by the stated
amount and that the corrected form holds.
"""


def _table(header: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    names = list(header)
    # A bar ends a cell, even in code.
    cells = [[cell.replace("|", r"\|") for cell in row] for row in rows]
    return "".join(f"| {' | '.join(row)} |\n" for row in [names, ["---"] * len(names), *cells])


def _code(names: Iterable[str]) -> str:
    return "<br>".join(f"`{name}`" for name in names)


def _cells(row: Row) -> list[str]:
    says = f"{row.says}<br>*Here:* {row.here}" if row.here else row.says
    places = "<br>".join(place.link() for place in row.report)
    return [row.label, says, _code(row.code), _code(row.tests), places]


def _symbols() -> str:
    return f"## Symbols\n\n{_table(('paper', 'here'), SYMBOLS)}"


def _misprints() -> str:
    rows = [(m.label, m.printed, m.correct, m.shown.format(error=f"{m.error:.4g}"), _code(m.tests)) for m in MISPRINTS]
    return f"{MISPRINTS_TEXT}\n{_table(('where', 'printed', 'correct', 'measured', 'test'), rows)}"


def _verdicts() -> str:
    rows = [
        (str(n), v.place, v.statement, f"**{v.verdict}**{' *' if v.timed else ''}") for n, v in enumerate(VERDICTS, 1)
    ]
    return f"{VERDICTS_TEXT}\n{_table(('no.', 'place', 'the paper', 'verdict'), rows)}"


def text() -> str:
    """Return the whole page."""
    header = ("paper", "what it says", "code", "tests", "report")
    maps = [f"## {title}\n\n{_table(header, map(_cells, rows))}" for title, rows in SECTIONS.items()]
    return "\n".join([INTRODUCTION_TEXT, _symbols(), _verdicts(), _misprints(), *maps])
