"""Complex subspaces compared with complex formulas in NumPy, SciPy and the reflections 2 Y Y^H - I in U(n)."""

import itertools

import numpy as np
import pytest
import scipy.linalg
from complex_frames import EPS, H, assert_close, embed, normal, restrict, unitary

from stiefel_rs import Grassmann, OutsideDomainError, Stiefel

# k = 1, n = 2 k, n < 2 k, k = n - 1, and more columns than any special case.
SHAPES = [(2, 1), (3, 1), (4, 2), (5, 3), (5, 4), (20, 4), (30, 12)]
TINY = [1e-300, 1e-170, 1e-160, 1e-150, 1e-16, 1e-8]


@pytest.fixture(params=SHAPES, ids=lambda shape: f"Gr{shape[0]}_{shape[1]}_C")
def M(request):
    return Grassmann(*request.param, field="complex")


def unit(M, Y, rng, length=1.0):
    V = M.random_tangent(Y, rng)
    return V * (length / np.linalg.norm(V))


def separated(M, angles, rng):
    """Two dense points at given principal angles, the velocity from one to the other, and all angles."""
    n, k = M.n, M.k
    basis, W, Z = unitary(rng, n), unitary(rng, k), unitary(rng, k)
    count = min(k, n - k)
    full = np.zeros(k)
    full[:count] = np.resize(angles, count)
    Q = np.zeros((n, k), dtype=complex)
    Q[:, :count] = basis[:, k : k + count]
    Y0 = basis[:, :k] @ H(W)
    return Y0, (basis[:, :k] * np.cos(full) + Q * np.sin(full)) @ Z, (Q * full) @ H(W), full


def real_inner(V, W):
    return np.sum(V.conj() * W).real


# ---------------------------------------------------------------- projections and metric


def test_projections_and_metric(M, rng):
    Y, Z = M.random_point(rng, size=(2, 3)), normal(rng, 2, 3, M.n, M.k)
    V, W = M.random_tangent(Y, rng), M.random_tangent(Y, rng)
    bound = 10 * M.n * EPS
    assert_close(M.project_tangent(Y, Z), Z - Y @ (H(Y) @ Z), bound, "(I - Y Y^H) Z")
    assert_close(M.inner(Y, V, W), np.sum(V.conj() * W, axis=(-2, -1)).real, 5 * bound, "Re tr V^H W")
    assert_close(M.norm(Y, V), np.linalg.norm(V, axis=(-2, -1)), bound, "|V|")
    P = M.projector(Y)
    assert_close(P, Y @ H(Y), bound, "projector")
    assert (P == H(P)).all()
    assert_close(P @ P, P, bound, "P^2 = P")
    assert_close(np.trace(P, axis1=-2, axis2=-1), M.k, bound, "trace")


# ---------------------------------------------------------------- geodesics


@pytest.mark.parametrize("length", [1e-200, 1e-8, 0.3, 1.0, 3.2, 30.0, 5000.0])
def test_exp_is_its_formula(M, length, rng):
    Y = M.random_point(rng)
    V = unit(M, Y, rng, length)
    end = M.exp(Y, V)
    M.check_point(end, atol=1e-14 * M.k)
    Q, S, Wh = np.linalg.svd(V, full_matrices=False)
    exact = (Y @ H(Wh) * np.cos(S) + Q * np.sin(S)) @ Wh
    assert_close(end, exact, 10 * M.n * EPS * max(1.0, length), "(Y W cos S + Q sin S) W^H")


def test_exp_undoes_log(M, rng):
    Y0, Y1 = M.random_point(rng, size=20), M.random_point(rng, size=20)
    V = M.log(Y0, Y1)
    largest = M.principal_angles(Y0, Y1)[:, 0].max()
    M.check_tangent(Y0, V, atol=20 * M.n * EPS)
    assert_close(M.projector(M.exp(Y0, V)), M.projector(Y1), 20 * M.n * EPS, "span of exp(log)")
    assert_close(M.exp(Y0, V), M.align(Y0, Y1), 5 * M.n * EPS / np.cos(largest), "exp(log) is the aligned basis")
    assert_close(M.dist(Y0, Y1), np.linalg.norm(V, axis=(-2, -1)), 20 * M.n * EPS, "dist")


