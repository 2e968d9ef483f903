"""The Grassmann manifold compared with its formulas, SciPy, and the reflections 2 Y Y^T - I in O(n)."""

import itertools
import pickle
import re

import numpy as np
import pytest
import scipy.linalg

from stiefel_rs import Grassmann, InvalidInputError, OutsideDomainError, Stiefel

EPS = np.finfo(float).eps
# k = 1, n = 2k, n < 2k, k = n - 1, k = n (one point), and more columns than any special case.
SHAPES = [(3, 1), (4, 2), (5, 3), (5, 4), (3, 3), (20, 4), (30, 12)]
CURVED = [(3, 1), (4, 2), (5, 3), (5, 4), (20, 4)]


def T(A):
    return np.swapaxes(A, -1, -2)


def assert_close(measured, exact, bound, what):
    error = np.max(np.abs(np.asarray(measured) - exact), initial=0.0)
    assert error <= bound, f"{what}: error {error:.3e} exceeds {bound:.3e}"


@pytest.fixture(params=SHAPES, ids=lambda shape: f"Gr{shape[0]}_{shape[1]}")
def M(request):
    return Grassmann(*request.param)


@pytest.fixture(params=CURVED, ids=lambda shape: f"Gr{shape[0]}_{shape[1]}")
def curved(request):
    return Grassmann(*request.param)


def orthogonal(k, rng):
    return np.linalg.qr(rng.standard_normal((k, k)))[0]


def unit_tangent(M, Y, rng):
    V = M.random_tangent(Y, rng)
    # If the subspace is the whole space, the only vector is zero.
    return V / np.linalg.norm(V, axis=(-2, -1), keepdims=True) if M.dim else 0 * V


def separated(M, angles, rng):
    """Two points at the given principal angles, both dense, and the velocity from one to the other."""
    n, k = M.n, M.k
    basis = np.linalg.qr(rng.standard_normal((n, n)))[0]
    count = min(k, n - k)
    full = np.zeros(k)
    full[:count] = np.resize(angles, count)
    Q = np.zeros((n, k))
    Q[:, :count] = basis[:, k : k + count]
    W, Z = orthogonal(k, rng), orthogonal(k, rng)
    Y0 = basis[:, :k] @ W.T
    Y1 = (basis[:, :k] * np.cos(full) + Q * np.sin(full)) @ Z
    return Y0, Y1, (Q * full) @ W.T, full


# ---------------------------------------------------------------- the manifold


def test_attributes(M):
    n, k = M.n, M.k
    assert M.dim == k * (n - k)
    assert repr(M) == f"Grassmann({n}, {k})"
    assert M == Grassmann(n, k)
    assert M != Grassmann(n + 1, k)
    assert M != Stiefel(n, k)
    assert hash(M) == hash(Grassmann(n, k))
    assert pickle.loads(pickle.dumps(M)) == M


@pytest.mark.parametrize("sizes", [(0, 0), (2, 3), (-1, 1), (3, 0), (2**62, 2**40)])
def test_sizes_that_there_are_not(sizes):
    with pytest.raises(InvalidInputError, match=r"Gr\(n, k\): expected 1 <= k <= n"):
        Grassmann(*sizes)


def test_checks_measure_the_defect(M, rng):
    Y = M.random_point(rng)
    V = M.random_tangent(Y, rng)
    assert M.check_point(Y) is None
    assert M.check_tangent(Y, V, atol=20 * M.n * EPS) is None
    off = V + 1e-3 * Y
    defect = np.linalg.norm(Y.T @ off)
    message = re.escape(f"not horizontal, |Y^T V| = {defect:.3e}".replace("e-0", "e-"))
    with pytest.raises(InvalidInputError, match=message):
        M.check_tangent(Y, off)
    for call in [M.exp, M.norm]:
        with pytest.raises(InvalidInputError, match="V: not horizontal"):
            call(Y, off)
    with pytest.raises(InvalidInputError, match="W: not horizontal"):
        M.transport(Y, V, off)
    with pytest.raises(InvalidInputError, match=r"Y1: columns are not orthonormal.*batch member 1"):
        M.log(Y, np.stack([Y, 1.1 * Y]))


