"""The paper's 0.080 % and 0.45 %: the relative mean error of GCP under every reading of its sentences that was tried.

A reading is a choice of the meaning of the stated numbers (derivatives or momenta, in which order), of the error (mean
over the grid, average over the rows of the table, largest), and of the distance by which it is divided.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..errors import ConvergenceError, OutsideDomainError
from . import experiments
from .experiments import EXPERIMENTS, Array, Experiment
from .text import percent, table

USED: Final = "coordinate derivatives (used here)"
# The percentages as the paper prints them.
PRINTED: Final = {"sphere": "0.080 %", "stiefel_3_2": "0.45 %"}
MEAN_STEPS: Final = 100
# Numerators: means over a grid of N, over the rows of a table of such means, and the largest distance.
ERRORS: Final = (f"mean error, N = {MEAN_STEPS}", "average over the table", "largest error")


def divisors(experiment: Experiment) -> dict[str, float]:
    """Distances that the error may be divided by: none, the largest Frobenius and the largest geodesic distance."""
    return {"undivided": 1.0, "2 sqrt(k)": experiment.diameter, "pi": math.pi}


def momenta_by_reading(experiment: Experiment) -> dict[str, tuple[Array, Array]]:
    """``(p_q, p_qdot)`` under the readings of the paper's last two triples of numbers, by the name of the reading."""
    e, d = experiment, experiment.chart.d
    acceleration, jerk, zero = np.array(e.qddot), np.array(e.qdddot), np.zeros(d)
    metric = np.linalg.inv(e.chart.hessian(np.concatenate([e.q, e.qdot, zero, zero]))[3 * d :, 3 * d :])
    p_qdot = metric @ acceleration
    # H_qdot = p_q - 2 Gamma(qdot, .) p_qdot, and the covariant derivative of p_qdot is Gamma(qdot, .) p_qdot - p_q.
    gradient = e.chart.gradient(np.concatenate([e.q, e.qdot, zero, p_qdot]))
    return {
        USED: e.chart.momenta(e.q, e.qdot, e.qddot, e.qdddot),
        "covariant derivatives": (-gradient[d : 2 * d] / 2 - metric @ jerk, p_qdot),
        "momenta p_qdot = qddot, p_q = qdddot": (jerk, acceleration),
        "momenta p_qdot = qddot, p_q = -qdddot": (-jerk, acceleration),
        "momenta p_q = qddot, p_qdot = qdddot": (acceleration, jerk),
        "acceleration and jerk exchanged": e.chart.momenta(e.q, e.qdot, e.qdddot, e.qddot),
    }


def initial_states(experiment: Experiment) -> dict[str, Array]:
    """State at ``t = 0`` under each reading of the data, shape ``(4 d,)``."""
    e = experiment
    states = {name: np.concatenate([e.q, e.qdot, *p]) for name, p in momenta_by_reading(e).items()}
    exchanged = e.chart.momenta(e.q, e.qddot, e.qdot, e.qdddot)
    return states | {"velocity and acceleration exchanged": np.concatenate([e.q, e.qddot, *exchanged])}


def _errors(experiment: Experiment, z0: Array, steps: int) -> Array:
    exact = experiment.chart.reference(z0, experiments.time_grid(steps))
    gcp = experiments.geometric_cubic(experiment, exact[0], exact[-1])(experiments.time_grid(steps))
    return experiments.distances(gcp, experiments.points(experiment, exact))


@dataclass(frozen=True)
class Reading:
    """Errors of GCP under one reading of the data, in the order of `ERRORS`; empty if there is no curve."""

    experiment: Experiment
    name: str
    errors: tuple[float, ...]

    def values(self) -> Iterator[tuple[str, float]]:
        """Yield every relative error with its description."""
        for kind, error in zip(ERRORS, self.errors, strict=False):
            for name, divisor in divisors(self.experiment).items():
                yield f"{self.name}; {kind}; {name}", error / divisor


def measure(steps: Sequence[int]) -> list[Reading]:
    """Measure both experiments; `steps` are the rows of the table."""
    found = []
    for e in EXPERIMENTS:
        for name, z0 in initial_states(e).items():
            try:
                at_grid = _errors(e, z0, MEAN_STEPS)
                average = float(np.mean([_errors(e, z0, n).mean() for n in steps]))
                errors: tuple[float, ...] = (float(at_grid.mean()), average, float(at_grid.max()))
            except (OutsideDomainError, ConvergenceError):
                errors = ()
            found.append(Reading(e, name, errors))
    return found


def nearest(readings: list[Reading], experiment: Experiment) -> tuple[str, float]:
    """Return the reading whose value is nearest to the paper's, by ratio, and the value."""
    values = [pair for r in readings if r.experiment is experiment for pair in r.values()]
    return min(values, key=lambda pair: abs(math.log(pair[1] / experiment.paper_error)))


def coincides(experiment: Experiment, value: float) -> bool:
    """Whether a value rounds to the percentage that the paper prints."""
    printed = PRINTED[experiment.name]
    digits = len(printed.removesuffix(" %").partition(".")[2])
    return f"{100 * value:.{digits}f} %" == printed


def coinciding(readings: list[Reading], experiment: Experiment) -> list[tuple[str, float]]:
    """Return the readings whose values round to the paper's."""
    values = [pair for r in readings if r.experiment is experiment for pair in r.values()]
    return [pair for pair in values if coincides(experiment, pair[1])]


def _verdict(readings: list[Reading], experiment: Experiment) -> str:
    e = experiment
    matches = coinciding(readings, e)
    if matches:
        listed = "; ".join(f"{percent(value)} ({name})" for name, value in matches)
        return f"- {e.title}: the paper's {PRINTED[e.name]} coincides with {listed}."
    name, value = nearest(readings, e)
    return f"- {e.title}: no reading gives the paper's {PRINTED[e.name]}; nearest is {percent(value)} ({name})."


def section(readings: list[Reading], steps: Sequence[int]) -> str:
    """Text of the section of ``summary.md``."""
    cells = []
    for r in readings:
        if r.errors:
            mean, average, largest = r.errors
            over = [percent(mean / divisor) for divisor in divisors(r.experiment).values()]
            cells.append([r.experiment.title, r.name, *over, percent(average), percent(largest)])
        else:
            cells.append([r.experiment.title, r.name, *["no curve"] * 5])
    header = ["manifold", "the stated numbers read as", ERRORS[0], "over 2 sqrt(k)", "over pi", *ERRORS[1:]]
    verdicts = "\n".join(_verdict(readings, e) for e in EXPERIMENTS)
    return f"""### 0.080 % and 0.45 %: the relative mean error of GCP

The paper: "around 0.080 % in the sphere and 0.45 % in the Stiefel manifold", the ratio of "the average mean error" in
its tables and "the maximum distance between two points". The largest Frobenius distance is `2 sqrt(k)`, between `S` and
`-S`; the largest geodesic distance is pi on both manifolds. The average is taken over the rows of the table for
N = {", ".join(map(str, steps))}; it and the largest error are printed undivided, and were compared divided as well.

{table(header, cells, 2)}

{verdicts}

The numbers of the paper's tables are not printed in its text: these two percentages are its only ones to compare with.
"""
