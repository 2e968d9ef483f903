"""Costs of solutions of boundary problems, compared with other solutions of the same problem.

``python -m benchmarks.boundary.cost`` writes ``docs/boundary_cost.md``; ``--count 50`` is a short run.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from tabulate import tabulate  # type: ignore[import-untyped]
from tqdm import tqdm  # type: ignore[import-untyped]

from benchmarks.boundary.random_problems import Cubics
from benchmarks.environment import ROOT, machine, sentence
from benchmarks.problems import Array
from stiefel_rs import GeometricCubic, Stiefel, StiefelError

Problem = tuple[Array, Array, Array, Array]
COUNT = 2000
PROCESSES = 2
# For one in this many problems of each kind, all solutions are searched for, which takes a thousand times as long.
SEARCHED = 40
SLACK = 1.01
# Newton steps only, without other strategies.
NEWTON = 12

PREAMBLE = """# What solutions cost

`RiemannianCubic.from_boundary` returns one of many solutions. For {count} problems,
the table counts its solutions that cost more than {slack} times the cheapest of: the solution of the reversed problem;
the geodesic traversed from rest to rest (if both velocities are zero); the solution that Newton's method finds from the
geometric cubic; and, for one problem in {searched}, everything that `all_found=True` finds.
[How to repeat the measurements](development/measurements.md).
"""


@dataclass(frozen=True)
class Kind:
    """Problems of one kind: distances, or permuted coordinate frames if there are none, and the largest speed."""

    title: str
    share: float
    shapes: tuple[tuple[int, int], ...]
    distances: tuple[float, float] | None
    speed: float

    def problem(self, index: int) -> Problem:
        """One problem: S0, V0, S1, V1."""
        n, k = self.shapes[index % len(self.shapes)]
        M, rng = Stiefel(n, k), np.random.default_rng([index, *map(ord, self.title)])

        def tangent(S: Array, length: float) -> Array:
            V = M.project_tangent(S, rng.standard_normal(S.shape))
            return np.asarray(V * (length / M.norm(S, V)))

        if self.distances is None:
            S0, S1 = np.eye(n, k), permuted(n, k, rng)
        else:
            S0 = np.asarray(M.random_point(rng))
            S1 = np.asarray(M.exp(S0, tangent(S0, rng.uniform(*self.distances))))
        V0, V1 = (tangent(S, self.speed * rng.uniform()) for S in (S0, S1))
        return S0, V0, S1, V1


def permuted(n: int, k: int, rng: np.random.Generator) -> Array:
    """Columns of the identity in another order and with signs, in the component of the first ones."""
    Q = (np.eye(n) * rng.choice([-1.0, 1.0], n))[:, rng.permutation(n)]
    if np.linalg.det(Q) < 0:
        Q[:, 0] *= -1
    return np.asarray(Q[:, :k])


NEAR = ((3, 1), (3, 2), (4, 2), (5, 2), (6, 3))
FAR = ((3, 1), (3, 2), (4, 2), (5, 2), (4, 3), (4, 4), (10, 3))
KINDS = (
    Kind("moderate: distance and speeds up to 2", 0.2, NEAR, (0.0, 2.0), 2.0),
    Kind("rest to rest, distance 2 to 2.79", 0.2, FAR, (2.0, 2.79), 0.0),
    Kind("rest to rest, distance 2.79 to 3.1", 0.1, FAR, (2.79, 3.1), 0.0),
    Kind("slow ends: distance 0.5 to 3, speeds up to 0.5", 0.2, FAR, (0.5, 3.0), 0.5),
    Kind("coordinate to permuted frames, at rest", 0.1, FAR, None, 0.0),
    Kind("coordinate to permuted frames, speeds up to 2", 0.1, FAR, None, 2.0),
    Kind("hard: distance up to 3, speeds up to 6", 0.1, NEAR, (0.0, 3.0), 6.0),
)


@dataclass(frozen=True)
class Outcome:
    """The cost of the solution of one problem, the costs of others, and the time taken."""

    shape: tuple[int, int]
    cost: float
    others: dict[str, float]
    seconds: float

    @property
    def ratio(self) -> float:
        """Ratio to the cheapest other solution, whose cost is zero between equal frames at rest."""
        least = min(self.others.values(), default=np.inf)
        return 1.0 if self.cost == least else self.cost / max(least, np.finfo(float).tiny)


def costs(problem: Problem, search: bool) -> Iterator[tuple[str, float]]:
    """Costs of other solutions of a problem."""
    S0, V0, S1, V1 = problem

    def geometric() -> float:
        curve = GeometricCubic(*problem)
        guess = (curve.acceleration(0.0), curve.jerk(0.0))
        return float(Cubics.from_boundary(*problem, guess=guess, max_iterations=NEWTON).cost())

    def found() -> float:
        return float(Cubics.from_boundary(*problem, all_found=True)[0].cost())

    others = {"reversed": lambda: Cubics.from_boundary(S1, -V1, S0, -V0).cost(), "geometric": geometric}
    if not V0.any() and not V1.any():
        others["geodesic"] = lambda: 12 * Stiefel(*S0.shape).dist(S0, S1) ** 2
    if search:
        others["search"] = found
    for name, cost in others.items():
        try:
            yield name, float(cost())
        except StiefelError:
            continue


def outcome(kind: Kind, index: int) -> Outcome:
    """The problem with the given number, solved in every way."""
    problem = kind.problem(index)
    start = time.perf_counter()
    try:
        cost = float(Cubics.from_boundary(*problem).cost())
    except StiefelError:
        cost = np.inf
    seconds = time.perf_counter() - start
    return Outcome(problem[0].shape, cost, dict(costs(problem, index % SEARCHED == 0)), seconds)


def line(kind: Kind, outcomes: Sequence[Outcome]) -> tuple[Any, ...]:
    """A line of the table."""
    solved = [o for o in outcomes if np.isfinite(o.cost)]
    dear = Counter(min(o.others, key=o.others.__getitem__) for o in solved if o.ratio > SLACK)
    seconds = [o.seconds for o in outcomes]
    return (
        kind.title,
        len(outcomes),
        sum(bool(o.others) for o in outcomes if not np.isfinite(o.cost)),
        sum(not o.others for o in outcomes if not np.isfinite(o.cost)),
        ", ".join(f"{count} ({name})" for name, count in dear.items()) or 0,
        f"{max((o.ratio for o in solved), default=np.nan):.4g}",
        f"{1e3 * float(np.median(seconds)):.3g} ms",
        f"{max(seconds):.2g} s",
    )


def page(count: int, processes: int) -> str:
    """The page."""
    headers = (
        "kind",
        "problems",
        "failed, others solved",
        "failed, all",
        f"above {SLACK}",
        "largest ratio",
        "median time",
        "longest",
    )
    lines = []
    with ProcessPoolExecutor(processes) as pool:
        for kind in KINDS:
            numbers = range(round(kind.share * count))
            outcomes = pool.map(partial(outcome, kind), numbers, chunksize=2)
            lines.append(line(kind, list(tqdm(outcomes, kind.title, len(numbers)))))
    table = tabulate(lines, headers=headers, tablefmt="github")
    facts = machine() | {"date": time.strftime("%Y-%m-%d", time.gmtime()), "processes": str(processes)}
    preamble = PREAMBLE.format(count=count, slack=SLACK, searched=SEARCHED)
    return f"{preamble}\n{table}\n\n## The run\n\n{sentence(facts)}\n"


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.boundary.cost", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "boundary_cost.md", help="page to write")
    parser.add_argument("--count", type=int, default=COUNT, help="problems")
    parser.add_argument("--processes", type=int, default=PROCESSES, help="at once")
    options = parser.parse_args(arguments)
    text = page(options.count, options.processes)
    options.out.write_text(text)
    print(f"\n{text}\nwritten to {options.out}")


if __name__ == "__main__":
    main()
