"""Retractions, parallel transport, curvature, gradients and Hessians compared with NumPy and SciPy."""

import inspect

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg

from stiefel_rs import ConvergenceError, InvalidInputError, OutsideDomainError, Stiefel

EPS = np.finfo(float).eps
KINDS = ["quasi_geodesic", "qr", "polar", "cayley"]
METRICS = {"canonical": 0.5, "euclidean": 1.0, 1.5: 0.2, -0.8: 2.5}


def T(A):
    return np.swapaxes(A, -1, -2)


def skew(A):
    return (A - T(A)) / 2


def split(S, V):
    return V - S @ (T(S) @ V), skew(T(S) @ V)


def assert_close(measured, exact, bound, what):
    error = np.max(np.abs(np.asarray(measured) - exact), initial=0.0)
    assert error <= bound, f"{what}: error {error:.3e} exceeds {bound:.3e}"


@pytest.fixture(params=METRICS, ids=str)
def weighted(request, manifold):
    """A manifold with each metric, and its weight of |Omega|^2."""
    return Stiefel(manifold.n, manifold.k, metric=request.param), METRICS[request.param]


def unit_tangent(M, S, rng):
    V = M.random_tangent(S, rng)
    return V / np.linalg.norm(V, axis=(-2, -1), keepdims=True)


def exp(S, V, w):
    """Geodesic of the metric of weight w, with full-size matrices."""
    K, A = split(S, V)
    return scipy.linalg.expm(K @ T(S) - S @ T(K) + 2 * w * S @ A @ T(S)) @ S @ scipy.linalg.expm((1 - 2 * w) * A)


def log(M, S0, S1, w):
    """Inverse of `exp` for close points, by iteration."""
    V = M.project_tangent(S0, S1 - S0)
    for _ in range(200):
        step = M.project_tangent(S0, S1 - exp(S0, V, w))
        V = V + step
        if np.abs(step).max() < 4 * EPS:
            return V
    pytest.fail("the logarithm of close points did not converge")


def christoffel(S, V, W, w):
    (B, A), (D, C) = split(S, V), split(S, W)
    return S @ (T(B) @ D + T(D) @ B - A @ C - C @ A) / 2 + (w - 1) * (B @ C + D @ A)


# ---------------------------------------------------------------- retractions


def test_retractions_are_their_formulas(manifold, rng):
    n = manifold.n
    S = manifold.random_point(rng)
    for length in [0.1, 1.0, 5.0]:
        V = length * unit_tangent(manifold, S, rng)
        Q, R = np.linalg.qr(S + V)
        K, A = split(S, V)
        W = K @ S.T - S @ K.T + S @ A @ S.T
        exact = {
            "quasi_geodesic": scipy.linalg.expm(K @ S.T - S @ K.T) @ S @ scipy.linalg.expm(A),
            "qr": Q * np.sign(np.diag(R)),
            "polar": scipy.linalg.polar(S + V)[0],
            "cayley": np.linalg.solve(np.eye(n) - W / 2, (np.eye(n) + W / 2) @ S),
        }
        for kind in KINDS:
            assert_close(manifold.retract(S, V, kind), exact[kind], 40 * n * EPS * max(1, length), kind)
    assert_close(manifold.retract(S, V), exact["quasi_geodesic"], 200 * n * EPS, "default")


@pytest.mark.parametrize("kind", KINDS)
def test_inverse_undoes_the_retraction(kind, manifold, rng):
    S = manifold.random_point(rng, size=(2, 3))
    V = unit_tangent(manifold, S, rng)
    S1 = manifold.retract(S, V, kind=kind)
    manifold.check_point(S1, atol=50 * manifold.n * EPS)
    back = manifold.inverse_retract(S, S1, kind=kind)
    assert_close(back, V, 100 * manifold.n * EPS, "inverse of the retraction")
    assert_close(manifold.retract(S, back, kind), S1, 100 * manifold.n * EPS, "retraction of the inverse")


def test_inverse_of_polar_is_a_lyapunov_equation(manifold, rng):
    S = manifold.random_point(rng)
    S1 = exp(S, 0.5 * unit_tangent(manifold, S, rng), 0.5)
    P = scipy.linalg.solve_continuous_lyapunov(S.T @ S1, 2 * np.eye(manifold.k))
    assert_close(manifold.inverse_retract(S, S1, "polar"), S1 @ P - S, 100 * manifold.n * EPS, "S1 P - S0")


