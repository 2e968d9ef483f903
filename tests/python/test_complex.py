"""The manifold of complex frames compared with formulas with complex matrices in NumPy and SciPy."""

import copy
import pickle

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
from complex_frames import (
    EPS,
    METRICS,
    SHAPES,
    H,
    assert_close,
    embed,
    exp,
    inner,
    norm,
    normal,
    restrict,
    skew,
    split,
    tangents,
    unitary,
)

from stiefel_rs import InvalidInputError, OutsideDomainError, Stiefel

KINDS = ["quasi_geodesic", "qr", "polar", "cayley"]


@pytest.fixture(params=SHAPES, ids=str)
def M(request):
    return Stiefel(*request.param, field="complex")


@pytest.fixture(params=METRICS, ids=str)
def weighted(request, M):
    """A manifold with each metric, and its weight of |Omega|^2."""
    return Stiefel(M.n, M.k, metric=request.param, field="complex"), METRICS[request.param]


def test_attributes():
    M = Stiefel(4, 2, field="complex")
    assert (M.n, M.k, M.dim, M.field, M.alpha) == (4, 2, 12, "complex", 0.0)
    assert Stiefel(4, 2).field == "real"
    assert Stiefel(3, 3, field="complex").dim == 9
    assert repr(M) == "Stiefel(4, 2, field='complex')"
    assert repr(Stiefel(4, 2, metric="euclidean", field="complex")) == (
        "Stiefel(4, 2, metric='euclidean', field='complex')"
    )


def test_equality_hash_and_pickles():
    M, same = Stiefel(4, 2, field="complex"), Stiefel(4, 2, metric="canonical", field="complex")
    others = [Stiefel(4, 2), Stiefel(8, 4), Stiefel(4, 2, metric="euclidean", field="complex")]
    assert M == same
    assert hash(M) == hash(same)
    assert all(M != other for other in others)
    for one in [M, *others]:
        assert pickle.loads(pickle.dumps(one)) == copy.copy(one) == one


def test_an_unknown_field_is_refused():
    with pytest.raises(InvalidInputError, match="field: expected 'real' or 'complex', found \"quaternion\""):
        Stiefel(3, 1, field="quaternion")
    with pytest.raises(InvalidInputError, match=r"St\(n, k\): expected 1 <= k <= n, found n = 2, k = 3"):
        Stiefel(2, 3, field="complex")


def test_points_are_distributed_by_haar_measure(M):
    """Entries of uniform unit vectors: mean zero, also of the squares, and of |s|^2 the mean 1 / n."""
    S = M.random_point(rng=0, size=4000)
    assert S.dtype == np.complex128
    assert S.shape == (4000, M.n, M.k)
    assert_close(H(S) @ S, np.eye(M.k), 40 * M.n * EPS, "S^H S = I")
    # Standard deviations: below 1 / sqrt(4000 n) of the means; six of them.
    spread = 6 / np.sqrt(4000 * M.n)
    assert_close(S.mean(axis=0), 0, spread, "mean")
    assert_close((np.abs(S) ** 2).mean(axis=0), 1 / M.n, spread, "second moment")
    assert_close((S**2).mean(axis=0), 0, spread, "no phase is preferred")
    assert (M.random_point(rng=0) == M.random_point(rng=0)).all()


def test_tangent_vectors_are_tangent_and_independent_of_points(M):
    S = M.random_point(rng=1, size=2000)
    V = M.random_tangent(S, rng=1)
    assert_close(H(S) @ V + H(V) @ S, 0, 1e-13, "S^H V is skew-Hermitian")
    # The squared norm has one unit of variance per dimension.
    mean = np.mean(np.sum(np.abs(V) ** 2, axis=(-2, -1)))
    assert abs(mean - M.dim) < 6 * np.sqrt(2 * M.dim / 2000) + 6 * np.sqrt(2) * M.k / np.sqrt(2000)


def test_projections(M, rng):
    Y = normal(rng, M.n, M.k)
    U, _, W = np.linalg.svd(Y, full_matrices=False)
    assert_close(M.project(Y), U @ W, 1e-12, "polar factor")
    S = M.random_point(rng)
    sym = (H(S) @ Y + H(Y) @ S) / 2
    assert_close(M.project_tangent(S, Y), Y - S @ sym, 1e-14, "projection on the tangent space")


