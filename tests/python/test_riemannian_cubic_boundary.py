"""Riemannian cubics from boundary data: their ends, the paper's problems, reports, threads, Ctrl-C, bad input."""

import json
import pickle
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.boundary import random_problems
from stiefel_rs import (
    ConvergenceError,
    GeometricCubic,
    Grassmann,
    InvalidInputError,
    OutsideDomainError,
    RiemannianCubic,
    SolverReport,
    Stiefel,
    StiefelError,
    skew_exp,
)
from stiefel_rs.reproduce.experiments import EXPERIMENTS, initial_state

EPS = np.finfo(float).eps
DATA = json.loads((Path(__file__).parents[1] / "data" / "cubics.json").read_text())
STATE = ["point", "velocity", "acceleration", "jerk"]
# Tolerance of the solver; the defect measured here uses other norms and has its own round-off.
TOL = 1e-12


def assert_close(measured, exact, bound, what):
    error = np.max(np.abs(np.asarray(measured) - exact), initial=0.0)
    assert error <= bound, f"{what}: error {error:.3e} exceeds {bound:.3e}"


def numbers(entry):
    return [np.array([[float(x) for x in row] for row in entry[name]]) for name in STATE]


def random_boundary(n, k, rng, distance=1.0, speed=1.0):
    M = Stiefel(n, k)

    def tangent(S, length):
        V = M.random_tangent(S, rng)
        V *= length / (M.norm(S, V) or 1.0)
        # A short vector, lengthened, is tangent to less than the round-off of its new length.
        return V - S @ (S.T @ V + V.T @ S) / 2

    S0 = M.random_point(rng)
    S1 = M.retract(S0, tangent(S0, distance))
    return S0, tangent(S0, speed), S1, tangent(S1, speed)


def assert_meets(curve, ends, what=""):
    S0, V0, S1, V1 = ends
    defect = np.sqrt(np.sum((curve(1.0) - S1) ** 2) + np.sum((curve.velocity(1.0) - V1) ** 2))
    assert defect <= 2 * TOL, f"{what}: the end is off by {defect:.2e}"
    bound = 50 * curve.n * EPS * (1 + np.abs(V0).max())
    assert_close(curve(0.0), S0, bound, f"{what}: start")
    assert_close(curve.velocity(0.0), V0, bound, f"{what}: velocity at the start")


def test_boundary_data_are_met(boundary):
    curve = RiemannianCubic.from_boundary(*boundary)
    assert curve.t_span == (0.0, 1.0)
    assert_meets(curve, boundary)
    report = curve.report
    assert isinstance(report, SolverReport)
    assert report.converged
    assert report.reason == "converged"
    assert report.residual <= report.tolerance == TOL
    assert report.iterations <= 12
    # The same curve as an initial value problem.
    again = RiemannianCubic.from_initial(*curve.initial)
    t = np.linspace(0, 1, 5)
    assert_close(again(t), curve(t), 100 * curve.n * EPS, "from its own initial data")


def test_forty_digit_data():
    for entry in DATA:
        start, end = numbers(entry["initial"]), numbers(entry["at"]["1.0"])
        curve = RiemannianCubic.from_boundary(*start[:2], *end[:2])
        middle = numbers(entry["at"]["0.5"])
        name = f"St({entry['n']}, {entry['k']})"
        assert_meets(curve, (*start[:2], *end[:2]), name)
        # Errors at the end are magnified by the inverse derivative of the flow.
        assert_close(curve.initial[2], start[2], 1e-11 * (1 + np.abs(start[2]).max()), f"{name}: acceleration")
        assert_close(curve.initial[3], start[3], 1e-10 * (1 + np.abs(start[3]).max()), f"{name}: jerk")
        assert_close(curve(0.5), middle[0], 1e-11, f"{name}: middle")


