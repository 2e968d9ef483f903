"""Smoothing splines: geodesic regression as the limit, two points, distant points, bounds of the objective."""

import pickle

import numpy as np
import pytest
from scipy.optimize import least_squares

from stiefel_rs import ConvergenceError, CubicSpline, InvalidInputError, SmoothingSpline, Stiefel, load

LAMBDAS = (1e-3, 1.0, 1e3, 1e6, 1e9, 1e12, 1e15, np.inf)


def unit_tangent(M, S, rng):
    V = M.project_tangent(S, rng.standard_normal(S.shape))
    return V / M.norm(S, V)


def noisy(n, k, count, seed):
    """Points 0.1 off a geodesic of length 1, at equal times for even seeds."""
    rng, M = np.random.default_rng(seed), Stiefel(n, k)
    t = np.linspace(0.0, 1.0, count)
    if seed % 2:
        t[1:-1] = np.sort(rng.uniform(0.0, 1.0, count - 2))
    start = np.linalg.qr(rng.standard_normal((n, k)))[0]
    V = unit_tangent(M, start, rng)
    along = [M.exp(start, V * time) for time in t]
    off = [0.1 * M.project_tangent(S, rng.standard_normal((n, k))) for S in along]
    return t, M.exp(np.array(along), np.array(off))


def basis(S):
    """Tangent vectors at S: rotations of the columns among themselves, and directions outside their span."""
    n, k = S.shape
    normal = np.linalg.qr(np.hstack([S, np.eye(n)]))[0][:, k:n]
    turns = [np.outer(S[:, i], np.eye(k)[j]) - np.outer(S[:, j], np.eye(k)[i]) for j in range(k) for i in range(j)]
    return np.array(turns + [np.outer(q, e) for q in normal.T for e in np.eye(k)])