def test_inner_product_and_norm(weighted, rng):
    M, w = weighted
    S = M.random_point(rng)
    V, W = tangents(M, S, rng, 2)
    assert_close(M.inner(S, V, W), inner(S, V, W, w), 1e-14, "inner product")
    assert_close(M.norm(S, V), norm(S, V, w), 1e-14, "norm")
    if w == 0.5:
        exact = np.trace(H(V) @ (np.eye(M.n) - S @ H(S) / 2) @ W).real
        assert_close(M.inner(S, V, W), exact, 1e-14, "Re tr V^H (I - S S^H / 2) W")


def test_decompose_and_compose(M, rng):
    S = M.random_point(rng)
    (V,) = tangents(M, S, rng, 1)
    X, Omega = M.decompose(S, V)
    K, A = split(S, V)
    assert_close(X, K @ H(S) - S @ H(K), 1e-14, "X")
    assert_close(Omega, A, 1e-14, "Omega")
    assert_close(M.compose(S, X, Omega), V, 1e-14, "V = X S + S Omega")


def test_exponential_and_logarithm(weighted, rng):
    M, w = weighted
    S = M.random_point(rng)
    (V,) = tangents(M, S, rng, 1, 0.5)
    end = M.exp(S, V)
    assert end.dtype == np.complex128
    assert_close(end, exp(S, V, w), 2e-14, "exponential")
    found, report = M.log(S, end, full_output=True)
    assert_close(found, V, 1e-12, "logarithm")
    assert report.converged
    assert_close(report.length, norm(S, V, w), 1e-12, "length")
    assert_close(M.dist(S, end), norm(S, V, w), 1e-12, "distance")
    assert report.residual < 1e-13


def test_distance_in_the_unitary_group(rng):
    """log of unitary matrices: eigenvalues exp(i phi), canonical length sqrt(sum phi^2 / 2)."""
    for m in (1, 2, 4):
        M, U, phi = Stiefel(m, m, field="complex"), unitary(rng, m), rng.uniform(-2.5, 2.5, m)
        S0 = unitary(rng, m)
        S1 = S0 @ U @ np.diag(np.exp(1j * phi)) @ H(U)
        assert_close(M.dist(S0, S1), np.sqrt(np.sum(phi**2) / 2), 1e-12, f"U({m})")
        assert_close(M.log(S0, S1), S0 @ U @ np.diag(1j * phi) @ H(U), 1e-12, f"U({m})")


def test_retractions(M, rng):
    S = M.random_point(rng)
    (V,) = tangents(M, S, rng, 1)
    K, A = split(S, V)
    Q, R = np.linalg.qr(S + V)
    X = K @ H(S) - S @ H(K)
    P = np.eye(M.n) - S @ H(S) / 2
    W = P @ V @ H(S) - S @ H(V) @ P
    exact = {
        "quasi_geodesic": scipy.linalg.expm(X) @ S @ scipy.linalg.expm(A),
        "qr": Q * (np.diag(R) / np.abs(np.diag(R))),
        "polar": scipy.linalg.polar(S + V)[0],
        "cayley": np.linalg.solve(np.eye(M.n) - W / 2, (np.eye(M.n) + W / 2) @ S),
    }
    for kind in KINDS:
        end = M.retract(S, V, kind)
        assert_close(end, exact[kind], 2e-14, kind)
        assert_close(M.inverse_retract(S, end, kind), V, 1e-12, f"inverse of {kind}")


def test_transport(weighted, rng):
    """It preserves inner products, and the velocity of the geodesic; on U(n) it is S e^{A/2} B e^{A/2}."""
    M, w = weighted
    S = M.random_point(rng)
    V, W, Z = tangents(M, S, rng, 3)
    end = M.exp(S, V)
    moved = [M.transport(S, V, X) for X in (V, W, Z)]
    for X, Y in [(0, 1), (1, 2), (2, 2)]:
        given = [V, W, Z]
        assert_close(inner(end, moved[X], moved[Y], w), inner(S, given[X], given[Y], w), 1e-13, "inner products")
    h = 1e-5
    velocity = (exp(S, (1 + h) * V, w) - exp(S, (1 - h) * V, w)) / (2 * h)
    assert_close(moved[0], velocity, 1e-9, "the velocity")
    if M.n == M.k:
        A, B, half = H(S) @ V, H(S) @ W, scipy.linalg.expm(H(S) @ V / 2)
        assert_close(moved[1], S @ half @ B @ half, 1e-13, "in the unitary group")
        assert_close(A, skew(A), 1e-14, "skew")


