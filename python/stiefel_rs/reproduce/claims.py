"""The first page of the report: each statement of arXiv 2404.19407, what was measured, and the verdict.

Every verdict is computed from the numbers of the run.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import astuple, dataclass
from typing import Final

from . import challenges, conjecture, control_points, near_start, readings, timing
from . import embedded as embedding
from .evidence import constant_part, gains
from .experiments import EXPERIMENTS, METHODS, SPHERE, STIEFEL_3_2, Experiment
from .geometry import DIFFERENCE_BOUND, ROUND_OFF, SAMPLES
from .measurements import Measurements
from .paper_tables import slope_text
from .retractions import PAPER
from .text import LABELS, between, number, percent, table

HOLDS: Final = "holds"
FAILS: Final = "does not hold"
OPEN: Final = "open"
# Verdict on difficulties that the paper names and this package overcomes.
ANSWERED: Final = "answered"
# What counts as "much": a factor in error or time.
MUCH: Final = 2.0
# Largest difference between a measured order and the order of the method.
ORDER_MARGIN: Final = 0.2
# GCP's error counts as independent of the step up to this relative spread: the error of the trapezoidal rule at N = 5.
CONSTANT: Final = 0.05

# Stated for the dependence on the step in a run with `--steps N` for a single N.
ONE_SIZE: Final = "not measured: this run has one N only"


@dataclass(frozen=True)
class Claim:
    """One row: the place in the paper, its statement in short, the numbers of this run, and the verdict."""

    place: str
    statement: str
    measured: str
    verdict: str


def _only_if(condition: str) -> str:
    return f"holds only if {condition}"


def euler_lagrange(found: Measurements) -> Claim:
    """Judge the difficulty of the exact curves."""
    residual, shapes = max(r.residual for r in found.shapes), [f"St({r.n},{r.k})" for r in found.shapes]
    seconds = [1e3 * r.build_seconds for r in found.shapes]
    measured = f"boundary problems on {len(shapes)} manifolds, {shapes[0]} to {shapes[-1]}: residual at most "
    measured += f"{number(residual)}, in {between(seconds)} ms"
    verdict = f"{ANSWERED}: solved to round-off" if residual < ROUND_OFF else HOLDS
    return Claim("1", "the Euler-Lagrange equations are hard to solve", measured, verdict)


def quasi_geodesics(found: Measurements) -> Claim:
    """Quasi-geodesics are geodesics on the sphere, and others on St(3,2)."""
    g = found.geometry
    holds = g.sphere_distance < ROUND_OFF < g.frame_distance
    measured = f"largest distance at length 1: {number(g.sphere_distance)} on the sphere, "
    measured += f"{number(g.frame_distance)} on St(3,2)"
    statement = "quasi-geodesics are geodesics on the sphere, not on St(3,2)"
    return Claim("1", statement, measured, HOLDS if holds else FAILS)


def remark(found: Measurements) -> Claim:
    """Remark 1."""
    X, omega, distance = found.geometry.counterexample
    measured = f"on St(4,3), X S Omega = 0, norms of X and Omega {X:.2f} and {omega:.2f}: distance to the geodesic "
    measured += number(distance)
    counter = min(X, omega) > ROUND_OFF > distance
    verdict = _only_if("k <= 2; for any k the condition is X S Omega = 0") if counter else HOLDS
    return Claim("Remark 1", "a quasi-geodesic is a geodesic only if X = 0 or Omega = 0", measured, verdict)


def joining(found: Measurements) -> Claim:
    """Proposition 1."""
    near, far = found.geometry.joined
    measured = f"sphere: {near} of {SAMPLES} random pairs joined at angles below pi/2, {far} of {SAMPLES} beyond"
    if near == far == SAMPLES:
        verdict = HOLDS
    else:
        verdict = (
            f"{HOLDS} for close points, as Remark 1 says: nearer than pi/2 on the sphere" if near == SAMPLES else FAILS
        )
    return Claim("Prop. 1", "the quasi-geodesic of its X and Omega joins two points", measured, verdict)


def end_data(found: Measurements) -> Claim:
    """Judge Theorem 1."""
    defect = found.geometry.end_defect
    measured = f"largest error of end points and end velocities: {number(defect)}"
    return Claim("Thm 1", "GCP has the given ends and end velocities", measured, HOLDS if defect < ROUND_OFF else FAILS)


def symplectic(found: Measurements) -> Claim:
    """Proposition 2."""
    defect = found.geometry.symplectic
    measured = "largest entry of M^T W M - W, M the differential of a step, W the symplectic form: "
    measured += number(defect)
    verdict = HOLDS if defect < DIFFERENCE_BOUND else FAILS
    return Claim("Prop. 2", "both discretization maps give symplectic integrators", measured, verdict)


def general_hamiltonian(found: Measurements) -> Claim:
    """Judge the difficulty of the Hamiltonian on any St(n,k): the splittings are made of it."""
    distance, last = max(r.distance for r in found.shapes), found.shapes[-1]
    measured = f"cubics and splittings with it, {len(found.shapes)} manifolds up to St({last.n},{last.k}): largest "
    measured += f"distance {number(distance)}"
    verdict = f"{ANSWERED}: mu . x + p . p / 2 in a moving frame" if distance < ROUND_OFF else HOLDS
    return Claim("4.1", "a general expression for the Hamiltonian might be hard to find", measured, verdict)


def sphere_hamiltonian(found: Measurements) -> Claim:
    """Judge the Hamiltonian on the sphere."""
    difference = found.geometry.sphere_hamiltonian
    measured = f"largest relative difference to the one from the metric, {SAMPLES} random states: {number(difference)}"
    return Claim("4.1", "the Hamiltonian on the sphere", measured, HOLDS if difference < ROUND_OFF else FAILS)


def hamiltonian(found: Measurements) -> Claim:
    """Judge the Hamiltonian on St(3,2)."""
    one, two = found.geometry.hamiltonian
    measured = f"the same: {number(one)} with one bracket around both fractions, {number(two)} otherwise"
    if one < ROUND_OFF:
        verdict = HOLDS if two < ROUND_OFF else _only_if("one bracket spans its first two fractions")
    else:
        verdict = FAILS
    return Claim("4.1", "the Hamiltonian on St(3,2)", measured, verdict)


def below_euclidean(found: Measurements) -> Claim:
    """De Casteljau on curved and on flat manifolds."""
    last = [found.rows[e.name][-1].errors["gcp"] for e in EXPERIMENTS]
    flat = found.geometry.circle_error
    measured = (
        f"error {number(flat)} on the flat St(2,1), {number(last[0])} on the sphere, {number(last[1])} on St(3,2)"
    )
    holds = flat < ROUND_OFF < min(last)
    statement = "GCP is far less accurate here than in Euclidean space, even on the sphere"
    return Claim("4.3", statement, measured, HOLDS if holds else FAILS)


def _relative_error(found: Measurements, experiment: Experiment) -> Claim:
    """One of the paper's two percentages."""
    used = next(r for r in found.readings if r.experiment is experiment and r.name == readings.USED)
    values = [percent(used.errors[0] / divisor) for divisor in readings.divisors(experiment).values()]
    measured = f"{values[0]}; over 2 sqrt(k) {values[1]}; over pi {values[2]}"
    tried = len([pair for r in found.readings if r.experiment is experiment for pair in r.values()])
    printed = readings.PRINTED[experiment.name]
    statement = (
        f"relative mean error of GCP around {printed} {'in the sphere' if experiment is SPHERE else 'in St(3,2)'}"
    )
    divided, undivided = (readings.coincides(experiment, used.errors[0] / d) for d in (experiment.diameter, 1.0))
    if divided:
        verdict = HOLDS
    elif undivided:
        verdict = _only_if(f"undivided: {printed} coincides with the mean error itself")
    else:
        name, value = readings.nearest(found.readings, experiment)
        measured += f"; of {tried} readings the nearest gives {percent(value)} ({name})"
        matches = readings.coinciding(found.readings, experiment)
        verdict = _only_if(f"read as {matches[0][0]}") if matches else f"{FAILS} under any reading tried"
    return Claim("4.3", statement, measured, verdict)


