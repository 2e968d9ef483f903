"""The adapter for pymanopt with complex frames and complex subspaces: pymanopt's own checks, geometry, and solvers."""

import warnings

import numpy as np
import pytest
from complex_frames import EPS, H, assert_close, normal

pymanopt = pytest.importorskip("pymanopt")

from pymanopt.optimizers import ConjugateGradient, SteepestDescent, TrustRegions  # noqa: E402
from pymanopt.tools import diagnostics  # noqa: E402
from pymanopt_checks import assert_derivatives, assert_slopes  # noqa: E402
from test_pymanopt import straightest_piece  # noqa: E402

from stiefel_rs.pymanopt import GrassmannManifold, StiefelManifold  # noqa: E402

FRAMES = {
    "St(1, 1), canonical": lambda: StiefelManifold(1, 1, field="complex", rng=7),
    "St(3, 1), canonical": lambda: StiefelManifold(3, 1, field="complex", rng=7),
    "St(4, 2), canonical": lambda: StiefelManifold(4, 2, field="complex", rng=7),
    "St(3, 3), canonical": lambda: StiefelManifold(3, 3, field="complex", rng=7),
    "St(12, 4), canonical": lambda: StiefelManifold(12, 4, field="complex", rng=7),
    "St(4, 2), Euclidean": lambda: StiefelManifold(4, 2, metric="euclidean", field="complex", rng=7),
    "St(4, 2), alpha": lambda: StiefelManifold(4, 2, metric=0.7, field="complex", rng=7),
}
SUBSPACES = {
    f"Gr({n}, {k})": lambda n=n, k=k: GrassmannManifold(n, k, field="complex", rng=7)
    for n, k in [(2, 1), (3, 1), (4, 2), (5, 3), (12, 4)]
}


def frame_problem(M, rng):
    """Re tr S^H A S B / 2 + Re tr C^H S with Hermitian A and B: a cost without symmetries."""
    n, k = M.stiefel.n, M.stiefel.k
    A, B, C = normal(rng, n, n), normal(rng, k, k), normal(rng, n, k)
    A, B = A + H(A), B + H(B)
    numpy = pymanopt.function.numpy(M)
    return pymanopt.Problem(
        M,
        numpy(lambda S: float(np.sum(S.conj() * (A @ S @ B)).real / 2 + np.sum(C.conj() * S).real)),
        euclidean_gradient=numpy(lambda S: A @ S @ B + C),
        euclidean_hessian=numpy(lambda S, V: A @ V @ B),
    )


def subspace_problem(M, rng):
    """Re tr(P A P B) of the projector P = Y Y^H: a cost of the subspace alone."""
    A, B = (X + H(X) for X in normal(rng, 2, M.grassmann.n, M.grassmann.n))
    numpy = pymanopt.function.numpy(M)

    def mixed(P):
        return 2 * (A @ P @ B + B @ P @ A)

    return pymanopt.Problem(
        M,
        numpy(lambda Y: float(np.trace(Y @ H(Y) @ A @ Y @ H(Y) @ B).real)),
        euclidean_gradient=numpy(lambda Y: mixed(Y @ H(Y)) @ Y),
        euclidean_hessian=numpy(lambda Y, V: mixed(Y @ H(Y)) @ V + mixed(V @ H(Y) + Y @ H(V)) @ Y),
    )


@pytest.fixture(params=[*FRAMES, *SUBSPACES])
def problem(request, rng):
    if request.param in FRAMES:
        return frame_problem(FRAMES[request.param](), rng)
    return subspace_problem(SUBSPACES[request.param](), rng)


def test_slopes_of_the_models(problem, monkeypatch):
    monkeypatch.setattr(diagnostics, "identify_linear_piece", straightest_piece)
    assert_slopes(diagnostics, problem)


def test_check_gradient_and_check_hessian(problem, monkeypatch, capsys):
    plt = pytest.importorskip("matplotlib.pyplot")
    plt.switch_backend("agg")
    monkeypatch.setattr(diagnostics, "identify_linear_piece", straightest_piece)
    monkeypatch.setattr(plt, "show", lambda: plt.close("all"))
    assert_derivatives(diagnostics, problem, capsys)