def test_inverse_of_qr_is_triangular(manifold, rng):
    S = manifold.random_point(rng)
    S1 = exp(S, 0.5 * unit_tangent(manifold, S, rng), 0.5)
    R = S1.T @ (S + manifold.inverse_retract(S, S1, "qr"))
    assert_close(np.tril(R, -1), 0, 100 * manifold.n * EPS, "below the diagonal")
    assert np.diag(R).min() > 0, "diagonal"


@pytest.mark.parametrize("kind", KINDS[1:])
def test_points_out_of_reach(kind, manifold, rng):
    S = manifold.random_point(rng)
    with pytest.raises(OutsideDomainError, match=f"{kind} retraction.*= -?[0-9.]+e"):
        manifold.inverse_retract(S, -S, kind)
    reached = 0
    for far in manifold.random_point(rng, size=50):
        try:
            V = manifold.inverse_retract(S, far, kind)
        except OutsideDomainError:
            continue
        reached += 1
        assert_close(manifold.retract(S, V, kind), far, 1e-8, "an inverse that is returned is one")
    assert reached > 0 or (manifold.n, manifold.k) == (6, 6), "no random point was reached"


def test_unknown_kinds(manifold, rng):
    S = manifold.random_point(rng)
    for call in (lambda kind: manifold.retract(S, 0 * S, kind), lambda kind: manifold.inverse_retract(S, S, kind)):
        for bad in ["QR", "", "exp"]:
            with pytest.raises(InvalidInputError, match=f"kind.*'quasi_geodesic'.*found '{bad}'"):
                call(bad)
        for bad in [None, 3, b"qr"]:
            with pytest.raises(TypeError):
                call(bad)


def test_vectors_too_long_are_refused_with_a_number():
    M, S = Stiefel(4, 2), np.eye(4, 2)
    V = np.zeros((4, 2))
    V[2, 0] = 1e200
    for kind in ["qr", "polar"]:
        with pytest.raises(InvalidInputError, match=r"S \+ V.*1\.000e200"):
            M.retract(S, V, kind)
    with pytest.raises(InvalidInputError, match=r"norm of V.*1e8"):
        M.retract(S, V, "cayley")


# ---------------------------------------------------------------- parallel transport


def test_transport_solves_its_equation(weighted, rng):
    M, w = weighted
    S = M.random_point(rng)
    V, W = 1.5 * unit_tangent(M, S, rng), unit_tangent(M, S, rng)

    def rate(_, y):
        s, v, x = y.reshape(3, M.n, M.k)
        return np.stack([v, -christoffel(s, v, v, w), -christoffel(s, v, x, w)]).ravel()

    start = np.stack([S, V, W]).ravel()
    solution = scipy.integrate.solve_ivp(rate, (0, 1), start, method="DOP853", rtol=1e-12, atol=1e-13)
    end, _, field = solution.y[:, -1].reshape(3, M.n, M.k)
    # The accuracy that the integrator promises, over a few tens of steps.
    assert_close(M.transport(S, V, W), field, 1e-10, "parallel field")
    # The velocity is parallel; the tangent space is that of exp(S, V).
    assert_close(M.transport(S, V, V), solution.y[:, -1].reshape(3, M.n, M.k)[1], 1e-10, "velocity")
    assert_close(end, exp(S, V, w), 1e-10, "end of the geodesic")
    M.check_tangent(exp(S, V, w), M.transport(S, V, W), atol=100 * M.n * EPS)


def test_transport_keeps_lengths_and_angles(weighted, rng):
    M, w = weighted
    S = M.random_point(rng, size=7)
    V = M.random_tangent(S, rng)
    W = M.random_tangent(S, rng)
    ends = np.stack([exp(s, v, w) for s, v in zip(S, V, strict=True)])
    TW, TV = M.transport(S, V, W), M.transport(S, V, V)
    scale = np.max(M.norm(S, W) * M.norm(S, V)) + np.max(M.norm(S, W)) ** 2
    assert_close(M.inner(ends, TW, TW), M.inner(S, W, W), 200 * EPS * scale, "length")
    assert_close(M.inner(ends, TW, TV), M.inner(S, W, V), 200 * EPS * scale, "angle")


