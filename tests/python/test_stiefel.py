"""The manifold: every method compared with its formula in NumPy, batches, broadcasting, random points."""

import numpy as np
import pytest
import scipy.linalg

from stiefel_rs import InvalidInputError, OutsideDomainError, Stiefel

EPS = np.finfo(float).eps


def T(A):
    return np.swapaxes(A, -1, -2)


def assert_close(measured, exact, bound, what):
    error = np.max(np.abs(np.asarray(measured) - exact), initial=0.0)
    assert error <= bound, f"{what}: error {error:.3e} exceeds {bound:.3e}"


@pytest.fixture
def points(manifold, rng):
    """A batch (2, 3, n, k) of points and two batches of tangent vectors."""
    S = manifold.random_point(rng, size=(2, 3))
    return S, manifold.random_tangent(S, rng), manifold.random_tangent(S, rng)


def test_attributes(manifold):
    n, k = manifold.n, manifold.k
    assert manifold.dim == n * k - k * (k + 1) // 2
    assert repr(manifold) == f"Stiefel({n}, {k})"
    assert manifold == Stiefel(n, k)
    assert manifold != Stiefel(n + 1, k)
    assert hash(manifold) == hash(Stiefel(n, k))
    assert manifold != (n, k)


def test_check_point_measures_the_defect(manifold, points):
    S = points[0]
    assert manifold.check_point(S) is None
    off = S[0, 0] * (1 + 1e-6)
    defect = np.linalg.norm(off.T @ off - np.eye(manifold.k))
    with pytest.raises(InvalidInputError, match=f"{defect:.3e}".replace("e-0", "e-0?")):
        manifold.check_point(off)
    manifold.check_point(off, atol=1.01 * defect)
    with pytest.raises(InvalidInputError):
        manifold.check_point(off, atol=0.99 * defect)


def test_check_tangent_measures_the_defect(manifold, points):
    S, V, _ = points
    assert manifold.check_tangent(S, V) is None
    s, v = S[0, 0], V[0, 0] + 1e-3 * S[0, 0]
    defect = np.linalg.norm(s.T @ v + v.T @ s) / 2
    relative = defect / max(1.0, np.linalg.norm(v))
    with pytest.raises(InvalidInputError, match=f"{defect:.3e}".replace("e-0", "e-0?")):
        manifold.check_tangent(s, v)
    manifold.check_tangent(s, v, atol=1.01 * relative)
    with pytest.raises(InvalidInputError):
        manifold.check_tangent(s, v, atol=0.99 * relative)


def test_project_is_the_polar_factor(manifold, rng):
    n, k = manifold.n, manifold.k
    Y = rng.standard_normal((2, 3, n, k))
    U, sigma, Vt = np.linalg.svd(Y, full_matrices=False)
    # Condition number of the polar factor: 1 / smallest singular value.
    assert_close(manifold.project(Y), U @ Vt, 20 * n * EPS * sigma.max() / sigma.min(), "polar factor")
    S = manifold.random_point(rng)
    assert_close(manifold.project(3.0 * S), S, 8 * n * EPS, "projection of a multiple of a point")


def test_project_tangent_is_the_orthogonal_projection(manifold, points, rng):
    S = points[0]
    Z = rng.standard_normal(S.shape)
    P = manifold.project_tangent(S, Z)
    exact = Z - S @ (T(S) @ Z + T(Z) @ S) / 2
    assert_close(P, exact, 16 * manifold.n * EPS, "Z - S sym(S^T Z)")
    manifold.check_tangent(S, P, atol=16 * manifold.n * EPS)
    # Z - P is orthogonal (Frobenius) to every tangent vector.
    inner = np.einsum("...ij,...ij", Z - P, points[1])
    assert_close(inner, 0.0, 64 * S.shape[-1] * S.shape[-2] * EPS * 10, "normal part against a tangent vector")


