"""The conjecture of arXiv 2404.19407 on retractions, measured.

The paper's discretization maps are linear in coordinates. It expects that a retraction closer to the Riemannian
exponential gives a smaller mean error. Here the same methods are built from other retractions, lifted to velocities,
and run on the paper's two curves and on random ones; the verdict is read off the numbers.
"""

from __future__ import annotations

import csv
import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from tabulate import tabulate  # type: ignore[import-untyped]

from .._core import Stiefel
from ..errors import ConvergenceError, OutsideDomainError
from . import experiments
from .experiments import EXPERIMENTS, SPHERE, Array, Experiment

if TYPE_CHECKING:
    from .._core import _Map

COORDINATES: Final = "linear in coordinates"
EXPONENTIAL: Final = "exponential"
# The maps of order 1 (from the initial point) and of order 2 (around the mid-point) of each retraction.
MAPS: Final[dict[str, tuple[_Map, _Map]]] = {
    COORDINATES: ("initial_point", "midpoint"),
    "quasi-geodesic": ("quasi_geodesic", "quasi_geodesic_midpoint"),
    "Cayley": ("cayley", "cayley_midpoint"),
    EXPONENTIAL: ("exponential", "exponential_midpoint"),
}
PROBLEMS: Final = ("IVP", "BVP")
ORDERS: Final = (1, 2)
STEPS: Final = (10, 20, 50, 100)
RANDOM_STEPS: Final = 20
RANDOM_CURVES: Final = 30
QUICK_RANDOM_CURVES: Final = 10
SEED: Final = 20240419
# A random curve counts where it keeps off the poles, at which the coordinates themselves break down.
SMALLEST_SINE: Final = 0.3
LENGTHS: Final = (0.1, 0.05, 0.025)


def retractions(experiment: Experiment) -> tuple[str, ...]:
    """Names of the retractions compared; on the sphere the quasi-geodesics are the geodesics."""
    return tuple(name for name in MAPS if experiment is not SPHERE or name != "quasi-geodesic")


@dataclass(frozen=True)
class Closeness:
    """How far a retraction is from the Riemannian exponential along the paper's curve.

    Attributes
    ----------
    distance : float
        Mean Frobenius distance of the two points for tangent vectors of length ``LENGTHS[0]``.
    exponent : float or None
        ``p`` of ``distance = O(length^p)``, fitted; None for the exponential itself.
    """

    manifold: str
    retraction: str
    distance: float
    exponent: float | None


@dataclass(frozen=True)
class MeanError:
    """Mean Frobenius error of one method on one curve."""

    manifold: str
    curve: str
    problem: str
    order: int
    steps: int
    retraction: str
    error: float


@dataclass(frozen=True)
class Study:
    """Everything measured: the closeness of each retraction, errors by curve, and random curves left out."""

    closeness: list[Closeness]
    errors: list[MeanError]
    left_out: dict[str, int]


def measure_closeness(experiment: Experiment) -> list[Closeness]:
    """Distances to the exponential at 11 points of the paper's curve, 40 random directions each."""
    chart, d = experiment.chart, experiment.chart.d
    rng = np.random.default_rng(SEED)
    q = np.repeat(experiments.reference(experiment, 10)[:, :d], 40, axis=0)
    u = rng.standard_normal(q.shape)
    u /= Stiefel(3, chart.k).norm(chart.embed(q), chart.embed_velocity(q, u))[:, None]
    rest = np.zeros_like(u)

    def ends(retraction: str, length: float) -> Array:
        pair = chart.discretize(np.hstack([q, rest]), np.hstack([length * u, rest]), MAPS[retraction][0])
        return chart.embed(pair[:, 1, :d])

    found = []
    for name in retractions(experiment):
        mean = [float(experiments.distances(ends(name, t), ends(EXPONENTIAL, t)).mean()) for t in LENGTHS]
        exponent = None if name == EXPONENTIAL else float(np.polyfit(np.log(LENGTHS), np.log(mean), 1)[0])
        found.append(Closeness(experiment.name, name, mean[0], exponent))
    return found


