"""Curves of complex frames, compared with complex formulas, SciPy's splines of phases, and real curves."""

import copy
import itertools
import pickle

import numpy as np
import pytest
import scipy.interpolate
import scipy.linalg
from complex_frames import H, assert_close, embed, exp, norm, restrict, skew, split, tangents, unitary, walk

import stiefel_rs
from stiefel_rs import (
    Geodesic,
    GeometricCubic,
    GeometricPolynomial,
    Grassmann,
    InvalidInputError,
    QuasiGeodesic,
    RiemannianCubic,
    Stiefel,
    integrate_cubic,
    integrate_embedded,
    solve_boundary,
)

SHAPES = [(1, 1), (2, 1), (3, 1), (2, 2), (3, 2), (4, 2), (4, 4), (9, 2)]


@pytest.fixture(params=SHAPES, ids=str)
def ends(request):
    """Two points at distance 0.7, with velocities: (S0, V0, S1, V1)."""
    M, rng = Stiefel(*request.param, field="complex"), np.random.default_rng(7)
    S0 = M.random_point(rng)
    V, V0 = tangents(M, S0, rng, 2)
    S1 = exp(S0, V)
    return S0, V0, S1, tangents(M, S1, rng, 1)[0]


CURVES = {
    "quasi-geodesic": lambda S0, V0, S1, V1: QuasiGeodesic(S0, S1),
    "geodesic": lambda S0, V0, S1, V1: Geodesic(S0, S1),
    "Euclidean geodesic": lambda S0, V0, S1, V1: Geodesic(S0, S1, metric="euclidean"),
    "geometric cubic": GeometricCubic,
    "cubic of geodesics": lambda *ends: GeometricCubic(*ends, pieces="geodesic"),
    "polynomial": lambda S0, V0, S1, V1: GeometricPolynomial([S0, S1, S0]),
    "minimal cost": lambda *ends: GeometricPolynomial.minimal_cost(*ends, degree=4),
    "quintic": lambda S0, V0, S1, V1: GeometricPolynomial.quintic(S0, V0, V0, S1, V1, 0 * V1),
    "initial": lambda S0, V0, S1, V1: RiemannianCubic.from_initial(S0, V0, V0 / 2, -V0, 1.5),
    "boundary": RiemannianCubic.from_boundary,
    "in tension": lambda *ends: RiemannianCubic.from_boundary(*ends, tension=4.0),
}


# Found by minimising the cost to 1e-12: control points are accurate to 1e-8, third derivatives of quartics to 24 times
# that.
SEARCHED = {"minimal cost"}


@pytest.fixture(params=CURVES)
def make(request):
    return CURVES[request.param]


@pytest.fixture
def bound(make):
    return 1e-7 if make in [CURVES[name] for name in SEARCHED] else 1e-11


def test_shapes_and_attributes(make, ends):
    curve = make(*ends)
    n, k = ends[0].shape
    assert (curve.n, curve.k, curve.field) == (n, k, "complex")
    assert f"on St({n}, {k}, C)" in repr(curve)
    t = np.linspace(*curve.t_span, 6).reshape(2, 3)
    for quantity in [curve, curve.velocity, curve.acceleration, curve.jerk]:
        found = quantity(t)
        assert found.dtype == np.complex128
        assert found.shape == (2, 3, n, k)
        assert quantity(0.25).shape == (n, k)
        assert quantity([]).shape == (0, n, k)
        assert (quantity(t, num_threads=1) == quantity(t, num_threads=2)).all()
        assert_close(found[1, 2], quantity(t[1, 2]), 1e-13 * max(1, np.abs(found).max()), "alone")


def test_points_and_derivatives(make, ends):
    """Unitary columns; derivatives of all orders compared with differences."""
    curve = make(*ends)
    t = np.linspace(0.1, 0.9, 5)
    assert_close(H(curve(t)) @ curve(t), np.eye(curve.k), 1e-13, "S^H S = I")
    h = 1e-4
    for nu in range(3):
        slope = (curve(t + h, nu) - curve(t - h, nu)) / (2 * h)
        # The second next derivative times h^2 / 6, and round-off divided by h.
        assert_close(curve(t, nu + 1), slope, 3e-6 * max(1, np.abs(slope).max()), f"derivative of order {nu + 1}")
    assert (curve.velocity(t) == curve(t, 1)).all()


