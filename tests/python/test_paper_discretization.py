"""Section 4 of arXiv 2404.19407 as printed: discretization maps, their cotangent lifts, Proposition 2."""

import itertools

import numpy as np
import paper_charts
import pytest
from paper import EPS, assert_close, difference

from stiefel_rs import Chart
from stiefel_rs.reproduce import experiments

CHARTS = {"sphere": Chart.sphere(), "frame": Chart.frame()}
HAMILTONIANS = {"sphere": paper_charts.sphere_hamiltonian, "frame": paper_charts.frame_hamiltonian}
EXPERIMENTS = {"sphere": experiments.SPHERE, "frame": experiments.STIEFEL_3_2}
# Maps whose first point is the given one.
FROM_THE_START = ["initial_point", "exponential", "cayley", "quasi_geodesic"]
MAPS = [*FROM_THE_START, "midpoint", "exponential_midpoint", "cayley_midpoint", "quasi_geodesic_midpoint"]


@pytest.fixture(params=CHARTS)
def name(request):
    return request.param


@pytest.fixture
def chart(name):
    return CHARTS[name]


@pytest.fixture(params=["random", "equator at rest"])
def x(request, chart, rng):
    """A position and a velocity of the chart: a point of TS, which is the paper's Q here."""
    x = rng.uniform(0.5, 1.0, 2 * chart.d)
    if request.param != "random":
        x[0], x[chart.d :] = np.pi / 2, 0.0
    return x


@pytest.fixture
def v(chart, rng):
    return rng.uniform(-0.3, 0.3, 2 * chart.d)


@pytest.mark.parametrize("step_map", MAPS)
def test_definition_2_discretization_map(chart, x, v, step_map):
    start, end = chart.discretize(x, 0 * v, step_map)
    assert_close(start, x, 16 * EPS, "R^1(q, 0) = q")
    assert_close(end, x, 16 * EPS, "R^2(q, 0) = q")
    slope = difference(lambda t: chart.discretize(x, t * v, step_map), 0.0)
    # Truncation h^4 / 30 times the fifth derivative, round-off eps / h.
    assert_close(slope[1] - slope[0], v, 1e-11 + 64 * EPS / 1e-3, "T R^2 - T R^1 is the identity")


@pytest.mark.parametrize("step_map", MAPS)
def test_definition_2_local_diffeomorphism(chart, x, step_map):
    half = 2 * chart.d
    rates = [difference(lambda t, e=e: chart.discretize(x, t * e, step_map), 0.0) for e in np.eye(half)]
    first, second = (np.stack([rate[i] for rate in rates], axis=1) for i in (0, 1))
    jacobian = np.block([[np.eye(half), first], [np.eye(half), second]])
    assert_close(np.linalg.det(jacobian), 1.0, half * (1e-11 + 64 * EPS / 1e-3), "determinant at the zero section")


@pytest.mark.parametrize("step_map", FROM_THE_START)
def test_definition_2_with_the_first_point_fixed_is_definition_1(chart, x, v, step_map):
    start, end = chart.discretize(x, v, step_map)
    assert_close(start, x, 16 * EPS, "R^1(q, v) = q")
    assert np.abs(end - x).max() > 0.01
    assert_close(chart.discretize(x, 0 * v, step_map)[1], x, 16 * EPS, "(i) R_S(0) = S")
    slope = difference(lambda t: chart.discretize(x, t * v, step_map)[1], 0.0)
    assert_close(slope, v, 1e-11 + 64 * EPS / 1e-3, "(ii) dR_S(0) = I")


def test_example_1_initial_point(chart, x, v):
    assert_close(chart.discretize(x, v, "initial_point"), [x, x + v], EPS, "R_d(q, v) = (q, q + v)")


def test_example_2_midpoint(chart, x, v):
    assert_close(chart.discretize(x, v, "midpoint"), [x - v / 2, x + v / 2], EPS, "R_d(q, v) = (q - v/2, q + v/2)")


def midpoint_lift(q, p, dq, dp):
    return q - dq / 2, p - dp / 2, q + dq / 2, p + dp / 2


def initial_point_lift(q, p, dq, dp):
    return q, p - dp, q + dq, p


LIFTS = {"midpoint": midpoint_lift, "initial_point": initial_point_lift}


@pytest.mark.parametrize("step_map", LIFTS)
def test_example_3_lift_is_symplectic(step_map):
    m = 3
    zero, one = np.zeros((m, m)), np.eye(m)
    columns = [np.concatenate(LIFTS[step_map](*e.reshape(4, m))) for e in np.eye(4 * m)]
    A = np.stack(columns, axis=1)
    omega = np.block([[zero, one], [-one, zero]])
    product = np.block([[-omega, 0 * omega], [0 * omega, omega]])
    # dq ^ d(dp) + d(dq) ^ dp in the order (q, p, dq, dp).
    lifted = np.block([[0 * omega, omega], [omega, 0 * omega]])
    assert_close(A.T @ product @ A, lifted, 0.0, "pull-back of Omega_12 against d_T omega")


@pytest.mark.parametrize("step_map", LIFTS)
def test_example_3_lift_is_that_of_the_map(chart, x, v, step_map, rng):
    # The cotangent lift pairs as the map does: p_1 . dq_1 - p_0 . dq_0 = dp . dq + p . d(dq) for every change.
    p, dp = rng.standard_normal((2, len(x)))
    q0, p0, q1, p1 = LIFTS[step_map](x, p, v, dp)
    assert_close(chart.discretize(x, v, step_map), [q0, q1], EPS, "positions of the lift")
    a, b = rng.standard_normal((2, len(x)))
    change = difference(lambda t: chart.discretize(x + t * a, v + t * b, step_map), 0.0)
    # The maps are linear, so only the differences have round-off, eps / h.
    assert_close(p1 @ change[1] - p0 @ change[0], dp @ a + p @ b, 64 * len(x) * EPS / 1e-3, "pairing")


INVERSES = {
    "midpoint": lambda q0, p0, q1, p1: ((q0 + q1) / 2, (p0 + p1) / 2, q1 - q0, p1 - p0),
    "initial_point": lambda q0, p0, q1, p1: (q0, p1, q1 - q0, p1 - p0),
}


@pytest.mark.parametrize("step_map", INVERSES)
def test_proposition_2_equation_of_the_step(name, chart, step_map):
    half, steps = 2 * chart.d, 10
    path = chart.integrate(experiments.initial_state(EXPERIMENTS[name]), steps, map=step_map)
    for z0, z1 in itertools.pairwise(path):
        ends = (z0[:half], z0[half:], z1[:half], z1[half:])
        q, p, dq, dp = INVERSES[step_map](*ends)
        assert_close(LIFTS[step_map](q, p, dq, dp), ends, 64 * EPS, "the inverse of the lift")
        G = paper_charts.gradient(HAMILTONIANS[name], np.concatenate([q, p]))
        # Newton's method for the implicit equation stops at round-off; G is up to 10^2.
        bound = 256 * EPS * (1 + np.abs(G).max())
        assert_close(dq, G[half:] / steps, bound, "positions: h dH/dp at the base point of the inverse lift")
        assert_close(dp, -G[:half] / steps, bound, "momenta: -h dH/dq at the base point of the inverse lift")
