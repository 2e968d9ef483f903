"""The report as a Markdown page: written, read again, and brought up to date by a run of some rows."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from tabulate import tabulate  # type: ignore[import-untyped]

HEADERS = ("work", "ours", "other", "its figure", "ratio", "reach", "reached")
WHOLE = "this run"
# An escaped bar is part of a cell.
BAR = re.compile(r"(?<!\\)\|")
SKIPPED = re.compile(r"^`(\w+)` skipped: (.*)$", re.MULTILINE)

PREAMBLE = """# Benchmarks

Written by `make benchmark`; `benchmarks/compare/` holds the harness, each library's pinned versions, and the methods
that were written for comparison. Every library runs in a process and a virtual environment of its own, on the same
seeded inputs, with one thread each (rows that say otherwise excepted). Before timing, results are compared. Samples are
taken in turn, so that a slow moment of the machine meets everybody.

Figures are the shortest time of all samples, with the median in brackets; for one call, or for one point or problem of
a call on many. Ratios are of the shortest times, the other's over ours: above 1, ours is faster. Errors are relative,
against 40 digits, or, of interpolants, against the curve that was sampled. Costs are integrals of the squared covariant
acceleration, jumps those of that acceleration at the knots. Compilation is no part of a figure; for heyoka its time is
told. Rows that were measured again by themselves (`ARGS="--only TEXT"`) have a column of their own in the first table.
"""


@dataclass(frozen=True)
class Page:
    """What the page says.

    Attributes
    ----------
    facts : dict of str to dict of str to str
        For each run its circumstances.
    lines : list of tuple of str
        Cells of the table, in the order of `HEADERS`.
    failures : dict of str to str
        Libraries that could not be had, and why.
    """

    facts: dict[str, dict[str, str]]
    lines: list[tuple[str, ...]]
    failures: dict[str, str]

    @staticmethod
    def parse(text: str) -> Page:
        """A page that `text` wrote."""
        runs: dict[str, dict[str, str]] = {}
        lines: list[tuple[str, ...]] = []
        for header, *rows in _tables(text):
            if header == HEADERS:
                lines = rows
            else:
                for i, run in enumerate(header[1:], 1):
                    runs[run] = {row[0]: row[i] for row in rows if row[i]}
        return Page(runs, lines, dict(SKIPPED.findall(text)))

    def updated(self, newer: Page, order: Sequence[str]) -> Page:
        """The lines of `newer`, and of this page those of other work; work that is not in `order` is dropped."""
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
        facts = [(name, *(run.get(name, "") for run in self.facts.values())) for name in names]
        judged = [line[-1] for line in self.lines if line[-1]]
        parts = [
            PREAMBLE,
            _table(facts, ("", *self.facts)),
            f"\nReached: {judged.count('yes')} of the {len(judged)} targets that could be judged.\n",
            *(f"`{peer}` skipped: {_line(reason)}\n" for peer, reason in self.failures.items()),
            _table(self.lines, HEADERS),
        ]
        return "\n".join(parts) + "\n"


def _table(rows: Iterable[Sequence[str]], headers: Sequence[str]) -> str:
    escaped = [[_line(cell).replace("|", "\\|") for cell in row] for row in rows]
    return str(tabulate(escaped, headers=headers, tablefmt="github", disable_numparse=True))


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