def test_covariant_derivatives(make, ends):
    """The acceleration is S'' plus the Christoffel term and tangent; D_t A is A' plus the Christoffel term of A."""
    curve = make(*ends)
    for t in (0.2, 0.7):
        S, V, A = curve(t), curve.velocity(t), curve.acceleration(t)

        def christoffel(V, W, S=S):
            (B, A), (D, C) = split(S, V), split(S, W)
            return S @ (H(B) @ D + H(D) @ B - A @ C - C @ A) / 2 - (B @ C + D @ A) / 2

        scale = 1 + np.abs(curve(t, 2)).max()
        assert_close(A, curve(t, 2) + christoffel(V, V), 1e-12 * scale, "covariant acceleration")
        h = 1e-5
        slope = (curve.acceleration(t + h) - curve.acceleration(t - h)) / (2 * h)
        assert_close(curve.jerk(t), slope + christoffel(V, A), 1e-7 * scale, "covariant jerk")


def test_cost_and_lengths(make, ends):
    """Integrals of the complex norms; costs of the real embedding are twice as large, lengths larger by sqrt 2."""
    curve = make(*ends)
    start, end = curve.t_span
    x, weights = np.polynomial.legendre.leggauss(24)
    t, weights = start + (end - start) * (x + 1) / 2, weights * (end - start) / 2
    S, V, A = curve(t), curve.velocity(t), curve.acceleration(t)
    tension = getattr(curve, "tension", 0.0)
    squares = np.array([norm(s, a) ** 2 + tension * norm(s, v) ** 2 for s, v, a in zip(S, V, A, strict=True)])
    cost = weights @ squares
    assert_close(curve.cost(), cost, 1e-9 * max(1, cost), "cost")
    # By the midpoint rule, since speeds have a kink at their zeros.
    count = 1000
    middles = start + (end - start) * (np.arange(count) + 0.5) / count
    speeds = np.array(list(map(norm, curve(middles), curve.velocity(middles))))
    assert_close(curve.arc_length(), speeds.mean() * (end - start), 1e-5, "length")
    bounds = curve.derivative_bounds()
    assert speeds.max() * (1 - 1e-12) <= bounds.velocity <= 1.05 * speeds.max() + 1e-12
    at = curve.resample(4)
    lengths = [curve.arc_length(a, b) for a, b in itertools.pairwise(at)]
    assert_close(lengths, curve.arc_length() / 3, 1e-10, "equal lengths")


def test_files_pickles_and_copies(make, ends, tmp_path):
    curve = make(*ends)
    curve.save(tmp_path / "curve.npz")
    t = np.linspace(*curve.t_span, 5)
    for again in [stiefel_rs.load(tmp_path / "curve.npz"), pickle.loads(pickle.dumps(curve)), copy.deepcopy(curve)]:
        assert type(again) is type(curve)
        assert again.field == "complex"
        assert (again(t) == curve(t)).all()
        assert again.cost() == curve.cost()
    assert str(curve._stored()["field"]) == "complex"
    assert "field" not in make(*(end.real for end in real_ends()))._stored()


def real_ends():
    M, rng = Stiefel(4, 2), np.random.default_rng(3)
    S0 = M.random_point(rng)
    V, V0 = (V * (0.6 / M.norm(S0, V)) for V in (M.random_tangent(S0, rng) for _ in range(2)))
    S1 = M.exp(S0, V)
    V1 = M.random_tangent(S1, rng)
    return S0, V0, S1, V1 * (0.6 / M.norm(S1, V1))


