"""Sections 4.1 and 4.2 of arXiv 2404.19407 as printed: charts, Hamiltonians, their flow and the initial data."""

import itertools

import numpy as np
import paper_charts
import pytest
from paper import EPS, assert_close, inner
from scipy.integrate import solve_ivp

from stiefel_rs import Chart, RiemannianCubic, Stiefel
from stiefel_rs.reproduce import experiments

# Chart, point, Hamiltonian, initial data.
SPHERE = (Chart.sphere(), paper_charts.sphere_point, paper_charts.sphere_hamiltonian, paper_charts.SPHERE_DATA)
FRAME = (Chart.frame(), paper_charts.frame_point, paper_charts.frame_hamiltonian, paper_charts.FRAME_DATA)
both = pytest.mark.parametrize(("chart", "point", "hamiltonian", "data"), [SPHERE, FRAME], ids=["sphere", "frame"])
# Angles at which sines or cosines vanish, and others.
ANGLES = [np.pi / 2, 0.4, 2.2, np.pi, 3 * np.pi / 2, 5.9]
# Monomials of the Hamiltonian of St(3,2), by the exponents of the variables in (q, qdot, p_q, p_qdot).
MONOMIALS = {
    "dtheta p_theta": (3, 6),
    "dphi p_phi": (4, 7),
    "dpsi p_psi": (5, 8),
    "p_dtheta^2": (9, 9),
    "p_dphi^2": (10, 10),
    "p_dpsi^2": (11, 11),
    "p_dphi p_dpsi": (10, 11),
    "dphi dpsi p_dtheta": (4, 5, 9),
    "dphi dtheta p_dphi": (4, 3, 10),
    "dphi dtheta p_dpsi": (4, 3, 11),
    "dpsi dtheta p_dphi": (5, 3, 10),
    "dpsi dtheta p_dpsi": (5, 3, 11),
}


def size(z):
    """Largest size of the terms of a Hamiltonian, divided by sines and cosines."""
    return (1 + np.abs(z).max()) ** 3 / min(1.0, abs(np.sin(z[0])), abs(np.cos(z[0])) if len(z) == 12 else 1.0) ** 2


def states(d, rng):
    """States away from the pole and, as the long form divides by cos(theta), from the equator; some without velocity
    or without momenta.
    """
    for theta in (0.3, 0.9, 1.4, 2.0, 2.8):
        z = rng.standard_normal(4 * d)
        z[0] = theta
        at_rest, free = z.copy(), z.copy()
        at_rest[d : 2 * d], free[2 * d :] = 0.0, 0.0
        yield from (z, at_rest, free)


@both
def test_charts(chart, point, hamiltonian, data):
    for q in itertools.product([0.4, np.pi / 2, 2.2], *[ANGLES] * (chart.d - 1)):
        S = point(q)
        assert_close(chart.embed(q), S, 8 * EPS, f"point at {q}")
        assert_close(S.T @ S, np.eye(chart.k), 8 * EPS, f"orthonormal columns at {q}")


@both
def test_charts_cover_neighbourhoods(chart, point, hamiltonian, data):
    for q in itertools.product([0.4, np.pi / 2, 2.2], *[ANGLES] * (chart.d - 1)):
        # Complex steps: the derivative of the printed formula with respect to each angle.
        columns = [point(np.array(q) + 1e-30j * e).imag / 1e-30 for e in np.eye(chart.d)]
        for found, e in zip(columns, np.eye(chart.d), strict=True):
            assert_close(chart.embed_velocity(q, e), found, 8 * EPS, f"derivative at {q}")
        singular = np.linalg.svd(np.stack([c.ravel() for c in columns]), compute_uv=False)
        assert singular.min() > 0.1 * np.sin(q[0]), f"rank at {q}: {singular}"


def test_frames_are_unit_tangent_vectors_of_the_sphere():
    for q in itertools.product([0.4, np.pi / 2, 2.2], ANGLES, ANGLES):
        at, unit = paper_charts.frame_point(q).T
        assert_close(at, paper_charts.sphere_point(q[:2])[:, 0], 0.0, "first column is the point of the sphere")
        assert_close([at @ unit, unit @ unit], [0.0, 1.0], 8 * EPS, "second column is a unit vector there")


def test_sphere_hamiltonian(rng):
    chart, _, hamiltonian, _ = SPHERE
    equator = np.concatenate([[np.pi / 2, np.pi], rng.standard_normal(6)])
    for z in [*states(2, rng), equator]:
        assert_close(chart.hamiltonian(z), hamiltonian(z), 4 * EPS * size(z), f"H at {z}")