def test_inner_and_norm_are_the_canonical_metric(manifold, points):
    S, V, W = points
    metric = np.eye(manifold.n) - S @ T(S) / 2
    exact = np.einsum("...ij,...ij", V, metric @ W)
    bound = 16 * manifold.n * manifold.k * EPS * np.linalg.norm(V) * np.linalg.norm(W)
    assert manifold.inner(S, V, W).shape == (2, 3)
    assert_close(manifold.inner(S, V, W), exact, bound, "tr V^T (I - S S^T/2) W")
    assert_close(manifold.inner(S, W, V), exact, bound, "symmetry of the metric")
    norm = np.sqrt(np.einsum("...ij,...ij", V, metric @ V))
    assert_close(manifold.norm(S, V), norm, 16 * manifold.n * EPS * norm.max(), "canonical norm")


def test_decompose_and_compose(manifold, points):
    S, V, _ = points
    X, Omega = manifold.decompose(S, V)
    n, k = manifold.n, manifold.k
    assert X.shape == (2, 3, n, n)
    assert Omega.shape == (2, 3, k, k)
    bound = 32 * n * EPS * np.abs(V).max()
    K = V - S @ (T(S) @ V)
    assert_close(X, K @ T(S) - S @ T(K), bound, "X = K S^T - S K^T")
    assert_close(Omega, T(S) @ V, bound, "Omega = S^T V")
    assert_close(X, -T(X), 0.0, "X is exactly skew")
    assert_close(Omega, -T(Omega), 0.0, "Omega is exactly skew")
    assert_close(manifold.compose(S, X, Omega), V, bound, "V = X S + S Omega")


def test_retract_is_two_exponentials(manifold, points):
    S, V, _ = points
    R = manifold.retract(S, V)
    for i in np.ndindex(2, 3):
        X, Omega = manifold.decompose(S[i], V[i])
        exact = scipy.linalg.expm(X) @ S[i] @ scipy.linalg.expm(Omega)
        bound = 32 * manifold.n * EPS * max(1.0, np.linalg.norm(V[i]))
        assert_close(R[i], exact, bound, "e^X S e^Omega")
    manifold.check_point(R, atol=32 * manifold.n * EPS)
    assert_close(manifold.retract(S, 0 * V), S, 16 * manifold.n * EPS, "retraction of zero")


def test_retract_starts_along_its_vector(manifold, points):
    S, V, _ = points
    h = 1e-4
    slope = (manifold.retract(S, h * V) - manifold.retract(S, -h * V)) / (2 * h)
    # Truncation h^2 |V|^3 / 6, round-off eps / h.
    assert_close(slope, V, h**2 * np.linalg.norm(V[0, 0]) ** 3 * 10 + 100 * EPS / h, "d/dt retract(S, t V) at 0")


def test_inverse_retract_inverts_retract(manifold, points):
    S, V, _ = points
    V = V * (1.2 / manifold.norm(S, V))[..., None, None]
    back = manifold.inverse_retract(S, manifold.retract(S, V))
    # Angles up to 1.2 sqrt(2) < pi; conditioning about 1 / sin.
    assert_close(back, V, 200 * manifold.n * EPS, "inverse_retract(S, retract(S, V))")


def test_inverse_retract_meets_almost_every_point(rng):
    for n, k in [(3, 1), (4, 2), (6, 3)]:
        M = Stiefel(n, k)
        S0, S1 = M.random_point(rng, size=200), M.random_point(rng, size=200)
        V = M.inverse_retract(S0, S1)
        M.check_tangent(S0, V)
        # Conditioning 1/(pi - angle): 200 random pairs come within about 1e-2 of pi.
        assert_close(M.retract(S0, V), S1, 1e-12, f"end of the quasi-geodesic on St({n},{k})")


