"""The report as a PDF: its pages, its numbers, and the message if Typst is missing."""

import re
import shutil
import sys
from pathlib import Path

import pytest

from stiefel_rs import cli, reproduce
from stiefel_rs.reproduce import command

TEMPLATE = Path(command.__file__).with_name("report.typ")


def test_report_has_at_most_twelve_pages_and_the_numbers_of_the_tables(request, tmp_path):
    pytest.importorskip("typst")
    from stiefel_rs.reproduce import pdf  # noqa: PLC0415

    # A copy: the report is written into its folder.
    run = shutil.copytree(request.getfixturevalue("quick")[0], tmp_path / "run")
    before = set(run.rglob("*"))
    path = pdf.write(run)
    found = path.read_bytes()
    assert found.startswith(b"%PDF-") and found.rstrip().endswith(b"%%EOF")
    # The copy of the template has been removed.
    assert set(run.rglob("*")) == before | {path}
    pages = pdf.pages(run, 20)
    assert 5 <= len(pages) <= 12
    assert all(page.startswith(b"\x89PNG\r\n") for page in pages)

    claims = run / "tables" / "claims.csv"
    text = claims.read_text(encoding="utf-8")
    claims.write_text(text.replace("0.0108 %", "0.0999 %"), encoding="utf-8")
    changed = pdf.pages(run, 20)
    assert changed[0] != pages[0] and changed[-1] == pages[-1]


def test_the_template_holds_no_results():
    """The template contains no number with three or more decimals, and no fraction with an exponent."""
    template = TEMPLATE.read_text(encoding="utf-8").replace("2404.19407", "").replace("0.080 %", "")
    assert not re.findall(r"\d\.\d{3,}|\d\.\d+e-\d", template)


def test_without_typst_the_rest_is_written(monkeypatch, tmp_path, capsys):
    monkeypatch.setitem(sys.modules, "typst", None)
    monkeypatch.delitem(sys.modules, "stiefel_rs.reproduce.pdf", raising=False)
    monkeypatch.delattr(reproduce, "pdf", raising=False)
    monkeypatch.setattr(command.measurements, "measure", lambda *_: None)
    monkeypatch.setattr(command.write_tables, "write_all", lambda *_: [])
    monkeypatch.setattr(command.summary, "headline", lambda _: [])
    monkeypatch.setattr(command, "_draw", lambda *_: [])
    assert cli.main(["reproduce", "--report", "--out", str(tmp_path)]) == command.EXIT_FAILURE
    printed = capsys.readouterr()
    assert printed.err.startswith("stiefel-rs: no report (") and "pip install 'stiefel-rs[report]'" in printed.err
    assert (tmp_path / "manifest.json").is_file() and not (tmp_path / "report.pdf").exists()
