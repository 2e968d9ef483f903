"""The formulas of docs/mathematics.md in NumPy and SciPy, compared with the package."""

import numpy as np
import pytest
from formulas import bracket, christoffel, skew, split
from scipy.linalg import block_diag, expm, logm, lu, polar, sqrtm, svd

from stiefel_rs import (
    Geodesic,
    GeometricCubic,
    GeometricPolynomial,
    Grassmann,
    QuasiGeodesic,
    RiemannianCubic,
    Stiefel,
    integrate_cubic,
    integrate_embedded,
    orthogonal_log,
    skew_exp,
)

SHAPES = [(3, 1), (3, 2), (5, 2), (6, 3), (4, 4)]
METRICS = ["canonical", "euclidean", 1.5]


@pytest.fixture(params=SHAPES, ids=str)
def data(request, rng):
    """A point, three tangent vectors of length about 0.6 at it, and the manifold."""
    M = Stiefel(*request.param)
    S = M.random_point(rng)
    vectors = (M.random_tangent(S, rng) for _ in range(3))
    return M, S, *(V * (0.6 / M.norm(S, V)) for V in vectors)


def function_of_ad(coefficients, X, Y):
    """`sum_j c_j ad_X^j Y`."""
    total = np.zeros_like(Y)
    for c in coefficients:
        total, Y = total + c * Y, bracket(X, Y)
    return total


def differential(S, u, z, h=1e-5):
    """`D R_u[z]` of the quasi-geodesic retraction, by central differences."""

    def image(tau):
        Omega, _, X = split(S, u + tau * z)
        return expm(X) @ S @ expm(Omega)

    return (8 * (image(h) - image(-h)) - (image(2 * h) - image(-2 * h))) / (12 * h)


def weight(M):
    return 1 / (2 * (M.alpha + 1))


def normal_basis(S, *vectors):
    """An orthonormal basis of the normal parts of tangent vectors."""
    K = np.hstack([split(S, V)[1] for V in vectors])
    U, s, _ = svd(K, full_matrices=False)
    return U[:, s > 1e-12]


def generator(w, A, B):
    return np.block([[2 * w * A, -B.T], [B, np.zeros((len(B), len(B)))]])


def test_metric(data):
    M, S, V, W, _ = data
    for metric in METRICS:
        N = Stiefel(M.n, M.k, metric=metric)
        a = N.alpha
        form = np.trace(V.T @ (np.eye(M.n) - (2 * a + 1) / (2 * (a + 1)) * S @ S.T) @ W)
        assert np.isclose(N.inner(S, V, W), form)
        Omega, K, _ = split(S, V)
        assert np.isclose(N.norm(S, V) ** 2, np.sum(K**2) + weight(N) * np.sum(Omega**2))


@pytest.mark.parametrize("metric", METRICS)
def test_geodesic(metric, data):
    M, S, V, _, _ = data
    w = weight(Stiefel(M.n, M.k, metric=metric))
    Q, A = normal_basis(S, V), S.T @ V
    E = expm(0.7 * generator(w, A, Q.T @ V))[:, : M.k]
    expected = np.hstack([S, Q]) @ E @ expm(0.7 * (1 - 2 * w) * A)
    assert np.allclose(Geodesic.from_velocity(S, V, metric=metric)(0.7), expected, atol=1e-13)


@pytest.mark.parametrize("metric", METRICS)
def test_transport(metric, data):
    M, S, V, W, _ = data
    N = Stiefel(M.n, M.k, metric=metric)
    w, Q, Omega = weight(N), normal_basis(S, V), S.T @ V
    B, C, D = Q.T @ V, S.T @ W, Q.T @ W
    rest = W - S @ C - Q @ D

    def operator(C, D):
        return (0.5 - 2 * w) * bracket(Omega, C) + (B.T @ D - D.T @ B) / 2, w * (D @ Omega - B @ C)

    # The exponential of the operator by its series.
    term, total = (C, D), (C, D)
    for j in range(1, 40):
        term = tuple(part / j for part in operator(*term))
        total = tuple(a + b for a, b in zip(total, term, strict=True))
    E = expm(generator(w, Omega, B))
    expected = np.hstack([S, Q]) @ E @ np.vstack(total) @ expm((1 - 2 * w) * Omega) + rest @ expm((1 - w) * Omega)
    assert np.allclose(N.transport(S, V, W), expected, atol=1e-13)


