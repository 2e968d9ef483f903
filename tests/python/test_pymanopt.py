"""The adapter for pymanopt: geometry compared with finite differences, and pymanopt's solvers."""

import doctest
import warnings

import numpy as np
import pytest

pymanopt = pytest.importorskip("pymanopt")

from pymanopt.optimizers import (  # noqa: E402
    ConjugateGradient,
    NelderMead,
    ParticleSwarm,
    SteepestDescent,
    TrustRegions,
)
from pymanopt.tools import diagnostics  # noqa: E402
from pymanopt_checks import assert_derivatives, assert_slopes  # noqa: E402

from stiefel_rs import InvalidInputError, OutsideDomainError  # noqa: E402
from stiefel_rs import pymanopt as adapter_module  # noqa: E402
from stiefel_rs.pymanopt import GrassmannManifold, StiefelManifold  # noqa: E402

METRICS = ["canonical", "euclidean", 0.7]
RETRACTIONS = ["quasi_geodesic", "polar", "qr", "cayley"]
SHAPES = [(3, 1), (4, 2), (5, 3), (4, 4), (12, 4)]
EPS = np.finfo(float).eps


@pytest.fixture(params=METRICS, ids=str)
def metric(request):
    return request.param


@pytest.fixture(params=SHAPES, ids=lambda shape: f"St{shape[0]}_{shape[1]}")
def adapter(request, metric):
    return StiefelManifold(*request.param, metric=metric, rng=7)


def make_problem(manifold, rng):
    """A cost without symmetries: sum of S * (A S B) and a linear term, so that no gradient vanishes by chance."""
    n, k = manifold.stiefel.n, manifold.stiefel.k
    A, B, C = rng.standard_normal((n, n)), rng.standard_normal((k, k)), rng.standard_normal((n, k))
    A, B = A + A.T, B + B.T
    numpy = pymanopt.function.numpy(manifold)
    return pymanopt.Problem(
        manifold,
        numpy(lambda S: float(np.sum(S * (A @ S @ B)) / 2 + np.sum(C * S))),
        euclidean_gradient=numpy(lambda S: A @ S @ B + C),
        euclidean_hessian=numpy(lambda S, V: A @ V @ B),
    )


def slope(x, y):
    return np.polyfit(np.log(x), np.log(y), 1)[0]


def geodesic_model_errors(problem, S, V, h):
    """Cost along the geodesic minus its Taylor polynomials of degree 1 and 2."""
    M = problem.manifold
    first = M.inner_product(S, problem.riemannian_gradient(S), V)
    second = M.inner_product(S, problem.riemannian_hessian(S, V), V)
    change = np.array([problem.cost(M.exp(S, t * V)) for t in h]) - problem.cost(S)
    return np.abs(change - first * h), np.abs(change - first * h - second * h**2 / 2)


def test_gradient_is_tangent_and_represents_the_differential(adapter, rng):
    problem = make_problem(adapter, rng)
    S = adapter.random_point()
    gradient = problem.riemannian_gradient(S)
    adapter.stiefel.check_tangent(S, gradient, atol=1e-12)
    for _ in range(3):
        V = adapter.random_tangent_vector(S)
        directional = np.sum(problem.euclidean_gradient(S) * V)
        scale = np.linalg.norm(problem.euclidean_gradient(S))
        assert abs(adapter.inner_product(S, gradient, V) - directional) <= 100 * EPS * scale


def test_hessian_is_tangent_linear_and_symmetric(adapter, rng):
    problem = make_problem(adapter, rng)
    S = adapter.random_point()
    V, W = adapter.random_tangent_vector(S), adapter.random_tangent_vector(S)
    HV, HW = problem.riemannian_hessian(S, V), problem.riemannian_hessian(S, W)
    adapter.stiefel.check_tangent(S, HV, atol=1e-12)
    scale = max(adapter.norm(S, HV), adapter.norm(S, HW), 1.0)
    bound = 1000 * EPS * scale
    assert abs(adapter.inner_product(S, HV, W) - adapter.inner_product(S, V, HW)) <= bound
    combined = problem.riemannian_hessian(S, 2 * V - 3 * W)
    assert np.linalg.norm(combined - 2 * HV + 3 * HW) <= 10 * bound