def sphere_error(found: Measurements) -> Claim:
    """Judge the paper's 0.080 %."""
    return _relative_error(found, SPHERE)


def frame_error(found: Measurements) -> Claim:
    """Judge the paper's 0.45 %."""
    return _relative_error(found, STIEFEL_3_2)


def independent_of_the_step(found: Measurements) -> Claim:
    """GCP's error and the step."""
    spreads = []
    for e in EXPERIMENTS:
        values = constant_part(found.rows[e.name])
        spreads.append(max(values) / min(values) - 1)
    measured = f"mean error times (N + 1) / N: changes by {percent(max(spreads), 2)} over all N; the curve is the same"
    verdict = HOLDS if max(spreads) < CONSTANT else FAILS
    if len(found.settings.steps) < 2:
        measured, verdict = ONE_SIZE, OPEN
    return Claim("4.3", "the error of GCP does not depend on the step h", measured, verdict)


def increasing_in_the_step(found: Measurements) -> Claim:
    """Judge the integrators' errors and the step."""
    falls = True
    for e in EXPERIMENTS:
        for m in METHODS[1:]:
            errors = [r.errors[m] for r in found.rows[e.name]]
            falls &= all(b < a for a, b in itertools.pairwise(errors))
    orders = {
        m: [slope_text(found.rows[e.name], f"{m}_bvp") for e in EXPERIMENTS] for m in ("initial_point", "midpoint")
    }
    measured = "smaller at each larger N; slopes " if falls else "not smaller at each larger N; slopes "
    measured += (
        f"{' and '.join(orders['initial_point'])} (initial-point), {' and '.join(orders['midpoint'])} (mid-point)"
    )
    verdict = HOLDS if falls else FAILS
    if len(found.settings.steps) < 2:
        measured, verdict = ONE_SIZE, OPEN
    return Claim("4.3", "the integrators' error increases with h and tends to zero", measured, verdict)


