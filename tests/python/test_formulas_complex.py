"""The formulas of docs/mathematics.md about complex frames."""

import numpy as np
from complex_frames import H, assert_close, embed, normal, restrict, skew, split, tangents, unitary

from stiefel_rs import RiemannianCubic, SmoothingSpline, Stiefel

M = Stiefel(4, 2, field="complex")


def test_metric(rng):
    S = M.random_point(rng)
    V, W = tangents(M, S, rng, 2)
    exact = np.trace(H(V) @ (np.eye(4) - S @ H(S) / 2) @ W).real
    assert_close(M.inner(S, V, W), exact, 1e-14, "Re tr V^H (I - S S^H / 2) W")
    assert M.dim == 2 * 4 * 2 - 2**2


def test_gradient(rng):
    S, G = M.random_point(rng), normal(rng, 4, 2)
    (V,) = tangents(M, S, rng, 1)
    gradient = M.euclidean_to_riemannian_gradient(S, G)
    assert_close(gradient, (np.eye(4) - S @ H(S)) @ G + 2 * S @ skew(H(S) @ G), 1e-13, "gradient")
    assert_close(M.inner(S, gradient, V), np.trace(H(G) @ V).real, 1e-13, "df(V)")


def test_embedding(rng):
    """It preserves products and the conjugate transpose; J R J^T fixes its image, and squared lengths double."""
    A, B = normal(rng, 4, 2), normal(rng, 2, 3)
    assert_close(embed(A @ B), embed(A) @ embed(B), 1e-14, "products")
    assert_close(embed(H(A)), embed(A).T, 0.0, "transpose")
    left, right = (np.kron([[0.0, -1.0], [1.0, 0.0]], np.eye(m)) for m in (4, 2))
    assert_close(left @ embed(A) @ right.T, embed(A), 0.0, "fixed points")
    S = M.random_point(rng)
    U, V = tangents(M, S, rng, 2)
    real = Stiefel(8, 4)
    assert_close(real.inner(embed(S), embed(U), embed(V)), 2 * M.inner(S, U, V), 1e-13, "metric")
    curvatures = [m.sectional_curvature(*data) for m, data in ((M, (S, U, V)), (real, map(embed, (S, U, V))))]
    assert_close(curvatures[0], 2 * curvatures[1], 1e-12, "sectional curvature")


def test_what_is_halved_and_what_stays(rng):
    S0 = M.random_point(rng)
    V0, A, J = tangents(M, S0, rng, 3)
    curve, real = (
        RiemannianCubic.from_initial(*data, tension=2.0)
        for data in ((S0, V0, A, J), [embed(x) for x in (S0, V0, A, J)])
    )
    assert_close(curve.cost(), real.cost() / 2, 1e-12, "cost")
    assert_close(curve.energy, real.energy / 2, 1e-12, "energy")
    assert_close(curve.arc_length(), real.arc_length() / np.sqrt(2), 1e-12, "length")
    ends = [(part(0.0), part.velocity(0.0), part(1.0), part.velocity(1.0)) for part in (curve, real)]
    gradients = [RiemannianCubic.from_boundary(*data).cost_gradient() for data in ends]
    for own, embedded in zip(*gradients, strict=True):
        assert_close(own, restrict(embedded), 1e-9, "gradient by a matrix")
    t = np.linspace(0, 1, 6)
    S = M.project(curve(t) + 0.05 * normal(rng, 6, 4, 2))
    own = SmoothingSpline(t, S, lam=0.01)
    other = SmoothingSpline(t, np.stack([embed(x) for x in S]), lam=0.01)
    assert_close(own(0.3), restrict(other(0.3)), 1e-11, "lambda stays")
    assert_close(own.misfit, other.misfit / 2, 1e-11, "misfit")


def test_spheres_with_a_phase():
    C = Stiefel(3, 1, field="complex")
    S, K, _ = np.eye(3)[:, :, None]
    assert_close(C.norm(S, 1j * S), np.sqrt(0.5), 1e-15, "phase")
    assert_close(C.sectional_curvature(S, K, 1j * K), 2.5, 1e-13, "K, iK")
    assert_close(C.sectional_curvature(S, K, 1j * S), 0.5, 1e-13, "with the phase")


def test_qr_in_pairs(rng):
    """Embedded columns in pairs have as triangular factor the embedding of the complex one."""
    S = M.random_point(rng)
    (V,) = tangents(M, S, rng, 1)
    pairs = embed(S + V)[:, [0, 2, 1, 3]]
    Q, R = np.linalg.qr(pairs)
    Q = Q * np.sign(np.diag(R))
    assert_close(M.retract(S, V, "qr"), restrict(Q[:, [0, 2, 1, 3]]), 1e-13, "QR")
    Q, R = np.linalg.qr(S + V)
    assert_close(M.retract(S, V, "qr"), Q * (np.diag(R) / np.abs(np.diag(R))), 1e-13, "complex QR")
    X, Omega = M.decompose(S, V)
    K, A = split(S, V)
    assert_close(X, K @ H(S) - S @ H(K), 1e-13, "X")
    assert_close(Omega, A, 1e-13, "Omega")
    assert unitary(rng, 2).shape == (2, 2)