@pytest.mark.parametrize("metric", METRICS)
def test_curvature(metric, data):
    M, S, U, V, W = data
    N = Stiefel(M.n, M.k, metric=metric)
    k, w, Q = M.k, weight(N), normal_basis(S, U, V, W)
    # Pairs (A, B), one above the other.
    x, y, z = (np.hstack([S, Q]).T @ T for T in (U, V, W))

    def connection(x, z):
        A, B, C, D = x[:k], x[k:], z[:k], z[k:]
        return np.vstack([(bracket(A, C) - B.T @ D + D.T @ B) / 2, w * B @ C - (1 - w) * D @ A])

    A, B, C, D = x[:k], x[k:], y[:k], y[k:]
    in_m = np.vstack([bracket(A, C) - B.T @ D + D.T @ B, B @ C - D @ A])
    in_h = D @ B.T - B @ D.T
    turned = np.vstack([np.zeros((k, k)), in_h @ z[k:]])
    R = connection(x, connection(y, z)) - connection(y, connection(x, z)) - connection(in_m, z) - turned
    assert np.allclose(N.curvature(S, U, V, W), np.hstack([S, Q]) @ R, atol=1e-13)
    area = N.norm(S, U) ** 2 * N.norm(S, V) ** 2 - N.inner(S, U, V) ** 2
    if area > 1e-3:
        sectional = N.inner(S, N.curvature(S, U, V, V), U) / area
        assert np.isclose(N.sectional_curvature(S, U, V), sectional)


@pytest.mark.parametrize("metric", METRICS)
def test_gradient_and_hessian(metric, data, rng):
    M, S, V, _, _ = data
    N = Stiefel(M.n, M.k, metric=metric)
    w, (G, H) = weight(N), rng.standard_normal((2, M.n, M.k))
    P, (A, B, _) = np.eye(M.n) - S @ S.T, split(S, V)
    Y, normal = (S.T @ G + G.T @ S) / 2, P @ G
    gradient = normal + S @ skew(S.T @ G) / w
    inner = skew(S.T @ H) - (A @ Y + Y @ A) / 2 + (1 - w) * skew(B.T @ normal)
    hessian = P @ H - B @ Y - (1 - w) * normal @ A + S @ inner / w
    assert np.allclose(N.euclidean_to_riemannian_gradient(S, G), gradient, atol=1e-13)
    assert np.allclose(N.euclidean_to_riemannian_hessian(S, G, H, V), hessian, atol=1e-13)


def test_retractions_and_their_inverses(data):
    M, S, V, _, _ = data
    Omega, K, _ = split(S, V)
    half = np.eye(M.n) - S @ S.T / 2
    W = half @ V @ S.T - S @ V.T @ half
    N = np.eye(M.k) - Omega / 2 + K.T @ K / 4
    cayley = (2 * S + K) @ np.linalg.inv(N) - S
    assert np.allclose(W @ S, V)
    assert np.allclose(cayley, np.linalg.solve(np.eye(M.n) - W / 2, (np.eye(M.n) + W / 2) @ S))
    assert np.allclose(M.retract(S, V, "cayley"), cayley, atol=1e-14)
    assert np.allclose(N, 2 * np.linalg.inv(np.eye(M.k) + S.T @ cayley))
    assert np.allclose((np.eye(M.n) - S @ S.T) @ cayley @ N, K)
    nearest = (S + V) @ np.linalg.inv(sqrtm(np.eye(M.k) + V.T @ V))
    assert np.allclose(M.retract(S, V, "polar"), nearest, atol=1e-13)

    # The matrix sign iteration, without its scaling.
    A, G = S.T @ nearest, 2 * np.eye(M.k)
    for _ in range(30):
        inverse = np.linalg.inv(A)
        A, G = (A + inverse) / 2, (G + inverse @ G @ inverse.T) / 2
    assert np.allclose(nearest @ (G / 2) - S, M.inverse_retract(S, nearest, "polar"), atol=1e-12)

    # The triangular equation, by elimination without exchanges.
    S1 = M.retract(S, V, "qr")
    exchange, L, U = lu(S.T @ S1)
    if np.allclose(exchange, np.eye(M.k)):
        F = np.linalg.solve(L, np.linalg.solve(L, 2 * np.eye(M.k)).T).T
        R = np.linalg.solve(U, (np.triu(F, 1) + np.diag(np.diag(F)) / 2) @ L.T)
        assert np.allclose(S1 @ R - S, M.inverse_retract(S, S1, "qr"), atol=1e-12)


