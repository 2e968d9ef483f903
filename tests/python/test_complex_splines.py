"""Curves through many complex frames: splines, Hermite and smoothing curves, estimates of velocities."""

import pickle

import numpy as np
import pytest
import scipy.interpolate
from complex_frames import H, assert_close, exp, norm, skew, tangents, unitary, walk

import stiefel_rs
from stiefel_rs import (
    CubicHermite,
    CubicSpline,
    QuasiGeodesic,
    RiemannianCubic,
    SmoothingSpline,
    Stiefel,
    estimate_velocities,
)

SHAPES = [(1, 1), (2, 1), (3, 1), (2, 2), (3, 2), (4, 2), (4, 4), (18, 2)]


@pytest.fixture(params=SHAPES, ids=str)
def data(request):
    return walk(*request.param, 5)


def closed(t, S):
    return np.append(t, t[-1] + 1), np.concatenate([S, S[:1]])


CURVES = {
    "hermite": CubicHermite,
    "geometric hermite": lambda t, S, V: CubicHermite(t, S, V, "geometric", extrapolate=True),
    "estimated": lambda t, S, V: CubicHermite(t, S, "akima"),
    "natural": lambda t, S, V: CubicSpline(t, S),
    "clamped": lambda t, S, V: CubicSpline(t, S, "clamped"),
    "periodic": lambda t, S, V: CubicSpline(*closed(t, S), "periodic"),
    "mixed": lambda t, S, V: CubicSpline(t, S, ((2, V[0]), "clamped")),
    "velocities": lambda t, S, V: CubicSpline(t, S, ((1, V[0]), (1, V[-1]))),
    "geometric": lambda t, S, V: CubicSpline(t, S, kind="geometric"),
    "in tension": lambda t, S, V: CubicSpline(t, S, tension=3.0),
    "smoothing": lambda t, S, V: SmoothingSpline(t, S, lam=0.1),
}


@pytest.fixture(params=CURVES)
def make(request):
    return CURVES[request.param]


def test_curves_through_points(make, data):
    t, S, V = data
    curve = make(t, S, V)
    n, k = S.shape[1:]
    assert (curve.n, curve.k, curve.field) == (n, k, "complex")
    assert f"on St({n}, {k}, C), " in repr(curve)
    assert curve.points.dtype == np.complex128
    assert not curve.points.flags.writeable
    if not isinstance(curve, SmoothingSpline):
        assert (curve.points[: len(S)] == S).all()
    assert_close(curve(curve.t), curve.points, 1e-11, "points at the knots")
    inside = curve.t[1:-1]
    for quantity in (curve, curve.velocity):
        assert_close(quantity(inside - 1e-7), quantity(inside + 1e-7), 1e-5, "continuous")
    piece = curve.pieces[1]
    assert piece.field == "complex"
    width = curve.t[2] - curve.t[1]
    assert_close(piece(0.3), curve(curve.t[1] + 0.3 * width), 1e-12, "piece")
    again = pickle.loads(pickle.dumps(curve))
    at = np.linspace(*curve.t_span, 9)
    assert (again(at) == curve(at)).all()
    assert (again.points == curve.points).all()


def test_files_keep_what_a_spline_was_made_of(data, tmp_path):
    t, S, V = data
    mixed, hermite = CubicSpline(t, S, ((2, V[0]), "clamped")), CubicHermite(t, S, V)
    for curve in (mixed, hermite):
        curve.save(tmp_path / "curve.npz")
        again = stiefel_rs.load(tmp_path / "curve.npz")
        assert again.field == "complex"
        if curve is hermite:
            assert (again.velocities == V).all()
            assert again.velocities.dtype == np.complex128
        else:
            (order, vector), word = again.bc_type
            assert (order, word) == (2, "clamped")
            assert (vector == V[0]).all()