def _errors(experiment: Experiment, curve: str, z0: Array, steps: int) -> list[MeanError]:
    """Mean errors of all retractions, orders and problems on the cubic through one state."""
    chart, d = experiment.chart, experiment.chart.d
    exact = chart.reference(z0, experiments.time_grid(steps))
    points, (start, end) = experiments.points(experiment, exact), (exact[0], exact[-1])
    found = []
    for name in retractions(experiment):
        for order, step_map in zip(ORDERS, MAPS[name], strict=True):
            discrete = {
                "IVP": chart.integrate(start, steps, map=step_map),
                "BVP": chart.shoot(start[:d], start[d : 2 * d], end[:d], end[d : 2 * d], steps, step_map).trajectory,
            }
            for problem, z in discrete.items():
                error = float(experiments.distances(experiments.points(experiment, z), points).mean())
                found.append(MeanError(experiment.name, curve, problem, order, steps, name, error))
    return found


def random_states(experiment: Experiment) -> Iterator[Array]:
    """Endless initial states: speed, covariant acceleration and covariant jerk of length up to 1, 3 and 3."""
    chart = experiment.chart
    manifold, rng = Stiefel(3, chart.k), np.random.default_rng(SEED)
    while True:
        q = rng.uniform(-np.pi, np.pi, chart.d)
        q[0] = rng.uniform(0.7, np.pi - 0.7)
        S = chart.embed(q)
        vectors = []
        for longest in (1.0, 3.0, 3.0):
            V = manifold.random_tangent(S, rng)
            vectors.append(longest * rng.uniform() / float(manifold.norm(S, V)) * V)
        yield chart.state(S, *vectors)


def measure(curves: int = RANDOM_CURVES) -> Study:
    """Measure both manifolds: the paper's curves at all `STEPS`, and `curves` random ones at `RANDOM_STEPS`."""
    closeness, errors, left_out = [], [], {}
    for e in EXPERIMENTS:
        closeness += measure_closeness(e)
        for steps in STEPS:
            errors += _errors(e, "paper", experiments.initial_state(e), steps)
        taken, tried = 0, 0
        for z0 in itertools.islice(random_states(e), 20 * curves):
            if taken == curves:
                break
            tried += 1
            try:
                theta = e.chart.reference(z0, experiments.time_grid(RANDOM_STEPS))[:, 0]
                if np.sin(theta).min() < SMALLEST_SINE:
                    continue
                errors += _errors(e, f"random {taken + 1}", z0, RANDOM_STEPS)
            except (OutsideDomainError, ConvergenceError):
                continue
            taken += 1
        left_out[e.name] = tried - taken
    return Study(closeness, errors, left_out)


@dataclass(frozen=True)
class Comparison:
    """One retraction closer to the exponential than another, on the curves of one kind: how often its error is smaller.

    Attributes
    ----------
    wins, cases : int
        Of so many cases (curves, or ``N``) so many with the smaller error for the closer retraction.
    ratio : float
        Geometric mean of the error of the closer one over that of the other.
    """

    manifold: str
    curves: str
    problem: str
    order: int
    closer: str
    farther: str
    wins: int
    cases: int
    ratio: float


def comparisons(study: Study) -> list[Comparison]:
    """Compare all pairs of retractions, on the paper's curve and on the random ones."""
    table = {(e.manifold, e.curve, e.problem, e.order, e.steps, e.retraction): e.error for e in study.errors}
    found = []
    for e in EXPERIMENTS:
        ranked = sorted((c for c in study.closeness if c.manifold == e.name), key=lambda c: c.distance)
        names = [c.retraction for c in ranked]
        curves = {x.curve for x in study.errors if x.manifold == e.name and x.curve != "paper"}
        cases = {
            "paper": [("paper", n) for n in STEPS],
            "random": [(curve, RANDOM_STEPS) for curve in sorted(curves)],
        }
        for kind, problem, order in itertools.product(cases, PROBLEMS, ORDERS):
            for closer, farther in itertools.combinations(names, 2):
                ratios = [
                    table[e.name, curve, problem, order, n, closer] / table[e.name, curve, problem, order, n, farther]
                    for curve, n in cases[kind]
                ]
                wins = sum(ratio < 1 for ratio in ratios)
                mean = float(np.exp(np.mean(np.log(ratios)))) if ratios else float("nan")
                found.append(Comparison(e.name, kind, problem, order, closer, farther, wins, len(ratios), mean))
    return found