def test_curvature_of_the_unitary_group(rng):
    """R(U, V) W = -[[U, V], W] / 4 for left-invariant fields; SU(2) has curvature 1 with |V|^2 = tr V^H V / 2."""
    M = Stiefel(2, 2, field="complex")
    S = M.random_point(rng)
    A, B, C = (skew(normal(rng, 2, 2)) for _ in range(3))

    def bracket(X, Y):
        return X @ Y - Y @ X

    found = M.curvature(S, S @ A, S @ B, S @ C)
    assert_close(found, -S @ bracket(bracket(A, B), C) / 4, 1e-14, "curvature")
    A, B = np.diag([1j, -1j]), np.array([[0, 1], [-1, 0]])
    assert_close(M.sectional_curvature(S, S @ A, S @ B), 1.0, 1e-13, "SU(2)")


def test_sectional_curvature(weighted, rng):
    M, w = weighted
    if M.dim == 1:
        pytest.skip("there are no planes")
    S = M.random_point(rng)
    U, V = tangents(M, S, rng, 2)
    R = M.curvature(S, U, V, V)
    area = inner(S, U, U, w) * inner(S, V, V, w) - inner(S, U, V, w) ** 2
    assert_close(M.sectional_curvature(S, U, V), inner(S, R, U, w) / area, 1e-11, "<R(U, V) V, U> / area")


def test_curvature_of_spheres_with_a_phase():
    """St(n, 1) is a Berger sphere, with the phase direction scaled: 4 - 3/2 on (V, iV), 1/2 with the phase."""
    M = Stiefel(3, 1, field="complex")
    S, V, W = np.eye(3)[:, :, None]
    assert_close(M.sectional_curvature(S, V, 1j * V), 2.5, 1e-14, "complex plane")
    assert_close(M.sectional_curvature(S, V, W), 1.0, 1e-14, "totally real plane")
    assert_close(M.sectional_curvature(S, V, 1j * S), 0.5, 1e-14, "with the phase")
    assert_close(M.norm(S, 1j * S), np.sqrt(0.5), 1e-15, "length of the phase direction")


def test_complex_projective_line(rng):
    """Modulo phases St(2, 1) is the sphere of radius 1/2: horizontal geodesics have the length of arcs on it."""
    M = Stiefel(2, 1, field="complex")
    S, V = M.random_point(rng), M.random_tangent(M.random_point(rng), rng)
    K = V - S @ (H(S) @ V)
    K *= 0.6 / np.linalg.norm(K)
    end = M.exp(S, K)
    assert_close(end, np.cos(0.6) * S + np.sin(0.6) * K / 0.6, 1e-14, "horizontal geodesic")
    assert_close(M.dist(S, end), np.arccos(np.abs(np.vdot(S, end))), 1e-13, "length")

    def bloch(z):
        a, b = z.ravel()
        return np.array([2 * (a.conjugate() * b).real, 2 * (a.conjugate() * b).imag, abs(a) ** 2 - abs(b) ** 2]) / 2

    angle = np.arccos(4 * bloch(S) @ bloch(end))
    assert_close(M.dist(S, end), angle / 2, 1e-13, "arc of radius 1/2")


def test_gradient_and_hessian(weighted, rng):
    """f = Re tr S^H A S B + Re tr C^H S with Hermitian A, B, along geodesics."""
    M, w = weighted
    A, B, C = normal(rng, M.n, M.n), normal(rng, M.k, M.k), normal(rng, M.n, M.k)
    A, B = A + H(A), B + H(B)
    S = M.random_point(rng)
    V, W = tangents(M, S, rng, 2, 0.5)

    def f(S):
        return (np.trace(H(S) @ A @ S @ B) + np.trace(H(C) @ S)).real

    G = 2 * A @ S @ B + C
    gradient = M.euclidean_to_riemannian_gradient(S, G)
    scale = np.linalg.norm(G)
    assert_close(inner(S, gradient, V, w), np.sum(G.conj() * V).real, 1e-13 * scale, "df(V)")

    def hessian(X):
        return M.euclidean_to_riemannian_hessian(S, G, 2 * A @ X @ B, X)

    h = 1e-4
    second = (f(exp(S, h * V, w)) - 2 * f(S) + f(exp(S, -h * V, w))) / h**2
    assert_close(inner(S, hessian(V), V, w), second, 1e-5 * scale, "second derivative along a geodesic")
    assert_close(inner(S, hessian(V), W, w), inner(S, hessian(W), V, w), 1e-12 * scale, "symmetric")