def test_end_conditions(data):
    t, S, V = data
    curve = CubicSpline(t, S, ((1, V[0]), (2, V[-1])))
    assert_close(curve.velocity(t[0]), V[0], 1e-11, "velocity of the first end")
    assert_close(curve.acceleration(t[-1]), V[-1], 1e-9, "acceleration of the last end")
    natural = CubicSpline(t, S)
    assert_close(natural.acceleration(t[[0, -1]]), 0, 1e-9, "natural ends")
    jump = natural.acceleration(t[1:-1] - 1e-9) - natural.acceleration(t[1:-1] + 1e-9)
    assert_close(jump, 0, 1e-6, "acceleration")


def test_complex_vectors_at_the_ends_of_real_points():
    """A complex end condition makes all results complex, and real vectors may be given with complex points."""
    M, rng = Stiefel(3, 1), np.random.default_rng(4)
    S = np.stack([M.random_point(rng)] * 3)
    S[1:] = [M.exp(S[0], 0.2 * i * M.random_tangent(S[0], rng)) for i in (1, 2)]
    V = 0.3j * S[0]
    curve = CubicSpline([0.0, 1.0, 2.0], S, ((1, V), "natural"))
    assert curve.field == "complex"
    assert_close(curve.velocity(0.0), V, 1e-12, "velocity")
    mixed = CubicSpline([0.0, 1.0, 2.0], S + 0j, ((1, 0 * S[0]), "natural"))
    assert_close(mixed(0.5), CubicSpline([0.0, 1.0, 2.0], S, ((1, 0 * S[0]), "natural"))(0.5), 1e-12, "real data")


def test_phases():
    """U(1): splines of phases are SciPy's; the misfit is that of phi / sqrt 2, so lam is the same."""
    t = np.array([0.0, 0.7, 1.5, 3.0, 3.6])
    phi = np.array([0.2, 0.9, 0.4, -0.8, -0.5])
    S, at = np.exp(1j * phi)[:, None, None], np.linspace(0, 3.6, 37)
    for ends in ("natural", "clamped"):
        flat = scipy.interpolate.CubicSpline(t, phi, bc_type=ends)
        curve = CubicSpline(t, S, ends)
        assert_close(curve(at)[:, 0, 0], np.exp(1j * flat(at)), 1e-12, ends)
        assert_close(curve.acceleration(at)[:, 0, 0], 1j * flat(at, 2) * np.exp(1j * flat(at)), 1e-10, ends)
    given = scipy.interpolate.CubicSpline(t, phi, bc_type=((1, 0.3), (2, -0.4)))
    ends = ((1, 0.3j * S[0]), (2, -0.4j * S[-1]))
    assert_close(CubicSpline(t, S, ends)(at)[:, 0, 0], np.exp(1j * given(at)), 1e-12, "given ends")
    flat = scipy.interpolate.make_smoothing_spline(t, phi, lam=0.05)
    curve = SmoothingSpline(t, S, lam=0.05)
    assert_close(curve(at)[:, 0, 0], np.exp(1j * flat(at)), 1e-9, "smoothing")
    assert_close(curve.misfit, np.sum((flat(t) - phi) ** 2) / 2, 1e-9, "misfit")
    akima = scipy.interpolate.Akima1DInterpolator(t, phi, method="makima")
    found = estimate_velocities(t, S, "akima")
    assert found.dtype == np.complex128
    assert_close(found[2:3, 0, 0], 1j * akima(t[2:3], nu=1) * S[2:3, 0, 0], 1e-12, "akima")


@pytest.mark.parametrize("method", ["catmull-rom", "akima", "natural"])
def test_velocities(method, data):
    """Tangent, equivariant, and equal to those of the curve built from the method's name."""
    t, S, _ = data
    V = estimate_velocities(t, S, method)
    assert_close(H(S) @ V + H(V) @ S, 0, 1e-12, "tangent")
    rng = np.random.default_rng(3)
    L, R = unitary(rng, S.shape[1]), unitary(rng, S.shape[2])
    assert_close(estimate_velocities(t, L @ S @ R, method), L @ V @ R, 1e-11, "unitary factors")
    assert (CubicHermite(t, S, method).velocities == V).all()
    closed_t, closed_S = closed(t, S)
    found = estimate_velocities(closed_t, closed_S, method, closed=True)
    assert_close(found[0], found[-1], 1e-13, "closed")