@pytest.mark.parametrize("experiment", EXPERIMENTS, ids=lambda e: e.name)
def test_the_papers_problems(experiment):
    chart, d = experiment.chart, experiment.chart.d
    z0 = initial_state(experiment)
    t = np.linspace(0, 1, 11)
    z = chart.reference(z0, t)
    q, qdot = z[:, :d], z[:, d : 2 * d]
    S, V = chart.embed(q), chart.embed_velocity(q, qdot)
    curve = RiemannianCubic.from_boundary(S[0], V[0], S[-1], V[-1])
    assert_close(curve(t), S, 2e-12, "the chart's reference")
    assert_close(curve.velocity(t), V, 1e-11, "velocities of the chart's reference")
    # Shooting in the chart has the same ends, with a second-order error in between.
    errors = []
    for steps in [20, 40, 80]:
        shot = chart.shoot(q[0], qdot[0], q[-1], qdot[-1], steps, "midpoint").trajectory
        exact = curve(np.linspace(0, 1, steps + 1))
        errors.append(np.linalg.norm(chart.embed(shot[:, :d]) - exact, axis=(-2, -1)).mean())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all(np.abs(orders - 2) < 0.1), f"errors {errors}, orders {orders}"


@pytest.mark.parametrize("size", [(3, 1), (3, 2), (5, 2), (6, 3)])
def test_it_costs_less_than_de_casteljau(size):
    # Cubics are stationary, not minimal: this holds for data as moderate as these.
    for seed in range(25):
        rng = np.random.default_rng([seed, *size])
        S0, V0, S1, V1 = random_boundary(*size, rng, rng.uniform(0.0, 2.0))
        ends = (S0, rng.uniform(0.0, 2.0) * V0, S1, rng.uniform(0.0, 2.0) * V1)
        exact, close = RiemannianCubic.from_boundary(*ends), GeometricCubic(*ends)
        # Costs are accurate to 1e-12.
        ratio = exact.cost() / close.cost()
        assert ratio <= 1 + 2e-12, f"seed {seed}: {ratio - 1:.2e} above"


def test_run_backwards(boundary):
    S0, V0, S1, V1 = boundary
    curve, back = RiemannianCubic.from_boundary(*boundary), RiemannianCubic.from_boundary(S1, -V1, S0, -V0)
    t = np.linspace(0, 1, 7)
    assert_close(back(t), curve.reversed()(t), 1e-10, "boundary data exchanged")


def test_isometries(manifold, boundary, rng):
    g = np.linalg.qr(rng.standard_normal((manifold.n, manifold.n)))[0]
    q = np.linalg.qr(rng.standard_normal((manifold.k, manifold.k)))[0]
    curve = RiemannianCubic.from_boundary(*boundary)
    moved = RiemannianCubic.from_boundary(*(g @ x @ q for x in boundary))
    t = np.linspace(0, 1, 5)
    assert_close(moved(t), g @ curve(t) @ q, 1e-10, "moved by isometries")


def test_special_cases(manifold, rng):
    S = manifold.random_point(rng)
    zero = np.zeros_like(S)
    still = RiemannianCubic.from_boundary(S, zero, S, zero)
    assert_close(still([0.0, 0.5, 1.0]), S, 1e-12, "nothing to do")
    assert still.cost() < 1e-20
    V = manifold.random_tangent(S, rng)
    V = V / manifold.norm(S, V)
    end, there = manifold.exp(S, V), manifold.transport(S, V, V)
    straight = RiemannianCubic.from_boundary(S, V, end, there)
    assert straight.cost() < 1e-20, "a geodesic is a cubic without cost"


def test_pickles_keep_the_report(boundary):
    curve = RiemannianCubic.from_boundary(*boundary)
    again = pickle.loads(pickle.dumps(curve))
    assert again.report.residual == curve.report.residual
    assert again.report.iterations == curve.report.iterations
    t = np.linspace(0, 1, 5)
    assert_close(again(t), curve(t), 100 * curve.n * EPS, "pickled")


