"""The formulas of docs/mathematics.md for curves of subspaces, compared with the package."""

import itertools

import numpy as np
import pytest
from complex_frames import H, assert_close, embed, restrict
from formulas import bracket
from scipy.linalg import expm, polar, svd

from stiefel_rs import (
    CubicSpline,
    Geodesic,
    GeometricCubic,
    GeometricPolynomial,
    Grassmann,
    RiemannianCubic,
    SmoothingSpline,
    Stiefel,
    integrate_cubic,
    orthogonal_log,
)

SHAPES = [(3, 1), (3, 2), (4, 2), (5, 3), (8, 3)]
PAULI = np.array([[[0, 1], [1, 0]], [[0, -1j], [1j, 0]], [[1, 0], [0, -1]]])


@pytest.fixture(params=SHAPES, ids=str)
def data(request, rng):
    """A manifold, a basis, and three horizontal vectors of length 0.6 at it."""
    return problem(Grassmann(*request.param), rng)


def problem(M, rng):
    Y = M.random_point(rng)
    vectors = (M.random_tangent(Y, rng) for _ in range(3))
    return M, Y, *(V * (0.6 / M.norm(Y, V)) for V in vectors)


def horizontal(Y, W):
    return W - Y @ (H(Y) @ W)


def derivative(f, t, h=1e-3):
    return (8 * (f(t + h) - f(t - h)) - (f(t + 2 * h) - f(t - 2 * h))) / (12 * h)


def reflection(Y):
    return 2 * Y @ H(Y) - np.eye(Y.shape[-2])


def reflected(Y, V):
    return 2 * (V @ H(Y) + Y @ H(V))


@pytest.mark.parametrize("tension", [0.0, 2.5])
def test_equation_of_cubics(data, tension):
    M, *initial = data
    curve = RiemannianCubic.from_initial(*initial, tension=tension, manifold=M)
    t = 0.4
    Y, V, A, J = curve(t), curve.velocity(t), curve.acceleration(t), curve.jerk(t)
    assert_close(Y.T @ curve(t, 1), 0, 1e-14, "Y^T Y'")
    assert_close(A, horizontal(Y, curve(t, 2)), 1e-12, "D_t Y' = (I - Y Y^T) Y''")
    assert_close(horizontal(Y, derivative(curve.velocity, t)), A, 1e-10, "D_t V")
    assert_close(horizontal(Y, derivative(curve.acceleration, t)), J, 1e-10, "D_t A")
    third = horizontal(Y, derivative(curve.jerk, t))
    assert_close(third, tension * A - M.curvature(Y, A, V, V), 1e-9, "the equation of cubics")
    energy = (np.sum(A**2) + tension * np.sum(V**2)) / 2 - np.sum(J * V)
    assert_close(curve.energy, energy, 1e-12, "energy")
    nodes, weights = np.polynomial.legendre.leggauss(30)
    squares = [np.sum(curve.acceleration(s) ** 2 + tension * curve.velocity(s) ** 2) for s in (nodes + 1) / 2]
    assert_close(curve.cost(), weights @ squares / 2, 1e-11, "cost")


def test_another_basis_at_the_start(data, rng):
    M, *initial = data
    Q = Stiefel(M.k, M.k).random_point(rng)
    curve, turned = (
        RiemannianCubic.from_initial(*vectors, manifold=M) for vectors in (initial, [X @ Q for X in initial])
    )
    assert_close(turned(0.7), curve(0.7) @ Q, 1e-13, "Y Q")


def frame(Y):
    return np.hstack([Y, svd(Y)[0][:, Y.shape[1] :]])


def parts(x, k):
    """The parts of a skew matrix in m and in h, which has both diagonal blocks."""
    m = np.zeros_like(x)
    m[k:, :k], m[:k, k:] = x[k:, :k], x[:k, k:]
    return m, x - m


def lifted(g, V):
    k = V.shape[1]
    x = np.zeros((len(g), len(g)))
    x[k:, :k] = (g.T @ V)[k:]
    return x - x.T