def test_quasi_geodesic(data):
    M, S, V, _, _ = data
    Omega, K, X = split(S, V)
    t = 0.6
    curve = QuasiGeodesic.from_velocity(S, V)
    expected = expm(t * X) @ S @ expm(t * Omega)
    Q, s, Wt = svd(K, full_matrices=False)
    thin = (S @ Wt.T * np.cos(t * s) + Q * np.sin(t * s)) @ Wt @ expm(t * Omega)
    assert np.allclose(curve(t), expected, atol=1e-13)
    assert np.allclose(thin, expected, atol=1e-13)
    F = np.hstack([S @ Wt.T, Q])
    C, D = np.diag(np.cos(s)) - np.eye(M.k), np.diag(np.sin(s))
    assert np.allclose(V + F @ np.block([[C, -D], [D, C]]) @ F.T @ V, expm(X) @ V)
    # Covariant acceleration: by Christoffel symbols, and in closed form.
    assert np.allclose(curve.acceleration(0), curve(0, 2) + christoffel(S, V, V), atol=1e-12)
    assert np.allclose(curve.acceleration(0), K @ Omega, atol=1e-12)


def test_quasi_geodesic_between_two_points(data):
    M, S0, V, _, _ = data
    S1 = M.retract(S0, V)
    U, c, Zt = svd(S0.T @ S1)
    R, P = polar(S0.T @ S1, side="left")
    Omega = np.real(logm(U @ Zt))
    normal = (np.eye(M.n) - S0 @ S0.T) @ S1 @ Zt.T
    theta = np.arctan2(np.linalg.norm(normal, axis=0), c)
    K = normal / np.maximum(np.linalg.norm(normal, axis=0), 1e-300) * theta @ U.T
    assert np.allclose(M.inverse_retract(S0, S1), K + S0 @ Omega, atol=1e-7)

    t, (cosines, basis) = 0.3, np.linalg.eigh(P)
    angles = np.arccos(np.clip(cosines, -1, 1))
    b = np.where(angles < 1e-6, t, np.sin(t * angles) / np.where(angles < 1e-6, 1, np.sin(angles)))
    a = np.cos(t * angles) - cosines * b
    Rt = expm(t * np.real(logm(R)))
    beta = (S0 @ (basis * a) @ basis.T + S1 @ R.T @ (basis * b) @ basis.T) @ Rt
    assert np.allclose(QuasiGeodesic(S0, S1)(t), beta, atol=1e-7)


def test_derivative_of_the_inverse_retraction(data):
    _, S, u, z, _ = data
    Omega, _, X = split(S, u)
    dOmega, _, dX = split(S, z)
    carried = expm(-X) @ differential(S, u, z) @ expm(-Omega)
    j = np.arange(24)
    factorial = np.cumprod(np.r_[1.0, j[1:]])
    # sinh x / x, (1 - cosh x) / x and (e^x - 1) / x.
    sinh = np.where(j % 2 == 0, 1 / (factorial * (j + 1)), 0)
    cosh = np.where(j % 2 == 1, -1 / (factorial * (j + 1)), 0)
    exp = 1 / (factorial * (j + 1))
    L = function_of_ad(sinh, X, dX) @ S
    Psi = S.T @ function_of_ad(cosh, X, dX) @ S + function_of_ad(exp, Omega, dOmega)
    assert np.allclose(carried, L + S @ Psi, atol=1e-9)


def test_acceleration_at_the_start_of_a_geometric_cubic(data):
    M, S0, V0, V, V1 = data
    S1 = M.retract(S0, V)
    V1 = M.project_tangent(S1, V1)
    curve = GeometricCubic(S0, V0, S1, V1)
    P = curve.control_points
    U, W = V0 / 3, M.inverse_retract(P[1], P[2])
    Omega, _, X = split(S0, U)
    assert np.allclose(P[1], M.retract(S0, V0 / 3), atol=1e-13)
    assert np.allclose(P[2], M.retract(S1, -V1 / 3), atol=1e-13)
    bend = W - expm(X) @ U @ expm(Omega)
    Omega, K, _ = split(S0, V0)
    # With D R_U on both sides.
    assert np.allclose(differential(S0, U, curve.acceleration(0) - K @ Omega), 6 * bend, atol=1e-8)