def test_real_data_given_as_complex(make, bound):
    """The same results as for real data, with zero imaginary parts; one complex array makes all results complex."""
    real = make(*real_ends())
    S0, V0, S1, V1 = real_ends()
    curve = make(S0 + 0j, V0, S1.astype(np.complex64).astype(complex) * 0 + S1, V1)
    t = np.linspace(*real.t_span, 7)
    for nu in range(4):
        scale = max(1, np.abs(real(t, nu)).max())
        assert_close(curve(t, nu), real(t, nu), bound * scale, f"derivative {nu}")
    assert_close(curve.cost(), real.cost(), 1e-11 * max(1, real.cost()), "cost")
    assert_close(curve.arc_length(), real.arc_length(), bound, "length")


def test_equivariance(make, ends, bound):
    """Unitary factors from the left and from the right, and complex conjugation."""
    n, k = ends[0].shape
    rng = np.random.default_rng(11)
    L, R = unitary(rng, n), unitary(rng, k)
    curve, t = make(*ends), np.linspace(0, 1, 5)
    moved, conjugate = make(*(L @ end @ R for end in ends)), make(*(end.conj() for end in ends))
    assert_close(moved(t), L @ curve(t) @ R, bound, "unitary factors")
    assert_close(conjugate(t), curve(t).conj(), bound, "conjugation")
    assert_close(moved.cost(), curve.cost(), 1e-11 * max(1, curve.cost()), "cost")


# ---------------------------------------------------------------- closed forms


def test_quasi_geodesic_and_geodesic(ends):
    S0, V0, S1, _ = ends
    t = 0.6
    K, A = split(S0, V0)
    X = K @ H(S0) - S0 @ H(K)
    quasi = QuasiGeodesic.from_velocity(S0, V0)
    assert_close(quasi(t), scipy.linalg.expm(t * X) @ S0 @ scipy.linalg.expm(t * A), 1e-13, "e^{tX} S e^{t Omega}")
    geodesic = Geodesic.from_velocity(S0, V0)
    assert_close(geodesic(t), exp(S0, t * V0), 1e-13, "geodesic")
    assert_close(geodesic.length, norm(S0, V0), 1e-13, "length")
    assert_close(Geodesic(S0, S1)(1.0), S1, 1e-12, "end")
    assert_close(QuasiGeodesic(S0, S1)(1.0), S1, 1e-13, "end")


def test_control_points(ends):
    curve = GeometricCubic(*ends)
    P = curve.control_points
    assert P.dtype == np.complex128
    assert P.shape == (4, *ends[0].shape)
    again = GeometricCubic.from_control_points(P)
    assert_close(again(0.4), curve(0.4), 1e-13, "the same curve")
    assert_close(3 * Stiefel(*P.shape[1:], field="complex").inverse_retract(P[0], P[1]), ends[1], 1e-12, "V0 / 3")


def test_phases():
    """U(1): exp(i phi) with polynomials phi; |V|^2 = phi'^2 / 2."""

    def point(angle):
        return np.array([[np.exp(1j * angle)]])

    def vector(angle, speed):
        return 1j * speed * point(angle)

    phi = scipy.interpolate.CubicHermiteSpline([0, 1], [0.2, 1.1], [0.7, -0.4])
    curve = RiemannianCubic.from_boundary(point(0.2), vector(0.2, 0.7), point(1.1), vector(1.1, -0.4))
    t = np.linspace(0, 1, 11)
    assert_close(curve(t)[:, 0, 0], np.exp(1j * phi(t)), 1e-13, "cubic")
    exact = np.polynomial.legendre.leggauss(4)
    cost = np.sum(exact[1] / 2 * phi((exact[0] + 1) / 2, 2) ** 2) / 2
    assert_close(curve.cost(), cost, 1e-12 * cost, "cost")
    _, V, A, J = curve.initial
    angles = [1j * phi(0, nu) * point(0.2) for nu in (1, 2, 3)]
    assert_close(np.stack([V, A, J]), np.stack(angles), 1e-12, "initial data")
    assert_close(curve.energy, (phi(0, 2) ** 2 / 2 - phi(0, 3) * phi(0, 1)) / 2, 1e-12, "energy")
    flat = GeometricCubic(point(0.2), vector(0.2, 0.7), point(1.1), vector(1.1, -0.4))
    assert_close(flat(t), curve(t), 1e-13, "de Casteljau")