@pytest.mark.parametrize("tension", [0.0, 3.0])
def test_form_in_frames(data, tension):
    M, Y, V, A, J = data
    k, g = M.k, frame(Y)
    # The second derivative of x is the covariant jerk.
    x, dx, ddx = (lifted(g, W) for W in (V, A, J))
    assert_close(parts(bracket(x, dx), k)[0], 0, 0.0, "[m, m] in h")
    third = -bracket(parts(bracket(x, dx), k)[1], x) + tension * dx
    assert_close(parts(third, k)[1], 0, 1e-15, "the part of x''' in h")
    B, dB, ddB = (y[k:, :k] for y in (x, dx, ddx))
    N, P = dB.T @ B, B.T @ B
    assert_close(third[k:, :k], B @ (2 * N - N.T) - dB @ P + tension * dB, 1e-15, "the blocks")
    assert_close(B @ (2 * N - N.T) - dB @ P, B @ (N - (N.T - N)) - dB @ P, 1e-15, "N^T - N for omega''")
    assert_close(g @ x, np.hstack([g[:, k:] @ B, -Y @ B.T]), 1e-15, "Y' and E'")
    curve = RiemannianCubic.from_initial(Y, V, A, J, tension=tension, manifold=M)
    Z = tension * B - ddB
    mu = np.block([[N - N.T, -Z.T], [Z, dB @ B.T - B @ dB.T]])
    assert_close(mu, tension * x - ddx + parts(bracket(x, dx), k)[1], 1e-15, "mu")
    assert_close(curve.momentum, g @ mu @ g.T, 1e-13, "momentum")


def test_bounds_of_derivatives(data, rng):
    M, Y, V, A, J = data
    v, a, j = (np.linalg.norm(X) for X in (V, A, J))
    assert np.linalg.norm(M.curvature(Y, A, V, V)) <= 2 * a * v**2 * (1 + 1e-14)
    # The derivative of -R(A, V) V along a cubic, since the tensor is parallel.
    second = M.curvature(Y, J, V, V) + M.curvature(Y, A, V, A)
    assert np.linalg.norm(second) <= 2 * (j * v**2 + a**2 * v)
    curve = RiemannianCubic.from_initial(Y, V, A, J, manifold=M)
    bounds, t = curve.derivative_bounds(), np.linspace(0, 1, 200)
    for name in ("velocity", "acceleration", "jerk"):
        largest = np.linalg.norm(getattr(curve, name)(t), axis=(1, 2)).max()
        assert largest <= getattr(bounds, name) <= 1.1 * largest, name
    moved = derivative(lambda s: horizontal(curve(s), derivative(curve.jerk, s)), 0.4)
    Y, V, A, J = curve(0.4), curve.velocity(0.4), curve.acceleration(0.4), curve.jerk(0.4)
    exact = -M.curvature(Y, J, V, V) - M.curvature(Y, A, V, A)
    assert_close(horizontal(Y, moved), exact, 1e-7, "D_t^2 J")


def test_bound_of_curvature_is_reached():
    M = Grassmann(4, 2)
    Y, U = np.eye(4, 2), np.eye(4, 2, -2)
    V = U[:, ::-1] * [1, -1]
    assert np.isclose(np.linalg.norm(M.curvature(Y, U, V, V)), 2 * np.linalg.norm(U) * np.linalg.norm(V) ** 2)
    assert np.isclose(M.sectional_curvature(Y, U, V), 2)


def test_reflections(data):
    M, *initial = data
    curve = RiemannianCubic.from_initial(*initial, manifold=M)
    Y, *vectors = initial
    other = RiemannianCubic.from_initial(reflection(Y), *(reflected(Y, V) for V in vectors))
    t = np.linspace(0, 1, 5)
    Y = curve(t)
    assert_close(other(t), reflection(Y), 1e-12, "points")
    for name in ("velocity", "acceleration", "jerk"):
        pairs = zip(Y, getattr(curve, name)(t), strict=True)
        assert_close(getattr(other, name)(t), [reflected(*pair) for pair in pairs], 1e-11, name)
    assert_close(other.cost(), 4 * curve.cost(), 1e-11, "cost")
    assert_close(other.arc_length(), 2 * curve.arc_length(), 1e-11, "length")
    noisy = M.project(Y + 0.05 * np.sin(np.arange(Y.size)).reshape(Y.shape))
    smooth, oracle = (
        SmoothingSpline(t, points, lam=0.01, **kind)
        for points, kind in ((noisy, {"manifold": M}), (reflection(noisy), {}))
    )
    assert_close(oracle.misfit, 4 * smooth.misfit, 1e-8, "misfit")


def test_complex_subspaces(rng):
    M, real = Grassmann(4, 2, field="complex"), Grassmann(8, 4)
    _, *initial = problem(M, rng)
    curve = RiemannianCubic.from_initial(*initial, manifold=M)
    other = RiemannianCubic.from_initial(*map(embed, initial), manifold=real)
    assert M.dim == 2 * 2 * (4 - 2)
    assert_close(curve(0.6), restrict(other(0.6)), 1e-13, "points")
    assert_close(curve.cost(), other.cost() / 2, 1e-12, "cost")
    assert_close(H(curve(0.6)) @ curve(0.6, 1), 0, 1e-14, "Y^H Y'")