def verdict(found: list[Comparison]) -> str:
    """Where the conjecture holds and where not, in words, from the comparisons alone."""
    titles = {e.name: e.title for e in EXPERIMENTS}
    cases, wins = sum(c.cases for c in found), sum(c.wins for c in found)
    lines = [f"The closer retraction has the smaller mean error in {wins} of {cases} single cases.", ""]
    for problem, order in itertools.product(PROBLEMS, ORDERS):
        rows = [c for c in found if (c.problem, c.order) == (problem, order)]
        share = sum(c.wins for c in rows) / max(1, sum(c.cases for c in rows))
        wrong = "; ".join(
            f"{c.closer} against {c.farther} on {titles[c.manifold]}, {c.curves} (error {c.ratio:.2f} times as large)"
            for c in rows
            if c.ratio > 1
        )
        average = f"wrong for {wrong}" if wrong else "right for every pair"
        lines.append(f"- {problem}, order {order}: right in {100 * share:.0f} % of the cases; on average {average}.")
    best = [c for c in found if c.closer == EXPONENTIAL]
    means = sum(c.ratio < 1 for c in found)
    tendency = (
        f"on average over the curves of a row it holds in {means} of {len(found)} rows of the table, and in "
        f"{sum(c.ratio < 1 for c in best)} of the {len(best)} in which the exponential itself takes part"
    )
    if wins == cases:
        rule = "**Verdict: the conjecture holds in every case measured here**"
    elif 2 * means > len(found):
        rule = "**Verdict: as a rule without exceptions the conjecture is false; as a tendency it holds**"
    else:
        rule = "**Verdict: the conjecture is false, as a rule and as a tendency**"
    return "\n".join([*lines, "", f"{rule}: {tendency}."])


def _table(header: list[str], rows: list[list[str]]) -> str:
    return str(tabulate(rows, header, tablefmt="pipe", disable_numparse=True))


def section(study: Study) -> str:
    """Text of the section of ``summary.md``."""
    titles = {e.name: e.title for e in EXPERIMENTS}
    found = comparisons(study)
    near = [
        [titles[c.manifold], c.retraction, f"{c.distance:.3e}", "-" if c.exponent is None else f"{c.exponent:.2f}"]
        for c in study.closeness
    ]
    table = {
        (e.manifold, e.problem, e.order, e.steps, e.retraction): e.error for e in study.errors if e.curve == "paper"
    }
    errors = []
    for e in EXPERIMENTS:
        for problem, order, name in itertools.product(PROBLEMS, ORDERS, retractions(e)):
            cells = [f"{table[e.name, problem, order, n, name]:.4e}" for n in STEPS]
            errors.append([e.title, problem, str(order), name, *cells])
    pairs = [
        [
            titles[c.manifold],
            c.curves,
            c.problem,
            str(c.order),
            c.closer,
            c.farther,
            f"{c.wins} of {c.cases}",
            f"{c.ratio:.3f}",
        ]
        for c in found
    ]
    left = ", ".join(f"{count} on {titles[name]}" for name, count in study.left_out.items())
    return f"""
## The conjecture: a retraction closer to the exponential has a smaller mean error

The paper's maps are linear in coordinates. The same methods from other retractions of the manifold, lifted to
velocities: order 1 from the initial point, order 2 around the mid-point. How far each retraction is from the
Riemannian exponential along the paper's curve, for tangent vectors of length {LENGTHS[0]:g} (the distance is of order
length^p):

{_table(["manifold", "retraction", "mean distance", "p"], near)}

On the sphere the quasi-geodesics are the geodesics. Mean errors on the paper's curves:

{_table(["manifold", "problem", "order", "retraction", *(f"N = {n}" for n in STEPS)], errors)}

Every pair of retractions: in how many cases (the N above on the paper's curve, or random cubics at
N = {RANDOM_STEPS}) the closer one has the smaller error, and the geometric mean of its error over the other's. Left out
because the curve comes near a pole of the chart (`sin theta < {SMALLEST_SINE:g}`) or a method fails on it: {left}
random curves.

{_table(["manifold", "curves", "problem", "order", "closer", "farther", "smaller error", "ratio"], pairs)}

{verdict(found)}
"""


def write_all(folder: Path, study: Study) -> list[Path]:
    """Write ``conjecture.csv`` into `folder` and append the section to its ``summary.md``; the paths written."""
    path = folder / "conjecture.csv"
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["manifold", "curve", "problem", "order", "N", "retraction", "mean_error"])
        for e in study.errors:
            writer.writerow([e.manifold, e.curve, e.problem, e.order, e.steps, e.retraction, e.error])
    with (folder / "summary.md").open("a", encoding="utf-8") as file:
        file.write(section(study))
    return [path]