def test_guesses_are_any_pair(boundary):
    curve = RiemannianCubic.from_boundary(*boundary)
    _, _, A, J = curve.initial
    known = RiemannianCubic.from_boundary(*boundary, guess=(A, J))
    for guess in ([A, J], np.stack([A, J]), iter([A, J])):
        found = RiemannianCubic.from_boundary(*boundary, guess=guess, all_found=np.False_)
        assert found.report.iterations == known.report.iterations
        assert np.array_equal(found(0.5), known(0.5))
    for wrong in ((A,), (A, J, J), np.stack([A, J, J]), ()):
        with pytest.raises(InvalidInputError, match="guess: expected two items"):
            RiemannianCubic.from_boundary(*boundary, guess=wrong)
    with pytest.raises(TypeError):
        RiemannianCubic.from_boundary(*boundary, guess=3)


def test_numbers_of_any_size(boundary):
    curve = RiemannianCubic.from_boundary(*boundary, max_iterations=2**63)
    assert curve.report.converged
    with pytest.raises(InvalidInputError, match="max_iterations: must be at least 1"):
        RiemannianCubic.from_boundary(*boundary, max_iterations=-(2**70))
    with pytest.raises(TypeError):
        RiemannianCubic.from_boundary(*boundary, max_iterations=2.0)


def test_conjugate_ends_are_told():
    # At rest at both ends of a half great circle: a family of solutions.
    e = np.eye(3)
    zero = np.zeros((3, 1))
    curve = RiemannianCubic.from_initial(e[:, :1], zero, 6 * np.pi * e[:, 1:2], -12 * np.pi * e[:, 1:2])
    aside = (zero, zero, e[:, 2:], zero)
    for call in (lambda: curve.initial_variation(*aside), lambda: curve.point_variation(0.5, *aside)):
        with pytest.raises(OutsideDomainError, match="conjugate") as caught:
            call()
        assert caught.value.angle is None
    assert np.isfinite(curve.cost_gradient()).all()


def test_errors_of_the_iteration():
    ends = random_boundary(4, 2, np.random.default_rng(1), 2.0, 2.0)
    with pytest.raises(ConvergenceError) as caught:
        RiemannianCubic.from_boundary(*ends, max_iterations=1)
    report = caught.value.report
    assert not report.converged
    assert report.iterations == 1
    assert report.reason == "max_iterations"
    assert report.residual > report.tolerance == TOL
    loose = RiemannianCubic.from_boundary(*ends, tol=1e-3)
    assert 0 < loose.report.residual <= 1e-3
    assert loose.report.tolerance == 1e-3


def test_reports_say_what_found_the_solution():
    near, far = (random_boundary(3, 2, np.random.default_rng(0), *size) for size in ((1.0, 1.0), (3.0, 12.0)))
    direct, descent = (RiemannianCubic.from_boundary(*ends) for ends in (near, far))
    assert direct.report.strategy == "direct"
    assert descent.report.strategy == "descent"
    # A solution as a guess needs no descent.
    guess = (descent.acceleration(0.0), descent.jerk(0.0))
    assert RiemannianCubic.from_boundary(*far, guess=guess).report.strategy == "direct"
    found = RiemannianCubic.from_boundary(*far, all_found=True)
    assert {curve.report.strategy for curve in found} >= {"descent", "continuation"}
    assert found[0].cost() == pytest.approx(descent.cost(), rel=1e-9)
    for curve in (direct, descent, found[-1]):
        again = pickle.loads(pickle.dumps(curve))
        assert again.report.strategy == curve.report.strategy
        assert repr(again.report) == repr(curve.report)
        assert repr(pickle.loads(pickle.dumps(curve.report))) == repr(curve.report)
    plain = SolverReport(True, 1, 0.0, 1e-12, "converged")
    assert plain.strategy is None
    assert SolverReport(True, 1, 0.0, 1e-12, "converged", "descent").strategy == "descent"
    with pytest.raises(InvalidInputError, match="strategy: unknown strategy 'luck'"):
        SolverReport(True, 1, 0.0, 1e-12, "converged", "luck")
    with pytest.raises(ConvergenceError) as caught:
        RiemannianCubic.from_boundary(*near, max_iterations=1)
    assert caught.value.report.strategy is None