@pytest.mark.parametrize("metric", ["canonical", "euclidean"])
@pytest.mark.parametrize("shape", [(4, 2), (5, 3), (6, 6)])
def test_pole_ladder_converges_to_the_transport(shape, metric, rng):
    M, w = Stiefel(*shape, metric=metric), METRICS[metric]
    S = M.random_point(rng)
    V, W = unit_tangent(M, S, rng), unit_tangent(M, S, rng)
    exact = M.transport(S, V, W)
    errors = []
    for rungs in [4, 8, 16]:
        point, vector = S, W / rungs
        for i in range(rungs):
            middle, after = exp(S, (i + 0.5) / rungs * V, w), exp(S, (i + 1) / rungs * V, w)
            pole = exp(middle, -log(M, middle, exp(point, vector, w), w), w)
            point, vector = after, -log(M, after, pole, w)
        errors.append(np.abs(rungs * vector - exact).max())
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 1e-3, f"errors {errors}"
    # A group with its bi-invariant metric is symmetric: there the ladder is exact.
    assert np.all(slopes > 1.8) or max(errors) < 1e-11, f"errors {errors}, slopes {slopes}"


def test_transport_of_extreme_vectors(manifold, rng):
    S = manifold.random_point(rng)
    V = unit_tangent(manifold, S, rng)
    with pytest.raises(InvalidInputError, match=r"V.*1e5"):
        manifold.transport(S, 1e7 * V, V)
    assert_close(manifold.transport(S, 1e-300 * V, V), V, 20 * EPS, "no way to go")
    TW = manifold.transport(S, V, 1e-280 * V)
    assert_close(TW * 1e280, manifold.transport(S, V, V), 20 * EPS, "short vectors")


# ---------------------------------------------------------------- curvature


def full_size_curvature(S, U, V, W, rng):
    """The naturally reductive quotient SO(n) / SO(n - k) with brackets of n x n matrices."""
    n, k = S.shape
    g = np.linalg.qr(np.hstack([S, rng.standard_normal((n, n - k))]))[0]
    g[:, :k] = S

    def lift(v):
        x = np.zeros((n, n))
        x[:, :k] = g.T @ v
        x[:k, k:] = -x[k:, :k].T
        return x

    def h(a):
        out = np.zeros((n, n))
        out[k:, k:] = a[k:, k:]
        return out

    def bracket(a, b):
        return a @ b - b @ a

    def m(a, b):
        return bracket(a, b) - h(bracket(a, b))

    x, y, z = lift(U), lift(V), lift(W)
    out = m(x, m(y, z)) / 4 - m(y, m(x, z)) / 4 - m(m(x, y), z) / 2 - bracket(h(bracket(x, y)), z)
    return (g @ out)[:, :k]


def test_curvature_of_the_quotient(manifold, rng):
    S = manifold.random_point(rng)
    U, V, W = (unit_tangent(manifold, S, rng) for _ in range(3))
    exact = full_size_curvature(S, U, V, W, rng)
    assert_close(manifold.curvature(S, U, V, W), exact, 40 * manifold.n * EPS, "R(U, V) W")


def test_curvature_has_its_symmetries(weighted, rng):
    M, _ = weighted
    S = M.random_point(rng)
    U, V, W = (unit_tangent(M, S, rng) for _ in range(3))
    bound = 100 * M.n * EPS
    R = M.curvature
    assert_close(R(S, U, V, W), -R(S, V, U, W), bound, "R(U, V) = -R(V, U)")
    assert_close(R(S, U, V, W) + R(S, V, W, U) + R(S, W, U, V), 0, bound, "Bianchi")
    assert_close(M.inner(S, R(S, U, V, W), W), 0, bound, "R(U, V) is skew")
    M.check_tangent(S, R(S, U, V, W), atol=bound)


def test_sectional_curvature_is_the_quotient_of_the_tensor(weighted, rng):
    M, _ = weighted
    S = M.random_point(rng, size=(2, 2))
    U, V = M.random_tangent(S, rng), M.random_tangent(S, rng)
    area = M.norm(S, U) ** 2 * M.norm(S, V) ** 2 - M.inner(S, U, V) ** 2
    K = M.sectional_curvature(S, U, V)
    assert K.shape == (2, 2)
    size = M.norm(S, U) ** 2 * M.norm(S, V) ** 2 / area
    assert_close(K, M.inner(S, M.curvature(S, U, V, V), U) / area, 100 * M.n * EPS * size.max(), "<R(U,V)V,U> / area")
    if M.k == 1:
        assert_close(K, 1.0, 20 * EPS, "the unit sphere")


def test_dependent_vectors_span_no_plane(manifold, rng):
    S = manifold.random_point(rng)
    U = manifold.random_tangent(S, rng)
    for V in [U, -3 * U, 0 * U]:
        with pytest.raises(InvalidInputError, match=r"linearly dependent.*area of [0-9.]+e"):
            manifold.sectional_curvature(S, U, V)


# ---------------------------------------------------------------- gradients and Hessians