def test_projections_and_metric(M, rng):
    Y = M.random_point(rng, size=(2, 3))
    Z = rng.standard_normal(Y.shape)
    P = np.eye(M.n) - Y @ T(Y)
    assert_close(M.project_tangent(Y, Z), P @ Z, 20 * M.n * EPS, "(I - Y Y^T) Z")
    V, W = M.random_tangent(Y, rng), M.random_tangent(Y, rng)
    assert V.shape == Y.shape
    assert_close(M.inner(Y, V, W), np.sum(V * W, axis=(-2, -1)), 100 * M.n * EPS, "tr V^T W")
    assert_close(M.norm(Y, V), np.linalg.norm(V, axis=(-2, -1)), 20 * M.n * EPS, "|V|")
    assert_close(M.project(3 * Y), Y, 8 * M.n * EPS, "project")
    assert_close(M.projector(Y), Y @ T(Y), 8 * M.n * EPS, "projector")
    assert np.array_equal(M.projector(Y), T(M.projector(Y)))


def test_random_streams(M):
    assert np.array_equal(M.random_point(3), Stiefel(M.n, M.k).random_point(3))
    Y = M.random_point(3, size=2)
    assert np.array_equal(M.random_tangent(Y, 5), M.random_tangent(Y, 5))
    M.check_tangent(Y, M.random_tangent(Y), atol=20 * M.n * EPS)


def test_small_parts_are_projected_twice():
    M = Grassmann(200, 3)
    Y = M.random_point(0)
    V = M.random_tangent(Y, 1)
    Z = M.project_tangent(Y, Y @ np.ones((3, 3)) + 1e-12 * V)
    assert np.linalg.norm(Y.T @ Z) <= 100 * EPS * np.linalg.norm(Z)


# ---------------------------------------------------------------- geodesics


@pytest.mark.parametrize("length", [1e-200, 1e-8, 0.3, 1.0, 3.0, 3.2, 30.0, 5000.0, 1e12])
def test_exp_is_its_formula_and_orthonormal(M, length, rng):
    Y = M.random_point(rng, size=4)
    V = length * unit_tangent(M, Y, rng)
    end = M.exp(Y, V)
    M.check_point(end, atol=1e-14 * M.k)
    if length <= 5000:
        Q, S, Wt = np.linalg.svd(V, full_matrices=False)
        exact = (Y @ T(Wt) * np.cos(S)[:, None] + Q * np.sin(S)[:, None]) @ Wt
        assert_close(end, exact, 20 * M.n * EPS * max(1.0, length), "(Y W cos S + Q sin S) W^T")


def test_exp_of_fast_and_slow_directions_at_once():
    M = Grassmann(8, 4)
    rates = np.array([4000.0, 1e-3, 1.0, 0.0])
    rng = np.random.default_rng(1)
    basis = np.linalg.qr(rng.standard_normal((8, 8)))[0]
    W = orthogonal(4, rng)
    Y, Q = basis[:, :4], basis[:, 4:]
    end = M.exp(Y, (Q * rates) @ W.T)
    M.check_point(end, atol=1e-14)
    exact = (Y @ W * np.cos(rates) + Q * np.sin(rates)) @ W.T
    assert_close(end, exact, 10 * EPS * 4000, "exp")


def test_exp_undoes_log(M, rng):
    Y0, Y1 = M.random_point(rng, size=50), M.random_point(rng, size=50)
    V = M.log(Y0, Y1)
    largest = M.principal_angles(Y0, Y1)[:, 0]
    M.check_tangent(Y0, V, atol=20 * M.n * EPS)
    assert_close(M.projector(M.exp(Y0, V)), M.projector(Y1), 50 * M.n * EPS, "span of exp(log)")
    loss = 1 / np.cos(largest.max())
    assert_close(M.exp(Y0, V), M.align(Y0, Y1), 50 * M.n * EPS * loss, "exp(log) is the aligned basis")
    assert_close(M.dist(Y0, Y1), np.linalg.norm(V, axis=(-2, -1)), 20 * M.n * EPS, "dist")
    assert largest.max() <= np.pi / 2


def test_log_undoes_exp(M, rng):
    Y = M.random_point(rng)
    for length in [1e-3, 0.5, 1.2]:
        V = length * unit_tangent(M, Y, rng)
        assert_close(M.log(Y, M.exp(Y, V)), V, 50 * M.n * EPS, f"length {length}")