def test_frame_hamiltonian(rng):
    chart, _, hamiltonian, _ = FRAME
    for z in states(3, rng):
        assert_close(chart.hamiltonian(z), hamiltonian(z), 8 * EPS * size(z), f"H at {z}")


def coefficient(function, theta, variables):
    """The coefficient of a product of variables in a polynomial of velocities and momenta, for fixed angles."""
    total, distinct = 0.0, sorted(set(variables))
    for count in range(len(distinct) + 1):
        for chosen in itertools.combinations(distinct, count):
            z = np.zeros(12)
            z[0], z[list(chosen)] = theta, 1.0
            total += (-1) ** (len(distinct) - count) * function(z)
    return total


@pytest.mark.parametrize("name", MONOMIALS)
def test_frame_hamiltonian_term_by_term(name):
    chart, _, hamiltonian, _ = FRAME
    for theta in (0.3, 0.9, 1.4, 2.0, 2.8):
        found, exact = (coefficient(f, theta, MONOMIALS[name]) for f in (chart.hamiltonian, hamiltonian))
        # Terms of the size 1 / (s c)^2; 1 - cos(2 theta) = 2 s^2 is exact to eps / s^2.
        bound = 8 * EPS / (np.sin(theta) ** 4 * np.cos(theta) ** 2)
        assert_close(found, exact, bound, f"coefficient of {name} at theta = {theta}")


def test_frame_hamiltonian_has_no_other_terms(rng):
    hamiltonian = FRAME[2]
    for z in states(3, rng):
        total = sum(
            coefficient(hamiltonian, z[0], variables) * np.prod(z[list(variables)]) for variables in MONOMIALS.values()
        )
        assert_close(hamiltonian(z), total, 32 * EPS * size(z), f"sum of the terms at {z}")


@both
def test_hamiltonian_is_that_of_the_metric(chart, point, hamiltonian, data):
    # The part quadratic in the last momenta is the inverse of the metric (5) in the chart.
    q, d = np.array([0.9, 2.1, 4.0])[: chart.d], chart.d
    fields = [point(q + 1e-30j * e).imag / 1e-30 for e in np.eye(d)]
    metric = np.array([[inner(point(q), a, b) for b in fields] for a in fields])
    for m in np.random.default_rng(3).standard_normal((4, d)):
        z = np.concatenate([q, np.zeros(2 * d), m])
        assert_close(hamiltonian(z), m @ np.linalg.solve(metric, m) / 2, 8 * EPS * size(z), "p g^-1 p / 2")


@both
def test_hamiltonian_flow_is_that_of_riemannian_cubics(chart, point, hamiltonian, data):
    d, z0 = chart.d, experiments.initial_state({1: experiments.SPHERE, 2: experiments.STIEFEL_3_2}[chart.k])

    def flow(_t, z):
        G = paper_charts.gradient(hamiltonian, z)
        return np.concatenate([G[2 * d :], -G[: 2 * d]])

    # The benchmark of the paper: a Runge-Kutta method of higher order in one chart.
    t = np.array([0.25, 0.5, 1.0])
    found = solve_ivp(flow, (0.0, 1.0), z0, method="DOP853", t_eval=t, rtol=1e-12, atol=1e-13).y.T
    # Relative tolerance 1e-12 per step, some 30 steps, states up to 10.
    assert_close(chart.reference(z0, t), found, 1e-10, "states along the flow")
    cubic = RiemannianCubic.from_initial(*chart.covariant(z0))
    assert_close(cubic(t), [point(q) for q in found[:, :d]], 1e-10, "points of the cubic")


@both
def test_initial_data(chart, point, hamiltonian, data):
    experiment = {1: experiments.SPHERE, 2: experiments.STIEFEL_3_2}[chart.k]
    for found, exact in zip((experiment.q, experiment.qdot, experiment.qddot, experiment.qdddot), data, strict=True):
        assert_close(found, exact, 0.0, "data of the experiment")


@both
def test_flow_on_ttq(chart, point, hamiltonian, data):
    experiment = {1: experiments.SPHERE, 2: experiments.STIEFEL_3_2}[chart.k]
    z = experiments.reference(experiment, 8)
    flow = chart.derivatives(z)
    # Positions, velocities, accelerations and jerks at N + 1 times, starting from the printed ones.
    for found, exact in zip(flow, data, strict=True):
        assert found.shape == (9, chart.d)
        assert_close(found[0], exact, 64 * EPS, "the first member of the flow")
    S0, V0, S1, V1 = experiments.boundary_data(experiment, z[0], z[-1])
    M = Stiefel(3, chart.k)
    for S, V in ((S0, V0), (S1, V1)):
        M.check_tangent(S, V, atol=64 * EPS)