@pytest.mark.parametrize("angles", [[0.4], [1.2, 1.2, 0.0], [1e-9], [0.0], [1.0, 1e-12], [1.5, 1.5, 1.5]])
def test_logarithm_at_given_angles(M, angles, rng):
    Y0, Y1, V, full = separated(M, angles, rng)
    bound = 10 * M.n * EPS
    assert_close(M.log(Y0, Y1), V, bound / np.cos(full.max()), "log")
    assert_close(M.principal_angles(Y0, Y1), np.sort(full)[::-1], bound, "angles")
    assert_close(M.dist(Y0, Y1), np.linalg.norm(full), bound, "dist")


def test_principal_angles_are_those_of_scipy(M, rng):
    Y0, Y1 = M.random_point(rng, size=5), M.random_point(rng, size=5)
    for a, b, angles in zip(Y0, Y1, M.principal_angles(Y0, Y1), strict=True):
        # SciPy computes some small angles from cosines, and loses half of the digits.
        assert_close(angles, scipy.linalg.subspace_angles(a, b), 1e-7, "subspace_angles")


def test_align_is_the_nearest_basis(M, rng):
    Y0, Y1 = M.random_point(rng), M.random_point(rng)
    U, _, Zh = np.linalg.svd(H(Y1) @ Y0)
    loss = 1 / np.cos(M.principal_angles(Y0, Y1)[0])
    assert_close(M.align(Y0, Y1), Y1 @ U @ Zh, 5 * M.n * EPS * loss, "Procrustes")
    product = H(Y0) @ M.align(Y0, Y1)
    assert_close(product, H(product), 5 * M.n * EPS, "Y0^H Y is Hermitian")
    assert np.linalg.eigvalsh(product).min() >= 0


@pytest.mark.parametrize("length", [0.5, 3.0, 40.0])
def test_transport_is_its_formula(M, length, rng):
    Y = M.random_point(rng)
    V, W, X = unit(M, Y, rng, length), unit(M, Y, rng), unit(M, Y, rng)
    end, moved, other = M.exp(Y, V), M.transport(Y, V, W), M.transport(Y, V, X)
    bound = 10 * M.n * EPS * max(1.0, length)
    Q, S, Wh = np.linalg.svd(V, full_matrices=False)
    turned = Q * (np.cos(S) - 1) - (Y @ H(Wh)) * np.sin(S)
    assert_close(moved, W + turned @ (H(Q) @ W), bound, "transport")
    M.check_tangent(end, moved, atol=1e-14 * M.k)
    assert_close(real_inner(moved, other), real_inner(W, X), bound, "isometric")
    # Parallel transport commutes with the complex structure.
    assert_close(M.transport(Y, V, 1j * W), 1j * moved, bound / 20, "complex linear")
    back = M.transport(end, -M.transport(Y, V, V), moved)
    assert_close(back, W, bound, "there and back")


# ---------------------------------------------------------------- small angles, right angles


