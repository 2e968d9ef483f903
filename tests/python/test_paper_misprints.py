"""Misprints of arXiv 2404.19407: the printed form fails by the amount in the map, the corrected one agrees."""

import numpy as np
import paper_charts
import pytest
from formulas import christoffel
from paper import EPS, Theorem1, assert_close, expm, log, reflection
from scipy.linalg import null_space

from stiefel_rs import Chart, Geodesic, QuasiGeodesic, Stiefel
from stiefel_rs.reproduce import experiments
from tools.paper_map import misprints

TIMES = np.linspace(0, 1, 11)


def assert_amount(measured, misprint):
    """The amount stated in the map, with four digits."""
    assert measured == pytest.approx(misprint.error, rel=5e-4), f"{misprint.label}: measured {measured:.4g}"


@pytest.mark.parametrize("n", [2, 3, 4, 5, 6])
def test_remark_1_dimension_of_the_sphere(n):
    S = np.eye(n, 1)
    dimension = null_space(S.T).shape[1]
    assert Stiefel(n, 1).dim == dimension
    assert_amount(n - dimension, misprints.SPHERE)


def test_remark_1_for_three_columns(rng):
    M = Stiefel(4, 3)
    # K has the row of the vector that Omega maps to zero.
    Omega = 0.8 * np.array([[0, -1, 0], [1, 0, 0], [0, 0, 0]])
    turn = np.linalg.qr(rng.standard_normal((4, 4)))[0]
    S, K = turn[:, :3], 0.8 * np.outer(turn[:, 3], [0, 0, 1])
    V, bound = S @ Omega + K, 64 * M.n * EPS
    X, found = M.decompose(S, V)
    for matrix in (X, found):
        assert_amount(np.linalg.norm(matrix), misprints.GEODESIC)
    assert_close(K @ Omega, 0.0, bound, "K Omega")
    beta, geodesic = QuasiGeodesic.from_velocity(S, V), Geodesic.from_velocity(S, V)
    assert_close(beta(TIMES), geodesic(TIMES), bound, "quasi-geodesic against geodesic")
    for t in TIMES:
        acceleration = beta(t, 2) + christoffel(beta(t), beta(t, 1), beta(t, 1))
        assert_close(acceleration, 0.0, bound, f"covariant acceleration at {t}")


@pytest.mark.parametrize("shape", [(3, 1), (3, 2), (4, 3), (6, 3), (4, 4)], ids=str)
def test_remark_1_condition_for_any_number_of_columns(shape, rng):
    M = Stiefel(*shape)
    S = M.random_point(rng)
    V = M.random_tangent(S, rng)
    Omega = S.T @ V
    K, beta = V - S @ Omega, QuasiGeodesic.from_velocity(S, V)
    size = 1 + np.linalg.norm(V) ** 2
    for t in TIMES:
        # K Omega is carried along the curve, so the acceleration vanishes everywhere or nowhere.
        carried = expm(t * (K @ S.T - S @ K.T)) @ K @ Omega @ expm(t * Omega)
        acceleration = beta(t, 2) + christoffel(beta(t), beta(t, 1), beta(t, 1))
        assert_close(acceleration, carried, 8 * M.n * EPS * size, f"covariant acceleration at {t}")


def on_a_great_circle(angle):
    return np.array([[np.cos(angle)], [np.sin(angle)], [0.0]])


@pytest.mark.parametrize("angle", [0.5, 1.5, 1.6, 2.0, 3.0])
def test_proposition_1_past_a_right_angle(angle):
    S0, S1 = on_a_great_circle(0.0), on_a_great_circle(angle)
    X = log(reflection(S1) @ reflection(S0)) / 2
    inner = S0.T @ expm(-X) @ S1
    past = angle > np.pi / 2
    # The only skew 1 x 1 matrix is 0, whose exponential is 1.
    assert_close(inner, -1.0 if past else 1.0, 64 * EPS, "the matrix whose logarithm is Omega")
    missed = np.linalg.norm(expm(X) @ S0 - S1)
    if past:
        assert_amount(missed, misprints.PROPOSITION)
    else:
        assert_close(missed, 0.0, 64 * EPS, "end of the printed curve")
    M = Stiefel(3, 1)
    V = M.inverse_retract(S0, S1)
    assert_close(M.norm(S0, V), angle, 64 * EPS, "length of the curve")
    assert_close(QuasiGeodesic(S0, S1)(TIMES), [on_a_great_circle(t * angle) for t in TIMES], 64 * EPS, "great circle")


def test_bracket_of_the_hamiltonian_of_frames():
    z = np.array([0.9, 0.4, 1.1, 0.3, -0.2, 0.5, 0.7, 0.2, -0.4, 0.6, -0.3, 0.8])
    exact = Chart.frame().hamiltonian(z)
    assert_close(paper_charts.frame_hamiltonian(z), exact, 32 * EPS, "bracket around both fractions")
    assert_amount(abs(paper_charts.frame_hamiltonian_as_typeset(z) - exact), misprints.BRACKET)


def sphere_legendre(z, factor):
    """The largest value of `p . qdot + m . a - factor |a + Gamma|^2` over all accelerations a."""
    theta, _, dtheta, dphi, p_theta, p_phi, *m = z
    inverse = np.diag([1.0, 1 / np.sin(theta) ** 2])
    gamma = np.array([-np.sin(2 * theta) / 2 * dphi**2, 2 / np.tan(theta) * dtheta * dphi])
    covariant = inverse @ m / (2 * factor)
    cost = factor * covariant @ np.linalg.inv(inverse) @ covariant
    return p_theta * dtheta + p_phi * dphi + m @ (covariant - gamma) - cost


def test_functional_with_and_without_one_half():
    z = np.array([1.0, 0.4, 0.3, 0.5, 0.2, -0.4, 0.7, -0.6])
    exact = Chart.sphere().hamiltonian(z)
    printed = paper_charts.sphere_hamiltonian(z)
    assert_close(printed, exact, 16 * EPS, "the printed Hamiltonian")
    assert_close(sphere_legendre(z, 0.5), exact, 16 * EPS, "the Hamiltonian of J / 2")
    assert_amount(abs(sphere_legendre(z, 1.0) - exact), misprints.FACTOR)
    # Momenta twice as large give the same velocities and accelerations, and twice the Hamiltonian.
    twice = np.concatenate([z[:4], 2 * z[4:]])
    assert_close(sphere_legendre(twice, 1.0), 2 * exact, 32 * EPS, "the Hamiltonian of J")


def test_geometric_cubics_are_no_riemannian_ones():
    experiment, steps = experiments.STIEFEL_3_2, 10
    states = experiments.reference(experiment, steps)
    found = experiments.solve(experiment, "gcp", steps, states[0], states[-1])
    S0, V0, S3, V3 = experiments.boundary_data(experiment, states[0], states[-1])
    printed = Theorem1(S0, V0, S3, V3)
    geometric = [printed(t) for t in experiments.time_grid(steps)]
    # Six successive logarithms.
    assert_close(found, geometric, 32 * 3 * EPS, "the geometric cubic polynomial")
    riemannian = experiments.points(experiment, states)
    assert_amount(experiments.distances(found, riemannian).mean(), misprints.GEOMETRIC)
