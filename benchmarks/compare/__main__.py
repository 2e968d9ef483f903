"""`python -m benchmarks.compare`: this project compared with SciPy, heyoka, geomstats and others, as a page."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence, Set
from dataclasses import replace
from pathlib import Path

from tqdm import tqdm  # type: ignore[import-untyped]

from benchmarks.compare.measure import FULL, QUICK, Effort, Outcome, Pool, run_row
from benchmarks.compare.page import WHOLE, Page
from benchmarks.compare.row import THREADS, Row
from benchmarks.compare.rows import all_rows
from benchmarks.compare.table import shown, verdicts
from benchmarks.compare.virtual_environments import UnavailableError, python_of
from benchmarks.environment import ROOT, load, machine

PEERS = ("scipy", "heyoka", "geomstats", "morphomatics", "pymanopt", "interpolatepy", "jax")

# Names of rows that fit into a heading of the page.
MOST_NAMES = 3


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Parse the options of the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.compare", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "benchmarks.md", help="page to write")
    parser.add_argument("--quick", action="store_true", help="few samples: a look, not a measurement")
    parser.add_argument(
        "--clock", choices=("wall", "cpu"), default="wall", help="cpu on a machine that others use at the same time"
    )
    parser.add_argument(
        "--only",
        action="append",
        default=[],
        metavar="TEXT",
        help="rows whose name contains TEXT; the page keeps its other rows",
    )
    parser.add_argument("--peers", nargs="*", choices=PEERS, default=PEERS, help="libraries to run beside this one")
    parser.add_argument("--venvs", type=Path, default=ROOT / ".venv-bench", help="where their environments are")
    parser.add_argument("--list", action="store_true", help="print the names of the rows and stop")
    return parser.parse_args(arguments)


def make_pool(peers: Sequence[str], needed: Set[str], venvs: Path) -> Pool:
    """A pool of processes; installs missing libraries."""
    ours = Path(sys.executable)
    starters: dict[str, tuple[Path, str, int] | str] = {
        "stiefel_rs": (ours, "stiefel_rs", 1),
        "stiefel_rs_threads": (ours, "stiefel_rs", THREADS),
    }
    for peer in tqdm(PEERS, desc="installing", unit="library", leave=False):
        if peer not in peers or peer not in needed:
            starters[peer] = "not asked for"
            continue
        try:
            starters[peer] = (python_of(peer, venvs.resolve()), peer, 1)
        except UnavailableError as error:
            starters[peer] = str(error)
    return Pool(starters)


def run(rows: Sequence[Row], pool: Pool, effort: Effort) -> list[Outcome]:
    """All rows, one after another; results that disagree stop the run."""
    outcomes = []
    progress = tqdm(rows, unit="row")
    for row in progress:
        progress.set_postfix_str(row.name)
        try:
            outcomes.append(run_row(row, pool, effort))
        except AssertionError as error:
            raise SystemExit(f"{row.name}: {error}") from error
    return outcomes


def facts_of(pool: Pool, started: float) -> dict[str, str]:
    """Date and duration of the run, versions, BLAS."""
    facts = {"date": time.strftime("%Y-%m-%d", time.gmtime(started))}
    # The load includes the processes of the run itself: one, or two if two threads are timed.
    facts["load average, at the end"] = load()
    facts["duration"] = f"{time.time() - started:.0f} s"
    for name, info in pool.infos().items():
        if name == "stiefel_rs_threads":
            continue
        versions = info["versions"]
        assert isinstance(versions, dict)
        facts[f"`{name}`"] = ", ".join(f"{package} {version}" for package, version in versions.items())
        if name == "scipy" and isinstance(info["blas"], list):
            facts["BLAS of SciPy and NumPy"] = "; ".join(info["blas"])
    return facts


def page_of(
    outcomes: Sequence[Outcome], facts: dict[str, str], failures: dict[str, str], options: argparse.Namespace
) -> Page:
    """The page of a run; a run of some rows updates the existing page."""
    lines = [line.cells() for outcome in outcomes for line in shown(outcome)]
    if not options.only:
        return Page({WHOLE: facts}, lines, failures)
    # Many names would make the column wider than the page.
    names = ", ".join(f"`{text}`" for text in options.only)
    column = f"rows with {names}" if len(options.only) <= MOST_NAMES else f"{len(outcomes)} rows, later"
    page = Page({column: facts}, lines, failures)
    if not options.out.is_file():
        return page
    return Page.parse(options.out.read_text()).updated(page, [row.title for row in all_rows()])


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    options = parse(arguments)
    rows = [row for row in all_rows() if not options.only or any(text in row.name for text in options.only)]
    if options.list or not rows:
        print("\n".join(row.name for row in (rows or all_rows())))
        raise SystemExit(0 if options.list else "no row has such a name")
    facts, started = machine(), time.time()
    if options.clock == "cpu":
        facts["clock"] = "the processor's, of each process; the wall's where two threads are timed"
    pool = make_pool(options.peers, {rival.peer for row in rows for rival in row.rivals}, options.venvs)
    try:
        outcomes = run(rows, pool, replace(QUICK if options.quick else FULL, clock=options.clock))
        facts |= facts_of(pool, started)
    finally:
        pool.close()
    page = page_of(outcomes, facts, pool.failed, options).text()
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(page)
    print(f"\n{page}\nwritten to {options.out}\n{verdicts(outcomes)}")


if __name__ == "__main__":
    main()
