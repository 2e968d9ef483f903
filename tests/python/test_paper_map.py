"""The map of arXiv 2404.19407: complete, and every function, test and place that it names exists."""

import csv
import functools
import importlib
import re
from pathlib import Path

import pytest

import stiefel_rs
from tools.paper_map import page, report
from tools.paper_map.misprints import MISPRINTS
from tools.paper_map.verdicts import VERDICTS

ROOT = Path(__file__).parents[2]
NUMBERED = [
    *(f"({number})" for number in range(1, 12)),
    *("Definition 1", "Definition 2", "Proposition 1", "Proposition 2", "Theorem 1", "Remark 1", "Problem 1"),
    *("Example 1", "Example 2", "Example 3"),
    *("Figure 1", "Figure 2a", "Figure 2b", "Figure 3a", "Figure 3b"),
    *("Challenge 1", "Challenge 2", "Conjecture", "Future work"),
]


def test_page_is_that_of_the_table():
    assert page.PAGE.read_text(encoding="utf-8") == page.text(), "make paper-map"


@pytest.mark.parametrize("item", NUMBERED)
def test_every_numbered_item_has_a_row(item):
    assert any(item in row.label for row in page.ROWS)


def test_no_row_is_empty():
    for row in page.ROWS:
        assert all([row.label, row.says, row.code, row.tests, row.report]), row
    for misprint in MISPRINTS:
        assert all([misprint.label, misprint.printed, misprint.correct, misprint.tests]), misprint
        assert "{error}" in misprint.shown, misprint


def test_no_row_stands_twice():
    said = [row.says for row in page.ROWS]
    assert len(said) == len(set(said))


@functools.cache
def rust_source():
    return "\n".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "src").rglob("*.rs")))


def exists_in_rust(name):
    return re.search(rf"\bpub (fn|struct|trait|enum|const) {name.rsplit('::', 1)[1]}\b", rust_source()) is not None


def exists_in_python(name):
    if name.startswith("reproduce."):
        module, _, name = name.removeprefix("reproduce.").partition(".")
        thing = importlib.import_module(f"stiefel_rs.reproduce.{module}")
    else:
        thing = stiefel_rs
    for part in name.split("."):
        thing = getattr(thing, part, None)
    return thing is not None


@pytest.mark.parametrize("name", sorted({name for row in page.ROWS for name in row.code}))
def test_functions_exist(name):
    assert exists_in_rust(name) if "::" in name else exists_in_python(name)


@pytest.mark.parametrize("name", sorted({name for row in (*page.ROWS, *MISPRINTS) for name in row.tests}))
def test_tests_exist(name):
    path, _, test = name.partition("::")
    rust = path.endswith(".rs")
    text = (ROOT / ("" if rust else "tests/python") / path).read_text(encoding="utf-8")
    assert (f"#[test]\nfn {test}()" if rust else f"\ndef {test}(") in text


@pytest.mark.parametrize("place", [p for p in report.ALL if p.kind == "page"], ids=lambda place: place.title)
def test_pages_exist(place):
    text = (ROOT / "docs" / place.name).read_text(encoding="utf-8")
    assert not place.heading or f"\n## {place.heading}\n" in text


def test_a_run_writes_every_place_of_the_report(quick):
    folder = quick[0]
    summary = (folder / "tables" / "summary.md").read_text(encoding="utf-8")
    headings = [line.removeprefix("### ") for line in summary.splitlines() if line.startswith("### ")]
    for place in report.ALL:
        if place.kind == "summary":
            assert headings.count(place.name) == 1, place
        elif place.kind == "table":
            assert (folder / "tables" / f"{place.name}.md").is_file(), place
        elif place.kind == "figure":
            assert (folder / "figures" / f"{place.name}.png").is_file(), place


def test_verdicts_are_those_of_a_run(quick):
    with (quick[0] / "tables" / "claims.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(v.claim, v.place, v.statement) for v in VERDICTS] == [
        (row["claim"], row["place"], row["the paper"]) for row in rows
    ]
    for v, row in zip(VERDICTS, rows, strict=True):
        assert v.timed or v.verdict == row["verdict"], v.claim


def test_every_place_is_used():
    used = {place for row in page.ROWS for place in row.report}
    assert used == set(report.ALL)