def near_the_start(found: Measurements) -> Claim:
    """Judge the integrators near the initial point."""
    rows = found.near_start
    ahead = {m: [near_start.against_gcp(rows, e, m) for e in EXPERIMENTS] for m in METHODS[1:]}
    orders = {m: [near_start.of(rows, e, m).order or 0.0 for e in EXPERIMENTS] for m in near_start.COMPOSED}
    reached = all(abs(x - near_start.COMPOSED[m]) < ORDER_MARGIN for m, values in orders.items() for x in values)
    measured = f"error at t = {near_start.TIME:g}, GCP = 1: " + ", ".join(
        f"{LABELS[m]} {between(values)}" for m, values in ahead.items()
    )
    measured += f"; compositions have orders {between([x for values in orders.values() for x in values])}"
    winners = [m for m, values in ahead.items() if max(values) < 1]
    if not reached:
        verdict = FAILS
    elif len(winners) == len(ahead):
        verdict = HOLDS
    elif set(winners) >= {"midpoint_ivp", "midpoint_bvp"}:
        verdict = _only_if(f"the order is 2 or more (at N = {near_start.STEPS[-1]})")
    else:
        verdict = _only_if(f"by {', '.join(LABELS[m] for m in winners)}") if winners else FAILS
    statement = "integrators, not GCP, are ideal near the initial point, at any desired order"
    return Claim("4.3", statement, measured, verdict)


def better_retractions(found: Measurements) -> Claim:
    """Judge the conjecture as stated."""
    rows = conjecture.outcomes(found.study)
    paper, random = conjecture.totals(rows, PAPER), conjecture.totals(rows, "random")
    means = [r.mean for r in rows]
    measured = f"order 2, boundary values: {paper[0]} of {paper[1]} cases on its curves, {random[0]} of {random[1]} on "
    measured += f"random ones; mean ratio of the errors {between(means)}"
    if paper[0] == paper[1] and random[0] == random[1]:
        verdict = HOLDS
    else:
        verdict = "holds only on average, not in every case" if max(means) < 1 else FAILS
    statement = "conjecture: better retractions have smaller errors than the mid-point method"
    return Claim("4.3", statement, measured, verdict)


def midpoint_wins(found: Measurements) -> Claim:
    """Judge the mid-point against the initial-point map."""
    ratios = {p: [x for e in EXPERIMENTS for x in gains(found.rows[e.name], p)] for p in ("bvp", "ivp")}
    measured = f"error ratio {between(ratios['bvp'])} (boundary values), {between(ratios['ivp'])} (initial)"
    verdict = HOLDS if min(ratios["bvp"] + ratios["ivp"]) > MUCH else FAILS
    statement = "the mid-point map has a significantly lower error than the initial-point map"
    return Claim("4.3", statement, measured, verdict)


