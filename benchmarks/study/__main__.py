"""`python -m benchmarks.study`: the study of integrators of Riemannian cubics, a Markdown page with figures."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import numpy as np
import scipy
from tqdm import tqdm  # type: ignore[import-untyped]

import stiefel_rs
from benchmarks.environment import ROOT, machine
from benchmarks.study import figures, long_runs, text, work
from benchmarks.study.cases import cases
from benchmarks.study.equations import STRAIGHT_LINE
from stiefel_rs import figure_style

PAGE = Path(__file__).with_name("page.md")


@dataclass(frozen=True)
class Extent:
    """The extent of a run."""

    rounds: int
    curves: int
    peers: bool
    bounded_time: float
    growing_time: float
    drift_steps: tuple[int, ...]
    sizes: tuple[tuple[int, int], ...]


FULL = Extent(15, 4, True, 500.0, 100.0, long_runs.DRIFT_STEPS, work.COST_SIZES)
QUICK = Extent(1, 1, False, 50.0, 10.0, (100, 1000), ((3, 1), (5, 2), (10, 3)))


def _versions() -> str:
    try:
        peer = f"heyoka {import_module('heyoka').__version__}"
    except ImportError:
        peer = "heyoka not installed"
    return f"stiefel_rs {stiefel_rs.__version__}, NumPy {np.__version__}, SciPy {scipy.__version__}, {peer}"


def run(extent: Extent, folder: Path) -> str:
    """Run everything: figures are written to a folder, the page is returned."""
    facts = machine()
    chosen = cases()[: extent.curves]
    solves = []
    for case in tqdm(chosen, desc="work"):
        found = work.solves(case, peers=extent.peers)
        work.interleave(found, extent.rounds)
        solves += found
    energies = long_runs.energies(extent.bounded_time, extent.growing_time)
    drifts = long_runs.drifts(extent.drift_steps)
    costs = work.costs(extent.sizes, extent.rounds)
    with figure_style.context():
        figures.write(
            folder,
            {
                "work": figures.work(solves),
                "energy": figures.energy(energies),
                "drift": figures.drift(drifts),
                "cost": figures.cost(costs),
            },
        )
    speeds = {e.curve: e.speeds for e in energies if e.method == text.REFERENCE_METHOD}
    reached = speeds.pop(long_runs.GROWING)[1]
    return PAGE.read_text().format(
        machine=f"{_versions()}; {facts['processor']}, {facts['system']}; load average: "
        f"{facts['load average, at the start']}.",
        rounds=extent.rounds,
        reference=text.references(chosen, {case.name: case.error(work.taylor(case.data, 1.0)(1.0)) for case in chosen}),
        straight_line=STRAIGHT_LINE,
        compilation=text.compilation(solves),
        accurate=work.ACCURATE,
        work=text.work_table(solves),
        work_text=text.work_text(solves),
        second_order=text.second_order_table(solves),
        slow=min(slow for slow, _ in speeds.values()),
        fast=max(fast for _, fast in speeds.values()),
        reached=reached,
        same_speed=f"{text.SAME_SPEED:.0%}",
        accelerations=" or ".join(map(str, long_runs.ACCELERATIONS)),
        bounded_time=extent.bounded_time,
        growing_time=extent.growing_time,
        step=long_runs.STEP,
        energy=text.energy_table(energies),
        drift_time=long_runs.DRIFT_TIME,
        drift=text.drift_table(drifts),
        cost=text.cost_table(costs),
        cost_text=text.cost_text(costs),
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.study", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "integrators.md", help="page to write")
    parser.add_argument("--quick", action="store_true", help="one curve, few sizes, short runs, no other libraries")
    options = parser.parse_args(arguments)
    page = run(QUICK if options.quick else FULL, options.out.parent / "figures")
    options.out.write_text(page)
    print(f"{page}\nwritten to {options.out}")


if __name__ == "__main__":
    main()