@pytest.mark.parametrize("angle", TINY)
def test_tiny_angles_are_relatively_accurate(M, angle, rng):
    """Bases that differ by exact unitary factors: permutations and phases i, -1, -i."""
    n, k, count = M.n, M.k, min(M.k, M.n - M.k)
    theta = angle * np.linspace(1, 0.5, count)
    phases = 1j ** rng.integers(0, 4, count)
    Y0, N = np.eye(n, k, dtype=complex), np.zeros((n, k), dtype=complex)
    N[k + np.arange(count), np.arange(count)] = theta * phases
    # The relative errors of cos(angle) = 1 and sin(angle) = angle are below 5e-17.
    turn = np.eye(k)[:, rng.permutation(k)] * 1j ** rng.integers(0, 4, k)
    Y1 = (Y0 + N) @ turn
    # Measured at most 2 eps.
    assert_close(M.log(Y0, Y1) / angle, N / angle, 16 * EPS, "log")
    assert_close(M.principal_angles(Y0, Y1)[:count] / theta, 1.0, 16 * EPS, "angles")
    assert_close(M.dist(Y0, Y1) / np.linalg.norm(theta / angle) / angle, 1.0, 16 * EPS, "dist")
    end = M.exp(Y0, N)
    assert_close(end, Y0 + N, 4 * EPS, "exp")
    assert_close(end[k:] / angle, N[k:] / angle, 16 * EPS, "small entries of exp")


def test_just_below_a_right_angle(M, rng):
    for gap in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
        Y0, Y1, V, full = separated(M, [np.pi / 2 - gap, 0.3], rng)
        bound = 20 * M.n * EPS
        assert_close(M.log(Y0, Y1), V, bound / gap, "log")
        assert_close(M.principal_angles(Y0, Y1)[0], full.max(), bound, "largest angle")
        assert_close(M.projector(M.exp(Y0, M.log(Y0, Y1))), M.projector(Y1), bound, "span of exp(log)")


def test_a_right_angle_is_refused_with_the_angle(M, rng):
    Y0, Y1, _, full = separated(M, [np.pi / 2, 0.3], rng)
    for call in (M.log, M.align):
        with pytest.raises(OutsideDomainError, match=r"a principal angle is 1\.5707963") as caught:
            call(Y0, Y1)
        assert abs(caught.value.angle - np.pi / 2) <= 1e-14
    assert_close(M.dist(Y0, Y1), np.linalg.norm(full), 10 * M.n * EPS, "dist is defined there")
    with pytest.raises(OutsideDomainError, match="batch member 1") as caught:
        M.log(np.stack([Y0, Y0]), np.stack([Y0 @ unitary(rng, M.k), Y1]))
    assert abs(caught.value.angle - np.pi / 2) <= 1e-14


def test_coordinate_columns_with_phases():
    identity = np.eye(5, dtype=complex)
    for k, phase in itertools.product((1, 2, 3), (1j, -1.0)):
        M = Grassmann(5, k, field="complex")
        for columns in itertools.permutations(range(5), k):
            Y1 = identity[:, list(columns)] * phase
            outside = sum(column >= k for column in columns)
            angles = [np.pi / 2] * outside + [0.0] * (k - outside)
            assert_close(M.principal_angles(identity[:, :k], Y1), angles, EPS, "angles")
            if outside:
                with pytest.raises(OutsideDomainError) as caught:
                    M.log(identity[:, :k], Y1)
                assert caught.value.angle == np.pi / 2
            else:
                assert (M.log(identity[:, :k], Y1) == 0).all()
                assert (M.align(identity[:, :k], Y1) == identity[:, :k]).all()


# ---------------------------------------------------------------- symmetries