def test_second_leg_of_the_quintic(data):
    M, S0, V, A, T = data
    S1 = M.retract(S0, T)
    V1, A1 = (M.project_tangent(S1, Y) for Y in (V, A))
    P = GeometricPolynomial.quintic(S0, V, A, S1, V1, A1).control_points
    Omega, K, _ = split(S0, V)
    m = 5
    w = differential(S0, V / m, V / m + (A - K @ Omega) / (m * (m - 1)))
    assert np.allclose(M.inverse_retract(P[1], P[2]), w, atol=1e-9)


def frame(S):
    """An orthogonal matrix whose first columns are those of `S`."""
    U, _, _ = svd(S)
    return np.hstack([S, U[:, S.shape[1] :]])


def parts(x, k):
    """The parts of a skew matrix in m and in h."""
    h = block_diag(np.zeros((k, k)), x[k:, k:])
    return x - h, h


def horizontal(g, V):
    """The matrix in m for which `V` is the first columns of `g v`."""
    n, k = V.shape
    Y = g.T @ V
    v = np.zeros((n, n))
    v[:, :k], v[:k, k:] = Y, -Y[k:].T
    return v


def initial(data):
    M, S, V, A, J = data
    g = frame(S)
    x, dx, j = (horizontal(g, T) for T in (V, A, J))
    return M, g, x, dx, j - parts(bracket(x, dx), M.k)[0] / 2


@pytest.mark.parametrize("tension", [0.0, 2.5])
def test_equation_of_cubics(data, tension):
    M, S, V, A, J = data
    curve = RiemannianCubic.from_initial(S, V, A, J, tension=tension)
    t, h = 0.4, 1e-3
    S, V, A = curve(t), curve.velocity(t), curve.acceleration(t)

    def derivative(f):
        return (8 * (f(t + h) - f(t - h)) - (f(t + 2 * h) - f(t - 2 * h))) / (12 * h)

    for function, expected in ((curve.velocity, A), (curve.acceleration, curve.jerk(t))):
        assert np.allclose(derivative(function) + christoffel(S, V, function(t)), expected, atol=1e-9)
    third = derivative(curve.jerk) + christoffel(S, V, curve.jerk(t))
    assert np.allclose(third, tension * A - M.curvature(S, A, V, V), atol=1e-9)
    H = (M.norm(S, A) ** 2 + tension * M.norm(S, V) ** 2) / 2 - M.inner(S, curve.jerk(t), V)
    assert np.isclose(curve.energy, H, atol=1e-12)


def test_frame_form_of_cubics(data):
    M, g, x, dx, ddx = initial(data)
    curve = RiemannianCubic.from_initial(*data[1:])
    k = M.k
    mu = -ddx + parts(bracket(x, dx), k)[1]
    assert np.allclose(curve.momentum, g @ mu @ g.T, atol=1e-13)
    taut = RiemannianCubic.from_initial(*data[1:], tension=3.0)
    assert np.allclose(taut.momentum, g @ (3 * x + mu) @ g.T, atol=1e-13)
    third = parts(bracket(ddx, x), k)[0] - bracket(parts(bracket(x, dx), k)[1], x)
    # The blocks of the recurrence.
    (w, b), (_, db), (ddw, ddb) = ((y[:k, :k], y[k:, :k]) for y in (x, dx, ddx))
    n, p = db.T @ b, b.T @ b
    dn = ddb.T @ b + db.T @ db
    assert np.allclose(third[k:, :k], ddb @ w + b @ (n - ddw) - db @ p, atol=1e-13)
    assert np.allclose(third[:k, :k], ddw @ w - (ddw @ w).T - (dn - dn.T), atol=1e-13)
    if M.n - k <= 1:
        assert np.allclose(third, ddx @ x - x @ ddx, atol=1e-13)


