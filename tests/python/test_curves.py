"""Curves compared with formulas in NumPy and SciPy, with differences, and with each other."""

import itertools
from math import comb

import numpy as np
import pytest
import scipy.linalg

from stiefel_rs import Curve, GeometricCubic, InvalidInputError, QuasiGeodesic, Stiefel

EPS = np.finfo(float).eps
EXPM = scipy.linalg.expm


def assert_close(measured, exact, bound, what):
    error = np.max(np.abs(np.asarray(measured) - exact), initial=0.0)
    assert error <= bound, f"{what}: error {error:.3e} exceeds {bound:.3e}"


def pair(S, V):
    return V @ S.T - S @ V.T + 2 * S @ V.T @ S @ S.T, S.T @ V


def quasi_geodesic_derivative(S, V, t, nu):
    """The nu-th derivative of e^{tX} S e^{t Omega}, with n x n matrices."""
    X, Omega = pair(S, V)
    power = np.linalg.matrix_power
    middle = sum(comb(nu, j) * power(X, j) @ S @ power(Omega, nu - j) for j in range(nu + 1))
    return EXPM(t * X) @ middle @ EXPM(t * Omega)


def join(S0, S1):
    """The velocity of the quasi-geodesic from S0 to S1, all angles below pi/2, by a singular value decomposition."""
    U, _, Zt = np.linalg.svd(S0.T @ S1)
    normal = (S1 - S0 @ (S0.T @ S1)) @ Zt.T
    s, c = np.linalg.norm(normal, axis=0), np.sum((S0 @ U) * (S1 @ Zt.T), axis=0)
    theta = np.arctan2(s, c)
    # s_i q_i theta_i / s_i: the limit at s = 0 is q_i s_i itself.
    K = normal * np.where(s > 1e-8, theta / np.where(s > 1e-8, s, 1.0), 1.0) @ U.T
    return K + S0 @ scipy.linalg.logm(U @ Zt).real


def de_casteljau(P, t):
    P = list(P)
    while len(P) > 1:
        P = [quasi_geodesic_derivative(a, join(a, b), t, 0) for a, b in itertools.pairwise(P)]
    return P[0]


@pytest.mark.parametrize("shape", [(3, 2), (4, 3), (5, 4), (4, 2), (5, 2)])
def test_quasi_geodesics_from_the_first_columns_of_the_identity(shape):
    # For n = k + 1 the normal part of a velocity is a single row, whose entries, as columns, are exactly dependent.
    manifold, rng = Stiefel(*shape), np.random.default_rng(7)
    S = np.eye(shape[0])[:, : shape[1]]
    for _ in range(200):
        V = manifold.project_tangent(S, rng.standard_normal(shape))
        exact = quasi_geodesic_derivative(S, V, 1.0, 0)
        assert_close(QuasiGeodesic.from_velocity(S, V)(1.0), exact, 1e-13, f"{V}")
        assert_close(manifold.retract(S, V), exact, 1e-13, f"{V}")


def christoffel(S, V, W):
    P = np.eye(len(S)) - S @ S.T
    return (V @ W.T + W @ V.T) @ S / 2 + S @ (V.T @ P @ W + W.T @ P @ V) / 2


def covariant(c0, c1, c2, c3):
    """Covariant acceleration and jerk from ambient derivatives, by the product rule for the Christoffel term."""
    S, v = c0, c1
    a = c2 + christoffel(S, v, v)
    P = np.eye(len(S)) - S @ S.T
    dP = -(v @ S.T + S @ v.T)
    da = c3 + (c2 @ v.T + v @ c2.T) @ S + v @ v.T @ v
    da += v @ (v.T @ P @ v) + S @ (c2.T @ P @ v + v.T @ dP @ v + v.T @ P @ c2)
    return a, da + christoffel(S, v, a)


def difference(f, t, h=2e-3):
    """Central difference of sixth order by two Richardson extrapolations."""
    d = [(f(t + s) - f(t - s)) / (2 * s) for s in (h, 2 * h, 4 * h)]
    once = [(4 * d[0] - d[1]) / 3, (4 * d[1] - d[2]) / 3]
    return (16 * once[0] - once[1]) / 15


@pytest.fixture(params=["joining", "from_velocity", "boundary", "control_points"])
def curve(request, manifold, boundary):
    S0, V0, S1, V1 = boundary
    if request.param == "joining":
        return QuasiGeodesic(S0, S1)
    if request.param == "from_velocity":
        return QuasiGeodesic.from_velocity(S0, V0)
    if request.param == "boundary":
        return GeometricCubic(S0, V0, S1, V1)
    P = [S0, manifold.retract(S0, V0), manifold.retract(S1, V1), S1]
    return GeometricCubic.from_control_points(P)


