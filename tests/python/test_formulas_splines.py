"""The formulas of docs/mathematics.md for splines and for the cost of cubics, compared with the package."""

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from scipy.optimize import minimize_scalar

from stiefel_rs import Grassmann, RiemannianCubic, SmoothingSpline, Stiefel, estimate_velocities


def test_cost_of_a_cubic_of_flat_space(rng):
    h, (D, V, W) = 0.7, rng.standard_normal((3, 4))
    # s = V t + a t^2 / 2 + j t^3 / 6 ends at D with velocity W.
    a, j = 6 * D / h**2 - (4 * V + 2 * W) / h, -12 * D / h**3 + 6 * (V + W) / h**2
    cost = h * np.sum(a**2 + a * j * h + (j * h) ** 2 / 3)
    assert np.isclose(cost, np.sum((W - V) ** 2) / h + 12 / h * np.sum((D / h - (V + W) / 2) ** 2))


def derivatives(curve, t, count=4, radius=0.4, degree=16):
    """A curve and its derivatives at a time, from the Chebyshev polynomial of its points around it."""
    angles = np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1)
    points = curve(t + radius * np.cos(angles))
    series = chebyshev.chebfit(np.cos(angles), points.reshape(degree + 1, -1), degree)
    at = [chebyshev.chebval(0.0, chebyshev.chebder(series, order)) / radius**order for order in range(count + 1)]
    return [x.reshape(points.shape[1:]) for x in at]


def fourth_derivative(S, V, S2, S3, tau):
    """The equation of cubics of frames, in the embedding."""
    Omega = S.T @ V
    a = V.T @ V + Omega @ Omega
    Omega1 = S.T @ S2 + V.T @ V
    m12, m13 = (V.T @ X + Omega @ S.T @ X for X in (S2, S3))
    b = m12 - a @ Omega
    c = S2.T @ S2 - S2.T @ S @ S.T @ S2 - m12.T @ Omega + Omega @ b
    e = m13 - m12 @ Omega - a @ (2 * Omega1 - a)
    Omega2 = S.T @ S3 - S.T @ S2 @ Omega - Omega @ (2 * Omega1 - a) + 2 * b + b.T
    one = np.eye(len(Omega))
    C1 = 2 * Omega2 - 3 * b - b.T + Omega @ a - (2 * Omega1 - a) @ Omega - tau * Omega
    C0 = (2 * b + b.T) @ Omega + (tau * one + Omega1 - a) @ a - Omega @ b.T - 3 * c - 2 * e - 2 * e.T
    return 2 * S3 @ Omega + S2 @ (tau * one + 3 * Omega1 - 2 * a - Omega @ Omega) + V @ C1 + S @ C0


def fourth_derivative_of_subspaces(Y, V, Y2, Y3, tau):
    a, b = V.T @ V, V.T @ Y2
    c, e = Y2.T @ Y2 - a @ a, V.T @ Y3 + a @ a
    one = np.eye(len(a))
    return Y2 @ (tau * one - 2 * a) - 4 * V @ b + Y @ (tau * a - a @ a - 3 * c - 3 * e - e.T)


@pytest.mark.parametrize("tau", [0.0, 0.8])
@pytest.mark.parametrize("M", [Stiefel(3, 1), Stiefel(5, 2), Stiefel(4, 4), Grassmann(5, 2)], ids=str)
def test_fourth_derivative_in_the_embedding(M, tau, rng):
    S = M.random_point(rng)
    V, A, J = (X * (0.6 / M.norm(S, X)) for X in (M.random_tangent(S, rng) for _ in range(3)))
    curve = RiemannianCubic.from_initial(S, V, A, J, tension=tau, manifold=M)
    *lower, found = derivatives(curve, 0.4)
    formula = fourth_derivative if isinstance(M, Stiefel) else fourth_derivative_of_subspaces
    # Differentiating the polynomial four times leaves errors of 1e-9.
    assert np.allclose(formula(*lower, tau), found, rtol=0, atol=1e-8)


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