def test_results_do_not_depend_on_the_basis(M, rng):
    Y0, Y1, _, _ = separated(M, [1.4, 0.9, 0.3, 1e-5], rng)
    Q0, Q1 = unitary(rng, M.k), unitary(rng, M.k)
    V, W, U = M.log(Y0, Y1), unit(M, Y0, rng), unit(M, Y0, rng)
    G, D = normal(rng, 2, M.n, M.k)
    pairs = {
        "log": (M.log(Y0 @ Q0, Y1 @ Q1), V @ Q0),
        "exp": (M.exp(Y0 @ Q0, V @ Q0), M.exp(Y0, V) @ Q0),
        "dist": (M.dist(Y0 @ Q0, Y1 @ Q1), M.dist(Y0, Y1)),
        "angles": (M.principal_angles(Y0 @ Q0, Y1 @ Q1), M.principal_angles(Y0, Y1)),
        "transport": (M.transport(Y0 @ Q0, V @ Q0, W @ Q0), M.transport(Y0, V, W) @ Q0),
        "curvature": (M.curvature(Y0 @ Q0, U @ Q0, V @ Q0, W @ Q0), M.curvature(Y0, U, V, W) @ Q0),
        "align": (M.align(Y0 @ Q0, Y1 @ Q1), M.align(Y0, Y1) @ Q0),
        "projector": (M.projector(Y0 @ Q0), M.projector(Y0)),
        "gradient": (
            M.euclidean_to_riemannian_gradient(Y0 @ Q0, G @ Q0),
            M.euclidean_to_riemannian_gradient(Y0, G) @ Q0,
        ),
        "Hessian": (
            M.euclidean_to_riemannian_hessian(Y0 @ Q0, G @ Q0, D @ Q0, W @ Q0),
            M.euclidean_to_riemannian_hessian(Y0, G, D, W) @ Q0,
        ),
    }
    for name, (turned, expected) in pairs.items():
        assert_close(turned, expected, 1e-12, name)


def test_equivariance_under_unitary_matrices(M, rng):
    Y0, Y1, V, _ = separated(M, [1.2, 0.4], rng)
    g, bound = unitary(rng, M.n), 20 * M.n * EPS
    assert_close(M.log(g @ Y0, g @ Y1), g @ M.log(Y0, Y1), bound, "log")
    assert_close(M.exp(g @ Y0, g @ V), g @ M.exp(Y0, V), bound, "exp")
    assert_close(M.log(Y0.conj(), Y1.conj()), M.log(Y0, Y1).conj(), bound, "conjugation")


def reflection(Y):
    return 2 * Y @ H(Y) - np.eye(Y.shape[-2])


def lifted(Y, V):
    return 2 * (V @ H(Y) + Y @ H(V))


def test_reflections_in_the_unitary_group(M, rng):
    """Lengths there (canonical metric of complex St(n, n)) are twice those here."""
    G, Y = Stiefel(M.n, M.n, field="complex"), M.random_point(rng)
    U, V, W = (unit(M, Y, rng, 0.4) for _ in range(3))
    S, end, bound = reflection(Y), M.exp(Y, U), 20 * M.n * EPS
    lift = [lifted(Y, X) for X in (U, V, W)]
    assert_close(G.norm(S, lift[0]), 2 * M.norm(Y, U), bound, "length")
    assert_close(G.exp(S, lift[0]), reflection(end), bound, "exp")
    assert_close(G.dist(S, reflection(end)), 2 * M.dist(Y, end), bound, "dist")
    assert_close(G.transport(S, *lift[:2]), lifted(end, M.transport(Y, U, V)), bound, "transport")
    assert_close(G.curvature(S, *lift), lifted(Y, M.curvature(Y, U, V, W)), bound, "curvature")


def test_the_real_embedding(M, rng):
    real, Y = Grassmann(2 * M.n, 2 * M.k), M.random_point(rng)
    U, V, W = (unit(M, Y, rng, 0.7) for _ in range(3))
    y, u, v, w = (embed(X) for X in (Y, U, V, W))
    bound = 20 * M.n * EPS
    assert_close(restrict(real.exp(y, u)), M.exp(Y, U), bound, "exp")
    assert_close(restrict(real.transport(y, u, v)), M.transport(Y, U, V), bound, "transport")
    assert_close(restrict(real.curvature(y, u, v, w)), M.curvature(Y, U, V, W), bound, "curvature")
    angles = M.principal_angles(Y, M.exp(Y, U))
    assert_close(real.principal_angles(y, real.exp(y, u)), np.repeat(angles, 2), bound, "angles, twice each")


# ---------------------------------------------------------------- curvature, gradients


