"""The wider study of retractions: every pair, initial and boundary values, orders 1 and 2."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from .experiments import EXPERIMENTS
from .retractions import (
    EXPONENTIAL,
    LENGTHS,
    ORDERS,
    PAPER,
    PROBLEMS,
    RANDOM_STEPS,
    STEPS,
    Study,
    by_closeness,
    retractions,
)
from .text import table


@dataclass(frozen=True)
class Comparison:
    """One retraction closer to the exponential than another, on the curves of one kind: how often its error is smaller.

    Attributes
    ----------
    wins, cases : int
        Number of cases (curves, or ``N``) in which the closer retraction has the smaller error, and of all cases.
    ratio : float
        Geometric mean of the error of the closer retraction divided by the error of the other.
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
    error = {(e.manifold, e.curve, e.problem, e.order, e.steps, e.retraction): e.error for e in study.errors}
    found = []
    for e in EXPERIMENTS:
        names = by_closeness(study, e)
        # The curves that were run in every case, not in the setting of the conjecture alone.
        own = [x for x in study.errors if x.manifold == e.name and (x.problem, x.order) == ("IVP", 1)]
        curves = sorted({x.curve for x in own if x.curve != PAPER})
        cases = {PAPER: [(PAPER, n) for n in STEPS], "random": [(curve, RANDOM_STEPS) for curve in curves]}
        for kind, problem, order in itertools.product(cases, PROBLEMS, ORDERS):
            for closer, farther in itertools.combinations(names, 2):
                ratios = [
                    error[e.name, curve, problem, order, n, closer] / error[e.name, curve, problem, order, n, farther]
                    for curve, n in cases[kind]
                ]
                wins = sum(ratio < 1 for ratio in ratios)
                mean = float(np.exp(np.mean(np.log(ratios)))) if ratios else float("nan")
                found.append(Comparison(e.name, kind, problem, order, closer, farther, wins, len(ratios), mean))
    return found


def verdict(found: list[Comparison]) -> str:
    """Describe where the conjecture holds and where it does not, from the comparisons alone."""
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
        rule = "Read of every pair, problem and order, it holds in every case measured here"
    elif 2 * means > len(found):
        rule = "Read of every pair, problem and order, it is false as a rule without exceptions and holds as a tendency"
    else:
        rule = "Read of every pair, problem and order, it is false, as a rule and as a tendency"
    return "\n".join([*lines, "", f"{rule}: {tendency}."])


def section(study: Study) -> str:
    """Text of the section of ``summary.md``."""
    titles = {e.name: e.title for e in EXPERIMENTS}
    found = comparisons(study)
    near = [
        [titles[c.manifold], c.retraction, f"{c.distance:.3e}", "-" if c.exponent is None else f"{c.exponent:.2f}"]
        for c in study.closeness
    ]
    error = {(e.manifold, e.problem, e.order, e.steps, e.retraction): e.error for e in study.errors if e.curve == PAPER}
    errors = [
        [e.title, problem, str(order), name, *(f"{error[e.name, problem, order, n, name]:.4e}" for n in STEPS)]
        for e in EXPERIMENTS
        for problem, order, name in itertools.product(PROBLEMS, ORDERS, retractions(e))
    ]
    pairs = [
        [
            *(titles[c.manifold], c.curves, c.problem, str(c.order), c.closer, c.farther),
            *(f"{c.wins} of {c.cases}", f"{c.ratio:.3f}"),
        ]
        for c in found
    ]
    random = max(c.cases for c in found if c.curves != PAPER)
    return f"""### Every pair of retractions, initial and boundary values, orders 1 and 2

The paper's maps are linear in coordinates. The same methods from other retractions of the manifold, lifted to
velocities: order 1 from the initial point, order 2 around the mid-point. How far each retraction is from the
Riemannian exponential along the paper's curve, for tangent vectors of length {LENGTHS[0]:g} (the distance is of order
length^p); on the sphere the quasi-geodesics are the geodesics:

{table(["manifold", "retraction", "mean distance", "p"], near, 2)}

Mean errors on the paper's curves:

{table(["manifold", "problem", "order", "retraction", *(f"N = {n}" for n in STEPS)], errors, 4)}

Every pair of retractions: in how many cases (the N above on the paper's curve, or {random} random cubics at
N = {RANDOM_STEPS}) the closer one has the smaller error, and the geometric mean of its error over the other's.

{table(["manifold", "curves", "problem", "order", "closer", "farther", "smaller error", "ratio"], pairs, 6)}

{verdict(found)}
"""