@pytest.mark.parametrize("tension", [0.0, 4.0])
def test_strang_step(data, tension):
    M, g, x, p, ddx = initial(data)
    h = 0.1
    mu = tension * x - ddx + parts(bracket(x, p), M.k)[1]
    x = x + h / 2 * p
    Z = h * x
    exp = (-1.0) ** np.arange(20) / np.cumprod(np.r_[1.0, np.arange(2, 21)])
    F = function_of_ad(exp, Z, mu)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    integral = sum(
        w * h / 2 * expm(-s * x) @ mu @ expm(s * x) for s, w in zip((nodes + 1) * h / 2, weights, strict=True)
    )
    assert np.allclose(h * F, integral, atol=1e-14)
    assert np.allclose(mu - bracket(Z, F), expm(-Z) @ mu @ expm(Z), atol=1e-14)
    g, p = g @ expm(Z), p + tension * Z - parts(h * F, M.k)[0]
    x = x + h / 2 * p
    step = integrate_cubic(*data[1:], 1, t_end=h, order=2, tension=tension)
    assert np.allclose(step.point[-1], g[:, : M.k], atol=1e-14)
    assert np.allclose(step.velocity[-1], (g @ x)[:, : M.k], atol=1e-14)
    assert np.allclose(step.acceleration[-1], (g @ p)[:, : M.k], atol=1e-13)


def embedded_field(z):
    """Vector field of the Hamiltonian in the embedding."""
    S, V, P, Q = z
    Omega = (S.T @ V - V.T @ S) / 2
    X, Y = V @ S.T - S @ V.T - S @ Omega @ S.T, Q @ S.T - S @ Q.T
    L = P @ S.T - S @ P.T + Q @ V.T - V @ Q.T
    K = S.T @ L @ S
    p_S = X @ P + Y @ Q + L @ (V - S @ Omega) - V @ K / 2
    return np.stack([X @ S, X @ V + Y @ S, p_S, X @ Q - L @ S + S @ K / 2])


def test_step_in_the_embedding(data):
    _, S, V, A, J = data
    h = 0.1

    def generated(W):
        return W @ S.T - S @ W.T - S @ S.T @ W @ S.T

    Q = A - S @ S.T @ A / 2
    B = (generated(V) @ A - generated(A) @ V) / 2 + Q @ S.T @ V - V @ S.T @ Q - J
    z = np.stack([S, V, B - S @ S.T @ B / 2, Q])
    end = z
    for _ in range(100):
        end = z + h * embedded_field((z + end) / 2)
    S, V, P, Q = end
    M = S.T @ Q + Q.T @ S
    P, Q = P - V @ M / 2, Q - S @ M / 2
    P = P - S @ (S.T @ P + P.T @ S) / 2
    A = Q - S @ Q.T @ S
    B = (generated(V) @ A - generated(A) @ V) / 2 + Q @ S.T @ V - V @ S.T @ Q
    step = integrate_embedded(*data[1:], 1, t_end=h)
    for name, value in (("point", S), ("velocity", V), ("acceleration", A), ("jerk", B - P + S @ P.T @ S)):
        assert np.allclose(getattr(step, name)[-1], value, atol=1e-13), name


SUBSPACES = [(3, 1), (4, 2), (5, 3), (5, 4), (8, 3)]


@pytest.fixture(params=SUBSPACES, ids=str)
def subspace(request, rng):
    """A Grassmann manifold, a point, and three tangent vectors of length 1."""
    M = Grassmann(*request.param)
    Y = M.random_point(rng)
    vectors = (M.random_tangent(Y, rng) for _ in range(3))
    return M, Y, *(V / np.linalg.norm(V) for V in vectors)


def test_geodesics_of_subspaces(subspace):
    M, Y, V, W, _ = subspace
    Q, s, Ut = svd(V, full_matrices=False)
    U, C, S = Ut.T, np.diag(np.cos(s)), np.diag(np.sin(s))
    assert M.dim == M.k * (M.n - M.k)
    np.testing.assert_allclose(Y.T @ V, 0, atol=1e-14)
    np.testing.assert_allclose(M.inner(Y, V, W), np.trace(V.T @ W), atol=1e-14)
    np.testing.assert_allclose(M.exp(Y, V), (Y @ U @ C + Q @ S) @ U.T, atol=1e-13)
    # Functions of G by its power series.
    G = V.T @ V
    terms = [np.linalg.matrix_power(-G, j) for j in range(12)]
    factorial = np.cumprod([1.0, *range(1, 25)])
    cosine = sum(term / factorial[2 * j] for j, term in enumerate(terms))
    sinc = sum(term / factorial[2 * j + 1] for j, term in enumerate(terms))
    np.testing.assert_allclose(M.exp(Y, V), Y @ cosine + V @ sinc, atol=1e-13)
    moved = W + (Q @ (C - np.eye(M.k)) - Y @ U @ S) @ Q.T @ W
    np.testing.assert_allclose(M.transport(Y, V, W), moved, atol=1e-13)