def test_results_do_not_depend_on_the_basis(M, rng):
    Y0, Y1, _, _ = separated(M, [1.4, 0.9, 0.3, 1e-5], rng)
    Q0, Q1 = orthogonal(M.k, rng), orthogonal(M.k, rng)
    Q1[:, 0] *= -np.sign(np.linalg.det(Q1)) * np.sign(np.linalg.det(Q0))
    V, W = M.log(Y0, Y1), M.random_tangent(Y0, rng)
    U = M.random_tangent(Y0, rng)
    assert_close(M.log(Y0 @ Q0, Y1 @ Q1), V @ Q0, 1e-12, "log")
    assert_close(M.exp(Y0 @ Q0, V @ Q0), M.exp(Y0, V) @ Q0, 1e-12, "exp")
    assert_close(M.dist(Y0 @ Q0, Y1 @ Q1), M.dist(Y0, Y1), 1e-12, "dist")
    assert_close(M.principal_angles(Y0 @ Q0, Y1 @ Q1), M.principal_angles(Y0, Y1), 1e-12, "angles")
    assert_close(M.transport(Y0 @ Q0, V @ Q0, W @ Q0), M.transport(Y0, V, W) @ Q0, 1e-12, "transport")
    assert_close(M.curvature(Y0 @ Q0, U @ Q0, V @ Q0, W @ Q0), M.curvature(Y0, U, V, W) @ Q0, 1e-11, "curvature")
    assert_close(M.align(Y0 @ Q0, Y1 @ Q1), M.align(Y0, Y1) @ Q0, 1e-12, "align")


def test_equivariance_under_rotations_of_space(M, rng):
    Y0, Y1, V, _ = separated(M, [1.2, 0.4], rng)
    g = orthogonal(M.n, rng)
    bound = 100 * M.n * EPS
    assert_close(M.log(g @ Y0, g @ Y1), g @ M.log(Y0, Y1), bound, "log")
    assert_close(M.exp(g @ Y0, g @ V), g @ M.exp(Y0, V), bound, "exp")


@pytest.mark.parametrize("angles", [[0.4], [1.2, 1.2, 0.0], [1e-9], [0.0], [1.0, 1e-12], [1.5, 1.5, 1.5]])
def test_logarithm_at_given_angles(M, angles, rng):
    """Including repeated angles, zeros and equal subspaces."""
    Y0, Y1, V, full = separated(M, angles, rng)
    bound = 20 * M.n * EPS / np.cos(full.max())
    assert_close(M.log(Y0, Y1), V, bound, "log")
    assert_close(M.principal_angles(Y0, Y1), np.sort(full)[::-1], 20 * M.n * EPS, "angles")
    assert_close(M.dist(Y0, Y1), np.linalg.norm(full), 20 * M.n * EPS, "dist")


def test_principal_angles_are_those_of_scipy(M, rng):
    Y0, Y1 = M.random_point(rng, size=10), M.random_point(rng, size=10)
    measured = M.principal_angles(Y0, Y1)
    for a, b, angles in zip(Y0, Y1, measured, strict=True):
        # SciPy computes angles below pi/4 from their cosines if others are above, and loses half of the digits.
        assert_close(angles, scipy.linalg.subspace_angles(a, b), 1e-7, "subspace_angles")
    common = max(2 * M.k - M.n, 0)
    assert np.array_equal(measured[:, M.k - common :], np.zeros((10, common)))


def test_one_point_alone(rng):
    M = Grassmann(3, 3)
    Y0, Y1 = M.random_point(rng, size=(2, 5))
    assert np.array_equal(M.log(Y0, Y1), np.zeros((5, 3, 3)))
    assert np.array_equal(M.dist(Y0, Y1), np.zeros(5))
    assert_close(M.align(Y0, Y1), Y0, 20 * EPS, "align")
    assert_close(M.exp(Y0, 0 * Y0), Y0, 4 * EPS, "exp")