def test_gradient_and_hessian_match_the_cost_along_geodesics(adapter, rng):
    problem = make_problem(adapter, rng)
    S = adapter.random_point()
    V = adapter.random_tangent_vector(S)
    h = np.logspace(-3.5, -2, 7)
    linear, quadratic = geodesic_model_errors(problem, S, V, h)
    assert slope(h, linear) == pytest.approx(2, abs=0.2), "the gradient leaves an error of second order"
    assert slope(h, quadratic) == pytest.approx(3, abs=0.2), "the Hessian leaves an error of third order"


def test_hessian_agrees_with_differences_of_the_cost_along_geodesics(adapter, rng):
    problem = make_problem(adapter, rng)
    S = adapter.random_point()
    V = adapter.random_tangent_vector(S)
    h = 1e-3
    f = [problem.cost(adapter.exp(S, i * h * V)) for i in (-2, -1, 0, 1, 2)]
    difference = (-f[0] + 16 * f[1] - 30 * f[2] + 16 * f[3] - f[4]) / (12 * h * h)
    exact = adapter.inner_product(S, problem.riemannian_hessian(S, V), V)
    # h^4 |f''''''|/90 is below 1e-8 here; round-off is 64 eps |f| / (12 h^2).
    scale = max(1.0, *map(abs, f), abs(exact))
    assert abs(difference - exact) <= 1e-8 * scale * 10


def test_exp_keeps_speed_and_leaves_along_its_vector(adapter):
    S = adapter.random_point()
    V = adapter.random_tangent_vector(S)
    assert np.linalg.norm(adapter.exp(S, adapter.zero_vector(S)) - S) <= 20 * EPS * S.size
    h = 1e-4
    for t in (0.0, 0.8):
        point = adapter.exp(S, t * V)
        velocity = (adapter.exp(S, (t + h) * V) - adapter.exp(S, (t - h) * V)) / (2 * h)
        adapter.stiefel.check_point(point, atol=1e-13)
        # Central differences: h^2 times a third derivative below 10, and eps / h.
        assert abs(adapter.norm(point, adapter.projection(point, velocity)) - 1.0) <= 1e-6
    forward = (adapter.exp(S, h * V) - adapter.exp(S, -h * V)) / (2 * h)
    assert np.linalg.norm(forward - V) <= 1e-6


@pytest.mark.parametrize("retraction", RETRACTIONS)
@pytest.mark.parametrize("shape", SHAPES)
def test_retractions_agree_with_exp_to_first_order(shape, retraction, metric):
    M = StiefelManifold(*shape, metric=metric, retraction=retraction, rng=3)
    S = M.random_point()
    V = M.random_tangent_vector(S)
    h = np.logspace(-3, -1.5, 6)
    distance = np.array([np.linalg.norm(M.exp(S, t * V) - M.retraction(S, t * V)) for t in h])
    M.stiefel.check_point(M.retraction(S, V), atol=1e-13)
    if distance.max() > 1e-13:
        assert slope(h, distance) > 1.8, f"distances to exp: {distance}"


@pytest.mark.parametrize(("retraction", "metric"), [("polar", "euclidean"), ("cayley", "canonical")])
@pytest.mark.parametrize("shape", [(4, 2), (5, 3), (12, 4)])
def test_second_order_retractions(shape, retraction, metric):
    M = StiefelManifold(*shape, metric=metric, retraction=retraction, rng=3)
    S = M.random_point()
    V = M.random_tangent_vector(S)
    h = np.logspace(-3, -1.5, 6)
    distance = np.array([np.linalg.norm(M.exp(S, t * V) - M.retraction(S, t * V)) for t in h])
    assert slope(h, distance) == pytest.approx(3, abs=0.2), f"distances to exp: {distance}"