@pytest.mark.parametrize("tol", [-1e-12, 0.0, 1e-16, 0.5, np.nan, np.inf])
def test_bad_tolerances(tol, boundary):
    with pytest.raises(InvalidInputError, match=r"^tol: must be between 1e-15 and 0\.1"):
        RiemannianCubic.from_boundary(*boundary, tol=tol)


def test_bad_iterations(boundary):
    with pytest.raises(InvalidInputError, match="max_iterations: must be at least 1"):
        RiemannianCubic.from_boundary(*boundary, max_iterations=0)
    with pytest.raises(TypeError):
        RiemannianCubic.from_boundary(*boundary, max_iterations=1.5)


@pytest.mark.parametrize("i", range(4))
def test_bad_matrices(i):
    ends = list(random_boundary(5, 2, np.random.default_rng(2)))
    name = ["S0", "V0", "S1", "V1"][i]

    def replaced(value):
        values = ends.copy()
        values[i] = value
        return RiemannianCubic.from_boundary(*values)

    for bad in [np.nan, np.inf]:
        value = ends[i].copy()
        value[-1, -1] = bad
        with pytest.raises(InvalidInputError, match=f"{name}: .*not finite"):
            replaced(value)
    for value in [ends[i][:-1], ends[i][:, :1], ends[i][None], ends[i][0], np.zeros((0, 0)), np.zeros((5, 0)), 1.0]:
        with pytest.raises(InvalidInputError):
            replaced(value)
    for value in [ends[i].astype(object), ends[i].astype(str), None, "text", object()]:
        with pytest.raises(TypeError):
            replaced(value)
    point = ends[i - i % 2]
    with pytest.raises(InvalidInputError, match=rf"{name}: .* exceeds"):
        replaced(ends[i] + 1e-3 * point)


def test_different_components():
    zero = np.zeros((3, 3))
    with pytest.raises(OutsideDomainError, match="components") as caught:
        RiemannianCubic.from_boundary(np.eye(3), zero, np.diag([1.0, 1.0, -1.0]), zero)
    assert caught.value.angle == np.pi


def test_antipodal_points():
    # No unique quasi-geodesic is the shortest between them, but cubics join them.
    S0, V = np.eye(3)[:, :1], np.eye(3)[:, 1:2]
    ends = (S0, V, -S0, V)
    try:
        assert_meets(RiemannianCubic.from_boundary(*ends), ends, "antipodal")
    except (ConvergenceError, OutsideDomainError) as error:
        assert str(error)


SIZES = st.sampled_from([(3, 1), (3, 2), (4, 2), (5, 2), (6, 3), (3, 3), (2, 1)])


@settings(max_examples=100, deadline=None)
@given(size=SIZES, seed=st.integers(0, 2**32 - 1), distance=st.floats(0.0, 1.5), speed=st.floats(0.0, 1.5))
def test_close_and_slow_problems_all_converge(size, seed, distance, speed):
    ends = random_boundary(*size, np.random.default_rng(seed), distance, speed)
    curve = RiemannianCubic.from_boundary(*ends)
    assert_meets(curve, ends, f"St{size}")
    assert curve.report.iterations <= 20