def test_initial_data_and_invariants(ends):
    """The equation of cubics on the unitary group, energy, momentum; on St(n, k), compared with the real embedding."""
    S0, V0, _, _ = ends
    rng, M = np.random.default_rng(5), Stiefel(*ends[0].shape, field="complex")
    A, J = tangents(M, S0, rng, 2)
    curve = RiemannianCubic.from_initial(S0, V0, A, J)
    for found, given in zip(curve.initial, (S0, V0, A, J), strict=True):
        assert_close(found, given, 1e-14, "initial data")
    real = RiemannianCubic.from_initial(*(embed(x) for x in (S0, V0, A, J)))
    t = np.linspace(0, 1, 5)
    assert_close(curve(t), restrict(real(t)), 1e-14, "points")
    assert_close(curve.energy, real.energy / 2, 1e-14, "energy")
    assert_close(curve.momentum, restrict(real.momentum), 1e-14, "momentum")
    assert_close(curve.momentum, skew(curve.momentum), 1e-14, "skew-Hermitian")
    assert_close(curve.reversed().initial[0], curve(1.0), 1e-13, "reversed")
    part = curve.restricted(0.2, 0.6)
    assert part.field == "complex"
    assert_close(part(0.5), curve(0.5), 1e-13, "part")
    assert_close(curve.reparametrised(0.0, 2.0)(1.0), curve(0.5), 1e-13, "other times")
    if M.n == M.k:
        # The body velocity x = S^H S' of U(n): x''' = [x'', x].
        h = 1e-3
        x = [H(curve(u)) @ curve.velocity(u) for u in 0.5 + h * np.arange(-2, 3)]
        second = (x[1] - 2 * x[2] + x[3]) / h**2
        third = (x[4] - 2 * x[3] + 2 * x[1] - x[0]) / (2 * h**3)
        assert_close(third, second @ x[2] - x[2] @ second, 1e-4, "x''' = [x'', x]")


def test_boundary_problems(ends):
    S0, V0, S1, V1 = ends
    curve = RiemannianCubic.from_boundary(*ends)
    assert curve.report.converged
    assert_close(curve(1.0), S1, 1e-12, "end point")
    assert_close(curve.velocity(1.0), V1, 1e-12, "end velocity")
    _, _, A, J = curve.initial
    again = RiemannianCubic.from_boundary(*ends, guess=(A, J))
    assert_close(again(0.5), curve(0.5), 1e-11, "from a guess")
    batch = solve_boundary(np.stack([S0, S0]), V0, S1, V1)
    assert batch.acceleration.dtype == np.complex128
    assert batch.converged.all()
    assert_close(batch.acceleration[1], A, 1e-10, "acceleration of a batch")
    assert_close(batch.jerk[1], J, 1e-10, "jerk of a batch")
    assert_close(batch.cost, curve.cost(), 1e-9, "cost of a batch")


def test_all_solutions():
    """The solutions on the sphere with a phase: each is complex and has the given ends; the cheapest comes first."""
    S0, V0, S1, V1 = (x + 0j for x in np.eye(2)[[0, 1, 1, 0], :, None])
    found = RiemannianCubic.from_boundary(S0, V0, S1, -V1, all_found=True)
    assert found
    costs = [curve.cost() for curve in found]
    assert costs == sorted(costs)
    for curve in found:
        assert curve.field == "complex"
        assert_close(curve(1.0), S1, 1e-11, "end point")
        assert_close(curve.velocity(1.0), -V1, 1e-11, "end velocity")


def hermite_cost(change, first, last, weight):
    """`weight` times the integral of phi''^2 of the cubic polynomial phi from 0 with given end and end slopes."""
    a, b = 6 * change - 4 * first - 2 * last, 6 * first + 6 * last - 12 * change
    return weight * (a**2 + a * b + b**2 / 3)