def test_vectors_and_points(adapter):
    S, other = adapter.random_point(), adapter.random_point()
    V = adapter.random_tangent_vector(S)
    assert adapter.norm(S, V) == pytest.approx(1, rel=1e-14)
    assert adapter.inner_product(S, V, V) == pytest.approx(1, rel=1e-14)
    adapter.stiefel.check_tangent(S, V)
    adapter.stiefel.check_tangent(other, adapter.transport(S, other, V))
    assert np.array_equal(adapter.zero_vector(S), np.zeros_like(S))
    assert adapter.dim == adapter.stiefel.dim
    assert adapter.typical_dist == pytest.approx(np.sqrt(adapter.stiefel.k))
    Z = np.ones_like(S)
    assert np.array_equal(adapter.to_tangent_space(S, Z), adapter.projection(S, Z))


@pytest.mark.parametrize("shape", [(3, 1), (4, 2), (12, 4), (4, 4)])
def test_log_dist_and_mean(shape):
    M = StiefelManifold(*shape, rng=5)
    S = M.random_point()
    V = 0.7 * M.random_tangent_vector(S)
    end = M.exp(S, V)
    assert np.linalg.norm(M.log(S, end) - V) <= 1e-12
    assert M.dist(S, end) == pytest.approx(0.7, abs=1e-13)
    assert np.linalg.norm(M.pair_mean(S, end) - M.exp(S, V / 2)) <= 1e-12


def test_seeded_randomness():
    points = [StiefelManifold(5, 2, rng=seed).random_point() for seed in (1, 1, 2)]
    assert np.array_equal(points[0], points[1])
    assert not np.array_equal(points[0], points[2])


def test_unknown_retraction_is_refused():
    with pytest.raises(InvalidInputError, match=r"retraction: must be one of .*, found 'exp'"):
        StiefelManifold(3, 1, retraction="exp")


def pca_problem(manifold, A):
    numpy = pymanopt.function.numpy(manifold)
    return pymanopt.Problem(
        manifold,
        numpy(lambda S: -float(np.sum(S * (A @ S)))),
        euclidean_gradient=numpy(lambda S: -2 * A @ S),
        euclidean_hessian=numpy(lambda S, V: -2 * A @ V),
    )


@pytest.fixture
def covariance(rng):
    """Symmetric with eigenvalues 20, 19, ..., 1: the leading subspaces are well separated."""
    basis = np.linalg.qr(rng.standard_normal((20, 20)))[0]
    return basis @ np.diag(np.arange(20.0, 0.0, -1.0)) @ basis.T


@pytest.mark.parametrize("retraction", RETRACTIONS)
@pytest.mark.parametrize("metric", METRICS[:2])
@pytest.mark.parametrize(
    ("optimizer", "subspace_error"),
    [
        # A gradient below 1e-10 bounds the angle to the eigenspace by the gradient divided by the gap of 2.
        (TrustRegions(verbosity=0, min_gradient_norm=1e-10), 1e-9),
        (ConjugateGradient(verbosity=0, min_gradient_norm=1e-6, max_iterations=2000), 1e-5),
        (SteepestDescent(verbosity=0, min_gradient_norm=1e-6, max_iterations=5000), 1e-5),
    ],
    ids=["trust_regions", "conjugate_gradient", "steepest_descent"],
)
def test_solvers_find_the_principal_components(covariance, optimizer, subspace_error, metric, retraction):
    k = 3
    manifold = StiefelManifold(20, k, metric=metric, retraction=retraction, rng=2)
    with warnings.catch_warnings():
        # A warning of pymanopt 2.2 with NumPy 2, not of this package.
        warnings.simplefilter("ignore", DeprecationWarning)
        result = optimizer.run(pca_problem(manifold, covariance), initial_point=manifold.random_point())
    exact = np.linalg.eigh(covariance)[1][:, -k:]
    distance = np.linalg.norm(result.point @ result.point.T - exact @ exact.T)
    assert distance <= subspace_error, (
        f"{distance:.3e} after {result.iterations} iterations: {result.stopping_criterion}"
    )
    assert result.cost == pytest.approx(-57, abs=max(1e-12 * 57, 20 * subspace_error**2))


