"""Integrators from four retractions, on the paper's two curves and on random ones.

Measured are the distance of each retraction from the Riemannian exponential and the mean errors of its methods.
The paper's discretization maps are linear in coordinates. Here the same methods are built from other retractions of the
manifold too, lifted to velocities.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from .._core import Stiefel
from ..errors import ConvergenceError, OutsideDomainError
from . import experiments
from .experiments import EXPERIMENTS, SPHERE, Array, Experiment
from .text import write_csv

if TYPE_CHECKING:
    from .._core import _Map

PAPER: Final = "paper"
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
CASES: Final = tuple(itertools.product(PROBLEMS, ORDERS))
# The setting of the paper's conjecture: boundary values, and the mid-point method, of order 2.
STATED: Final = ("BVP", 2)
STEPS: Final = (10, 20, 50, 100)
RANDOM_STEPS: Final = 20
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
class LeftOut:
    """Random curves that were not used: near a pole of the chart, or where a method did not converge."""

    near_pole: int
    failed: int


@dataclass(frozen=True)
class Study:
    """Everything measured.

    Attributes
    ----------
    closeness : list of Closeness
    errors : list of MeanError
    left_out : dict of str to LeftOut
        Random curves that were not used, by the name of the experiment.
    """

    closeness: list[Closeness]
    errors: list[MeanError]
    left_out: dict[str, LeftOut]


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


def _errors(
    experiment: Experiment, curve: str, z0: Array, steps: int, cases: tuple[tuple[str, int], ...] = CASES
) -> list[MeanError]:
    """Mean errors of all retractions on the cubic through one state, for some problems and orders."""
    chart, d = experiment.chart, experiment.chart.d
    exact = chart.reference(z0, experiments.time_grid(steps))
    points, (start, end) = experiments.points(experiment, exact), (exact[0], exact[-1])
    found = []
    for name, (problem, order) in itertools.product(retractions(experiment), cases):
        step_map = MAPS[name][order - 1]
        if problem == "IVP":
            z = chart.integrate(start, steps, map=step_map)
        else:
            z = chart.shoot(start[:d], start[d : 2 * d], end[:d], end[d : 2 * d], steps, step_map).trajectory
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


def _keeps_off_the_poles(experiment: Experiment, z0: Array) -> bool:
    theta = experiment.chart.reference(z0, experiments.time_grid(RANDOM_STEPS))[:, 0]
    return bool(np.sin(theta).min() >= SMALLEST_SINE)


def _measure_random(experiment: Experiment, curves: int, wide: int) -> tuple[list[MeanError], LeftOut]:
    """Errors on random curves, in all cases on the first `wide`; and how many curves were left out."""
    errors: list[MeanError] = []
    taken, near_pole, failed = 0, 0, 0
    for z0 in itertools.islice(random_states(experiment), 20 * curves):
        if taken == curves:
            break
        try:
            if not _keeps_off_the_poles(experiment, z0):
                near_pole += 1
                continue
            cases = CASES if taken < wide else (STATED,)
            errors += _errors(experiment, f"random {taken + 1}", z0, RANDOM_STEPS, cases)
            taken += 1
        except OutsideDomainError:
            near_pole += 1
        except ConvergenceError:
            failed += 1
    return errors, LeftOut(near_pole, failed)


def measure(curves: int, wide: int) -> Study:
    """Measure both manifolds: the paper's curves at all `STEPS`, random ones at `RANDOM_STEPS`.

    Parameters
    ----------
    curves : int
        Random curves of each manifold in the setting of the conjecture.
    wide : int
        How many of them are run for initial values and for order 1 too.
    """
    closeness, errors, left_out = [], [], {}
    for e in EXPERIMENTS:
        closeness += measure_closeness(e)
        for steps in STEPS:
            errors += _errors(e, PAPER, experiments.initial_state(e), steps)
        random, left_out[e.name] = _measure_random(e, curves, wide)
        errors += random
    return Study(closeness, errors, left_out)


def by_closeness(study: Study, experiment: Experiment) -> list[str]:
    """Names of the retractions, the closest to the exponential first."""
    own = [c for c in study.closeness if c.manifold == experiment.name]
    return [c.retraction for c in sorted(own, key=lambda c: c.distance)]


def write_table(folder: Path, study: Study) -> list[Path]:
    """Write ``conjecture.csv`` and return its path."""
    header = ["manifold", "curve", "problem", "order", "N", "retraction", "mean_error"]
    rows = [(e.manifold, e.curve, e.problem, e.order, e.steps, e.retraction, e.error) for e in study.errors]
    return [write_csv(folder / "conjecture.csv", header, rows)]