def _where_slower(found: Measurements) -> str:
    """Say under which condition the integrators take much longer than GCP, if they do with shooting."""
    slowest_first = reversed(found.settings.steps)
    initial = [t for t in found.timing if t.method in ("initial_point_ivp", "midpoint_ivp")]
    large = list(itertools.takewhile(lambda n: all(t.ratio > MUCH for t in initial if t.steps == n), slowest_first))
    return f"boundary values are met, or N is at least {large[-1]}" if large else "boundary values are met"


def more_effort(found: Measurements) -> Claim:
    """Judge times of initial value problems."""
    values = [r for m in ("initial_point_ivp", "midpoint_ivp") for r in timing.ratios(found.timing, m)]
    slower = sum(r > 1 for r in values)
    measured = f"initial values: {between(values)} times GCP's time, more in {slower} of {len(values)} cases"
    boundary = [r for m in timing.BOUNDARY_METHODS for r in timing.ratios(found.timing, m)]
    if min(values) > MUCH:
        verdict = HOLDS
    else:
        verdict = _only_if(_where_slower(found)) if min(boundary) > MUCH else FAILS
    return Claim("4.3", "the integrators need much more computational effort than GCP", measured, verdict)


def shooting(found: Measurements) -> Claim:
    """Judge the cost of shooting."""
    pairs = (("initial_point_bvp", "initial_point_ivp"), ("midpoint_bvp", "midpoint_ivp"))
    values = [r for pair in pairs for r in timing.over(found.timing, *pair)]
    measured = f"with shooting {between(values)} times the time without"
    return Claim("4.3", "shooting slows them down even further", measured, HOLDS if min(values) > 1 else FAILS)


def much_faster(found: Measurements) -> Claim:
    """GCP's time for boundary values."""
    same = [r for m in timing.BOUNDARY_METHODS for r in timing.ratios(found.timing, m)]
    equal = [x.ratio for x in found.equal_error if x.ratio is not None]
    exact = timing.ratios(found.timing, "exact_bvp")
    measured = f"integrators with shooting {between(same)} times GCP's time at equal N"
    measured += f", {between(equal)} at equal error; the exact cubic {between(exact)}" if equal else ""
    if min(same + equal) > MUCH:
        verdict = HOLDS
    else:
        verdict = _only_if("compared at equal N") if min(same) > MUCH else FAILS
    return Claim("4.3", "GCP is much faster for boundary values", measured, verdict)


def single_chart(found: Measurements) -> Claim:
    """Judge the first challenge."""
    rows = found.challenges.poles
    at_pole = {m: [challenges.of(rows, e, m, angle=0.0).error for e in EXPERIMENTS] for m in challenges.METHODS}
    reached = {m: [x for x in values if x is not None] for m, values in at_pole.items()}
    parts = [f"{name} {between(reached[m]) if reached[m] else 'fails'}" for m, name in challenges.METHODS.items()]
    measured = f"curve through the pole, N = {challenges.STEPS}: {', '.join(parts)}"
    answered = all(len(reached[m]) == len(EXPERIMENTS) for m in ("across", "splitting"))
    fails = len(reached["one_chart"]) < len(EXPERIMENTS)
    verdict = "holds for the chart method; answered by both others" if fails and answered else HOLDS if fails else FAILS
    return Claim("4.3", "challenge: a single chart only", measured, verdict)


def implicit_equations(found: Measurements) -> Claim:
    """Judge the second challenge."""
    rows = found.challenges.equal
    chart, across = (challenges.speed_up(rows, m) for m in ("one_chart", "across"))
    measured = f"at equal order and error, explicit splitting = 1: chart method {between(chart)}"
    measured += f", with changes of chart {between(across)} times the time"
    verdict = "holds; answered by the splittings" if min(chart) > MUCH else FAILS
    return Claim("4.3", "challenge: implicit equations make it very slow", measured, verdict)


