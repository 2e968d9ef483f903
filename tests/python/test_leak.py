"""Memory of many solves, and that the script that watches it sees a leak."""

import mmap
import sys

import pytest

from benchmarks import leak

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads memory from /proc")

SOLVES = {"spline": 300, "exact_cubic": 1000}


@pytest.mark.parametrize(("name", "solves"), [(x, SOLVES.get(x, 3000)) for x in leak.WORK])
def test_memory_of_many_solves_is_flat(name, solves):
    found = leak.watch(leak.WORK[name][0], solves)
    grown = leak.growth(found)
    # Seen is what keeps 0.4 kB in each of 3000 solves, or 4 kB in each of 300.
    assert grown <= 1e6, f"memory grew by {grown / 1e6:.1f} MB: {found}"


def keep(kept):
    """Two pages of memory that nothing before has used."""
    page = mmap.mmap(-1, 8192)
    page.write(bytes(range(256)) * 32)
    kept.append(page)


def test_a_leak_is_seen():
    kept = []
    found = leak.watch(lambda i: keep(kept), 3000)
    assert leak.growth(found) > leak.LIMIT, found


def test_a_leak_fails_the_command(monkeypatch, capfd):
    kept = []
    monkeypatch.setitem(leak.WORK, "errors", (lambda i: keep(kept), 1.0))
    assert leak.main(["--here", "errors", "--solves", "3000"]) == 1
    assert capfd.readouterr().out.startswith("| errors | 3000 |")


def test_the_command_prints_a_table(capfd):
    assert leak.main(["--only", "logarithm", "--solves", "50"]) == 0
    assert "| logarithm | 50 |" in capfd.readouterr().out