def straightest_piece(x, y, window_length):
    """The run of `window_length + 1` points through which a line fits best, and that line.

    Stands in for pymanopt 2.2's own, which stores an array of one element as a number: NumPy 2.4 refuses that.
    """
    fits = []
    for first in range(len(x) - window_length):
        piece = np.arange(first, first + window_length + 1)
        line = np.polyfit(x[piece], y[piece], 1)
        fits.append((np.linalg.norm(np.polyval(line, x[piece]) - y[piece]), first, piece, line))
    return min(fits)[2:]


def test_pymanopt_diagnostics(adapter, rng, monkeypatch):
    monkeypatch.setattr(diagnostics, "identify_linear_piece", straightest_piece)
    problem = make_problem(adapter, rng)
    assert_slopes(diagnostics, problem)


def test_example_of_the_documentation():
    outcome = doctest.testmod(adapter_module)
    assert outcome.attempted > 0
    assert outcome.failed == 0


def test_a_point_alone_has_no_direction():
    M = StiefelManifold(1, 1, rng=0)
    assert np.array_equal(M.random_tangent_vector(M.random_point()), [[0.0]])


@pytest.mark.parametrize("sign", [1, -1])
def test_random_points_of_one_component(sign):
    manifold = StiefelManifold(4, 4, determinant=sign, rng=3)
    points = [manifold.random_point() for _ in range(40)]
    for S in points:
        assert np.abs(S.T @ S - np.eye(4)).max() < 1e-14
        assert np.sign(np.linalg.det(S)) == sign
    both = {np.sign(np.linalg.det(S)) for S in map(lambda _: StiefelManifold(4, 4, rng=_).random_point(), range(40))}
    assert both == {1.0, -1.0}


@pytest.mark.parametrize("solver", [ParticleSwarm, NelderMead])
def test_solvers_that_join_random_points_need_one_component(solver):
    def run(**component):
        manifold = StiefelManifold(3, 3, rng=1, **component)
        cost = pymanopt.function.numpy(manifold)(lambda Q: -np.trace(Q))
        options = {"population_size": 10} if solver is ParticleSwarm else {}
        return solver(max_iterations=20, verbosity=0, **options).run(pymanopt.Problem(manifold, cost))

    assert np.linalg.det(run(determinant=1).point) > 0.0
    with pytest.raises(OutsideDomainError, match="different components"):
        run()


def test_a_determinant_is_checked():
    with pytest.raises(InvalidInputError, match="determinant: must be 1, -1 or None, found 2"):
        StiefelManifold(3, 3, determinant=2)
    with pytest.raises(InvalidInputError, match=r"determinant: points of St\(3, 2\) have none, found 1"):
        StiefelManifold(3, 2, determinant=1)
    with pytest.raises(InvalidInputError, match=r"determinant: must be None for unitary matrices, .* found -1"):
        StiefelManifold(3, 3, determinant=-1, field="complex")


@pytest.fixture(params=[(3, 1), (4, 2), (5, 3), (12, 4)], ids=lambda shape: f"Gr{shape[0]}_{shape[1]}")
def subspaces(request):
    return GrassmannManifold(*request.param, rng=7)


def subspace_problem(manifold, rng):
    """tr(P A P B) of the projector P = Y Y^T: a cost of the subspace alone, without symmetries."""
    n = manifold.grassmann.n
    A, B = (X + X.T for X in rng.standard_normal((2, n, n)))
    numpy = pymanopt.function.numpy(manifold)

    def mixed(P):
        return 2 * (A @ P @ B + B @ P @ A)

    return pymanopt.Problem(
        manifold,
        numpy(lambda Y: float(np.sum((A @ Y @ Y.T) * (B @ Y @ Y.T).T))),
        euclidean_gradient=numpy(lambda Y: mixed(Y @ Y.T) @ Y),
        euclidean_hessian=numpy(lambda Y, V: mixed(Y @ Y.T) @ V + mixed(V @ Y.T + Y @ V.T) @ Y),
    )


