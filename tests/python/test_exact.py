"""The exact cubic compared with the paper's curves: chart and chart-free solutions, costs, tables and text."""

import numpy as np
import pytest

from stiefel_rs import RiemannianCubic, Stiefel, integrate_cubic
from stiefel_rs.reproduce import exact, experiments
from stiefel_rs.reproduce.text import percent

# Agreement of chart and chart-free solutions: ten times the error of the reference in the chart.
AGREEMENT = 1e-12
each_experiment = pytest.mark.parametrize("experiment", experiments.EXPERIMENTS, ids=lambda e: e.name)


@pytest.fixture(scope="module")
def found():
    return exact.measure()


def assert_states_agree(experiment, z, covariant, what):
    """Compare points and covariant derivatives on the manifold, and the chart states computed from them."""
    for name, own, known in zip("SVAJ", covariant, experiment.chart.covariant(z), strict=True):
        np.testing.assert_allclose(own, known, rtol=0, atol=AGREEMENT, err_msg=f"{what}, {name}")
    # A state contains angles, which are determined up to whole turns.
    back = np.array([experiment.chart.state(*data) for data in zip(*covariant, strict=True)])
    d = experiment.chart.d
    difference = back - z
    difference[..., :d] -= 2 * np.pi * np.round(difference[..., :d] / (2 * np.pi))
    np.testing.assert_allclose(difference, 0, atol=AGREEMENT, err_msg=f"{what}, state")


@each_experiment
def test_initial_data_go_from_the_chart_and_back(experiment):
    z = experiments.reference(experiment, 20)
    assert_states_agree(experiment, z, experiment.chart.covariant(z), "round trip")


@each_experiment
def test_chart_free_solutions_are_those_of_the_chart(experiment):
    z, t = experiments.reference(experiment, 100), experiments.time_grid(100)
    initial = experiment.chart.covariant(z[0])
    cubics = {
        "initial": RiemannianCubic.from_initial(*initial),
        "boundary": RiemannianCubic.from_boundary(*experiments.boundary_data(experiment, z[0], z[-1]), tol=1e-13),
    }
    for name, c in cubics.items():
        assert_states_agree(experiment, z, (c(t), c.velocity(t), c.acceleration(t), c.jerk(t)), name)
    for order in (6, 8):
        found = integrate_cubic(*initial, 100, order=order)
        covariant = (found.point, found.velocity, found.acceleration, found.jerk)
        assert_states_agree(experiment, z, covariant, f"splitting of order {order}")


def test_the_boundary_problem_finds_the_papers_curve(found):
    for c in found:
        assert max(c.agreement.point, c.agreement.acceleration, c.agreement.jerk) < AGREEMENT
        # Steps with kept linear equations: the sphere takes 6, St(3,2) 10.
        assert c.agreement.residual <= experiments.BOUNDARY_TOLERANCE and c.agreement.iterations <= 10


@each_experiment
def test_cost_of_the_exact_cubic_is_that_of_the_reference(experiment):
    nodes, weights = np.polynomial.legendre.leggauss(40)
    z = experiment.chart.reference(experiments.initial_state(experiment), np.concatenate([[0.0], (1 + nodes) / 2]))[1:]
    start, end = experiments.reference(experiment, 1)
    cubic = experiments.exact_cubic(experiment, start, end)
    squares = exact.squared_acceleration(experiment, z)
    # The reference's 1e-13, times the 2 of a square.
    assert cubic.cost() == pytest.approx(float(weights @ squares) / 2, rel=1e-12)
    accelerations = cubic.acceleration((1 + nodes) / 2)
    norms = Stiefel(3, experiment.chart.k).norm(cubic((1 + nodes) / 2), accelerations)
    np.testing.assert_allclose(squares, norms**2, rtol=1e-11)


def test_trapezoid():
    t = experiments.time_grid(7)
    assert exact.trapezoid(3 * t + 1) == pytest.approx(2.5, rel=1e-15)
    # h^2 / 12 times the second derivative.
    assert exact.trapezoid(t**2) == pytest.approx(1 / 3 + 1 / (6 * 49), rel=1e-14)


def test_costs(found):
    for c in found:
        gcp = c.of("gcp")
        assert gcp.excess > 0 and gcp.error > 1e-5
        for n in exact.COST_STEPS:
            # The errors of both orders at N = 10.
            for order, bound in ((6, 1e-11), (8, 1e-13)):
                assert c.of(f"splitting_{order}", n).cost == pytest.approx(c.of("exact_sum", n).cost, rel=bound)
    sphere, frame = found
    assert sphere.of("geodesic_cubic").excess == pytest.approx(sphere.of("gcp").excess, rel=exact.SAME_EXCESS)
    assert 0 < frame.of("geodesic_cubic").excess < frame.of("gcp").excess / 1000
    # A relative excess of 8.2494e-3 and 5.758e-6: from the cost of the Taylor reference in the chart, by Gauss
    # quadrature.
    assert frame.of("gcp").excess == pytest.approx(8.2494e-3, rel=1e-4)
    assert sphere.of("gcp").excess == pytest.approx(5.758e-6, rel=1e-3)


@each_experiment
def test_sums_of_discrete_trajectories_have_the_order_of_their_method(experiment):
    start, end = experiments.reference(experiment, 1)
    least = experiments.exact_cubic(experiment, start, end).cost()
    errors = {}
    for steps in (200, 400, 800):
        for name, _, squares in exact._discrete(experiment, start, end, steps):
            errors.setdefault(name, []).append(abs(exact.trapezoid(squares) - least))
    for name, found in errors.items():
        expected = 1 if name.startswith("initial_point") else 2
        np.testing.assert_allclose(np.log2(np.divide(found[:-1], found[1:])), expected, atol=0.2, err_msg=name)


def test_rows_and_section(found):
    rows = {e.name: [experiments.mean_errors(e, n) for n in (5, 10)] for e in experiments.EXPERIMENTS}
    table = exact.csv_rows(found)
    assert len(table) == 2 * (3 + 9 * len(exact.COST_STEPS))
    assert all(len(row) == len(exact.HEADER) for row in table)
    text = exact.section(found, rows)
    assert text.startswith("### The exact cubic")
    assert text.count("is the paper's curve") == 2 and "nan" not in text.lower()
    for c in found:
        assert percent(c.of("gcp").excess) in text


def test_another_curve_is_called_so(found):
    far = exact.Agreement(3, 1e-15, 1e-3, 1.0, 1.0)
    changed = [exact.Comparison(c.experiment, far, c.costs) for c in found]
    assert exact._same(changed).count("another curve than the paper's") == 2


def test_slopes_leave_round_off_out():
    def slope(*errors):
        rows = [experiments.ErrorRow(n, {"m": x}) for n, x in zip((5, 10, 20), errors, strict=True)]
        return experiments.slope(rows, "m")

    assert slope(1e-10, 1e-12, 3e-16) == pytest.approx(np.log2(100))
    assert slope(1e-10, 1e-15, 3e-16) is None
    assert slope(3e-16, 0.0, 0.0) is None