def bloch(y):
    return np.einsum("...ia,pij,...ja->...p", y.conj(), PAULI, y).real


def test_lines_of_two_complex_numbers(rng):
    M = Grassmann(2, 1, field="complex")
    _, y, *vectors = problem(M, rng)
    other = M.exp(y, vectors[0])
    r, s = bloch(y), bloch(other)
    assert_close(np.linalg.norm(r), 1, 1e-15, "r on the sphere")
    assert_close(M.dist(y, other), np.arccos(abs(H(y) @ other)).item(), 1e-12, "arccos")
    assert_close(M.dist(y, other), np.arccos(r @ s) / 2, 1e-12, "half of the angle")
    assert np.isclose(M.sectional_curvature(y, *vectors[:2]), 4)
    curve = RiemannianCubic.from_initial(y, *vectors, manifold=M)
    ends = []
    for t in (0.0, 1.0):
        ends += [bloch(curve(t))[:, None], derivative(lambda s: bloch(curve(s)), t)[:, None]]
    around = RiemannianCubic.from_boundary(*ends, tol=1e-9)
    assert np.isclose(around.cost(), 4 * curve.cost(), rtol=1e-8)


def test_loop_of_states():
    """An octant of the sphere: counter-clockwise as seen from outside, along the axes z, x, y."""
    M = Grassmann(2, 1, field="complex")
    states = np.array([[1, 0], [np.sqrt(0.5), np.sqrt(0.5)], [np.sqrt(0.5), 1j * np.sqrt(0.5)], [1, 0]])[..., None]
    assert_close(bloch(states), [[0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 0, 1]], 1e-15, "axes")
    y = states[0] + 0j
    for state in states[1:]:
        y = Geodesic(y, state, manifold=M)(1.0)
    assert_close(y, np.exp(-0.5j * np.pi / 2) * states[0], 1e-14, "e^{-i Omega / 2} y")


@pytest.mark.parametrize("tension", [0.0, 4.0])
def test_strang_step(data, tension):
    M, Y, V, A, J = data
    k, g, h = M.k, frame(Y), 0.1
    x, p, ddx = (lifted(g, W) for W in (V, A, J))
    mu = tension * x - ddx + parts(bracket(x, p), k)[1]
    x = x + h / 2 * p
    Z = h * x
    term, F = mu, np.zeros_like(mu)
    for j in range(1, 20):
        F, term = F + term, -bracket(Z, term) / (j + 1)
    g, p = g @ expm(Z), p + tension * Z - parts(h * F, k)[0]
    x = x + h / 2 * p
    step = integrate_cubic(Y, V, A, J, 1, t_end=h, order=2, tension=tension, manifold=M)
    assert_close(step.point[-1], g[:, :k], 1e-14, "point")
    assert_close(step.velocity[-1], (g @ x)[:, :k], 1e-14, "velocity")
    assert_close(step.acceleration[-1], (g @ p)[:, :k], 1e-13, "acceleration")


