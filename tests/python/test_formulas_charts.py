"""The formulas of docs/mathematics.md for charts and kernels, compared with the package."""

import numpy as np
import pytest
from formulas import christoffel, skew
from scipy.linalg import expm
from scipy.special import jv

from stiefel_rs import Chart, Stiefel, skew_exp


def sphere_hamiltonian(z):
    th, _, dth, dph, p_th, p_ph, q_th, q_ph = z
    s, c = np.sin(th), np.cos(th)
    free = p_th * dth + p_ph * dph + q_th**2 / 2 + q_ph**2 / (2 * s**2)
    return free + s * c * dph**2 * q_th - 2 * c / s * dth * dph * q_ph


def frame_hamiltonian(z):
    (th, _, _), (dth, dph, dps), p, (q_th, q_ph, q_ps) = z.reshape(4, 3)
    s, c = np.sin(th), np.cos(th)
    free = p @ z[3:6] + q_th**2 / 2 + (q_ph**2 - 2 * c * q_ph * q_ps + q_ps**2) / (2 * s**2)
    turn = s * dph * dps * q_th + dth * dph * (c / s * q_ph - q_ps / s) + dth * dps * (c / s * q_ps - q_ph / s)
    return free - turn


CHARTS = [(Chart.sphere(), sphere_hamiltonian), (Chart.frame(), frame_hamiltonian)]


@pytest.mark.parametrize(("chart", "hamiltonian"), CHARTS, ids=["sphere", "frame"])
def test_charts(chart, hamiltonian, rng):
    d = chart.d
    z = rng.uniform(0.5, 1.0, 4 * d)
    q, qdot, p, r = z.reshape(4, d)
    assert np.isclose(chart.hamiltonian(z), hamiltonian(z))
    # The momenta agree with the covariant data.
    M = Stiefel(3, chart.k)
    S, _, A, J = chart.covariant(z)
    fields = [chart.embed_velocity(q, e) for e in np.eye(d)]
    assert np.allclose(r, [M.inner(S, field, A) for field in fields])
    free = np.concatenate([q, qdot, np.zeros(d), r])
    gamma = -chart.gradient(free)[d : 2 * d] / 2
    assert np.allclose(p, gamma - [M.inner(S, field, J) for field in fields])
    # Momentum of the rotations of space.
    start, end = (momentum(M, chart.covariant(state)) for state in (z, chart.reference(z, [0.0, 0.3])[-1]))
    assert np.allclose(start, end, atol=1e-11)


def momentum(M, covariant):
    S, V, A, J = covariant
    found = []
    for e in np.eye(3):
        xi, dxi = np.cross(e, S, axis=0), np.cross(e, V, axis=0)
        if S.ndim == 2:
            xi, dxi = (np.stack([np.cross(e, column) for column in Y.T], axis=1) for Y in (S, V))
        found.append(M.inner(S, A, dxi + christoffel(S, V, xi)) - M.inner(S, J, xi))
    return found


@pytest.mark.parametrize(("chart", "_hamiltonian"), CHARTS, ids=["sphere", "frame"])
def test_discretization_maps(chart, _hamiltonian, rng):
    half, h = 2 * chart.d, 0.01
    z0 = rng.uniform(0.5, 1.0, 2 * half)
    z1 = chart.integrate(z0, 1, t_end=h, map="initial_point")[-1]
    at = chart.gradient(np.concatenate([z0[:half], z1[half:]]))
    assert np.allclose(z1, z0 + h * np.concatenate([at[half:], -at[:half]]), atol=1e-12)
    z1 = chart.integrate(z0, 1, t_end=h, map="midpoint")[-1]
    at = chart.gradient((z0 + z1) / 2)
    assert np.allclose(z1, z0 + h * np.concatenate([at[half:], -at[:half]]), atol=1e-12)


def test_rotations(rng):
    omega = rng.standard_normal(3)
    angle = np.linalg.norm(omega)
    u = omega / angle
    hat = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
    R = np.cos(angle) * np.eye(3) + np.sin(angle) * hat + (1 - np.cos(angle)) * np.outer(u, u)
    assert np.allclose(skew_exp(angle * hat), R, atol=1e-15)


def test_chebyshev_series_of_the_action(rng):
    L, v = 3 * skew(rng.standard_normal((6, 6))), rng.standard_normal(6)
    rho = np.linalg.norm(L, 2)
    before, phi = v, L @ v / rho
    total = jv(0, rho) * v
    for j in range(1, 60):
        total = total + 2 * jv(j, rho) * phi
        before, phi = phi, 2 / rho * L @ phi + before
    assert np.allclose(total, expm(L) @ v, atol=1e-13)