def test_identities_of_the_curvature_tensor(M, rng):
    Y = M.random_point(rng)
    U, V, W, X = (unit(M, Y, rng) for _ in range(4))

    def R(*vectors):
        return M.curvature(Y, *vectors)

    bound = 5e-15 * M.k
    formula = U @ H(V) @ W - V @ H(U) @ W + W @ (H(V) @ U - H(U) @ V)
    assert_close(R(U, V, W), formula, bound, "U V^H W - V U^H W + W (V^H U - U^H V)")
    assert_close(R(U, V, W) + R(V, W, U) + R(W, U, V), 0, bound, "Bianchi")
    assert_close(real_inner(R(U, V, W), X), -real_inner(R(U, V, X), W), bound, "skew")
    assert_close(R(1j * U, 1j * V, W), R(U, V, W), bound, "the complex structure in the first pair")
    assert_close(R(U, V, 1j * W), 1j * R(U, V, W), bound, "the complex structure is parallel")


def test_sectional_curvature(M, rng):
    """Between 0 and 4; a complex plane (V, iV) of rank one has 4, and CP^n the curvature 1 + 3 <iU, V>^2."""
    Y = M.random_point(rng, size=200)
    U, V = M.random_tangent(Y, rng), M.random_tangent(Y, rng)
    values = M.sectional_curvature(Y, U, V)
    assert values.min() >= -1e-14
    assert values.max() <= 4 + 4e-14
    a, x = normal(rng, M.n, 1), normal(rng, 1, M.k)
    one = (a - Y[0] @ (H(Y[0]) @ a)) @ x
    assert_close(M.sectional_curvature(Y[0], one, 1j * one), 4.0, 5e-14, "complex plane")
    if M.k == 1:
        U, V = U[0], V[0]
        U = U / np.linalg.norm(U)
        V = V - real_inner(U, V) * U
        V /= np.linalg.norm(V)
        exact = 1 + 3 * real_inner(1j * U, V) ** 2
        assert_close(M.sectional_curvature(Y[0], U, V), exact, 5e-14, "projective space")


def test_gradient_and_hessian_against_the_cost_along_geodesics(M, rng):
    """f(Y) = Re tr(P A P B) of the projector P, with Hermitian A and B."""
    A, B = (X + H(X) for X in normal(rng, 2, M.n, M.n))

    def mixed(P):
        return 2 * (A @ P @ B + B @ P @ A)

    def f(Y):
        P = Y @ H(Y)
        return np.trace(P @ A @ P @ B).real

    def hessian(Y, V):
        return mixed(Y @ H(Y)) @ V + mixed(V @ H(Y) + Y @ H(V)) @ Y

    Y = M.random_point(rng)
    V, W = unit(M, Y, rng), unit(M, Y, rng)
    G = mixed(Y @ H(Y)) @ Y
    first = M.euclidean_to_riemannian_gradient(Y, G)
    second, other = (M.euclidean_to_riemannian_hessian(Y, G, hessian(Y, X), X) for X in (V, W))
    h = 1e-3
    values = [f(M.exp(Y, i * h * V)) for i in (-2, -1, 0, 1, 2)]
    scale = np.linalg.norm(A, 2) * np.linalg.norm(B, 2) * M.k
    slope = (values[0] - 8 * values[1] + 8 * values[3] - values[4]) / (12 * h)
    bend = (-values[0] + 16 * values[1] - 30 * values[2] + 16 * values[3] - values[4]) / (12 * h * h)
    # h^4 times a derivative, and eps / h or eps / h^2.
    assert_close(M.inner(Y, first, V), slope, 1e-11 * scale, "gradient")
    assert_close(M.inner(Y, second, V), bend, 2e-9 * scale, "Hessian")
    assert_close(M.inner(Y, second, W), M.inner(Y, other, V), 10 * M.n * EPS * scale, "symmetric")