@pytest.mark.parametrize("t", [-0.5, 0.0, 0.3, 1.0, 2.0])
@pytest.mark.parametrize("nu", [0, 1, 2, 3])
def test_quasi_geodesic_from_velocity(manifold, boundary, t, nu):
    S, V = boundary[:2]
    exact = quasi_geodesic_derivative(S, V, t, nu)
    assert_close(QuasiGeodesic.from_velocity(S, V)(t, nu), exact, 64 * manifold.n * EPS, f"derivative {nu} at {t}")


@pytest.mark.parametrize("t", [0.0, 1e-9, 0.4, 1.0])
def test_quasi_geodesic_between_points(manifold, boundary, t):
    S0, _, S1, _ = boundary
    curve = QuasiGeodesic(S0, S1)
    V = join(S0, S1)
    bound = 128 * manifold.n * EPS
    assert_close(curve.velocity(0.0), V, bound, "initial velocity")
    assert_close(curve(t), quasi_geodesic_derivative(S0, V, t, 0), bound, f"point at {t}")


def test_quasi_geodesic_ends(manifold, boundary):
    S0, _, S1, _ = boundary
    curve = QuasiGeodesic(S0, S1)
    assert_close(curve(0.0), S0, 32 * manifold.n * EPS, "start")
    assert_close(curve(1.0), S1, 32 * manifold.n * EPS, "end")
    assert_close(curve.velocity(0.0), manifold.inverse_retract(S0, S1), 32 * manifold.n * EPS, "inverse retraction")


def test_great_circle_is_a_geodesic_of_the_sphere(rng):
    M = Stiefel(3, 1)
    S0, S1 = M.random_point(rng, size=2)
    curve = QuasiGeodesic(S0, S1)
    t = np.linspace(0, 1, 11)
    angle = np.arccos(np.sum(S0 * S1))
    exact = (np.sin((1 - t) * angle)[:, None, None] * S0 + np.sin(t * angle)[:, None, None] * S1) / np.sin(angle)
    assert_close(curve(t), exact, 64 * EPS / np.sin(angle), "slerp")
    assert_close(curve.acceleration(t), 0.0, 64 * EPS * angle**2, "acceleration of a geodesic")
    assert curve.cost() <= (1e-13) ** 2, f"cost of a geodesic {curve.cost():.3e}"


def test_geometric_cubic_is_de_casteljau(manifold, boundary):
    S0, V0, S1, V1 = boundary
    inner = [quasi_geodesic_derivative(S0, V0 / 3, 1.0, 0), quasi_geodesic_derivative(S1, -V1 / 3, 1.0, 0)]
    P = [S0, inner[0], inner[1], S1]
    curve = GeometricCubic(S0, V0, S1, V1)
    assert_close(curve.control_points, P, 64 * manifold.n * EPS, "control points")
    same = GeometricCubic.from_control_points(curve.control_points)
    for t in [0.0, 0.25, 0.5, 0.9, 1.0]:
        # Six joins, each with a logarithm by SciPy (a few hundred eps at these sizes).
        assert_close(curve(t), de_casteljau(P, t), 2000 * manifold.n * EPS, f"de Casteljau at {t}")
        assert_close(same(t), curve(t), 100 * manifold.n * EPS, f"from its own control points at {t}")


def test_geometric_cubic_meets_its_data(manifold, boundary):
    S0, V0, S1, V1 = boundary
    curve = GeometricCubic(S0, V0, S1, V1)
    for name, measured, exact in [
        ("S0", curve(0.0), S0),
        ("V0", curve.velocity(0.0), V0),
        ("S1", curve(1.0), S1),
        ("V1", curve.velocity(1.0), V1),
    ]:
        assert_close(measured, exact, 200 * manifold.n * EPS, name)


def test_geometric_cubic_run_backwards(manifold, boundary):
    S0, V0, S1, V1 = boundary
    curve, back = GeometricCubic(S0, V0, S1, V1), GeometricCubic(S1, -V1, S0, -V0)
    t = np.linspace(0, 1, 7)
    assert_close(back(1 - t), curve(t), 300 * manifold.n * EPS, "time reversal")


@pytest.mark.parametrize("nu", [1, 2, 3])
def test_derivatives_are_derivatives(curve, nu):
    for t in [0.2, 0.5, 0.8]:
        exact = curve(t, nu)
        # Round-off of about 4 eps/h = 5e-13 of the order below; truncation h^6 is smaller.
        bound = 4e-12 * (1.0 + np.abs(curve(t, nu - 1)).max())
        assert_close(difference(lambda s: curve(s, nu - 1), t), exact, bound, f"derivative {nu} at {t}")


def test_covariant_derivatives(curve):
    for t in [0.0, 0.35, 1.0]:
        ambient = [curve(t, nu) for nu in range(4)]
        a, j = covariant(*ambient)
        size = 1.0 + max(np.abs(c).max() for c in ambient) ** 3
        bound = 100 * curve.n * EPS * size
        assert_close(curve.velocity(t), ambient[1], 0.0, "velocity is nu=1")
        assert_close(curve.acceleration(t), a, bound, f"covariant acceleration at {t}")
        assert_close(curve.jerk(t), j, bound, f"covariant jerk at {t}")


