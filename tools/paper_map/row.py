"""The contents of one line of the map."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Section:
    """A place that reports something: a part of the report, or a page of ``docs/``.

    Attributes
    ----------
    kind : str
    name : str
        Heading of ``summary.md``, stem of the files of a table or figure, name of a verdict, or path of the page below
        ``docs/``.
    heading : str
        Heading of the page; empty for the whole page.
    title : str
        Short name in the map.
    """

    kind: Literal["summary", "table", "figure", "verdict", "page"]
    name: str
    title: str
    heading: str = ""

    def link(self) -> str:
        """Return the place as Markdown; only pages and verdicts have an address."""
        if self.kind == "page":
            anchor = re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", self.heading).lower())
            return f"[{self.title}]({self.name}{'#' if anchor else ''}{anchor})"
        if self.kind == "verdict":
            return f"[{self.title}](#verdicts)"
        return f"summary: {self.title}" if self.kind == "summary" else f"{self.kind} `{self.name}`"


@dataclass(frozen=True)
class Row:
    """One statement of the paper.

    Attributes
    ----------
    label : str
        Number or place in the paper.
    says : str
        Summary of the statement.
    code : tuple of str
        Names below ``stiefel_rs`` in Python (``Stiefel.retract``), or in Rust (``stiefel_rs::Curve``).
    tests : tuple of str
        ``file::name``: a Python file below ``tests/python``, or the path of a Rust file.
    report : tuple of Section
    here : str
        Symbol or interpretation of the project, if it differs.
    """

    label: str
    says: str
    code: tuple[str, ...]
    tests: tuple[str, ...]
    report: tuple[Section, ...]
    here: str = ""


@dataclass(frozen=True)
class Misprint:
    """A sentence or formula of the paper that does not hold as printed.

    Attributes
    ----------
    label : str
        Place in the paper.
    printed, correct : str
        The printed and the correct form.
    shown : str
        Description of the measurement, with ``{error}`` in place of the number.
    error : float
        The amount by which the printed form fails, to four digits.
    tests : tuple of str
        As in `Row`.
    """

    label: str
    printed: str
    correct: str
    shown: str
    error: float
    tests: tuple[str, ...]