def test_inverse_retract_on_the_sphere_is_the_great_circle(rng):
    M = Stiefel(3, 1)
    S0, S1 = M.random_point(rng, size=50), M.random_point(rng, size=50)
    cross = np.linalg.norm(np.cross(S0[..., 0], S1[..., 0]), axis=-1)
    angle = np.arctan2(cross, np.sum(S0 * S1, axis=(-1, -2)))
    V = M.inverse_retract(S0, S1)
    assert_close(M.norm(S0, V), angle, 1e-14 * 8, "length of the great circle")


@pytest.mark.parametrize(("n", "k"), [(3, 1), (4, 2), (4, 4)])
def test_unreachable_points_carry_the_angle(n, k):
    M, S = Stiefel(n, k), np.eye(n, k)
    other = S.copy()
    other[0, 0] = -1.0
    with pytest.raises(OutsideDomainError) as caught:
        M.inverse_retract(S, other)
    assert abs(caught.value.angle - np.pi) < 1e-12, f"carried angle {caught.value.angle!r}"


def test_broadcasting(manifold, rng):
    S = manifold.random_point(rng)
    Z = rng.standard_normal((4, 1, *S.shape))
    V = manifold.project_tangent(S, Z)
    W = manifold.random_tangent(np.broadcast_to(S, (5, *S.shape)), rng)
    assert V.shape == (4, 1, *S.shape)
    inner = manifold.inner(S, V, W)
    assert inner.shape == (4, 5)
    for i, j in np.ndindex(4, 5):
        assert inner[i, j] == manifold.inner(S, V[i, 0], W[j]), f"member {i}, {j} differs from the single call"
    X, Omega = manifold.decompose(S, V)
    assert manifold.compose(S, X[0, 0], Omega).shape == V.shape
    assert manifold.norm(S, V).shape == (4, 1)
    assert manifold.retract(S, V).shape == V.shape
    manifold.check_tangent(S, V)


def test_single_points_give_numbers(manifold, rng):
    S = manifold.random_point(rng)
    V = manifold.random_tangent(S, rng)
    assert np.shape(manifold.inner(S, V, V)) == ()
    assert float(manifold.norm(S, V)) > 0.0


@pytest.mark.parametrize("lead", [(0,), (2, 0)])
def test_empty_batches(manifold, lead):
    n, k = manifold.n, manifold.k
    S = np.zeros((*lead, n, k))
    manifold.check_point(S)
    manifold.check_tangent(S, S)
    for result in [
        manifold.project(S),
        manifold.project_tangent(S, S),
        manifold.random_tangent(S, 0),
        manifold.retract(S, S),
        manifold.inverse_retract(S, S),
        manifold.random_point(0, size=lead),
    ]:
        assert result.shape == (*lead, n, k)
    assert manifold.inner(S, S, S).shape == lead
    assert manifold.decompose(S, S)[0].shape == (*lead, n, n)


def test_random_points_are_reproducible(manifold):
    S = manifold.random_point(rng=7, size=(2, 2))
    assert S.shape == (2, 2, manifold.n, manifold.k)
    manifold.check_point(S, atol=16 * manifold.n * EPS)
    assert np.array_equal(S, manifold.random_point(7, (2, 2)))
    assert np.array_equal(S, manifold.random_point(np.random.default_rng(7), (2, 2)))
    generator = np.random.default_rng(7)
    first, second = manifold.random_point(generator), manifold.random_point(generator)
    assert not np.array_equal(first, second), "a generator must advance"
    assert not np.array_equal(manifold.random_point(), manifold.random_point()), "no seed, no repetition"
    assert manifold.random_point(7, 3).shape == manifold.random_point(7, [3]).shape == (3, manifold.n, manifold.k)
    assert np.array_equal(manifold.random_tangent(S, 5), manifold.random_tangent(S, np.random.default_rng(5)))


