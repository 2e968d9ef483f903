"""Features that curves of subspaces share with curves of frames: estimates, guesses, batches, derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from test_subspaces import SHAPES, knots, reflection

import stiefel_rs
from stiefel_rs import (
    CubicHermite,
    CubicSpline,
    Grassmann,
    RiemannianCubic,
    Stiefel,
    estimate_velocities,
    solve_boundary,
)

METHODS = ["catmull-rom", "akima", "natural"]
PAULI = np.array([[[0, 1], [1, 0]], [[0, -1j], [1j, 0]], [[1, 0], [0, -1]]])


def adjoint(Y):
    return np.conj(np.swapaxes(Y, -1, -2))


def bloch(psi):
    return np.einsum("...ia,pij,...ja->...p", psi.conj(), PAULI, psi).real[..., None]


def moved_bloch(psi, V):
    """The velocity of the Bloch vector of a state that moves with velocity V."""
    return 2 * np.einsum("...ia,pij,...ja->...p", psi.conj(), PAULI, V).real[..., None]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_velocities_belong_to_their_bases(shape, method):
    M = Grassmann(shape[0], shape[1], field=shape[2])
    t, Y = np.array([0.0, 1.0, 1.8, 3.0, 4.1]), knots(M)
    V = estimate_velocities(t, Y, method, manifold=M)
    assert V.shape == Y.shape
    assert abs(adjoint(Y) @ V).max() < 1e-13
    Q = Stiefel(M.k, M.k, field=M.field).random_point(rng=1, size=5)
    assert abs(estimate_velocities(t, Y @ Q, method, manifold=M) - V @ Q).max() < 1e-12
    curve = CubicHermite(t, Y, method, manifold=M)
    assert abs(curve.velocities - V).max() == 0
    assert abs(curve.velocity(1.8) - V[2] @ (adjoint(Y[2]) @ curve(1.8))).max() < 1e-10
    closed = Y.copy()
    closed[4] = Y[0] @ Q[0]
    V = estimate_velocities(t, closed, method, closed=True, manifold=M)
    assert abs(V[4] - V[0] @ Q[0]).max() < 1e-12


@pytest.mark.parametrize("method", METHODS)
def test_velocities_of_qubits_are_those_of_bloch_vectors(method):
    M, t = Grassmann(2, 1, field="complex"), np.array([0.0, 1.0, 1.8, 3.0])
    psi = knots(M, 4, 0.5, seed=2)
    found = moved_bloch(psi, estimate_velocities(t, psi, method, manifold=M))
    assert abs(found - estimate_velocities(t, bloch(psi), method)).max() < 1e-12


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_a_solution_is_found_from_a_guess(shape):
    M = Grassmann(shape[0], shape[1], field=shape[2])
    Y0 = knots(M, 1)[0]
    V, A, J = (size * M.random_tangent(Y0, rng=seed) for seed, size in enumerate([1.0, 4.0, 16.0]))
    known = RiemannianCubic.from_initial(Y0, V, A, J, manifold=M)
    Q = Stiefel(M.k, M.k, field=M.field).random_point(rng=3)
    Y1 = known(1.0) @ Q
    V1 = M.project_tangent(Y1, known.velocity(1.0) @ Q)
    guess = (A * 1.001, J * 0.999)
    found = RiemannianCubic.from_boundary(Y0, V, Y1, V1, guess=guess, manifold=M)
    assert abs(found(0.5) - known(0.5)).max() < 1e-10
    assert found.report.iterations <= 8
    with pytest.raises(stiefel_rs.InvalidInputError, match="A: not horizontal"):
        RiemannianCubic.from_boundary(Y0, V, Y1, V1, guess=(Y0, J), manifold=M)


@pytest.mark.parametrize("M", [Stiefel(4, 2), Grassmann(4, 2)], ids=str)
def test_a_loose_tolerance_allows_a_distance_at_the_end_not_jumps(M):
    rng, moved = np.random.default_rng(1), 0
    for _ in range(6):
        S = [M.random_point(rng) for _ in range(2)]
        V = [8 * v / M.norm(s, v) for s, v in zip(S, (M.random_tangent(s, rng) for s in S), strict=True)]
        exact = RiemannianCubic.from_boundary(S[0], V[0], S[1], V[1], manifold=M)
        guess = []
        for vector in exact.initial[2:]:
            away = M.random_tangent(S[0], rng)
            guess.append(vector + 0.1 * M.norm(S[0], vector) / M.norm(S[0], away) * away)
        curve = RiemannianCubic.from_boundary(S[0], V[0], S[1], V[1], manifold=M, guess=guess, tol=1e-2)
        again = RiemannianCubic.from_initial(*curve.initial, manifold=M)
        # A cubic is the one with its own initial data, up to the growth of round-off.
        assert np.abs(curve(1.0) - again(1.0)).max() < 1e-7
        moved += curve.report.strategy == "direct"
    assert moved > 0


def test_all_found_of_qubits_are_those_of_bloch_vectors():
    M = Grassmann(2, 1, field="complex")
    psi = knots(M, 2, 0.6, seed=4)
    V = np.stack([0.6 * M.random_tangent(each, rng=5) for each in psi])
    found = RiemannianCubic.from_boundary(psi[0], V[0], psi[1], V[1], all_found=True, manifold=M)
    S, W = bloch(psi), moved_bloch(psi, V)
    sphere = RiemannianCubic.from_boundary(S[0], W[0], S[1], W[1], all_found=True)
    assert found[0].cost() == pytest.approx(sphere[0].cost() / 4, rel=1e-9)
    costs = [curve.cost() for curve in found]
    for curve in found:
        end = curve(1.0)
        assert abs(bloch(end) - S[1]).max() < 1e-11
        assert abs(moved_bloch(end, curve.velocity(1.0)) - W[1]).max() < 1e-9
    assert costs == sorted(costs)


@pytest.mark.parametrize("shape", [(3, 1, "real"), (4, 2, "real"), (5, 3, "real"), (4, 2, "complex")], ids=str)
def test_all_found(shape):
    M = Grassmann(shape[0], shape[1], field=shape[2])
    Y0, Y1 = M.random_point(rng=6, size=2)
    V0, V1 = M.random_tangent(Y0, rng=7), M.random_tangent(Y1, rng=8)
    found = RiemannianCubic.from_boundary(Y0, V0, Y1, V1, all_found=True, manifold=M)
    costs = [curve.cost() for curve in found]
    assert costs == sorted(costs)
    assert costs[0] <= (1 + 1e-6) * RiemannianCubic.from_boundary(Y0, V0, Y1, V1, manifold=M).cost()
    for curve in found:
        Q = adjoint(Y1) @ curve(1.0)
        assert abs(curve(1.0) - Y1 @ Q).max() < 1e-11
        assert abs(curve.velocity(1.0) - V1 @ Q).max() < 1e-9
        assert curve.manifold == M
        assert curve.report.converged
    if shape[2] == "real":
        assert len(found) >= 2


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_batches(shape):
    M = Grassmann(shape[0], shape[1], field=shape[2])
    Y0, Y1 = knots(M, 6, seed=9).reshape(2, 3, M.n, M.k)
    V0, V1 = (0.7 * M.random_tangent(Y, rng=10) for Y in (Y0, Y1))
    batch = solve_boundary(Y0, V0, Y1, V1, manifold=M, num_threads=1)
    assert batch.converged.all()
    assert batch.acceleration.shape == (3, M.n, M.k)
    for i in range(3):
        curve = RiemannianCubic.from_boundary(Y0[i], V0[i], Y1[i], V1[i], manifold=M)
        assert np.array_equal(batch.acceleration[i], curve.initial[2])
        assert np.array_equal(batch.jerk[i], curve.initial[3])
        assert batch.cost[i] == pytest.approx(curve.cost(), rel=1e-14)
        again = RiemannianCubic.from_initial(Y0[i], V0[i], batch.acceleration[i], batch.jerk[i], manifold=M)
        assert abs(reflection(again(1.0)) - reflection(Y1[i])).max() < 1e-10
    for threads in (2, 3):
        other = solve_boundary(Y0, V0, Y1, V1, manifold=M, num_threads=threads)
        assert all(np.array_equal(a, b) for a, b in zip(batch, other, strict=True))


def test_batches_broadcast_and_name_the_member():
    M = Grassmann(4, 2)
    Y = knots(M, 3, seed=11)
    batch = solve_boundary(Y[0], 0 * Y[0], Y[1:], 0 * Y[1:], manifold=M)
    assert batch.cost.shape == (2,)
    assert solve_boundary(Y[:0], Y[:0], Y[:0], Y[:0], manifold=M).cost.shape == (0,)
    with pytest.raises(stiefel_rs.InvalidInputError, match="not horizontal") as caught:
        solve_boundary(Y[0], 0 * Y[0], Y[1:], np.stack([0 * Y[1], Y[2]]), manifold=M)
    assert "1" in str(caught.value)
    with pytest.raises(stiefel_rs.InvalidInputError, match="points of shape"):
        solve_boundary(Y[0], 0 * Y[0], Y[1], 0 * Y[1], manifold=Grassmann(5, 2))
    E = np.eye(4)
    with pytest.raises(stiefel_rs.OutsideDomainError, match="principal angle"):
        solve_boundary(E[:, :2], 0 * E[:, :2], E[:, 2:], 0 * E[:, :2], manifold=M)


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_derivatives_of_closed_splines(shape):
    M = Grassmann(shape[0], shape[1], field=shape[2])
    t, Y = np.array([0.0, 1.0, 1.8, 3.0, 4.1]), knots(M)
    Y[4] = Y[0] @ Stiefel(M.k, M.k, field=M.field).random_point(rng=12)
    curve = CubicSpline(t, Y, "periodic", tol=1e-14, manifold=M)
    # Expressed in the bases of the curve.
    Y = curve(t)
    Q = adjoint(Y[0]) @ Y[4]
    dS = M.random_tangent(Y, rng=13)
    dS[4] = dS[0] @ Q
    dt = np.array([0.1, -0.2, 0.05, 0.0, 0.3])

    def moved(s):
        points = M.exp(Y, s * dS)
        points[4] = points[0] @ Q
        return CubicSpline(t + s * dt, points, "periodic", tol=1e-14, manifold=M)

    def difference(f, h=1e-3):
        return (8 * (f(h) - f(-h)) - f(2 * h) + f(-2 * h)) / (12 * h)

    times = np.array([0.3, 1.4, 3.7])
    found = curve.point_variation(times, dS, dt)
    expected = M.project_tangent(curve(times), difference(lambda s: M.align(curve(times), moved(s)(times))))
    assert abs(found - expected).max() < 1e-7
    W = M.random_tangent(curve(times), rng=14)
    GS, Gt, Gbc = curve.point_pullback(times, W)
    assert Gbc == (None, None)

    def product(a, b):
        return np.sum(a.conj() * b).real

    assert product(GS, dS) + product(Gt, dt) == pytest.approx(product(W, found), rel=1e-9)
    GS, Gt, _ = curve.cost_gradient()
    assert product(GS, dS) + product(Gt, dt) == pytest.approx(difference(lambda s: moved(s).cost()), rel=1e-7)
    if M.k > 1:
        dS[4] = dS[0]
        with pytest.raises(stiefel_rs.InvalidInputError, match="dS"):
            curve.point_variation(times, dS)