def test_coordinate_columns_and_permutations():
    identity = np.eye(6)
    for k in (1, 2, 3, 5):
        M = Grassmann(6, k)
        for columns in itertools.permutations(range(6), k):
            Y1 = identity[:, list(columns)]
            outside = sum(column >= k for column in columns)
            right = np.pi / 2
            assert_close(
                M.principal_angles(identity[:, :k], Y1), [right] * outside + [0.0] * (k - outside), EPS, "angles"
            )
            assert_close(M.dist(identity[:, :k], Y1), right * np.sqrt(outside), 4 * EPS, "dist")
            if outside:
                with pytest.raises(OutsideDomainError) as caught:
                    M.log(identity[:, :k], Y1)
                assert caught.value.angle == right
            else:
                assert np.array_equal(M.log(identity[:, :k], Y1), np.zeros((6, k)))
                assert np.array_equal(M.align(identity[:, :k], Y1), identity[:, :k])


def test_a_right_angle_is_refused_with_the_angle(curved, rng):
    Y0, Y1, _, full = separated(curved, [np.pi / 2, 0.3], rng)
    for call in (curved.log, curved.align):
        with pytest.raises(OutsideDomainError, match=r"a principal angle is 1\.5707963") as caught:
            call(Y0, Y1)
        assert abs(caught.value.angle - np.pi / 2) <= 1e-14
    assert_close(curved.dist(Y0, Y1), np.linalg.norm(full), 20 * curved.n * EPS, "dist is defined there")
    Y0, Y1, V, _ = separated(curved, [np.pi / 2 - 1e-8, 0.3], rng)
    assert_close(curved.log(Y0, Y1), V, 100 * curved.n * EPS * 1e8, "log just below")
    with pytest.raises(OutsideDomainError, match="batch member 1"):
        last = np.eye(curved.n)[:, ::-1][:, : curved.k]
        curved.log(np.stack([Y0, np.eye(curved.n, curved.k)]), np.stack([Y1, last]))


def test_align_is_the_nearest_basis(M, rng):
    Y0, Y1 = M.random_point(rng), M.random_point(rng)
    U, _, Zt = np.linalg.svd(Y1.T @ Y0)
    assert_close(M.align(Y0, Y1), Y1 @ U @ Zt, 100 * M.n * EPS / np.cos(M.principal_angles(Y0, Y1)[0]), "Procrustes")
    product = Y0.T @ M.align(Y0, Y1)
    assert_close(product, product.T, 20 * M.n * EPS, "Y0^T Y is symmetric")
    assert np.linalg.eigvalsh(product).min() >= 0


def test_transport(curved, rng):
    M = curved
    Y = M.random_point(rng, size=5)
    for length in [0.5, 3.0, 40.0]:
        V = length * unit_tangent(M, Y, rng)
        W, X = M.random_tangent(Y, rng), M.random_tangent(Y, rng)
        end = M.exp(Y, V)
        moved = M.transport(Y, V, W)
        bound = 50 * M.n * EPS * max(1.0, length)
        M.check_tangent(end, moved, atol=1e-14 * M.k)
        assert_close(M.inner(end, moved, M.transport(Y, V, X)), M.inner(Y, W, X), bound, "isometric")
        velocity = M.transport(Y, V, V)
        h = 1e-5
        ahead = (M.exp(Y, (1 + h) * V) - M.exp(Y, (1 - h) * V)) / (2 * h)
        # h^2 |V|^3 / 6 and eps / h.
        assert_close(velocity, ahead, 1e-10 * max(1.0, length**3) + 1e-9, "the velocity is parallel")
        back = M.transport(end, -velocity, moved)
        assert_close(back, W, 20 * bound, "there and back")


def test_transport_of_extreme_lengths():
    M = Grassmann(4, 2)
    Y, V = np.eye(4, 2), 0.7 * np.eye(4, 2, -2)
    unit = M.transport(Y, V, V)
    for scale in [1e-300, 1e-160, 1e300]:
        assert_close(M.transport(Y, V, scale * V) / scale, unit, 4 * EPS, f"{scale}")


def test_speed_is_constant(curved, rng):
    Y = curved.random_point(rng)
    V = unit_tangent(curved, Y, rng)
    for t in [0.3, 1.0, 1.5]:
        assert_close(curved.dist(Y, curved.exp(Y, t * V)), t, 50 * EPS, "dist of exp")


# ---------------------------------------------------------------- reflections in O(n)


def reflection(Y):
    return 2 * Y @ T(Y) - np.eye(Y.shape[-2])


def lifted(Y, V):
    """The differential of `reflection`."""
    return 2 * (V @ T(Y) + Y @ T(V))


