"""Other control points for de Casteljau curves on random boundary problems: distance to the exact cubic, and time.

``python -m benchmarks.boundary.control_points`` writes ``docs/control_points.md``; ``--count 10`` is a short run.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from tabulate import tabulate  # type: ignore[import-untyped]
from tqdm import tqdm  # type: ignore[import-untyped]

from benchmarks.boundary.random_problems import Cubics, Family, problem
from benchmarks.durations import seconds
from benchmarks.environment import ROOT, load, machine, sentence
from benchmarks.problems import Array
from stiefel_rs import Curve, GeometricCubic, GeometricPolynomial, Stiefel, StiefelError

PAGE = Path(__file__).with_name("control_points_page.md")
SHAPES = ((3, 1), (3, 2), (4, 2), (6, 3), (10, 3))
COUNT = 200
FAMILY = Family(1.5, 2.0, 1.0, None)
DEGREES = (4, 5, 6, 7)
# Times at which distances are measured, and at which the evaluation of a point is timed.
GRID = np.linspace(0.0, 1.0, 101)
POINTS = np.linspace(0.0, 1.0, 1000)
QUANTILES = (0.1, 0.9)
# Relative margin for comparing costs, which are accurate to 1e-12.
COST_MARGIN = 1e-11
# Ratios that agree to this factor are reported as one number.
SAME = 1.001
# Printed if every problem was refused.
REFUSED = "-"
EXACT = "`RiemannianCubic`"
BASE = "`GeometricCubic`"

Ends = tuple[Array, Array, Array, Array]


def methods() -> dict[str, Callable[[Ends, Any], Curve]]:
    """Each curve by its name, from the boundary data and the exact cubic, in the order of the tables."""

    def least(degree: int, ends: Ends, _exact: Any) -> Curve:
        return GeometricPolynomial.minimal_cost(*ends, degree=degree)

    def quintic(ends: Ends, exact: Any) -> Curve:
        S0, V0, S1, V1 = ends
        return GeometricPolynomial.quintic(S0, V0, exact.acceleration(0.0), S1, V1, exact.acceleration(1.0))

    return {
        BASE: lambda ends, _exact: GeometricCubic(*ends),
        '`pieces="geodesic"`': lambda ends, _exact: GeometricCubic(*ends, pieces="geodesic"),
        "`quintic`, end accelerations of the cubic": quintic,
        **{f"`minimal_cost`, degree {degree}": partial(least, degree) for degree in DEGREES},
    }


@dataclass
class Sample:
    """One method on all problems of a shape; entries are missing for refused problems."""

    distances: list[float] = field(default_factory=list)
    build: list[float] = field(default_factory=list)
    point: list[float] = field(default_factory=list)
    steps: list[int] = field(default_factory=list)
    failures: Counter[str] = field(default_factory=Counter)
    cheaper: int = 0


@dataclass(frozen=True)
class Tally:
    """All methods on one shape, and the number of boundary problems without an exact cubic for comparison."""

    n: int
    k: int
    unsolved: int
    samples: dict[str, Sample]

    @property
    def title(self) -> str:
        """The manifold."""
        return f"St({self.n},{self.k})"


def _timed(build: Callable[[], Any], sample: Sample) -> Any:
    """Build a curve and evaluate its points, with the times of both."""
    start = time.process_time()
    curve = build()
    middle = time.process_time()
    curve(POINTS, num_threads=1)
    sample.build.append(middle - start)
    sample.point.append((time.process_time() - middle) / len(POINTS))
    return curve


def _compare(ends: Ends, exact: Any, name: str, sample: Sample) -> None:
    try:
        curve = _timed(lambda: methods()[name](ends, exact), sample)
    except StiefelError as error:
        sample.failures[type(error).__name__] += 1
        sample.distances.append(np.nan)
        return
    sample.distances.append(float(np.linalg.norm(curve(GRID) - exact(GRID), axis=(1, 2)).mean()))
    sample.cheaper += curve.cost() < exact.cost() * (1 - COST_MARGIN)
    if name.startswith("`minimal_cost`"):
        sample.steps.append(curve.report.iterations)


def measure(n: int, k: int, count: int) -> Tally:
    """All methods on the boundary problems of one shape."""
    M, rng = Stiefel(n, k), np.random.default_rng([20240419, n, k])
    samples = {name: Sample() for name in (*methods(), EXACT)}
    unsolved = 0
    for _ in range(count):
        ends = problem(M, FAMILY, rng)
        try:
            exact = _timed(partial(Cubics.from_boundary, *ends), samples[EXACT])
        except StiefelError:
            unsolved += 1
            continue
        for name in methods():
            _compare(ends, exact, name, samples[name])
    return Tally(n, k, unsolved, samples)


def _gain(base: Sample, sample: Sample) -> str:
    """Ratio of the cubic's distance to that of another curve: geometric mean and quantiles."""
    ratio = np.divide(base.distances, sample.distances)
    ratio = ratio[np.isfinite(ratio)]
    if not len(ratio):
        return REFUSED
    low, high = np.quantile(ratio, QUANTILES)
    mean = float(np.exp(np.log(ratio).mean()))
    spread = "" if high < SAME * low else f" [{_three(low)}, {_three(high)}]"
    return f"{_three(mean)}{spread}"