@settings(max_examples=40, deadline=None)
@given(
    size=SIZES,
    seed=st.integers(0, 2**32 - 1),
    speeds=st.tuples(*[st.sampled_from([0.0, 1e-300, 1e-160, 1.0, 30.0, 1e4, 1e150, 1e300])] * 2),
)
def test_any_data_give_a_curve_or_a_typed_error(size, seed, speeds):
    S0, V0, S1, V1 = random_boundary(*size, np.random.default_rng(seed), 2.0, 1.0)
    try:
        curve = RiemannianCubic.from_boundary(S0, speeds[0] * V0, S1, speeds[1] * V1)
        assert np.all(np.isfinite(curve.velocity([0.0, 0.5, 1.0])))
        # For fast curves the remaining error may be round-off, up to 1e-9.
        assert curve.report.residual <= curve.report.tolerance <= 1e-9
    except StiefelError as error:
        assert max(speeds) > 1.0, f"moderate data refused: {error}"


def test_a_hundred_thousand_solves_in_threads():
    rng = np.random.default_rng(3)
    problems = [random_boundary(3, 1, rng, rng.uniform(0, 2), rng.uniform(0, 2)) for _ in range(200)]
    expected = [RiemannianCubic.from_boundary(*ends).initial[3] for ends in problems]
    for ends in problems:
        assert_meets(RiemannianCubic.from_boundary(*ends), ends)

    def work(i):
        return np.array_equal(RiemannianCubic.from_boundary(*problems[i % 200]).initial[3], expected[i % 200])

    with ThreadPoolExecutor(4) as pool:
        wrong = sum(not same for same in pool.map(work, range(100_000), chunksize=1000))
    assert wrong == 0, f"{wrong} of 100000 differ"


def test_guess_and_all_found():
    """The solver starts from a guess; several solutions are sorted by cost, and include the usual one."""
    sphere = Stiefel(3, 1)
    S0, S1 = np.eye(3)[:, :1], np.eye(3)[:, 1:2]
    V0, V1 = 4 * np.eye(3)[:, 2:], 4 * np.eye(3)[:, 2:]
    curve = RiemannianCubic.from_boundary(S0, V0, S1, V1)
    again = RiemannianCubic.from_boundary(S0, V0, S1, V1, guess=curve.initial[2:])
    assert again.report.iterations <= min(3, curve.report.iterations)
    found = RiemannianCubic.from_boundary(S0, V0, S1, V1, all_found=True)
    assert len(found) > 1
    costs = [one.cost() for one in found]
    assert costs == sorted(costs)
    assert min(abs(cost / curve.cost() - 1) for cost in costs) < 1e-9
    for one in found:
        assert_meets(one, (S0, V0, S1, V1))
        assert sphere.norm(one(0.5), one.velocity(0.5)) > 0
    with pytest.raises(InvalidInputError, match="A"):
        RiemannianCubic.from_boundary(S0, V0, S1, V1, guess=(S0, V0))


def family(shape, rng):
    """Boundary data as functions of one parameter: everything rotated and scaled by exponentials."""
    n, k = shape
    S0, V0, S1, V1 = random_boundary(n, k, rng, 1.0, 1.5)
    skews = [a - a.T for a in 0.2 * rng.standard_normal((2, n, n))]

    def data(e):
        turned = []
        for S, V, A in ((S0, V0, skews[0]), (S1, V1, skews[1])):
            Q = skew_exp(e * A)
            turned += [Q @ S, (1 + e) * Q @ V]
        return turned

    derivative = [skews[0] @ S0, V0 + skews[0] @ V0, skews[1] @ S1, V1 + skews[1] @ V1]
    return data, derivative


