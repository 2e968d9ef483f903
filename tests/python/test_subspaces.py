"""Curves of subspaces: the Python additions to the Rust tests, and comparisons with SciPy."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from scipy.interpolate import CubicSpline as FlatSpline

import stiefel_rs
from stiefel_rs import (
    CubicHermite,
    CubicSpline,
    Geodesic,
    GeometricCubic,
    GeometricPolynomial,
    Grassmann,
    RiemannianCubic,
    SmoothingSpline,
    Stiefel,
    integrate_cubic,
)

SHAPES = [(3, 1, "real"), (5, 2, "real"), (3, 2, "real"), (8, 3, "real"), (2, 1, "complex"), (4, 2, "complex")]


def reflection(Y):
    return 2 * Y @ Y.conj().swapaxes(-1, -2) - np.eye(Y.shape[-2])


def knots(M, count=5, far=0.6, seed=0):
    """Subspaces at given distances, with randomly rotated bases."""
    rng = np.random.default_rng(seed)
    points = [M.random_point(rng)]
    for _ in range(count - 1):
        V = M.random_tangent(points[-1], rng)
        points.append(M.exp(points[-1], far / M.norm(points[-1], V) * V))
    turns = Stiefel(M.k, M.k, field=M.field).random_point(rng, size=count)
    turns[0] = np.eye(M.k)
    return np.array(points) @ turns


def manifold_of_reflections(M):
    return Stiefel(M.n, M.n, field=M.field)


@pytest.mark.parametrize("shape", SHAPES, ids=str)
class TestAllShapes:
    def test_spline(self, shape):
        M = Grassmann(shape[0], shape[1], field=shape[2])
        t, Y = np.array([0.0, 1.0, 1.8, 3.0, 4.1]), knots(M)
        curve = CubicSpline(t, Y, manifold=M)
        oracle = CubicSpline(t, reflection(Y), manifold=manifold_of_reflections(M))
        times = np.linspace(0, 4.1, 30)
        assert abs(reflection(curve(times)) - oracle(times)).max() < 1e-10
        assert abs(curve(0.0) - Y[0]).max() < 1e-13
        assert abs(curve(times).conj().swapaxes(-1, -2) @ curve.velocity(times)).max() < 1e-11
        assert curve.manifold == M
        assert curve.cost() == pytest.approx(oracle.cost() / 4, rel=1e-9)
        assert repr(curve).startswith(f"<CubicSpline on Gr({M.n}, {M.k}")
        again = pickle.loads(pickle.dumps(curve))
        assert again.manifold == M
        assert np.array_equal(again(times), curve(times))

    def test_boundary_values(self, shape):
        M = Grassmann(shape[0], shape[1], field=shape[2])
        Y0, Y1 = knots(M, 2, seed=1)
        V0, V1 = (0.7 * M.random_tangent(Y, rng=2) for Y in (Y0, Y1))
        curve = RiemannianCubic.from_boundary(Y0, V0, Y1, V1, manifold=M)
        Q = Y1.conj().T @ curve(1.0)
        assert abs(curve(1.0) - Y1 @ Q).max() < 1e-11
        assert abs(curve.velocity(1.0) - V1 @ Q).max() < 1e-11
        assert abs(curve(0.0) - Y0).max() < 1e-14
        assert curve.report.converged
        again = RiemannianCubic.from_initial(*curve.initial, manifold=M)
        assert abs(again(1.0) - curve(1.0)).max() < 1e-12
        assert again.energy == pytest.approx(curve.energy, rel=1e-9, abs=1e-9)
        steps = integrate_cubic(*curve.initial, 100, order=8, manifold=M)
        assert abs(steps.point[-1] - curve(1.0)).max() < 1e-10

    def test_geodesic(self, shape):
        M = Grassmann(shape[0], shape[1], field=shape[2])
        Y0, Y1 = knots(M, 2, seed=3)
        curve = Geodesic(Y0, Y1, manifold=M)
        assert abs(reflection(curve(1.0)) - reflection(Y1)).max() < 1e-13
        assert abs(curve(0.5) - M.exp(Y0, 0.5 * M.log(Y0, Y1))).max() < 1e-13
        assert curve.length == pytest.approx(M.dist(Y0, Y1), rel=1e-12)
        assert curve.manifold == M
        assert pickle.loads(pickle.dumps(curve)).manifold == M

    def test_hermite_and_smoothing(self, shape):
        M = Grassmann(shape[0], shape[1], field=shape[2])
        t, Y = np.array([0.0, 1.0, 1.8, 3.0]), knots(M, 4, seed=4)
        V = 0.3 * M.random_tangent(Y, rng=5)
        curve = CubicHermite(t, Y, V, manifold=M)
        for i, time in enumerate(t):
            Q = Y[i].conj().T @ curve(time)
            assert abs(curve(time) - Y[i] @ Q).max() < 1e-11
            assert abs(curve.velocity(time) - V[i] @ Q).max() < 1e-10
        smooth = SmoothingSpline(t, Y, lam=0.1, manifold=M)
        oracle = SmoothingSpline(t, reflection(Y), lam=0.1, manifold=manifold_of_reflections(M))
        assert abs(reflection(smooth(1.3)) - oracle(1.3)).max() < 1e-7
        assert smooth.misfit == pytest.approx(oracle.misfit / 4, rel=1e-6)
        assert SmoothingSpline(t, Y, manifold=M).lam > 0


@pytest.mark.parametrize("shape", SHAPES, ids=str)
class TestDeCasteljau:
    def test_polynomial(self, shape):
        M = Grassmann(shape[0], shape[1], field=shape[2])
        Y, times = knots(M, 4, seed=20), np.linspace(0, 1, 17)
        curve = GeometricPolynomial(Y, manifold=M)
        oracle = GeometricPolynomial(reflection(Y), manifold=manifold_of_reflections(M))
        assert abs(reflection(curve(times)) - oracle(times)).max() < 1e-13
        assert abs(curve(0.0) - Y[0]).max() < 1e-14
        assert abs(curve(times).conj().swapaxes(-1, -2) @ curve.velocity(times)).max() < 1e-13
        assert abs(curve.control_points - Y).max() < 1e-15
        assert curve.cost() == pytest.approx(oracle.cost() / 4, rel=1e-11)
        assert curve.arc_length() == pytest.approx(oracle.arc_length() / 2, rel=1e-11)
        assert (curve.manifold, curve.degree, curve.pieces, curve.report) == (M, 3, "geodesic", None)
        turns = Stiefel(M.k, M.k, field=M.field).random_point(rng=21, size=4)
        other = GeometricPolynomial(Y @ turns, manifold=M)
        assert abs(other(times) - curve(times) @ turns[0]).max() < 1e-12
        again = pickle.loads(pickle.dumps(curve))
        assert again.manifold == M
        assert np.array_equal(again(times, 2), curve(times, 2))
        cubic = GeometricCubic.from_control_points(Y, manifold=M)
        assert np.array_equal(cubic(times), curve(times))
        assert isinstance(pickle.loads(pickle.dumps(cubic)), GeometricCubic)

    def test_cubic_and_its_pieces(self, shape):
        M = Grassmann(shape[0], shape[1], field=shape[2])
        t, Y = np.array([0.0, 1.0, 1.8, 3.0]), knots(M, 4, seed=22)
        V = 0.5 * M.random_tangent(Y, rng=23)
        curve = CubicHermite(t, Y, V, kind="geometric", manifold=M)
        assert (curve.kind, curve.manifold, curve.report) == ("geometric", M, None)
        for i, time in enumerate(t):
            for side in (time, np.nextafter(time, -1) if i else time):
                Q = Y[i].conj().T @ curve(side)
                assert abs(curve(side) - Y[i] @ Q).max() < 1e-13
                assert abs(curve.velocity(side) - V[i] @ Q).max() < 1e-12
        for i, piece in enumerate(curve.pieces):
            assert isinstance(piece, GeometricCubic)
            assert piece.manifold == M
            h = t[i + 1] - t[i]
            alone = GeometricCubic(Y[i], h * V[i], Y[i + 1], h * V[i + 1], manifold=M)
            assert abs(reflection(alone(0.3)) - reflection(curve(t[i] + 0.3 * h))).max() < 1e-13
            assert abs(piece(0.3) - curve(t[i] + 0.3 * h)).max() < 1e-14
            if i:
                assert abs(piece(0.0) - curve.pieces[i - 1](1.0)).max() < 1e-13

    def test_spline(self, shape):
        M = Grassmann(shape[0], shape[1], field=shape[2])
        t, Y = np.array([0.0, 1.0, 1.8, 3.0, 4.1]), knots(M, seed=24)
        V = 0.3 * M.random_tangent(Y[[0, -1]], rng=25)
        times = np.linspace(0, 4.1, 30)
        closed = np.append(Y[:4], Y[:1] @ Stiefel(M.k, M.k, field=M.field).random_point(rng=26, size=1), axis=0)
        up = [2 * (v @ y.conj().T + y @ v.conj().T) for v, y in zip(V, Y[[0, -1]], strict=True)]
        for points, low, high in (
            (Y, "natural", "natural"),
            (Y, ((1, V[0]), (2, V[1])), ((1, up[0]), (2, up[1]))),
            (closed, "periodic", "periodic"),
        ):
            curve = CubicSpline(t, points, low, kind="geometric", manifold=M)
            reflections = reflection(points)
            if high == "periodic":
                reflections[-1] = reflections[0]
            oracle = CubicSpline(t, reflections, high, kind="geometric", manifold=manifold_of_reflections(M))
            assert abs(reflection(curve(times)) - oracle(times)).max() < 1e-10
            assert curve.report.converged
            assert abs(curve(0.0) - points[0]).max() < 1e-13
            assert abs(curve(times).conj().swapaxes(-1, -2) @ curve.velocity(times)).max() < 1e-12
            again = pickle.loads(pickle.dumps(curve))
            assert (again.kind, again.manifold) == ("geometric", M)
            assert np.array_equal(again(times), curve(times))


def test_degenerate_control_points():
    E, M = np.eye(4), Grassmann(4, 2)
    still = GeometricPolynomial([E[:, [0, 1]], E[:, [1, 0]], -E[:, [0, 1]]], manifold=M)
    assert abs(still([0.0, 0.4, 1.0]) - E[:, :2]).max() < 1e-14
    with pytest.raises(stiefel_rs.OutsideDomainError, match="principal angle") as caught:
        GeometricPolynomial([E[:, [0, 1]], E[:, [1, 2]]], manifold=M)
    assert caught.value.angle == pytest.approx(np.pi / 2)
    V = np.zeros((4, 2))
    V[2, 0] = 5.4
    with pytest.raises(stiefel_rs.InvalidInputError, match=r"^V0: must be short enough .* found 5\.4"):
        GeometricCubic(E[:, :2], V, E[:, :2], 0 * V, manifold=M)
    with pytest.raises(stiefel_rs.InvalidInputError, match=r"V1: must be short enough .* found 5\.4") as caught:
        CubicHermite([0, 1, 2], [E[:, :2]] * 3, [0 * V, V, V], "geometric", manifold=M)
    assert caught.value.knot == 0
    turning = E[:, :2] @ np.array([[0, 1], [-1, 0]])
    with pytest.raises(stiefel_rs.InvalidInputError, match=r"V1.*not horizontal"):
        GeometricCubic(E[:, :2], 0 * V, E[:, :2], turning, manifold=M)
    for n, field in ((1, "real"), (3, "real"), (2, "complex")):
        whole = Grassmann(n, n, field=field)
        P = whole.random_point(14, size=3)
        assert abs(GeometricPolynomial(P, manifold=whole)(0.6) - P[0]).max() < 1e-14


def test_lines_in_the_plane_are_scipys_spline_of_half_the_angle():
    t, angle = np.array([0.0, 1.0, 1.5, 3.0]), np.array([0.0, 0.9, 1.4, 0.3])
    signs = np.array([1, -1, -1, 1])
    Y = signs[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], -1)[..., None]
    curve = CubicSpline(t, Y, manifold=Grassmann(2, 1))
    times = np.linspace(0, 3, 40)
    expected = FlatSpline(t, angle, bc_type="natural")(times)
    assert abs(curve(times)[..., 0] - np.stack([np.cos(expected), np.sin(expected)], -1)).max() < 1e-12


def test_states_of_a_qubit_are_a_sphere_of_radius_one_half():
    rng = np.random.default_rng(6)
    M, t = Grassmann(2, 1, field="complex"), np.array([0.0, 1.0, 2.0, 3.0])
    states = knots(M, 4, 0.5, seed=7) * np.exp(1j * rng.uniform(0, 6, (4, 1, 1)))
    pauli = np.array([[[0, 1], [1, 0]], [[0, -1j], [1j, 0]], [[1, 0], [0, -1]]])

    def bloch(psi):
        return np.einsum("...ia,pij,...ja->...p", psi.conj(), pauli, psi).real[..., None]

    curve, sphere = CubicSpline(t, states, manifold=M), CubicSpline(t, bloch(states))
    times = np.linspace(0, 3, 25)
    assert abs(bloch(curve(times)) - sphere(times)).max() < 1e-11
    assert curve.cost() == pytest.approx(sphere.cost() / 4, rel=1e-10)
    U, V = (M.random_tangent(states[0], rng=i) for i in (8, 9))
    assert M.sectional_curvature(states[0], U, V) == pytest.approx(4, rel=1e-12)


@pytest.mark.parametrize(
    ("n", "k", "field"), [(60, 3, "real"), (300, 6, "real"), (40, 10, "real"), (60, 3, "complex"), (40, 10, "complex")]
)
def test_tall_bases_and_representatives(n, k, field):
    M = Grassmann(n, k, field=field)
    t, Y = np.arange(6.0), knots(M, 6, 0.8, seed=10)
    curve = CubicSpline(t, Y, manifold=M)
    turned = Y @ Stiefel(k, k, field=field).random_point(rng=11, size=6)
    other = CubicSpline(t, turned, manifold=M)
    times = np.linspace(0, 5, 23)
    one, two = curve(times), other(times)
    # |P - Q| of projectors; measured at most 8e-15.
    assert abs(one - two @ (two.conj().swapaxes(-1, -2) @ one)).max() < 1e-12
    for i in range(1, 5):
        before, after = curve.pieces[i - 1], curve.pieces[i]
        # Measured at most 3e-15 and 2e-13.
        assert abs(before(1.0) - after(0.0)).max() < 5e-14
        assert abs(before.acceleration(1.0) - after.acceleration(0.0)).max() < 2e-12


def test_what_there_is_of_frames_only_is_refused():
    M = Grassmann(4, 2)
    Y = knots(M, 3)
    with pytest.raises(stiefel_rs.InvalidInputError, match="points of shape"):
        CubicSpline([0, 1, 2], Y, manifold=Grassmann(5, 2))
    with pytest.raises(TypeError, match="Stiefel or a Grassmann"):
        CubicSpline([0, 1, 2], Y, manifold="Gr")
    with pytest.raises(TypeError, match="complex"):
        CubicSpline([0, 1, 2], Y + 0j, manifold=M)
    with pytest.raises(stiefel_rs.InvalidInputError, match="canonical"):
        CubicSpline([0, 1, 2], Y, manifold=Stiefel(4, 2, metric="euclidean"))
    turning = Y[0] @ np.array([[0, 1], [-1, 0]])
    with pytest.raises(stiefel_rs.InvalidInputError, match="not horizontal"):
        RiemannianCubic.from_initial(Y[0], turning, 0 * turning, 0 * turning, manifold=M)
    E = np.eye(4)
    with pytest.raises(stiefel_rs.OutsideDomainError, match="principal angle") as caught:
        CubicSpline([0, 1], [E[:, :2], E[:, 2:]], manifold=M)
    assert caught.value.angle == pytest.approx(np.pi / 2)
    assert caught.value.knot == 0


def test_derivatives():
    M = Grassmann(5, 2)
    t, Y = np.arange(4.0), knots(M, 4, seed=12)
    curve = CubicSpline(t, Y, manifold=M)
    # Expressed in the bases of the curve.
    Y = curve(t)
    dY = M.random_tangent(Y, rng=13)
    found = curve.point_variation(1.4, dY)

    def point(s):
        moved = CubicSpline(t, M.exp(Y, s * dY), manifold=M)(1.4)
        return M.align(curve(1.4), moved)

    h = 1e-4
    expected = M.project_tangent(curve(1.4), (point(h) - point(-h)) / (2 * h))
    assert abs(found - expected).max() < 1e-6


@pytest.mark.parametrize(("n", "field"), [(1, "real"), (3, "real"), (2, "complex")])
def test_the_whole_space_stands_still(n, field):
    M = Grassmann(n, n, field=field)
    Y = M.random_point(14, size=3)
    for curve in (CubicSpline([0, 1, 2], Y, manifold=M), CubicHermite([0, 1, 2], Y, 0 * Y, manifold=M)):
        assert abs(curve(np.linspace(0, 2, 5)) - Y[0]).max() < 1e-14
        assert np.array_equal(pickle.loads(pickle.dumps(curve))(1.5), curve(1.5))


def test_lines_take_the_cheaper_sense():
    M, rng = Grassmann(3, 1), np.random.default_rng(15)
    for _ in range(20):
        Y0, Y1 = M.random_point(rng, size=2)
        V0, V1 = (4 * M.random_tangent(Y, rng) for Y in (Y0, Y1))
        cost = RiemannianCubic.from_boundary(Y0, V0, Y1, V1, manifold=M).cost()
        both = [RiemannianCubic.from_boundary(Y0, V0, s * Y1, s * V1).cost() for s in (1, -1)]
        assert cost == pytest.approx(min(both), rel=1e-9)


def test_fast_legs_are_stored():
    """Their polynomials have orders up to 70."""
    rng = np.random.default_rng(2)
    S = [Stiefel(3, 3).random_point(rng)]
    for _ in range(4):
        V = Stiefel(3, 3).random_tangent(S[-1], rng)
        S.append(Stiefel(3, 3).exp(S[-1], 2 / Stiefel(3, 3).norm(S[-1], V) * V))
    curve = CubicSpline([0, 1, 1.3, 3, 3.4], S)
    assert np.array_equal(pickle.loads(pickle.dumps(curve))(2.0), curve(2.0))


def test_fast_lines_in_complex_space_are_joined():
    """Near lines with speeds up to 6; without a descent from the cubic of flat space, four of these are not solved."""
    M, rng = stiefel_rs.Grassmann(3, 1, field="complex"), np.random.default_rng(0)

    def vector(Y, length):
        V = M.random_tangent(Y, rng=rng)
        return V * (length / M.norm(Y, V))

    for _ in range(60):
        Y0 = M.random_point(rng=rng)
        Y1 = M.exp(Y0, vector(Y0, rng.uniform(0, 1.4)))
        V0, V1 = (vector(Y, rng.uniform(0, 6)) for Y in (Y0, Y1))
        stiefel_rs.RiemannianCubic.from_boundary(Y0, V0, Y1, V1, manifold=M)