def assert_solutions(found, S1, V1, at_least):
    """Different curves with the given ends, the cheapest first."""
    assert len(found) >= at_least
    middles = [np.concatenate([curve(0.5), curve.velocity(0.5)]) for curve in found]
    for one, other in itertools.combinations(middles, 2):
        assert abs(one - other).max() > 1e-2
    costs = [curve.cost() for curve in found]
    assert costs == sorted(costs)
    for curve in found:
        assert curve.field == "complex"
        # A subspace ends in a basis of its own.
        Q = H(S1) @ curve(1.0) if isinstance(curve.manifold, Grassmann) else np.eye(curve.k)
        # Measured at most 7e-13.
        assert_close(curve(1.0), S1 @ Q, 1e-11, "end point")
        assert_close(curve.velocity(1.0), V1 @ Q, 1e-11, "end velocity")


def test_all_solutions_on_the_circle():
    """U(1): one cubic polynomial of phases for each number of turns."""
    S0, S1 = np.ones((1, 1), complex), np.exp(2.5j) * np.ones((1, 1))
    found = RiemannianCubic.from_boundary(S0, 0.7j * S0, S1, -0.4j * S1, all_found=True)
    assert_solutions(found, S1, -0.4j * S1, 3)
    costs = sorted(hermite_cost(2.5 + 2 * np.pi * turns, 0.7, -0.4, 0.5) for turns in range(-4, 5))
    assert_close([curve.cost() / cost for curve, cost in zip(found[:3], costs, strict=False)], 1.0, 3e-12, "costs")


def test_all_solutions_of_diagonal_gates():
    """U(2): diagonal matrices with any numbers of turns are solutions; those of least cost are found."""
    phases, first, last = np.array([1.1, 2.5]), np.array([0.7, -0.3]), np.array([-0.4, 0.5])
    S0, S1 = np.eye(2, dtype=complex), np.diag(np.exp(1j * phases))
    V1 = S1 @ np.diag(1j * last)
    Q = unitary(np.random.default_rng(2), 2)
    # Another basis of C^2 at the start, so that no entry vanishes.
    data = (Q @ x for x in (S0, np.diag(1j * first), S1, V1))
    found = RiemannianCubic.from_boundary(*data, all_found=True)
    assert_solutions(found, Q @ S1, Q @ V1, 3)
    known = sorted(
        sum(hermite_cost(phases[i] + 2 * np.pi * turns[i], first[i], last[i], 0.5) for i in (0, 1))
        for turns in itertools.product(range(-3, 4), repeat=2)
    )
    assert_close([curve.cost() / cost for curve, cost in zip(found[:3], known, strict=False)], 1.0, 3e-12, "costs")


def test_all_solutions_on_a_line_of_states():
    """CP^1: real states cos(phi) e1 + sin(phi) e2 have period pi, and all velocities are along the line."""
    M = Grassmann(2, 1, field="complex")
    S0, S1 = (np.array([[np.cos(phi)], [np.sin(phi) + 0j]]) for phi in (0.0, 0.9))
    V0, V1 = (speed * np.array([[-S[1, 0]], [S[0, 0]]]) for speed, S in ((0.7, S0), (-0.4, S1)))
    found = RiemannianCubic.from_boundary(S0, V0, S1 * np.exp(0.3j), V1 * np.exp(0.3j), all_found=True, manifold=M)
    assert_solutions(found, S1, V1, 2)
    known = sorted(hermite_cost(0.9 + np.pi * turns, 0.7, -0.4, 1.0) for turns in range(-4, 5))
    assert_close([curve.cost() / cost for curve, cost in zip(found[:2], known, strict=False)], 1.0, 3e-12, "costs")


