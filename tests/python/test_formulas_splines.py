"""The formulas of docs/mathematics.md for splines and for the cost of cubics, compared with the package."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from stiefel_rs import RiemannianCubic, SmoothingSpline, Stiefel, estimate_velocities


def test_cost_of_a_cubic_of_flat_space(rng):
    h, (D, V, W) = 0.7, rng.standard_normal((3, 4))
    # s = V t + a t^2 / 2 + j t^3 / 6 ends at D with velocity W.
    a, j = 6 * D / h**2 - (4 * V + 2 * W) / h, -12 * D / h**3 + 6 * (V + W) / h**2
    cost = h * np.sum(a**2 + a * j * h + (j * h) ** 2 / 3)
    assert np.isclose(cost, np.sum((W - V) ** 2) / h + 12 / h * np.sum((D / h - (V + W) / 2) ** 2))


def on_circle(angle):
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)[..., None]


@pytest.mark.parametrize("method", ["catmull-rom", "akima", "natural"])
def test_velocities(method):
    t, angle = np.array([0, 0.4, 1.1, 1.5, 2.4, 3.0]), np.array([0, 0.3, 0.9, 1.0, 0.4, 0.1])
    V = estimate_velocities(t, on_circle(angle), method)
    v = V[:, 1, 0] * np.cos(angle) - V[:, 0, 0] * np.sin(angle)
    h = np.diff(t)
    m = np.diff(angle) / h
    if method == "catmull-rom":
        assert np.allclose(v[1:-1], (h[1:] * m[:-1] + h[:-1] * m[1:]) / (h[:-1] + h[1:]))
    elif method == "akima":
        w = np.r_[np.nan, abs(m[1:] - m[:-1]) + abs(m[1:] + m[:-1]) / 2, np.nan]
        i = np.arange(2, 4)
        assert np.allclose(v[i], (w[i + 1] * m[i - 1] + w[i - 1] * m[i]) / (w[i - 1] + w[i + 1]))
    else:
        left = (2 * v[:-2] + 4 * v[1:-1]) / h[:-1] + (4 * v[1:-1] + 2 * v[2:]) / h[1:]
        assert np.allclose(left, 6 * (m[:-1] / h[:-1] + m[1:] / h[1:]))


def test_smoothing_spline(rng):
    M, lam = Stiefel(4, 2), 0.01
    t = np.array([0.0, 0.5, 1.2, 2.0])
    S = M.random_point(rng)
    Y = np.stack([M.retract(S, 0.3 * M.random_tangent(S, rng)) for _ in t])
    weights = np.array([1.0, 2.0, 0.5, 1.0])
    spline = SmoothingSpline(t, Y, weights, lam)
    h = np.diff(t)
    for i in (1, 2):
        jump = spline.pieces[i].jerk(0.0) / h[i] ** 3 - spline.pieces[i - 1].jerk(1.0) / h[i - 1] ** 3
        assert np.allclose(jump, weights[i] / lam * M.log(spline.points[i], Y[i]), atol=1e-7)
    assert np.isclose(spline.misfit, np.sum(weights * M.dist(spline.points, Y) ** 2))


def test_generalised_cross_validation(rng):
    N = 20
    t = np.linspace(0, 3, N) + rng.uniform(0, 0.1, N)
    angle = np.sin(t) + 0.05 * rng.standard_normal(N)
    spline = SmoothingSpline(t, on_circle(angle))
    # Reinsch: the cost of the natural spline through y is y^T K y.
    h = np.diff(t)
    Q, R = np.zeros((N, N - 2)), np.zeros((N - 2, N - 2))
    for j in range(N - 2):
        Q[j : j + 3, j] = 1 / h[j], -1 / h[j] - 1 / h[j + 1], 1 / h[j + 1]
        R[j, j] = (h[j] + h[j + 1]) / 3
        if j:
            R[j, j - 1] = R[j - 1, j] = h[j] / 6
    K = Q @ np.linalg.solve(R, Q.T)

    def influence(lam):
        return np.linalg.inv(np.eye(N) + lam * K)

    def score(log):
        A = influence(np.exp(log))
        return N * np.sum((angle - A @ angle) ** 2) / (N - np.trace(A)) ** 2

    assert np.isclose(spline.degrees_of_freedom, np.trace(influence(spline.lam)), rtol=1e-6)
    best = minimize_scalar(score, bounds=(np.log(spline.lam) - 2, np.log(spline.lam) + 2), method="bounded")
    assert score(np.log(spline.lam)) <= best.fun * (1 + 1e-6)


def test_least_cost_of_boundary_data():
    M = Stiefel(4, 2)
    S0, V0 = np.eye(4, 2), np.array([[0.0, -0.4], [0.4, 0.0], [0.3, 0.0], [0.0, -0.2]])
    for length in (0.5, 1.5, 2.5):
        D = np.array([[0.0, -0.3], [0.3, 0.0], [0.8, 0.1], [-0.2, 0.5]])
        S1 = M.exp(S0, D * (length / M.norm(S0, D)))
        rest = np.zeros((4, 2))
        at_rest = RiemannianCubic.from_boundary(S0, rest, S1, rest).cost()
        assert at_rest == pytest.approx(12 * length**2, rel=1e-9)
        V1 = M.project_tangent(S1, np.ones((4, 2)))
        u0, u1 = M.norm(S0, V0), M.norm(S1, V1)
        least = (u1 - u0) ** 2 + 12 * max(0.0, length - (u0 + u1) / 2) ** 2
        assert RiemannianCubic.from_boundary(S0, V0, S1, V1).cost() >= least * (1 - 1e-12)
