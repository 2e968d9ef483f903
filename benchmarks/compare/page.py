"""The report as a Markdown page: written, parsed again, and updated by a run of some rows."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from tabulate import tabulate  # type: ignore[import-untyped]

HEADERS = ("task", "stiefel-rs", "compared with", "its result", "ratio")
# In the table of circumstances: as in the column before.
DITTO = '"'
WHOLE = "this run"
# An escaped bar belongs to a cell.
BAR = re.compile(r"(?<!\\)\|")
SKIPPED = re.compile(r"^`(\w+)` skipped: (.*)$", re.MULTILINE)

PREAMBLE = """# Benchmarks

`benchmarks/compare/` contains the harness, the pinned versions of the libraries, and the
methods that were implemented for comparison. Each library runs in its own process and virtual environment, on the same
seeded inputs, with one thread unless stated otherwise. Results are compared before timing. Samples of all libraries
alternate, so that slowdowns of the machine affect all of them equally.
[How to repeat the measurements](development/measurements.md).

Times are the shortest of all samples, for one call, or per point or problem of a call on many; medians that exceed the
shortest time by more than 15 % are in brackets. A ratio is the other's shortest time over that of stiefel-rs: above 1,
stiefel-rs is faster. Errors are relative, to a reference of 40 digits or, for interpolants, to the sampled curve. A
cost is the integral of the squared covariant acceleration, a jump the largest discontinuity of the covariant
acceleration at a knot. Times exclude compilation; heyoka's is listed separately. An empty cell of the first two columns
repeats the cell above.

The first table describes the machine and the versions, a column for each run; a ditto mark repeats the cell to its
left.
"""


@dataclass(frozen=True)
class Page:
    """The contents of the page.

    Attributes
    ----------
    facts : dict of str to dict of str to str
        Circumstances of each run.
    lines : list of tuple of str
        Cells of the table, in the order of `HEADERS`.
    failures : dict of str to str
        Libraries that were not available, with the reason.
    """

    facts: dict[str, dict[str, str]]
    lines: list[tuple[str, ...]]
    failures: dict[str, str]

    @staticmethod
    def parse(text: str) -> Page:
        """Parse a page written by `text`."""
        runs: dict[str, dict[str, str]] = {}
        lines: list[tuple[str, ...]] = []
        for header, *rows in _tables(text):
            if header == HEADERS:
                lines = _filled(rows)
            else:
                facts = [_repeated(row) for row in rows]
                for i, run in enumerate(header[1:], 1):
                    runs[run] = {row[0]: row[i] for row in facts if row[i]}
        return Page(runs, lines, dict(SKIPPED.findall(text)))

    def updated(self, newer: Page, order: Sequence[str]) -> Page:
        """The lines of `newer`, and the lines of this page for other work; work that is not in `order` is dropped."""
        measured = {line[0] for line in newer.lines}
        place = {work: i for i, work in enumerate(order)}
        lines = [line for line in self.lines if line[0] not in measured] + newer.lines
        lines = sorted((line for line in lines if line[0] in place), key=lambda line: place[line[0]])
        seen = {name.strip("`") for facts in newer.facts.values() for name in facts}
        failures = {peer: why for peer, why in self.failures.items() if peer not in seen}
        return Page(self.facts | newer.facts, lines, failures | newer.failures)

    def text(self) -> str:
        """The page in Markdown."""
        names = dict.fromkeys(name for facts in self.facts.values() for name in facts)
        facts = [_dittoed((name, *(run.get(name, "") for run in self.facts.values()))) for name in names]
        ratios = [float(line[-1]) for line in self.lines if line[-1]]
        ahead = sum(ratio > 1 for ratio in ratios)
        parts = [
            PREAMBLE,
            _table(facts, ("", *self.facts)),
            f"\nstiefel-rs is faster in {ahead} of {len(ratios)} comparisons.\n",
            *(f"`{peer}` skipped: {_line(reason)}\n" for peer, reason in self.failures.items()),
            _table(_thinned(self.lines), HEADERS),
        ]
        return "\n".join(parts) + "\n"


def _table(rows: Iterable[Sequence[str]], headers: Sequence[str]) -> str:
    escaped = [[_line(cell).replace("|", "\\|") for cell in row] for row in rows]
    return str(tabulate(escaped, headers=headers, tablefmt="github", disable_numparse=True))


def _thinned(lines: Sequence[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Lines without what their first two cells repeat of the line above."""
    found, above = [], ("", "")
    for line in lines:
        work = "" if line[0] == above[0] else line[0]
        ours = "" if line[:2] == above else line[1]
        found.append((work, ours, *line[2:]))
        above = line[0], line[1]
    return found


def _filled(lines: Iterable[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """The inverse of `_thinned`."""
    found: list[tuple[str, ...]] = []
    for line in lines:
        work, ours = (cell or found[-1][i] for i, cell in enumerate(line[:2]))
        found.append((work, ours, *line[2:]))
    return found


def _dittoed(row: tuple[str, ...]) -> tuple[str, ...]:
    """A row of the table of circumstances, with marks for cells that repeat the cell before."""
    pairs = pairwise(row[1:])
    return *row[:2], *(DITTO if cell and cell == before else cell for before, cell in pairs)


def _repeated(row: tuple[str, ...]) -> tuple[str, ...]:
    """The inverse of `_dittoed`."""
    found = list(row)
    for i, cell in enumerate(row):
        if cell == DITTO:
            found[i] = found[i - 1]
    return tuple(found)


def _line(text: str) -> str:
    return " ".join(text.split())


def _tables(text: str) -> list[list[tuple[str, ...]]]:
    """Header and rows of each table."""
    found: list[list[tuple[str, ...]]] = []
    inside = False
    for line in text.splitlines():
        if not line.startswith("|"):
            inside = False
            continue
        cells = tuple(cell.strip().replace("\\|", "|") for cell in BAR.split(line)[1:-1])
        if not inside:
            found.append([cells])
        elif not all(set(cell) <= set("-:") and cell for cell in cells):
            found[-1].append(cells)
        inside = True
    return found