def regression(t, Y):
    """The least misfit of a geodesic, over its point and velocity at the middle time.

    The velocity is carried along with the point by projection, so all geodesics are covered.
    """
    M, middle = Stiefel(*Y.shape[1:]), 0.5 * (t[0] + t[-1])
    S0 = Y[len(Y) // 2]
    B = basis(S0)

    def residuals(x):
        shift, velocity = (np.tensordot(part, B, 1) for part in np.split(x, 2))
        S = M.exp(S0, shift)
        V = M.project_tangent(S, velocity)
        points = M.exp(np.repeat(S[None], len(t), 0), (t - middle)[:, None, None] * V)
        D = M.log(points, Y)
        turn = np.swapaxes(points, 1, 2) @ D
        return np.concatenate([(D - points @ turn).ravel(), turn.ravel() / np.sqrt(2)])

    found = least_squares(residuals, np.zeros(2 * len(B)), xtol=1e-15, ftol=1e-15, gtol=1e-13)
    return 2.0 * found.cost


@pytest.mark.parametrize("count", [10, 100])
@pytest.mark.parametrize(("n", "k"), [(3, 1), (3, 2), (4, 2)])
def test_much_weight_is_geodesic_regression(n, k, count):
    solved = 0
    seeds = range(20 if k == 1 or count == 10 else 8)
    for seed in seeds:
        t, Y = noisy(n, k, count, seed)
        straight = regression(t, Y)
        misfit, cost = 0.0, np.inf
        for lam in LAMBDAS:
            try:
                curve = SmoothingSpline(t, Y, lam=lam)
            except ConvergenceError:
                continue
            solved += 1
            # A larger weight increases the misfit and lowers the cost, and no geodesic is better.
            assert misfit <= curve.misfit * (1 + 1e-9), (seed, lam)
            assert curve.cost() <= cost * (1 + 1e-9), (seed, lam)
            misfit, cost = curve.misfit, curve.cost()
            weighted = misfit + lam * cost if np.isfinite(lam) else misfit
            assert weighted <= straight * (1 + 1e-9), (seed, lam, weighted, straight)
            if lam >= 1e9:
                # Compared with the straight line, cubics gain at most a fraction of about 1 / lam.
                assert abs(misfit - straight) < 1e-8 * straight, (seed, lam, misfit, straight)
                assert abs(curve.degrees_of_freedom - 2.0) < 1e-8
    assert solved == len(seeds) * len(LAMBDAS)


@pytest.mark.parametrize(("n", "k"), [(3, 1), (3, 2), (4, 2), (5, 3)])
def test_two_points_give_the_geodesic(n, k):
    M = Stiefel(n, k)
    for seed in range(10):
        rng = np.random.default_rng(seed)
        S0 = np.linalg.qr(rng.standard_normal((n, k)))[0]
        S1 = M.exp(S0, 2.5 * unit_tangent(M, S0, rng))
        length = M.dist(S0, S1)
        for lam in (0.0, 1e-3, 1.0, 1e9, np.inf):
            curve = SmoothingSpline([1.0, 3.0], [S0, S1], [2.0, 0.5], lam)
            assert curve.misfit == 0.0 and curve.degrees_of_freedom == 2.0 and curve.lam == lam
            assert curve.cost() < 1e-24
            assert abs(curve.arc_length(1.0, 3.0) - length) < 1e-10
            assert np.abs(curve([1.0, 3.0]) - [S0, S1]).max() < 1e-10


def test_an_infinite_weight_is_kept(tmp_path):
    t, Y = noisy(3, 2, 10, 1)
    curve = SmoothingSpline(t, Y, lam=np.inf)
    curve.save(tmp_path / "curve.npz")
    for kept in (load(tmp_path / "curve.npz"), pickle.loads(pickle.dumps(curve))):
        assert kept.lam == np.inf
        assert np.array_equal(kept(0.3), curve(0.3))


def test_two_points_leave_nothing_to_cross_validate():
    _, Y = noisy(3, 2, 10, 0)
    with pytest.raises(InvalidInputError, match=r"\(N,\) with N >= 3 for cross-validation, or lam given, found \(2,\)"):
        SmoothingSpline([0.0, 1.0], Y[:2])
    assert SmoothingSpline([0.0, 1.0, 2.0], Y[:3]).lam > 0.0


def far(n, k, count, seed):
    """Points 2 to 2.5 from one to the next."""
    rng, M = np.random.default_rng(seed), Stiefel(n, k)
    points = [np.linalg.qr(rng.standard_normal((n, k)))[0]]
    while len(points) < count:
        points.append(M.exp(points[-1], rng.uniform(2.0, 2.5) * unit_tangent(M, points[-1], rng)))
    return np.arange(float(count)), np.array(points)


def straight_bounds(t, Y):
    """The misfits of geodesics between some of the data, and of constant curves."""
    M = Stiefel(*Y.shape[1:])
    first, middle, last = 0, len(Y) // 2, len(Y) - 1
    for i, j in ((first, last), (first, middle), (middle, last)):
        V = M.log(Y[i], Y[j]) / (t[j] - t[i])
        points = M.exp(np.repeat(Y[i][None], len(Y), 0), (t - t[i])[:, None, None] * V)
        yield np.sum(M.dist(points, Y) ** 2)
    yield np.sum(M.dist(np.repeat(Y[middle][None], len(Y), 0), Y) ** 2)


def cost_of_the_spline(t, Y):
    try:
        return CubicSpline(t, Y).cost()
    except ConvergenceError:
        return np.inf


@pytest.mark.parametrize(("n", "k", "least"), [(3, 1, 20), (3, 2, 20), (4, 2, 14)])
def test_far_points_are_fitted_or_refused(n, k, least):
    solved = 0
    for seed in range(8):
        t, Y = far(n, k, 6, seed)
        straight, cost = min(straight_bounds(t, Y)), cost_of_the_spline(t, Y)
        for lam in (1.0, 100.0, 1e9):
            try:
                curve = SmoothingSpline(t, Y, lam=lam)
            except ConvergenceError as error:
                assert not error.report.converged
                continue
            solved += 1
            objective = curve.misfit + lam * curve.cost()
            assert objective <= min(straight, lam * cost) * (1 + 1e-6), (seed, lam)
    # Of 24.
    assert solved >= least