def test_pymanopt_diagnostics_of_subspaces(subspaces, rng, monkeypatch):
    monkeypatch.setattr(diagnostics, "identify_linear_piece", straightest_piece)
    problem = subspace_problem(subspaces, rng)
    assert_slopes(diagnostics, problem)


def test_pymanopt_checks_gradient_and_hessian_of_subspaces(subspaces, rng, monkeypatch, capsys):
    plt = pytest.importorskip("matplotlib.pyplot")
    plt.switch_backend("agg")
    monkeypatch.setattr(diagnostics, "identify_linear_piece", straightest_piece)
    monkeypatch.setattr(plt, "show", lambda: plt.close("all"))
    problem = subspace_problem(subspaces, rng)
    assert_derivatives(diagnostics, problem, capsys)


def test_subspaces_as_points(subspaces):
    Y, other = subspaces.random_point(), subspaces.random_point()
    V = subspaces.random_tangent_vector(Y)
    assert subspaces.norm(Y, V) == pytest.approx(1, rel=1e-14)
    assert subspaces.inner_product(Y, V, V) == pytest.approx(1, rel=1e-14)
    assert subspaces.dist(Y, subspaces.exp(Y, V)) == pytest.approx(1, rel=1e-13)
    middle = subspaces.pair_mean(Y, other)
    assert subspaces.dist(Y, middle) == pytest.approx(subspaces.dist(Y, other) / 2, rel=1e-12)
    assert subspaces.dist(other, middle) == pytest.approx(subspaces.dist(Y, other) / 2, rel=1e-12)
    subspaces.grassmann.check_tangent(other, subspaces.transport(Y, other, V))
    assert subspaces.dim == subspaces.grassmann.dim
    assert subspaces.typical_dist == pytest.approx(np.sqrt(subspaces.grassmann.k))
    ours, theirs = subspaces, pymanopt.manifolds.Grassmann(subspaces.grassmann.n, subspaces.grassmann.k)
    assert ours.dist(Y, other) == pytest.approx(theirs.dist(Y, other), rel=1e-7)
    # Their bases at the end differ from ours.
    ends = [end @ end.T for end in (ours.exp(Y, V), theirs.exp(Y, V))]
    assert np.abs(ends[0] - ends[1]).max() <= 100 * EPS
    alone = GrassmannManifold(3, 3, rng=0)
    assert np.array_equal(alone.random_tangent_vector(alone.random_point()), np.zeros((3, 3)))


@pytest.mark.parametrize(
    ("optimizer", "subspace_error"),
    [
        (TrustRegions(verbosity=0, min_gradient_norm=1e-10), 1e-9),
        (ConjugateGradient(verbosity=0, min_gradient_norm=1e-6, max_iterations=2000), 1e-5),
        (SteepestDescent(verbosity=0, min_gradient_norm=1e-6, max_iterations=5000), 1e-5),
    ],
    ids=["trust_regions", "conjugate_gradient", "steepest_descent"],
)
def test_solvers_find_the_principal_subspace(covariance, optimizer, subspace_error):
    manifold = GrassmannManifold(20, 3, rng=2)
    with warnings.catch_warnings():
        # A warning of pymanopt 2.2 with NumPy 2, not of this package.
        warnings.simplefilter("ignore", DeprecationWarning)
        result = optimizer.run(pca_problem(manifold, covariance), initial_point=manifold.random_point())
    exact = np.linalg.eigh(covariance)[1][:, -3:]
    distance = manifold.dist(result.point, exact)
    assert distance <= subspace_error, f"{distance:.3e}: {result.stopping_criterion}"