@pytest.mark.parametrize("shape", [(3, 1), (3, 2), (5, 2), (6, 3), (12, 2)], ids=str)
def test_derivatives_agree_with_differences(shape):
    """Exact derivatives of the solution; central differences of order 4 with their error of about 1e-8."""
    data, derivative = family(shape, np.random.default_rng(7))
    curve = RiemannianCubic.from_boundary(*data(0.0))
    h = 2e-3
    t = np.linspace(0, 1, 4)

    def difference(f):
        values = [np.asarray(f(RiemannianCubic.from_boundary(*data(x * h)))) for x in (-2, -1, 1, 2)]
        return (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * h)

    for i, exact in enumerate(curve.initial_variation(*derivative)):
        error = np.abs(exact - difference(lambda one, i=i: one.initial[i])).max()
        assert error < 1e-6 * max(1, np.abs(exact).max()), f"initial datum {i}: {error:.2e}"
    error = np.abs(curve.point_variation(t, *derivative) - difference(lambda one: one(t))).max()
    assert error < 1e-7, f"points: {error:.2e}"
    change = sum((g * d).sum() for g, d in zip(curve.cost_gradient(), derivative, strict=True))
    error = abs(change - difference(lambda one: one.cost()))
    assert error < 1e-6 * max(1, abs(change)), f"cost: {error:.2e}"


def test_hard_problems_that_no_quick_start_solves():
    """Two problems of `make boundary` on St(10, 3), from both ends, which take many steps."""
    M, family = Stiefel(10, 3), random_problems.FAMILIES[1]
    rng = np.random.default_rng([20240419, M.n, M.k, int(family.speed)])
    drawn = [random_problems.problem(M, family, rng) for _ in range(178)]
    for S0, V0, S1, V1 in (drawn[48], drawn[177]):
        there = RiemannianCubic.from_boundary(S0, V0, S1, V1)
        back = RiemannianCubic.from_boundary(S1, -V1, S0, -V0)
        assert there.cost() == pytest.approx(back.cost(), rel=1e-9)


@pytest.mark.parametrize("size", [(4, 2), (6, 3)], ids=str)
def test_moderate_solutions_are_one_polynomial(size):
    M, rng = Stiefel(*size), np.random.default_rng(3)
    for _ in range(20):
        curve = RiemannianCubic.from_boundary(*random_problems.problem(M, random_problems.FAMILIES[0], rng))
        assert curve.steps == 1
        again = RiemannianCubic.from_initial(*curve.initial)
        assert_close(curve.jerk([0, 0.4, 1]), again.jerk([0, 0.4, 1]), 1e-11, "jerk")


def test_solutions_continue_as_accurately_as_curves_from_initial_data():
    """Far beyond an end, where tension lets the curve grow fast."""
    M, rng = Grassmann(5, 2), np.random.default_rng(0)

    def vector(Y, length):
        V = M.random_tangent(Y, rng=rng)
        return V * (length / M.norm(Y, V))

    Y0 = M.random_point(rng=rng)
    Y1 = M.exp(Y0, vector(Y0, 1))
    curve = RiemannianCubic.from_boundary(Y0, vector(Y0, 3), Y1, vector(Y1, 3), manifold=M, tension=50.0)
    again = RiemannianCubic.from_initial(*curve.initial, tension=50.0, manifold=M)
    # Round-off grows by exp(sqrt(50) |t|).
    assert_close(curve(-1.0) @ curve(-1.0).T, again(-1.0) @ again(-1.0).T, 1e-9, "points")
    Y = curve(-1.6)
    assert_close(Y.T @ Y, np.eye(2), 1e-12, "orthonormality")


def test_variations_in_short_units_of_time():
    """The velocity vanishes half way; its round-off is large in a short unit of time."""
    M, rng = Stiefel(4, 2), np.random.default_rng(1)
    S, zero = M.random_point(rng), np.zeros((4, 2))
    V = M.random_tangent(S, rng)
    half = RiemannianCubic.from_boundary(S, V, S, -V).restricted(0.5, 1.0).reparametrised(0.0, 1.0)
    dS = M.random_tangent(half(0.0), rng)
    expected = half.point_variation(0.3, dS, zero, zero, zero)
    short = half.reparametrised(0.0, 1e-9).point_variation(0.3e-9, dS, zero, zero, zero)
    assert_close(short, expected, 1e-12, "variation")
