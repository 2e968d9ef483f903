"""Missing tools at the end of pytest's report: one line each."""

import os
import subprocess
import sys
from pathlib import Path

import skips

TESTS = """
import pytest

@pytest.mark.parametrize("i", range(5))
def test_browser(i):
    pytest.skip("chromium or chromedriver is not installed")

def test_peers():
    pytest.skip("not installed: geomstats, pymor")

def test_peer():
    pytest.importorskip("pymor.that_nobody_has")

def test_system():
    pytest.skip("a file of Linux")

def test_runs():
    pass
"""


def test_reasons_are_counted_by_tool():
    reasons = ["not installed: a, b", "could not import 'b.c': No module named 'b.c'", "signals", "b is not installed"]
    found = skips.lines(reasons)
    assert found == ["not installed: a (1 test)", "not installed: b (3 tests)", "skipped: signals (1 test)"]
    assert skips.lines([]) == []


def test_a_report_has_one_line_for_each_missing_tool(tmp_path):
    (tmp_path / "test_some.py").write_text(TESTS, encoding="utf-8")
    here = Path(__file__).parent
    options = ["-c", str(here.parents[1] / "pyproject.toml"), "-p", "conftest", str(tmp_path)]
    command = [sys.executable, "-m", "pytest", *options]
    env = os.environ | {"PYTHONPATH": os.pathsep.join([str(here), os.environ.get("PYTHONPATH", "")])}
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path, env=env)
    assert done.returncode == 0, done.stdout + done.stderr
    expected = [
        "not installed: chromium or chromedriver (5 tests)",
        "not installed: geomstats (1 test)",
        "not installed: pymor (2 tests)",
        "skipped: a file of Linux (1 test)",
    ]
    printed = done.stdout.splitlines()
    assert [line for line in printed if line.startswith(("not installed", "skipped"))] == expected
    assert not [line for line in printed if line.startswith("SKIPPED")]