def numerical_errors(found: Measurements) -> Claim:
    """Judge the other half of the second challenge, by the method with the smallest error."""
    method = list(near_start.COMPOSED)[-1]
    largest = [near_start.of(found.near_start, e, method).largest[-1] for e in EXPERIMENTS]
    measured = f"largest error of mid-point steps composed to order {near_start.COMPOSED[method]}, "
    measured += f"N = {near_start.STEPS[-1]}: {between(largest)}"
    verdict = f"{FAILS} on its curves: they stay at round-off" if max(largest) < ROUND_OFF else HOLDS
    return Claim("4.3", "challenge: implicit equations are subject to numerical errors", measured, verdict)


def homogeneous(found: Measurements) -> Claim:
    """Judge the first direction of improvement."""
    factors = challenges.speed_up(found.challenges.equal, "one_chart")
    measured = f"the splittings, for any St(n,k), are {between(factors)} times faster on both manifolds"
    statement = "the structure of a homogeneous space might improve performance"
    return Claim("4.3", statement, measured, HOLDS if min(factors) > 1 else FAILS)


def embedded(found: Measurements) -> Claim:
    """Judge the future work: order 2, constraints at round-off, and the cost compared with the splitting."""
    rows = found.embedded
    slopes = [embedding.slope(rows, manifold) for manifold in embedding.manifolds(rows)]
    orders, defect = [s for s in slopes if s is not None], embedding.largest_defect(rows)
    cost = challenges.speed_up(found.challenges.equal, challenges.EMBEDDED)
    if len(orders) < len(slopes):
        measured, verdict = ONE_SIZE, OPEN
    else:
        measured = f"slopes {between(orders, 3)} on {', '.join(embedding.manifolds(rows))}; constraints hold to "
        measured += f"{number(defect)}; {between(cost)} times the splitting's time at equal error on the paper's curves"
        reached = all(abs(s - embedding.ORDER) < ORDER_MARGIN for s in orders)
        verdict = "holds: it can be done" if reached and defect < ROUND_OFF else FAILS
        if verdict != FAILS and min(cost) > MUCH:
            verdict += ", but a splitting is much faster"
    return Claim("4.3", "future work: a submanifold of Euclidean space", measured, verdict)


def other_control_points(found: Measurements) -> Claim:
    """Judge the last sentence of the discussion."""
    factors = {
        degree: [
            control_points.of(found.control_points, e, "gcp").error
            / control_points.of(found.control_points, e, f"minimal_cost_{degree}").error
            for e in EXPERIMENTS
        ]
        for degree in (control_points.DEGREES[0], control_points.DEGREES[-1])
    }
    measured = "error of GCP over the error with control points of least cost: " + ", ".join(
        f"{between(values)} (degree {degree})" for degree, values in factors.items()
    )
    holds = min(x for values in factors.values() for x in values) > 1
    return Claim("4.3", "an alternative choice of control points", measured, "holds: it helps" if holds else FAILS)


CLAIMS: Final[tuple[Callable[[Measurements], Claim], ...]] = (
    euler_lagrange,
    quasi_geodesics,
    remark,
    joining,
    end_data,
    symplectic,
    general_hamiltonian,
    sphere_hamiltonian,
    hamiltonian,
    below_euclidean,
    sphere_error,
    frame_error,
    independent_of_the_step,
    increasing_in_the_step,
    near_the_start,
    better_retractions,
    midpoint_wins,
    more_effort,
    shooting,
    much_faster,
    single_chart,
    implicit_equations,
    numerical_errors,
    homogeneous,
    embedded,
    other_control_points,
)
HEADER: Final = ["place", "the paper", "measured", "verdict"]
CSV_HEADER: Final = ["claim", *HEADER]


def read(found: Measurements) -> list[Claim]:
    """All claims, in the order of the paper."""
    return [claim(found) for claim in CLAIMS]


def page(claims: list[Claim]) -> str:
    """Return the table of the first page."""
    cells = [[str(n), c.place, c.statement, c.measured, f"**{c.verdict}**"] for n, c in enumerate(claims, 1)]
    return table(["no.", *HEADER], cells, 1 + len(HEADER))


def csv_rows(found: Measurements) -> list[tuple[str, ...]]:
    """Return the rows of ``claims.csv``: the name of the claim, then the columns of the page."""
    return [(claim.__name__, *astuple(claim(found))) for claim in CLAIMS]