@pytest.mark.parametrize("shape", [(3, 1), (3, 2), (4, 4), (6, 2)])
@pytest.mark.parametrize("rng_of", [int, np.random.default_rng, np.random.SeedSequence, lambda seed: [seed, 5]])
def test_random_tangent_vectors_know_nothing_of_a_point_of_their_seed(shape, rng_of):
    (n, k), count = shape, 800
    M = Stiefel(n, k)
    pairs = []
    for seed in range(count):
        S = M.random_point(rng_of(seed))
        pairs.append((S, M.random_tangent(S, rng_of(seed))))
    S, V = (np.stack(x) for x in zip(*pairs, strict=True))
    # Directions derived from the point: its entries in other orders, and linear images of it.
    left, right = (np.cos(1.0 + np.arange(m * m)).reshape(m, m) for m in shape)
    images = [S[:, ::-1], S[:, ::-1, ::-1], np.roll(S, 1, axis=1), left @ S, S @ right, left @ S @ right, S**3]
    for i, image in enumerate(images):
        D = M.project_tangent(S, image)
        size = np.linalg.norm(D, axis=(1, 2))
        keep = size > 1e-6
        if not keep.any():
            continue
        # Standard normal if V is independent of S: five standard deviations of the mean and of the mean square.
        x = np.sum(V * D, axis=(1, 2))[keep] / size[keep]
        assert_close(x.mean(), 0.0, 5 / np.sqrt(x.size), f"mean along image {i}")
        assert_close((x**2).mean(), 1.0, 5 * np.sqrt(2 / x.size), f"variance along image {i}")


def test_random_points_are_uniform(manifold):
    n, k, count = manifold.n, manifold.k, 4000
    S = manifold.random_point(rng=1, size=count)
    # Entries of a Haar point have mean 0 and variance 1/n; five standard deviations of the mean for n k entries.
    assert_close(S.mean(axis=0), 0.0, 5 / np.sqrt(n * count), "mean of an entry")
    # The variance of a squared entry is at most 2/n^2 (exactly 2 (n-1) / (n^2 (n+2))).
    assert_close((S**2).mean(axis=0), 1 / n, 5 * np.sqrt(2 / count) / n, "variance of an entry")
    if k == n:
        # Both components of O(n) are hit: a fair coin, five standard deviations.
        assert_close(np.sign(np.linalg.det(S)).mean(), 0.0, 5 / np.sqrt(count), "mean determinant")


def test_random_tangents_are_tangent_and_centred(manifold):
    S = manifold.random_point(rng=3)
    V = manifold.random_tangent(np.broadcast_to(S, (4000, *S.shape)), rng=4)
    manifold.check_tangent(S, V, atol=64 * manifold.n * EPS)
    # Projected standard normal: every entry has variance at most 1.
    assert_close(V.mean(axis=0), 0.0, 5 / np.sqrt(4000), "mean of an entry")
    # E |V|^2 is the dimension; variance 2 dim.
    mean = np.mean(np.sum(V**2, axis=(-1, -2)))
    assert_close(mean, manifold.dim, 5 * np.sqrt(2 * manifold.dim / 4000), "mean squared length")


def test_the_seed_of_a_point_may_be_that_of_a_tangent_vector(manifold):
    for seed in range(20):
        S = manifold.random_point(seed)
        V = manifold.random_tangent(S, seed)
        assert np.linalg.norm(V) > 1e-3 or manifold.dim == 0, f"no direction from seed {seed}"
        assert np.array_equal(V, manifold.random_tangent(S, np.random.default_rng(seed)))


def test_everything_is_equivariant_under_left_rotations(manifold, points, rng):
    S, V, W = points
    g = np.linalg.qr(rng.standard_normal((manifold.n, manifold.n)))[0]
    bound = 64 * manifold.n * EPS * max(1.0, np.linalg.norm(V[0, 0]))
    assert_close(manifold.retract(g @ S, g @ V), g @ manifold.retract(S, V), bound, "retract")
    assert_close(manifold.project(g @ (S + V)), g @ manifold.project(S + V), bound, "project")
    assert_close(manifold.inner(g @ S, g @ V, g @ W), manifold.inner(S, V, W), bound * manifold.n * 10, "inner")