def test_reflections_in_the_orthogonal_group(curved, rng):
    """Lengths there (canonical metric of St(n, n)) are twice those here; geodesics and curvature correspond."""
    M, G = curved, Stiefel(curved.n, curved.n)
    Y = M.random_point(rng)
    U, V, W = (0.4 * unit_tangent(M, Y, rng) for _ in range(3))
    S = reflection(Y)
    bound = 100 * M.n * EPS
    lift = [lifted(Y, X) for X in (U, V, W)]
    G.check_tangent(S, lift[0], atol=bound)
    assert_close(G.norm(S, lift[0]), 2 * M.norm(Y, U), bound, "length")
    assert_close(G.inner(S, lift[0], lift[1]), 4 * M.inner(Y, U, V), bound, "inner product")
    assert_close(G.exp(S, lift[0]), reflection(M.exp(Y, U)), bound, "exp")
    end = M.exp(Y, U)
    assert_close(G.log(S, reflection(end)), lifted(Y, M.log(Y, end)), bound, "log")
    assert_close(G.dist(S, reflection(end)), 2 * M.dist(Y, end), bound, "dist")
    assert_close(G.transport(S, *lift[:2]), lifted(end, M.transport(Y, U, V)), bound, "transport")
    assert_close(G.curvature(S, *lift), lifted(Y, M.curvature(Y, U, V, W)), bound, "curvature")
    if M.dim > 1 and M.k < M.n:
        here = M.sectional_curvature(Y, U, V)
        assert_close(4 * G.sectional_curvature(S, *lift[:2]), here, 100 * bound, "sectional curvature")


# ---------------------------------------------------------------- curvature


def test_identities_of_the_curvature_tensor(curved, rng):
    M = curved
    Y = M.random_point(rng, size=4)
    U, V, W, X = (unit_tangent(M, Y, rng) for _ in range(4))

    def R(*vectors):
        return M.curvature(Y, *vectors)

    bound = 5e-15 * M.k
    assert_close(R(U, V, W), -R(V, U, W), bound, "skew in the first pair")
    assert_close(R(U, V, W) + R(V, W, U) + R(W, U, V), 0, 3 * bound, "Bianchi")
    assert_close(M.inner(Y, R(U, V, W), X), -M.inner(Y, R(U, V, X), W), 4 * bound, "skew in the second pair")
    assert_close(M.inner(Y, R(U, V, W), X), M.inner(Y, R(W, X, U), V), 4 * bound, "pairs exchanged")
    M.check_tangent(Y, R(U, V, W), atol=bound)
    formula = U @ T(V) @ W - V @ T(U) @ W + W @ (T(V) @ U - T(U) @ V)
    assert_close(R(U, V, W), formula, bound, "U V^T W - V U^T W + W (V^T U - U^T V)")
    assert_close(R(1e200 * U, 1e-250 * V, W), 1e-50 * R(U, V, W), 1e-50 * bound, "lengths of any size")


def test_curvature_is_the_holonomy_of_small_loops(curved, rng):
    """Transport around a parallelogram with sides h: W - h^2 R(U, V) W up to the next order."""
    M = curved
    Y = M.random_point(rng)
    U, V, W = (unit_tangent(M, Y, rng) for _ in range(3))
    errors, steps = [], 0.1 / 2.0 ** np.arange(4)
    for h in steps:
        # Along U, along V, and back along their transports; the gap is closed by a geodesic.
        point, carried, sides = Y, W, [U, V]
        for sign in (1, -1):
            for i in (0, 1):
                step = sign * h * sides[i]
                carried, other = (M.transport(point, step, X) for X in (carried, sides[1 - i]))
                sides[i] = M.transport(point, step, sides[i])
                sides[1 - i] = other
                point = M.exp(point, step)
        # The basis at the end nearly spans the subspace of Y; convert back to the basis Y.
        closing = M.log(point, Y)
        carried = M.transport(point, closing, carried)
        end = M.exp(point, closing)
        carried = carried @ (end.T @ Y)
        errors.append(np.linalg.norm(carried - W + h * h * M.curvature(Y, U, V, W)))
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0] if max(errors) > 1e-13 else 3.0
    assert slope > 2.8, f"errors {errors}"