def test_equivariance(make, data):
    t, S, V = data
    rng = np.random.default_rng(11)
    L, R = unitary(rng, S.shape[1]), unitary(rng, S.shape[2])
    curve, moved = make(t, S, V), make(t, L @ S @ R, L @ V @ R)
    at = np.linspace(*curve.t_span, 11)
    assert_close(moved(at), L @ curve(at) @ R, 1e-10, "unitary factors")
    assert_close(make(t, S.conj(), V.conj())(at), curve(at).conj(), 1e-10, "conjugation")


def test_real_data_given_as_complex(make):
    M, rng = Stiefel(4, 2), np.random.default_rng(5)
    S = [M.random_point(rng)]
    for _ in range(4):
        V = M.random_tangent(S[-1], rng)
        S.append(M.exp(S[-1], V * (0.5 / M.norm(S[-1], V))))
    t, S = np.arange(5.0), np.stack(S)
    V = 0.2 * M.random_tangent(S, rng)
    real, curve = make(t, S, V), make(t, S + 0j, V)
    at = np.linspace(*real.t_span, 13)
    assert_close(curve(at), real(at), 1e-10, "points")
    assert_close(curve.velocity(at), real.velocity(at), 1e-9, "velocities")
    assert_close(curve.cost(), real.cost(), 1e-9 * real.cost(), "cost")


def test_smoothing(data):
    """Cross-validation chooses the same weight as for the real embedding's data; misfit and cost balance."""
    t, S, _ = data
    M, rng = Stiefel(*S.shape[1:], field="complex"), np.random.default_rng(23)
    noisy = np.stack([exp(x, tangents(M, x, rng, 1, 0.05)[0]) for x in S])
    curve = SmoothingSpline(t, noisy, lam=0.02)
    misfit = sum(M.dist(a, b) ** 2 for a, b in zip(curve.points, noisy, strict=True))
    assert_close(curve.misfit, misfit, 1e-10, "misfit")
    rough = CubicSpline(t, noisy)
    assert curve.misfit + 0.02 * curve.cost() <= 0.02 * rough.cost() * (1 + 1e-9)
    chosen = SmoothingSpline(t, noisy)
    again = SmoothingSpline(t, noisy, lam=chosen.lam)
    assert_close(again(t[1]), chosen(t[1]), 1e-9, "the weight that was found")
    assert 2 <= chosen.degrees_of_freedom <= len(t)


def test_weights_found_for_real_data():
    M, rng = Stiefel(3, 1), np.random.default_rng(29)
    t = np.linspace(0, 1, 12)
    angle = 2 * t + 0.05 * rng.standard_normal(12)
    S = np.stack([np.cos(angle), np.sin(angle), 0 * t], axis=-1)[..., None]
    S = M.project(S + 0.05 * rng.standard_normal(S.shape))
    real, curve = SmoothingSpline(t, S), SmoothingSpline(t, S + 0j)
    assert_close(curve.lam / real.lam, 1.0, 1e-4, "lam")
    assert_close(curve.degrees_of_freedom, real.degrees_of_freedom, 1e-4, "degrees of freedom")
    assert_close(SmoothingSpline(t, S + 0j, lam=real.lam).misfit, real.misfit, 1e-10, "misfit")