def test_logarithm_of_subspaces(subspace, rng):
    M, Y, _, _, _ = subspace
    Y1 = M.random_point(rng)
    A, cosines, Zt = svd(Y.T @ Y1)
    theta = np.arccos(np.minimum(cosines, 1))
    factor = np.where(theta > 0, theta / np.where(theta > 0, np.sin(theta), 1), 1)
    log = (np.eye(M.n) - Y @ Y.T) @ Y1 @ Zt.T @ np.diag(factor) @ A.T
    np.testing.assert_allclose(M.log(Y, Y1), log, atol=1e-13)
    sines = svd(Y1 - Y @ Y.T @ Y1, compute_uv=False)
    # Arccosines of small angles have only half of the digits.
    np.testing.assert_allclose(np.sin(M.principal_angles(Y, Y1)), sines, atol=1e-14)
    np.testing.assert_allclose(np.cos(M.principal_angles(Y, Y1)), cosines[::-1], atol=1e-14)
    np.testing.assert_allclose(M.dist(Y, Y1), np.linalg.norm(theta), atol=1e-7)
    aligned = Y1 @ Zt.T @ A.T
    np.testing.assert_allclose(M.align(Y, Y1), aligned, atol=1e-12)
    np.testing.assert_allclose(M.exp(Y, M.log(Y, Y1)), aligned, atol=1e-12)


def test_curvature_and_derivatives_of_subspaces(subspace, rng):
    M, Y, U, V, W = subspace
    R = U @ V.T @ W - V @ U.T @ W + W @ (V.T @ U - U.T @ V)
    np.testing.assert_allclose(M.curvature(Y, U, V, W), R, atol=1e-13)
    G, H = rng.standard_normal((2, M.n, M.k))
    P = np.eye(M.n) - Y @ Y.T
    np.testing.assert_allclose(M.euclidean_to_riemannian_gradient(Y, G), P @ G, atol=1e-13)
    hessian = P @ H - V @ Y.T @ G
    np.testing.assert_allclose(M.euclidean_to_riemannian_hessian(Y, G, H, V), hessian, atol=1e-13)


def test_reflections_of_subspaces(subspace):
    M, Y, V, _, _ = subspace
    S, group = 2 * Y @ Y.T - np.eye(M.n), Stiefel(M.n, M.n)
    X = 2 * (V @ Y.T + Y @ V.T)
    np.testing.assert_allclose(group.norm(S, X), 2 * M.norm(Y, V), atol=1e-13)
    end = M.exp(Y, 0.5 * V)
    np.testing.assert_allclose(group.exp(S, 0.5 * X), 2 * end @ end.T - np.eye(M.n), atol=1e-12)


def test_complex_exponential_and_logarithm(rng):
    Z = rng.standard_normal((2, 4, 4)) + 1j * rng.standard_normal((2, 4, 4))
    A = Z[0] - Z[0].conj().T
    Q = skew_exp(A)
    assert np.allclose(Q, expm(A), atol=1e-13)
    # Two rows: A = i phi I + r N.
    A = A[:2, :2]
    phi = np.trace(A).imag / 2
    rest = A - 1j * phi * np.eye(2)
    r = np.sqrt(-np.trace(rest @ rest).real / 2)
    N = rest / r
    assert np.allclose(N @ N, -np.eye(2), atol=1e-14)
    assert np.allclose(skew_exp(A), np.exp(1j * phi) * (np.cos(r) * np.eye(2) + np.sin(r) * N), atol=1e-14)
    # The logarithm, and the two Hermitian matrices with the same eigenvectors.
    L, a = orthogonal_log(Q), 0.7
    theta, B = np.linalg.eigh(-1j * L)
    assert np.allclose(L, -L.conj().T, atol=0)
    assert np.allclose(expm(L), Q, atol=1e-13)
    assert (-np.pi < theta).all() and (theta <= np.pi).all()
    H = (np.exp(-1j * a) * Q + np.exp(1j * a) * Q.conj().T) / 2
    K = (np.exp(-1j * a) * Q - np.exp(1j * a) * Q.conj().T) / 2j
    assert np.allclose(H, (B * np.cos(theta - a)) @ B.conj().T, atol=1e-13)
    assert np.allclose(K, (B * np.sin(theta - a)) @ B.conj().T, atol=1e-13)