def test_points_and_covariant_derivatives_stay_where_they_belong(curve):
    M = Stiefel(curve.n, curve.k)
    t = np.linspace(0, 1, 9)
    S = curve(t)
    M.check_point(S, atol=100 * curve.n * EPS)
    for name in ["velocity", "acceleration", "jerk"]:
        V = getattr(curve, name)(t)
        defect = np.linalg.norm(np.swapaxes(S, -1, -2) @ V + np.swapaxes(V, -1, -2) @ S)
        bound = 1000 * curve.n * EPS * (1 + np.abs(V).max())
        assert defect <= bound, f"{name} not tangent: {defect:.3e} exceeds {bound:.3e}"


def test_cost_is_the_integral_of_the_squared_acceleration(curve):
    M = Stiefel(curve.n, curve.k)
    x, w = np.polynomial.legendre.leggauss(48)
    t = (x + 1) / 2
    exact = np.sum(w / 2 * M.norm(curve(t), curve.acceleration(t)) ** 2)
    # Relative errors of both; a geodesic has the cost (round-off)^2.
    assert_close(curve.cost(), exact, 1e-10 * exact + 1e-25, "cost against 48-point Gauss-Legendre")


def test_protocol(curve, manifold):
    assert isinstance(curve, Curve)
    assert (curve.n, curve.k) == (manifold.n, manifold.k)
    assert curve.t_span == (0.0, 1.0)
    assert repr(curve).startswith(f"<{type(curve).__name__} on St({curve.n}, {curve.k}), ")
    assert repr(curve).endswith("t_span (0.0, 1.0)>")
    if isinstance(curve, GeometricCubic):
        assert curve.control_points.shape == (4, curve.n, curve.k)


@pytest.mark.parametrize("method", ["__call__", "velocity", "acceleration", "jerk"])
def test_call_shapes(curve, method):
    f = getattr(curve, method)
    core = (curve.n, curve.k)
    single = f(0.25)
    assert single.shape == core
    assert single.dtype == np.float64
    for t in [np.array(0.25), np.float32(0.25), np.float64(0.25)]:
        assert np.array_equal(f(t), single), f"{t!r} differs from a float"
    assert f(1).shape == core
    grid = np.linspace(0, 1, 6).reshape(2, 3)
    values = f(grid)
    assert values.shape == (2, 3, *core)
    assert values.flags.writeable
    for i in np.ndindex(2, 3):
        # Blocks of parameters share one GEMM whose rounding may differ from a single product's.
        assert_close(values[i], f(grid[i]), 64 * curve.n * EPS * (1 + np.abs(values[i]).max()), f"member {i}")
    assert f([0.0, 1.0]).shape == (2, *core)
    assert f([]).shape == (0, *core)
    assert f(np.zeros((3, 0))).shape == (3, 0, *core)


def test_a_long_call_equals_its_pieces(manifold, boundary):
    curve = GeometricCubic(*boundary)
    t = np.linspace(0, 1, 1000)
    pieces = np.concatenate([curve(t[:321]), curve(t[321:])])
    assert_close(curve(t), pieces, 64 * manifold.n * EPS, "one call against two")


@pytest.mark.parametrize("nu", [-1, 4, 100])
def test_order_out_of_range(curve, nu):
    with pytest.raises(InvalidInputError, match=str(nu)):
        curve(0.5, nu)
    with pytest.raises(TypeError):
        curve(0.5, 1.5)


def test_parameters_must_be_finite(curve):
    for bad in [np.nan, np.inf, -np.inf]:
        with pytest.raises(InvalidInputError, match="t: "):
            curve([0.0, bad])


def test_constant_curve(manifold, rng):
    S = manifold.random_point(rng)
    zero = np.zeros_like(S)
    for curve in [QuasiGeodesic(S, S), QuasiGeodesic.from_velocity(S, zero), GeometricCubic(S, zero, S, zero)]:
        assert_close(curve([0.0, 0.5, 1.0]), S, 32 * manifold.n * EPS, f"{curve!r}")
        for nu in [1, 2, 3]:
            assert_close(curve(0.5, nu), 0.0, 200 * manifold.n * EPS, f"derivative {nu} of {curve!r}")
        assert curve.cost() <= 1e-25, f"cost {curve.cost():.3e}"


def test_equivariance(manifold, boundary, rng):
    g = np.linalg.qr(rng.standard_normal((manifold.n, manifold.n)))[0]
    curve, moved = GeometricCubic(*boundary), GeometricCubic(*(g @ x for x in boundary))
    t = np.linspace(0, 1, 5)
    for nu in range(4):
        assert_close(moved(t, nu), g @ curve(t, nu), 2000 * manifold.n * EPS, f"g curve, derivative {nu}")