def test_derivatives_by_data(data):
    """Points, times and end conditions; pull-backs are transposes for Re tr(W^H dS)."""
    t, S, V = data
    rng, h, at = np.random.default_rng(31), 1e-5, np.array([0.3, 0.8]) * (t[-1] - t[0]) + t[0]
    ends = ((1, V[0]), "natural")
    curve = CubicSpline(t, S, ends)
    X, dt = skew(unitary(rng, S.shape[1])), rng.standard_normal(len(t))
    from scipy.linalg import expm  # noqa: PLC0415

    def moved(u):
        Q, points = expm(u * X), S.copy()
        points[0] = Q @ S[0]
        return CubicSpline(t + u * dt, points, ((1, Q @ V[0]), "natural"))

    dS = np.zeros_like(S)
    dS[0] = X @ S[0]
    change = (X @ V[0], None)
    found = curve.point_variation(at, dS, dt, change)
    ahead, behind = moved(h), moved(-h)
    assert_close(found, (ahead(at) - behind(at)) / (2 * h), 1e-6, "points")
    W = rng.standard_normal(found.shape) + 1j * rng.standard_normal(found.shape)

    def pairing(G, X):
        return np.sum(np.conj(G) * X).real

    GS, Gt, (first, last) = curve.point_pullback(at, W)
    assert Gt.dtype == np.float64
    # With a natural end, the given acceleration is zero.
    assert last is None or last.shape == S.shape[1:]
    assert_close(pairing(GS, dS) + Gt @ dt + pairing(first, change[0]), pairing(W, found), 1e-9, "pull-back")
    GS, Gt, (first, _) = curve.cost_gradient()
    slope = (ahead.cost() - behind.cost()) / (2 * h)
    measured = pairing(GS, dS) + Gt @ dt + pairing(first, change[0])
    assert_close(measured, slope, 1e-5 * max(1, abs(slope)), "cost")


def test_hermite_pieces_are_cubics_between_ends(data):
    t, S, V = data
    width = t[2] - t[1]
    piece = RiemannianCubic.from_boundary(S[1], width * V[1], S[2], width * V[2])
    assert_close(CubicHermite(t, S, V)(t[1] + 0.4 * width), piece(0.4), 1e-11, "piece")


def test_speed_of_two_points(data):
    t, S, _ = data
    curve = CubicSpline(t[:2], S[:2])
    line = QuasiGeodesic(S[0], S[1])
    speeds = [norm(curve(u), curve.velocity(u)) for u in np.linspace(t[0], t[1], 5)]
    assert_close(speeds, speeds[0], 1e-9, "a geodesic")
    assert line.arc_length() >= curve.arc_length() - 1e-12


@pytest.mark.parametrize("unit", [1e-3, 1e-9, 1e-100])
def test_vectors_that_vanish_in_short_units_of_time(unit):
    """Their round-off is large in such a unit, and no sign of a curve that has left the complex frames."""
    a = np.array([0, 0.4, 1.0, 0.7, 0.2])
    Y = np.stack([np.cos(a / 2), np.sin(a / 2) * np.exp(0.7j * a)], axis=-1)[..., None]
    qubit = stiefel_rs.Grassmann(2, 1, field="complex")
    curve, slow = (CubicSpline(np.arange(5.0) * h, Y, manifold=qubit) for h in (unit, 1.0))
    assert_close(unit * unit * curve.acceleration(curve.t), slow.acceleration(slow.t), 1e-11, "acceleration")
    B, identity = np.array([[1j, 0.3], [-0.3, -0.2j]]), np.eye(2) + 0j
    frames = exp(identity, 0.5 * a[:, None, None] * B)
    clamped = CubicSpline(np.arange(5.0) * unit, frames, "clamped")
    assert np.abs(unit * clamped.velocity(clamped.t[0])).max() < 1e-14
    again = pickle.loads(pickle.dumps(clamped))
    assert np.array_equal(again(0.3 * unit), clamped(0.3 * unit))
    zero = np.zeros((2, 2), complex)
    geodesic = RiemannianCubic.from_initial(identity, B / unit, zero, zero, t_end=unit)
    for vector in (geodesic.acceleration(0.3 * unit), geodesic.restricted(0.3 * unit, unit).initial[2]):
        assert np.abs(unit * unit * vector).max() < 1e-13