def test_the_metric_of_the_real_embedding(weighted, rng):
    """All results agree with the embedded real frames; squared lengths double, curvatures are halved."""
    M, _ = weighted
    real = Stiefel(2 * M.n, 2 * M.k, metric=M.alpha)
    S = M.random_point(rng)
    U, V, W = tangents(M, S, rng, 3)
    s, u, v, x = (embed(A) for A in (S, U, V, W))
    assert_close(real.inner(s, u, v), 2 * M.inner(S, U, V), 1e-13, "inner product")
    assert_close(restrict(real.curvature(s, u, v, x)), M.curvature(S, U, V, W), 1e-13, "curvature")
    assert_close(restrict(real.transport(s, u, v)), M.transport(S, U, V), 1e-13, "transport")


def test_equivariance(M, rng):
    """Unitary factors from the left and from the right, and complex conjugation."""
    S = M.random_point(rng)
    V, W = tangents(M, S, rng, 2)
    L, R = unitary(rng, M.n), unitary(rng, M.k)

    def results(S, V, W):
        end = M.exp(S, V)
        parts = [end, M.log(S, end), M.transport(S, V, W), M.curvature(S, V, W, V), M.project_tangent(S, 2 * S + V)]
        parts += [M.retract(S, V, kind) for kind in ("quasi_geodesic", "polar", "cayley")]
        return np.stack(parts)

    found = results(S, V, W)
    assert_close(results(L @ S @ R, L @ V @ R, L @ W @ R), L @ found @ R, 1e-12, "unitary factors")
    assert_close(results(S.conj(), V.conj(), W.conj()), found.conj(), 1e-12, "conjugation")
    phases = np.exp(1j * rng.uniform(-3, 3, M.k))
    end = M.retract(S, V, "qr")
    assert_close(M.retract(L @ S * phases, L @ V * phases, "qr"), L @ end * phases, 1e-12, "QR: phases of columns")


def test_real_data_given_as_complex(rng):
    for n, k in [(3, 1), (4, 2), (3, 3), (3, 2)]:
        M, real = Stiefel(n, k, field="complex"), Stiefel(n, k)
        S = real.random_point(rng)
        V, W = (0.3 * real.random_tangent(S, rng) for _ in range(2))
        end = real.exp(S, V)
        pairs = [(getattr(M, f)(S, V), getattr(real, f)(S, V)) for f in ("exp", "retract", "norm")]
        pairs += [(M.log(S + 0j, end), real.log(S, end)), (M.dist(S, end + 0j), real.dist(S, end))]
        pairs += [(M.retract(S, V + 0j, kind), real.retract(S, V, kind)) for kind in KINDS]
        pairs += [(M.transport(S, V, W), real.transport(S, V, W)), (M.inner(S, V, W), real.inner(S, V, W))]
        pairs += [(M.curvature(S, V, W, V), real.curvature(S, V, W, V))]
        for found, exact in pairs:
            assert_close(found, exact, 1e-12, f"St({n}, {k})")


def test_coordinate_columns_and_permutations():
    """Entries 0, 1, -1 and i, for which angles repeat and blocks vanish."""
    M, eye = Stiefel(4, 2, field="complex"), np.eye(4, dtype=complex)
    for S0 in [eye[:, :2], eye[:, 2:], 1j * eye[:, [1, 3]], eye[:, [0, 2]] * [1, 1j]]:
        for S1 in [eye[:, :2], eye[:, [0, 3]], eye[:, [2, 3]], eye[:, :2] * [1j, -1j]]:
            try:
                V = M.log(S0, S1)
            except OutsideDomainError:
                continue
            assert_close(exp(S0, V), S1, 1e-12, "exp(log)")
    U = Stiefel(3, 3, field="complex")
    cycle = np.roll(np.eye(3), 1, axis=0)
    assert_close(exp(np.eye(3), U.log(np.eye(3), cycle + 0j)), cycle, 1e-12, "a cycle of axes")