def test_points_and_vectors(problem):
    M = problem.manifold
    Y, other = M.random_point(), M.random_point()
    V = M.random_tangent_vector(Y)
    assert Y.dtype == V.dtype == M.zero_vector(Y).dtype == np.complex128
    assert M.norm(Y, V) == pytest.approx(1, rel=1e-14)
    assert_close(M.norm(Y, M.zero_vector(Y)), 0.0, 0.0, "norm of zero")
    # The inner product is real and bilinear over the reals.
    W = M.random_tangent_vector(Y)
    assert isinstance(M.inner_product(Y, V, W), float)
    assert M.inner_product(Y, 2 * V, W) == pytest.approx(2 * M.inner_product(Y, V, W), rel=1e-13, abs=1e-15)
    assert M.dist(Y, M.exp(Y, 0.5 * V)) == pytest.approx(0.5, rel=1e-12)
    assert_close(M.log(Y, M.exp(Y, 0.5 * V)), 0.5 * V, 5e-14, "log of exp")
    middle = M.pair_mean(Y, M.exp(Y, 0.5 * V))
    assert M.dist(Y, middle) == pytest.approx(0.25, rel=1e-12)
    base = getattr(M, "stiefel", None) or M.grassmann
    base.check_tangent(other, M.transport(Y, other, V), atol=1e-13)
    assert M.dim == base.dim


def test_names_and_dimensions():
    assert str(StiefelManifold(4, 2, field="complex")) == "Stiefel manifold St(4,2,C), alpha = 0"
    assert str(GrassmannManifold(4, 2, field="complex")) == "Grassmann manifold Gr(4,2,C)"
    assert GrassmannManifold(4, 2, field="complex").dim == 8
    alone = GrassmannManifold(3, 3, field="complex", rng=0)
    assert np.array_equal(alone.random_tangent_vector(alone.random_point()), np.zeros((3, 3)))


def test_geometry_is_that_of_pymanopt():
    """pymanopt's ComplexGrassmann has the same metric; its bases at the ends of geodesics differ."""
    ours, theirs = GrassmannManifold(5, 2, field="complex", rng=3), pymanopt.manifolds.ComplexGrassmann(5, 2)
    Y, other = ours.random_point(), ours.random_point()
    V, W = ours.random_tangent_vector(Y), ours.random_tangent_vector(Y)
    assert ours.dim == theirs.dim
    assert ours.dist(Y, other) == pytest.approx(theirs.dist(Y, other), rel=1e-7)
    assert ours.inner_product(Y, V, W) == pytest.approx(theirs.inner_product(Y, V, W), rel=1e-13, abs=1e-15)
    ends = [end @ H(end) for end in (ours.exp(Y, V), theirs.exp(Y, V))]
    assert_close(ends[0], ends[1], 100 * EPS, "exp")
    Z = normal(np.random.default_rng(4), 5, 2)
    assert_close(ours.projection(Y, Z), theirs.projection(Y, Z), 100 * EPS, "projection")


@pytest.mark.parametrize("kind", [StiefelManifold, GrassmannManifold])
@pytest.mark.parametrize(
    ("optimizer", "bound"),
    [
        # A gradient below 1e-10 bounds the angle to the eigenspace by the gradient divided by the gap of 2.
        (TrustRegions(verbosity=0, min_gradient_norm=1e-10), 1e-9),
        (ConjugateGradient(verbosity=0, min_gradient_norm=1e-6, max_iterations=2000), 1e-5),
        (SteepestDescent(verbosity=0, min_gradient_norm=1e-6, max_iterations=5000), 1e-5),
    ],
    ids=["trust_regions", "conjugate_gradient", "steepest_descent"],
)
def test_solvers_find_the_principal_subspace(optimizer, bound, kind, rng):
    """Of a Hermitian matrix with eigenvalues 12, 11, ..., 1."""
    basis = np.linalg.qr(normal(rng, 12, 12))[0]
    A, exact = (basis * np.arange(12.0, 0.0, -1.0)) @ H(basis), basis[:, :3]
    M = kind(12, 3, field="complex", rng=2)
    numpy = pymanopt.function.numpy(M)
    problem = pymanopt.Problem(
        M,
        numpy(lambda S: -float(np.sum(S.conj() * (A @ S)).real)),
        euclidean_gradient=numpy(lambda S: -2 * A @ S),
        euclidean_hessian=numpy(lambda S, V: -2 * A @ V),
    )
    with warnings.catch_warnings():
        # A warning of pymanopt 2.2 with NumPy 2, not of this package.
        warnings.simplefilter("ignore", DeprecationWarning)
        result = optimizer.run(problem, initial_point=M.random_point())
    distance = np.linalg.norm(result.point @ H(result.point) - exact @ H(exact))
    assert distance <= bound, f"{distance:.3e} after {result.iterations} iterations: {result.stopping_criterion}"
    assert result.cost == pytest.approx(-33, abs=max(1e-12 * 33, 20 * bound**2))
