"""The conjecture of arXiv 2404.19407 as stated.

Integrators from retractions that are closer to the Riemannian exponential have a smaller mean error than the mid-point
method: measured in the paper's setting, order 2 and boundary values.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from .experiments import EXPERIMENTS, Array
from .retractions import COORDINATES, PAPER, RANDOM_STEPS, SMALLEST_SINE, STATED, STEPS, Study, by_closeness
from .text import table

HEADER: Final = ["manifold", "curves", "retraction", "wins", "cases", "mean_ratio", "median_ratio", "largest_ratio"]


@dataclass(frozen=True)
class Outcome:
    """One retraction compared with the mid-point method, on curves of one kind.

    Attributes
    ----------
    curves : str
        ``"paper"``, with one case per ``N``, or ``"random"``, with one case per curve.
    ratios : ndarray
        Mean errors divided by the mean errors of the mid-point method.
    """

    manifold: str
    curves: str
    retraction: str
    ratios: Array

    @property
    def wins(self) -> int:
        """Number of cases with a smaller error than the mid-point method."""
        return int((self.ratios < 1).sum())

    @property
    def cases(self) -> int:
        """Number of cases."""
        return len(self.ratios)

    @property
    def mean(self) -> float:
        """Geometric mean of the ratios."""
        return float(np.exp(np.log(self.ratios).mean()))


def better(study: Study, manifold: str) -> list[str]:
    """Names of the retractions closer to the exponential than the mid-point method's, the closest first."""
    experiment = next(e for e in EXPERIMENTS if e.name == manifold)
    ranked = by_closeness(study, experiment)
    return ranked[: ranked.index(COORDINATES)]


def outcomes(study: Study) -> list[Outcome]:
    """Compare every better retraction with the mid-point method, on the paper's curve and on the random ones."""
    found = []
    for e in EXPERIMENTS:
        own = [x for x in study.errors if x.manifold == e.name and (x.problem, x.order) == STATED]
        error = {(x.curve, x.steps, x.retraction): x.error for x in own}
        random = list(dict.fromkeys(x.curve for x in own if x.curve != PAPER))
        cases = {PAPER: [(PAPER, n) for n in STEPS], "random": [(curve, RANDOM_STEPS) for curve in random]}
        for kind, keys in cases.items():
            for name in better(study, e.name):
                ratios = np.array([error[(*key, name)] / error[(*key, COORDINATES)] for key in keys])
                found.append(Outcome(e.name, kind, name, ratios))
    return found


def totals(found: list[Outcome], curves: str) -> tuple[int, int]:
    """Return wins and cases on the curves of one kind."""
    own = [x for x in found if x.curves == curves]
    return sum(x.wins for x in own), sum(x.cases for x in own)


def csv_rows(study: Study) -> list[tuple[object, ...]]:
    """Rows of ``conjecture_outcomes.csv``, whose header is `HEADER`."""
    return [
        (x.manifold, x.curves, x.retraction, x.wins, x.cases, x.mean, float(np.median(x.ratios)), float(x.ratios.max()))
        for x in outcomes(study)
    ]


def section(study: Study) -> str:
    """Text of the section of ``summary.md``."""
    found = outcomes(study)
    titles = {e.name: e.title for e in EXPERIMENTS}
    cells = [
        [
            *(titles[x.manifold], x.curves, x.retraction, f"{x.wins} of {x.cases}"),
            *(f"{x.mean:.3f}", f"{np.median(x.ratios):.3f}", f"{x.ratios.max():.3g}"),
        ]
        for x in found
    ]
    header = ["manifold", "curves", "retraction", "smaller error", "mean ratio", "median", "largest"]
    left = "; ".join(
        f"{titles[name]}: {count.near_pole} near a pole of the chart, {count.failed} on which a method did not converge"
        for name, count in study.left_out.items()
    )
    random = max(x.cases for x in found if x.curves != PAPER)
    return f"""### The conjecture as stated

The paper: "Using retraction maps that are better approximations of the Riemannian exponential map [...] we conjecture
that the associated retraction map based integrators will possess a smaller mean error than the mid-point
retraction-based symplectic integrator." In its setting, boundary values and order 2: mean errors as multiples of the
mean errors of the mid-point method, whose map is linear in coordinates, on the paper's curve
(N = {", ".join(map(str, STEPS))}) and on {random} random cubics of each manifold
(N = {RANDOM_STEPS}). A retraction counts as better if it is closer to the exponential along the paper's curve.

{table(header, cells, 3)}

The mean is geometric. Random cubics have speed, covariant acceleration and covariant jerk of length up to 1, 3 and 3;
they keep off the poles (`sin theta >= {SMALLEST_SINE:g}`). Left out: {left}.
"""
