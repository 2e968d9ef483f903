"""Random boundary problems of Riemannian cubics: success rates, accuracy and numbers of steps.

``python -m benchmarks.boundary.solved`` writes ``docs/boundary_problems.md``; ``--count 100`` is a short run.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tabulate import tabulate  # type: ignore[import-untyped]
from tqdm import tqdm  # type: ignore[import-untyped]

from benchmarks.boundary import extremes
from benchmarks.boundary.random_problems import FAMILIES, RESIDUAL, Cubics, Family, problem
from benchmarks.environment import ROOT, load, machine, sentence
from stiefel_rs import ConvergenceError, SolverReport, Stiefel, StiefelError

SHAPES = ((3, 1), (3, 2), (4, 2), (5, 2), (6, 3), (10, 3), (12, 4), (16, 4))
COUNT = 1000
HEADERS = (
    "manifold", "solved", "after descents", "largest residual", "largest defect", "Newton steps, mean", "most",
    "time, median", "longest", "not solved",
)  # fmt: skip

PREAMBLE = (Path(__file__).parent / "solved_page.md").read_text()


@dataclass(frozen=True)
class Tally:
    """Results for the problems of one family on one manifold; the lists contain only solved problems."""

    count: int
    reports: list[SolverReport]
    defects: list[float]
    seconds: list[float]
    failures: Counter[str]

    def reaches(self, family: Family) -> bool:
        """Whether all targets are reached."""
        return (
            len(self.reports) >= family.share * self.count
            and all(report.residual <= RESIDUAL for report in self.reports)
            and (family.steps is None or all(report.iterations <= family.steps for report in self.reports))
        )

    def cells(self) -> tuple[str, ...]:
        """Its line of the table, without the manifold."""
        failures = ", ".join(f"{count} {reason}" for reason, count in self.failures.most_common())
        if not self.reports:
            return "0 %", *("" for _ in range(7)), failures
        steps = [report.iterations for report in self.reports]
        descents = sum(report.strategy == "descent" for report in self.reports)
        return (
            f"{100 * len(self.reports) / self.count:.4g} %",
            f"{100 * descents / len(self.reports):.3g} %",
            f"{max(report.residual for report in self.reports):.1e}",
            f"{max(self.defects):.1e}",
            f"{np.mean(steps):.2f}",
            str(max(steps)),
            f"{1e6 * np.median(self.seconds):.0f} us",
            f"{1e3 * max(self.seconds):.2f} ms",
            failures,
        )


def solve_all(n: int, k: int, family: Family, count: int) -> Tally:
    """All problems of a family on St(n, k)."""
    M, rng = Stiefel(n, k), np.random.default_rng([20240419, n, k, int(family.speed)])
    tally = Tally(count, [], [], [], Counter())
    for _ in range(count):
        ends = problem(M, family, rng)
        start = time.perf_counter()
        try:
            curve = Cubics.from_boundary(*ends)
        except ConvergenceError as error:
            tally.failures[error.report.reason if error.report is not None else "ConvergenceError"] += 1
            continue
        except StiefelError as error:
            tally.failures[type(error).__name__] += 1
            continue
        tally.seconds.append(time.perf_counter() - start)
        report = curve.report
        assert report is not None
        tally.reports.append(report)
        gaps = [curve(1.0) - ends[2], curve.velocity(1.0) - ends[3]]
        tally.defects.append(float(np.linalg.norm(gaps)))
    return tally


def page(count: int) -> tuple[str, list[str]]:
    """The page, and a line for each target of this project that is missed."""
    facts = machine() | {"date": time.strftime("%Y-%m-%d", time.gmtime())}
    parts = [PREAMBLE.format(count=count)]
    started, missed = time.time(), []
    progress = tqdm(total=len(FAMILIES) * len(SHAPES), unit="line")
    for family in FAMILIES:
        lines = []
        for n, k in SHAPES:
            tally = solve_all(n, k, family, count)
            lines.append((f"St({n},{k})", *tally.cells()))
            if not tally.reaches(family):
                missed.append(f"missed on St({n},{k}), {family.title}: {family.target}")
            progress.update()
        table = tabulate(lines, headers=HEADERS, tablefmt="github", disable_numparse=True)
        parts.append(f"## {family.title}\n\n{table}\n")
    progress.close()
    text, late = extremes.section(min(count, extremes.COUNT))
    parts.append(text)
    missed += late
    facts |= {"load average, at the end": load(), "duration": f"{time.time() - started:.0f} s"}
    parts.append("## The run\n\n" + sentence(facts))
    return "\n".join(parts) + "\n", missed


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.boundary.solved", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "boundary_problems.md", help="page to write")
    parser.add_argument("--count", type=int, default=COUNT, help="problems of each line")
    options = parser.parse_args(arguments)
    text, missed = page(options.count)
    options.out.write_text(text)
    print("\n".join(["", text, f"written to {options.out}", *missed]))


if __name__ == "__main__":
    main()