def test_minus_one_has_no_unique_logarithm():
    """Antipodes of U(1) and U(2): a typed error, or one of the shortest geodesics."""
    for m in (1, 2, 3):
        M, eye = Stiefel(m, m, field="complex"), np.eye(m, dtype=complex)
        with pytest.raises(OutsideDomainError):
            M.log(eye, -eye)


# ---------------------------------------------------------------- certainty of the logarithm

# Below this length every geodesic of the real embedding, where lengths are larger by sqrt 2, is the shortest one: its
# curvature is at most 5/4.
CERTAIN = np.pi * np.sqrt(0.8 / 2)


@pytest.mark.parametrize("shape", [(2, 1), (3, 2), (4, 2), (12, 3), (50, 5)], ids=str)
def test_near_points_have_a_certificate(shape, rng):
    M = Stiefel(*shape, field="complex")
    S = M.random_point(rng)
    for share in (1e-9, 0.3, 0.99):
        (V,) = tangents(M, S, rng, 1, share * CERTAIN)
        found, report = M.log(S, exp(S, V), full_output=True)
        assert report.certainly_shortest is True
        assert_close(report.length, share * CERTAIN, 1e-13, "length")
        # Measured at most 5e-15.
        assert_close(found, V, 1e-13, "the shortest geodesic")


@pytest.mark.parametrize("shape", [(12, 3), (50, 5)], ids=str)
def test_far_points_have_none(shape, rng):
    M = Stiefel(*shape, field="complex")
    S = M.random_point(rng)
    for share in (1.01, 1.2, 1.4):
        (V,) = tangents(M, S, rng, 1, share * CERTAIN)
        found, report = M.log(S, exp(S, V), full_output=True)
        assert report.certainly_shortest is False
        assert report.converged
        assert_close(exp(S, found), exp(S, V), 1e-12, "end point")
        assert report.length <= share * CERTAIN + 1e-12


def length_on_berger_sphere(z, samples=200):
    """Length of the shortest geodesic of St(n, 1) between points with S0^H S1 = z, by a scan of all geodesics.

    exp(S, V) with |K| = r and Omega = i w has the component e^{i w / 2} (cos a + i w sin a / (2 a)) along S, with
    a^2 = r^2 + w^2 / 4; the squared length is r^2 + w^2 / 2.
    """
    s = np.sqrt(1 - abs(z) ** 2)
    lengths = []

    def velocity(a, sign):
        return 2 * sign * np.sqrt(max(a**2 - (a * s / np.sin(a)) ** 2, 0.0))

    def angle(u, sign, low, high):
        a = (low + high) / 2 - (high - low) / 2 * np.cos(u)
        w = velocity(a, sign)
        return np.angle(np.exp(0.5j * w) * (np.cos(a) + 0.5j * w / a * np.sin(a)) / z)

    for turn, sign in [(0, 1), (0, -1), (1, 1), (1, -1)]:
        low, high = np.arcsin(s) + turn * np.pi, (turn + 1) * np.pi - np.arcsin(s)
        grid = np.linspace(0, np.pi, samples)
        values = [angle(u, sign, low, high) for u in grid]
        for i in range(samples - 1):
            if values[i] * values[i + 1] < 0 and abs(values[i] - values[i + 1]) < 1:
                u = scipy.optimize.brentq(angle, grid[i], grid[i + 1], (sign, low, high), xtol=1e-14)
                a = (low + high) / 2 - (high - low) / 2 * np.cos(u)
                lengths.append(np.sqrt(a**2 + velocity(a, sign) ** 2 / 4))
    return min(lengths)


@pytest.mark.parametrize("n", [2, 3])
def test_certified_geodesics_are_shortest(n):
    """On St(n, 1), whose geodesics are all known; also those that have no certificate."""
    M, rng = Stiefel(n, 1, field="complex"), np.random.default_rng(1)
    certificates = []
    for S0, S1 in zip(M.random_point(rng, size=15), M.random_point(rng, size=15), strict=True):
        _, report = M.log(S0, S1, full_output=True)
        certificates.append(report.certainly_shortest)
        # Measured at most 1e-14.
        assert_close(report.length, length_on_berger_sphere(np.vdot(S0, S1)), 1e-13, "length")
    assert sum(certificates) >= 10