def test_sectional_curvature(curved, rng):
    M = curved
    if M.dim < 2:
        return
    Y = M.random_point(rng, size=300)
    U, V = M.random_tangent(Y, rng), M.random_tangent(Y, rng)
    values = M.sectional_curvature(Y, U, V)
    assert values.min() >= -1e-14
    assert values.max() <= 2 + 1e-14
    if min(M.k, M.n - M.k) == 1:
        assert_close(values, 1.0, 1e-13, "curvature of projective space")
    R = M.curvature(Y, U, V, V)
    area = M.inner(Y, U, U) * M.inner(Y, V, V) - M.inner(Y, U, V) ** 2
    bound = 20 * M.n * EPS * np.max(M.norm(Y, U) ** 2 * M.norm(Y, V) ** 2)
    assert_close(values * area, M.inner(Y, R, U), bound, "quotient")
    with pytest.raises(InvalidInputError, match="U and V: linearly dependent"):
        M.sectional_curvature(Y[0], U[0], -2 * U[0])


# ---------------------------------------------------------------- gradients


def test_gradient_and_hessian_against_the_cost_along_geodesics(curved, rng):
    """f(Y) = tr(P A P B) of the projector P, which depends on the subspace alone."""
    M = curved
    A, B = (X + X.T for X in rng.standard_normal((2, M.n, M.n)))

    def f(Y):
        return np.sum((A @ Y @ Y.T) * (B @ Y @ Y.T).T)

    def gradient(Y):
        return 2 * (A @ Y @ Y.T @ B + B @ Y @ Y.T @ A) @ Y

    def hessian(Y, V):
        change = V @ Y.T + Y @ V.T
        return 2 * ((A @ Y @ Y.T @ B + B @ Y @ Y.T @ A) @ V + (A @ change @ B + B @ change @ A) @ Y)

    Y = M.random_point(rng)
    V, W = (unit_tangent(M, Y, rng) for _ in range(2))
    first = M.euclidean_to_riemannian_gradient(Y, gradient(Y))
    second = M.euclidean_to_riemannian_hessian(Y, gradient(Y), hessian(Y, V), V)
    h = 1e-3
    values = [f(M.exp(Y, i * h * V)) for i in (-2, -1, 0, 1, 2)]
    scale = np.linalg.norm(A, 2) * np.linalg.norm(B, 2) * M.k
    slope = (values[0] - 8 * values[1] + 8 * values[3] - values[4]) / (12 * h)
    bend = (-values[0] + 16 * values[1] - 30 * values[2] + 16 * values[3] - values[4]) / (12 * h * h)
    assert_close(M.inner(Y, first, V), slope, 1e-9 * scale, "gradient")
    assert_close(M.inner(Y, second, V), bend, 1e-7 * scale, "Hessian")
    other = M.euclidean_to_riemannian_hessian(Y, gradient(Y), hessian(Y, W), W)
    assert_close(M.inner(Y, second, W), M.inner(Y, other, V), 100 * M.n * EPS * scale, "symmetric")
    # The covariant derivative of the gradient, from a gradient carried back over a short distance.
    ahead, behind = (M.exp(Y, s * V) for s in (h, -h))

    def carried(end, s):
        field = M.euclidean_to_riemannian_gradient(end, gradient(end))
        return M.transport(end, -s * M.transport(Y, s * V, V), field)

    change = (carried(ahead, h) - carried(behind, -h)) / (2 * h)
    assert_close(change, second, 1e-4 * scale, "covariant derivative of the gradient")


# ---------------------------------------------------------------- batches


def test_batches_broadcast_and_equal_single_calls(M, rng):
    Y0, Y1 = M.random_point(rng, size=(3, 1)), M.random_point(rng, size=4)
    V = M.log(Y0, Y1)
    assert V.shape == (3, 4, M.n, M.k)
    assert M.dist(Y0, Y1).shape == (3, 4)
    assert M.principal_angles(Y0, Y1).shape == (3, 4, M.k)
    for i, j in np.ndindex(3, 4):
        assert np.array_equal(V[i, j], M.log(Y0[i, 0], Y1[j]))
        assert np.array_equal(M.exp(Y0, V)[i, j], M.exp(Y0[i, 0], V[i, j]))
    assert M.log(Y0[:0], Y1[:0]).shape == (0, 0, M.n, M.k)