def test_gradient_and_hessian_along_geodesics(weighted, rng):
    M, w = weighted
    n, k = M.n, M.k
    S = M.random_point(rng)
    V = unit_tangent(M, S, rng)
    A, C = rng.standard_normal((n, n)), rng.standard_normal((n, k))

    def f(X):
        return np.sum(X * (A @ X)) / 2 + np.sum(C * X) + np.sum(X**4)

    G = (A + A.T) @ S / 2 + C + 4 * S**3
    H = (A + A.T) @ V / 2 + 12 * S**2 * V
    h = 2e-3
    values = [f(exp(S, i * h * V, w)) for i in range(-2, 3)]
    slope = (8 * (values[3] - values[1]) - (values[4] - values[0])) / (12 * h)
    bend = (16 * (values[3] + values[1]) - (values[4] + values[0]) - 30 * values[2]) / (12 * h * h)
    size = np.linalg.norm(G) + np.linalg.norm(H)
    gradient, hessian = M.euclidean_to_riemannian_gradient(S, G), M.euclidean_to_riemannian_hessian(S, G, H, V)
    # h^4 = 1.6e-11; the second difference divides round-off by h^2.
    assert_close(M.inner(S, gradient, V), slope, 1e-9 * size, "first derivative along the geodesic")
    assert_close(M.inner(S, hessian, V), bend, 1e-8 * size, "second derivative along the geodesic")
    M.check_tangent(S, hessian, atol=100 * n * EPS)


# ---------------------------------------------------------------- batches

METHODS = [
    ("retract", 2),
    ("transport", 3),
    ("curvature", 4),
    ("sectional_curvature", 3),
    ("euclidean_to_riemannian_gradient", 2),
    ("euclidean_to_riemannian_hessian", 4),
]


@pytest.mark.parametrize(("name", "count"), METHODS)
def test_batches_and_broadcasting(name, count, weighted, rng):
    M, _ = weighted
    method = getattr(M, name)
    S = M.random_point(rng)
    vectors = [M.random_tangent(np.broadcast_to(S, (*lead, *S.shape)), rng) for lead in [(3, 1), (4,), (2, 1, 1)]]
    arguments = [S, *vectors[: count - 1]]
    result = method(*arguments)
    lead = np.broadcast_shapes(*(a.shape[:-2] for a in arguments))
    assert result.shape[: len(lead)] == lead
    full = [np.broadcast_to(a, (*lead, *S.shape)) for a in arguments]
    for i in np.ndindex(lead):
        assert np.array_equal(result[i], method(*(a[i] for a in full))), f"member {i}"
    empty = method(*(np.zeros((0, *S.shape)) for _ in arguments))
    assert empty.shape[0] == 0


@pytest.mark.parametrize(("name", "count"), METHODS)
def test_the_member_at_fault_is_named(name, count, manifold, rng):
    S = manifold.random_point(rng, size=3)
    vectors = [manifold.random_tangent(S, rng) for _ in range(count - 1)]
    S[1] *= 1.001
    with pytest.raises(InvalidInputError, match=r"S: columns are not orthonormal.*batch member 1"):
        getattr(manifold, name)(S, *vectors)


@pytest.mark.parametrize("name", [*(name for name, _ in METHODS), "inverse_retract"])
def test_methods_are_documented(name):
    doc = inspect.getdoc(getattr(Stiefel, name))
    for section in ["Parameters", "Returns", "Raises", "Examples"]:
        assert f"{section}\n---" in doc, f"{name} has no section {section}"


@pytest.mark.parametrize(("shape", "found"), [((4, 2), 297), ((5, 3), 298)])
def test_random_pairs_have_a_euclidean_logarithm(shape, found):
    # Most are beyond the injectivity radius. Following the family of metrics alone finds 296 and 294 of 300.
    M = Stiefel(*shape, metric="euclidean")
    pairs = list(zip(M.random_point(1, 300), M.random_point(2, 300), strict=True))
    count = 0
    for S0, S1 in pairs:
        try:
            V = M.log(S0, S1)
        except ConvergenceError:
            continue
        assert np.abs(M.exp(S0, V) - S1).max() < 1e-11
        count += 1
    assert count >= found


def test_log_of_equal_principal_angles_is_the_shortest():
    """Two equal principal angles of 3: the symmetric geodesic, of length 4.24, is a saddle."""
    S0 = np.eye(4)[:, :2]
    S1 = np.cos(3.0) * S0 + np.sin(3.0) * np.eye(4)[:, 2:]
    M = Stiefel(4, 2)
    assert abs(M.dist(S0, S1) - 3.14156) < 2e-5
    assert abs(M.exp(S0, M.log(S0, S1)) - S1).max() < 1e-12