def _three(x: float) -> str:
    """Three digits, without an exponent."""
    return f"{float(f'{x:.3g}'):.10g}"


def _table(tallies: list[Tally], cell: Callable[[Tally, str], str], names: dict[str, str]) -> str:
    rows = [(title, *(cell(tally, name) for tally in tallies)) for name, title in names.items()]
    return str(tabulate(rows, headers=("", *(t.title for t in tallies)), tablefmt="github", disable_numparse=True))


def distances_table(tallies: list[Tally]) -> str:
    """How much closer each curve is than the geometric cubic."""

    def cell(tally: Tally, name: str) -> str:
        base = tally.samples[BASE]
        return f"{np.nanmean(base.distances):.2g}" if name == BASE else _gain(base, tally.samples[name])

    names = {name: name for name in methods()} | {BASE: f"{BASE}, mean distance"}
    return _table(tallies, cell, names)


def times_table(tallies: list[Tally]) -> str:
    """Median times for building a curve, and for evaluating a point."""

    def cell(tally: Tally, name: str) -> str:
        sample = tally.samples[name]
        if not sample.build:
            return REFUSED
        return f"{seconds(float(np.median(sample.build)))}, {seconds(float(np.median(sample.point)))}"

    return _table(tallies, cell, {name: name for name in (*methods(), EXACT)})


def _steps(tallies: list[Tally]) -> str:
    steps = [n for t in tallies for s in t.samples.values() for n in s.steps]
    means = [float(np.mean(s.steps)) for t in tallies for s in t.samples.values() if s.steps]
    return (
        f"The search for least cost took {min(means):.2g} to {max(means):.2g} steps on average, by shape and "
        f"degree, and at most {max(steps)}."
    )


def _refused(tallies: list[Tally]) -> str:
    found = [
        f"{t.title}, {name}: {', '.join(f'{count} {reason}' for reason, count in s.failures.items())}"
        for t in tallies
        for name, s in t.samples.items()
        if s.failures
    ]
    found += [f"{t.title}: {t.unsolved} boundary problems without a solution" for t in tallies if t.unsolved]
    return "Left out: " + "; ".join(found) + "." if found else "All curves exist, and every search converged."


def _cheaper(tallies: list[Tally]) -> str:
    found = [
        f"{max(s.cheaper for name, s in t.samples.items() if name != EXACT)} on {t.title}"
        for t in tallies
        if any(s.cheaper for s in t.samples.values())
    ]
    if not found:
        return "No polynomial had a lower cost than the cubic."
    return (
        "Cubics are stationary, not always the cheapest: a polynomial had a lower cost than the cubic in up to "
        f"{', '.join(found)} of these problems."
    )


def _slower(tallies: list[Tally]) -> str:
    names = [name for name in methods() if "minimal_cost" in name]

    def ratios(kind: str) -> list[float]:
        return [
            float(np.median(getattr(t.samples[name], kind)) / np.median(getattr(t.samples[EXACT], kind)))
            for t in tallies
            for name in names
            if t.samples[name].build
        ]

    build, point = ratios("build"), ratios("point")
    return (
        f"Compared with the exact cubic, a polynomial of least cost took {min(build):.2g} to {max(build):.3g} times as "
        f"long to build, and {min(point):.2g} to {max(point):.3g} times as long for a point."
    )


def page(count: int) -> str:
    """The page."""
    facts = machine() | {"date": time.strftime("%Y-%m-%d", time.gmtime())}
    started = time.time()
    tallies = [measure(n, k, count) for n, k in tqdm(SHAPES, unit="shape")]
    facts |= {"load average, at the end": load(), "duration": f"{time.time() - started:.0f} s"}
    return PAGE.read_text().format(
        count=count,
        distance=FAMILY.distance,
        speed=FAMILY.speed,
        grid=len(GRID),
        low=f"{QUANTILES[0]:.0%}",
        high=f"{QUANTILES[1]:.0%}",
        distances=distances_table(tallies),
        steps=_steps(tallies),
        refused=_refused(tallies),
        cheaper=_cheaper(tallies),
        points=len(POINTS),
        times=times_table(tallies),
        slower=_slower(tallies),
        run=sentence(facts),
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.boundary.control_points", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "control_points.md", help="page to write")
    parser.add_argument("--count", type=int, default=COUNT, help="problems of each shape")
    options = parser.parse_args(arguments)
    text = page(options.count)
    options.out.write_text(text)
    print(f"\n{text}\nwritten to {options.out}")


if __name__ == "__main__":
    main()