@pytest.mark.parametrize("integrate", [integrate_cubic, integrate_embedded])
def test_trajectories(integrate, ends):
    S0, V0, _, _ = ends
    A, J = tangents(Stiefel(*S0.shape, field="complex"), S0, np.random.default_rng(5), 2)
    found = integrate(S0, V0, A, J, 40)
    exact = RiemannianCubic.from_initial(S0, V0, A, J)
    # Order 6, and order 2.
    bound = 1e-8 if integrate is integrate_cubic else 3e-3
    assert found.point.dtype == np.complex128
    assert_close(found.point, exact(found.t), bound, "points")
    assert_close(found.velocity, exact.velocity(found.t), 10 * bound, "velocities")
    assert_close(found.energy, exact.energy, 10 * bound, "energy")
    assert found.momentum_drift < 1e-12
    assert not found.point.flags.writeable
    again = pickle.loads(pickle.dumps(found))
    assert (again.jerk == found.jerk).all()
    assert again.energy.dtype == np.float64


# ---------------------------------------------------------------- derivatives by data


def pairing(gradients, changes):
    """Re sum(conj(G) * X), of all matrices."""
    return sum(np.sum(np.conj(G) * X).real for G, X in zip(gradients, changes, strict=True))


def test_derivatives_by_boundary_data(ends):
    """Along a one-parameter group of unitary matrices; pull-backs are transposes for Re tr(W^H dS)."""
    curve, rng = RiemannianCubic.from_boundary(*ends), np.random.default_rng(13)
    n, k = ends[0].shape
    X, h, t = skew(unitary(rng, n)), 1e-5, np.array([0.3, 0.8])
    S0, V0, S1, V1 = ends
    one = scipy.linalg.expm(h * X)
    # The first point rotates, the other end is fixed.
    change = (X @ S0, X @ V0, 0 * S1, 0 * V1)
    ahead, behind = (RiemannianCubic.from_boundary(Q @ S0, Q @ V0, S1, V1) for Q in (one, H(one)))
    found = curve.point_variation(t, *change)
    assert found.dtype == np.complex128
    assert_close(found, (ahead(t) - behind(t)) / (2 * h), 1e-7, "points")
    slopes = [(a - b) / (2 * h) for a, b in zip(ahead.initial, behind.initial, strict=True)]
    for part, slope in zip(curve.initial_variation(*change), slopes, strict=True):
        assert_close(part, slope, 1e-6, "initial data")
    W = rng.standard_normal((2, n, k)) + 1j * rng.standard_normal((2, n, k))
    gradient = curve.point_pullback(t, W)
    assert_close(pairing(gradient, change), pairing([W], [found]), 1e-11, "pull-back")
    slope = (ahead.cost() - behind.cost()) / (2 * h)
    assert_close(pairing(curve.cost_gradient(), change), slope, 1e-6, "cost")


def test_derivatives_by_initial_data(ends):
    S0, V0, _, _ = ends
    rng, M, t = np.random.default_rng(17), Stiefel(*ends[0].shape, field="complex"), np.array([0.4, 1.0])
    A, J = tangents(M, S0, rng, 2)
    curve, X = RiemannianCubic.from_initial(S0, V0, A, J), skew(unitary(rng, M.n))
    change = tuple(X @ part for part in (S0, V0, A, J))
    found = curve.initial_point_variation(t, *change)
    assert_close(found, X @ curve(t), 1e-12, "all data turn")
    W = rng.standard_normal(found.shape) + 1j * rng.standard_normal(found.shape)
    gradient = curve.initial_point_pullback(t, W)
    assert_close(pairing(gradient, change), pairing([W], [found]), 1e-12, "pull-back")


# ---------------------------------------------------------------- size


def test_many_points_of_a_tall_curve():
    """More numbers than are sampled in one piece."""
    _, S, _ = walk(200, 3, 2)
    curve = Geodesic(S[0], S[1])
    t = np.linspace(0, 1, 4001)
    points = curve(t)
    assert points.shape == (4001, 200, 3)
    for i in (0, 1747, 1748, 4000):
        assert_close(points[i], curve(t[i]), 1e-15, f"point {i}")
    with pytest.raises(InvalidInputError, match="t: entry 1 is not finite"):
        curve([0.0, np.nan])