def test_pieces_of_a_spline(rng):
    M, t = Grassmann(5, 2), np.array([0.0, 1.0, 1.5, 3.0])
    Y = M.random_point(rng)
    points = np.stack([M.exp(Y, 0.4 * M.random_tangent(Y, rng)) for _ in t])
    V = 0.3 * M.random_tangent(points[[0, -1]], rng)
    curve = CubicSpline(t, points, ((1, V[0]), (1, V[1])), manifold=M)
    h = np.diff(t)
    for i in range(4):
        Q = polar(points[i].T @ curve(t[i]))[0]
        assert_close(curve(t[i]), points[i] @ Q, 1e-12, "Y_i Q_i")
        if i in (0, 3):
            assert_close(curve.velocity(t[i]), V[i // 3] @ Q, 1e-11, "V_i Q_i")
    for i in (1, 2):
        before, after = curve.pieces[i - 1], curve.pieces[i]
        for name, order in (("velocity", 1), ("acceleration", 2)):
            left, right = getattr(before, name)(1.0) / h[i - 1] ** order, getattr(after, name)(0.0) / h[i] ** order
            assert_close(left, right, 1e-10, name)
    boundary = RiemannianCubic.from_boundary(points[0], V[0], points[-1], V[1], manifold=M)
    Q = polar(points[-1].T @ boundary(1.0))[0]
    assert_close(boundary(1.0), points[-1] @ Q, 1e-11, "Y_1 Q")
    assert_close(boundary.velocity(1.0), V[1] @ Q, 1e-11, "V_1 Q")


def weights(C, t):
    """The functions a_t and b_t of a symmetric matrix."""
    cosines, vectors = np.linalg.eigh(C)
    turns = np.arccos(np.minimum(cosines, 1)) / np.pi
    return [(vectors * (s * np.sinc(s * turns) / np.sinc(turns))) @ vectors.T for s in (1 - t, t)]


def joined(F0, F1, t):
    Q, C = polar(F0.T @ F1, side="left")
    a, b = weights(C, t)
    return F0 @ a + F1 @ Q.T @ b


def de_casteljau(points, t, join):
    while len(points) > 1:
        points = [join(x, y, t) for x, y in itertools.pairwise(points)]
    return points[0]


def test_de_casteljau_curves(data):
    M, Y, V, W, _ = data
    Y1 = M.exp(Y, W)
    V1 = M.project_tangent(Y1, V)
    curve = GeometricCubic(Y, V, Y1, V1, manifold=M)
    points = [Y, M.exp(Y, V / 3), M.exp(Y1, -V1 / 3), Y1]
    assert_close(curve.control_points, np.array(points), 1e-14, "control points")
    angles = [max(M.principal_angles(x, y)) for x, y in itertools.pairwise(points)]
    for t in (0.0, 0.3, 0.8):
        inner = [M.exp(x, t * M.log(x, y)) for x, y in itertools.pairwise(points)]
        assert max(M.principal_angles(inner[0], inner[1])) <= (1 - t) * angles[0] + t * angles[1] + 1e-14
        F = de_casteljau(points, t, joined)
        assert_close(reflection(F), reflection(curve(t)), 1e-13, "F")
    # The rate of the bases F, and of R = F^T Y.
    t = 0.4
    F, slope = de_casteljau(points, t, joined), derivative(lambda s: de_casteljau(points, s, joined), t)
    R, rate = F.T @ curve(t), derivative(lambda s: de_casteljau(points, s, joined).T @ curve(s), t)
    assert_close(rate, -F.T @ slope @ R, 1e-10, "R'")


def test_barycentric_weights_of_gauss_nodes_and_ends():
    x, w = np.polynomial.legendre.leggauss(20)
    nodes, signs = np.concatenate([[0], (x + 1) / 2, [1]]), np.resize([1, -1], 22)
    weights = signs * np.concatenate([[0.5], np.sqrt(w / 2 / (1 - x**2)), [0.5]])
    exact = 1 / np.prod(2 * (nodes[:, None] - nodes) + np.eye(22), axis=1)
    assert_close(weights / weights[0], exact / exact[0], 1e-12, "lambda")


def test_end_acceleration_of_de_casteljau_curves(data):
    M, Y, V, W, _ = data
    Y1 = M.exp(Y, W)
    curve = GeometricCubic(Y, V, Y1, M.project_tangent(Y1, V), manifold=M)
    U, A = V / 3, curve.acceleration(0.0)
    inner = M.exp(Y, U)
    onward = M.log(inner, curve.control_points[2]) - Geodesic.from_velocity(Y, U, manifold=M).velocity(1.0)
    moved = derivative(lambda s: M.align(inner, M.exp(Y, U + s * A)), 0.0)
    assert_close(horizontal(inner, moved), 6 * onward, 1e-9, "(D exp) [D_t Y'(0)]")


def test_de_casteljau_curves_of_reflections(data):
    M, Y, *vectors = data
    points = [Y, *(M.exp(Y, V) for V in vectors)]
    curve = GeometricPolynomial(points, manifold=M)

    def piece(P0, P1, t):
        return half_power(P1 @ P0, t) @ P0 @ half_power(P0 @ P1, t)

    for t in (0.2, 0.5, 1.0):
        expected = de_casteljau([reflection(y) for y in points], t, piece)
        assert_close(reflection(curve(t)), expected, 1e-13, "reflections")


def half_power(Q, t):
    """The power t / 2 of a rotation."""
    return expm(t / 2 * orthogonal_log(Q))


def test_isotropy_turns_the_blocks(rng):
    q = [Stiefel(m, m).random_point(rng) for m in (2, 3)]
    B = rng.standard_normal((3, 2))
    x = np.block([[np.zeros((2, 2)), -B.T], [B, np.zeros((3, 3))]])
    whole = np.block([[q[0], np.zeros((2, 3))], [np.zeros((3, 2)), q[1]]])
    assert_close((whole @ x @ whole.T)[2:, :2], q[1] @ B @ q[0].T, 1e-14, "Ad_q")
