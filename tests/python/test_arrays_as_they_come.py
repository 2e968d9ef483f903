"""Points in single precision, rounded points, and invalid points of both kinds."""

import numpy as np
import pytest

from stiefel_rs import (
    CubicHermite,
    CubicSpline,
    Geodesic,
    GeometricCubic,
    GeometricPolynomial,
    Grassmann,
    InvalidInputError,
    QuasiGeodesic,
    RiemannianCubic,
    SmoothingSpline,
    Stiefel,
    estimate_velocities,
    integrate_cubic,
    integrate_embedded,
    solve_boundary,
)

SHAPES = [(3, 1), (5, 2), (3, 3), (6, 3)]
FIELDS = ["real", "complex"]


def problem(n, k, field):
    """Data for a curve, three points, and vectors there."""
    M = Stiefel(n, k, field=field)
    S = M.random_point(rng=1)
    if (n, k, field) == (3, 3, "real") and np.linalg.det(S) < 0:
        S = S * [1, 1, -1]
    vector = M.random_tangent(S, rng=2)
    V = 0.4 * vector / M.norm(S, vector)
    points = np.stack([S, M.exp(S, V), M.exp(S, 2 * V)])
    vectors = np.stack([V, M.transport(S, V, V), M.transport(S, 2 * V, V)])
    return M, points, vectors


def makers(points, vectors):
    (S0, S1, _), (V0, V1, _) = points, vectors
    t = np.arange(3.0)
    ends = S0, V0, S1, V1
    return {
        "QuasiGeodesic": lambda **kw: QuasiGeodesic(S0, S1, **kw),
        "QuasiGeodesic.from_velocity": lambda **kw: QuasiGeodesic.from_velocity(S0, V0, **kw),
        "Geodesic": lambda **kw: Geodesic(S0, S1, **kw),
        "Geodesic.from_velocity": lambda **kw: Geodesic.from_velocity(S0, V0, **kw),
        "GeometricCubic": lambda **kw: GeometricCubic(*ends, **kw),
        "GeometricPolynomial": lambda **kw: GeometricPolynomial(points, **kw),
        "minimal_cost": lambda **kw: GeometricPolynomial.minimal_cost(*ends, degree=3, **kw),
        "quintic": lambda **kw: GeometricPolynomial.quintic(S0, V0, 0 * V0, S1, V1, 0 * V1, **kw),
        "from_initial": lambda **kw: RiemannianCubic.from_initial(S0, V0, 0.1 * V0, 0 * V0, **kw),
        "from_boundary": lambda **kw: RiemannianCubic.from_boundary(*ends, **kw),
        "guess": lambda **kw: RiemannianCubic.from_boundary(*ends, guess=(0 * V0, 0.01 * V0), **kw),
        "CubicHermite": lambda **kw: CubicHermite(t, points, vectors, **kw),
        "CubicSpline": lambda **kw: CubicSpline(t, points, **kw),
        "ends": lambda **kw: CubicSpline(t, points, ((1, V0), (2, 0.1 * vectors[2])), **kw),
        "SmoothingSpline": lambda **kw: SmoothingSpline(t, points, lam=1e-3, **kw),
        "integrate_cubic": lambda **kw: integrate_cubic(S0, V0, 0.1 * V0, 0 * V0, 4, **kw),
        "integrate_embedded": lambda **kw: integrate_embedded(S0, V0, 0.1 * V0, 0 * V0, 4, **kw),
        "solve_boundary": lambda **kw: solve_boundary(*ends, **kw),
        "estimate_velocities": lambda **kw: estimate_velocities(t, points, **kw),
    }


NAMES = list(makers(np.zeros((3, 1, 1)), np.zeros((3, 1, 1))))


def values(made):
    """Some numbers that represent a curve, a trajectory, a batch or an array."""
    if isinstance(made, np.ndarray):
        return made
    if hasattr(made, "t_span"):
        return made(np.linspace(*made.t_span, 7))
    return made.point if hasattr(made, "point") else made.jerk


def single(array):
    return array.astype(np.complex64 if array.dtype.kind == "c" else np.float32)


def rounded(array):
    return array.round(4)


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("name", NAMES)
def test_single_precision_counts_as_points(name, shape, field):
    _, points, vectors = problem(*shape, field)
    exact = values(makers(points, vectors)[name]())
    found = values(makers(single(points), single(vectors))[name]())
    assert found.dtype == exact.dtype
    assert np.abs(found - exact).max() < 1e-4


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("name", NAMES)
def test_rounded_points_are_projected_where_it_is_asked_for(name, shape, field):
    _, points, vectors = problem(*shape, field)
    exact = values(makers(points, vectors)[name]())
    make = makers(rounded(points), rounded(vectors))[name]
    with pytest.raises(InvalidInputError, match=r"not orthonormal, .* exceeds \S+; .*project=True"):
        make()
    found = values(make(project=True))
    assert np.abs(found - exact).max() < 5e-2


@pytest.mark.parametrize("name", NAMES)
def test_exact_points_stay_as_they_are(name):
    _, points, vectors = problem(5, 2, "real")
    make = makers(points, vectors)[name]
    np.testing.assert_array_equal(values(make(project=True)), values(make()))


def test_points_of_a_spline_are_on_the_manifold():
    M, points, _ = problem(5, 2, "real")
    spline = CubicSpline(np.arange(3.0), rounded(points), project=True)
    M.check_point(spline.points, atol=1e-14)
    np.testing.assert_allclose(spline(np.arange(3.0)), M.project(rounded(points)), atol=1e-13)


@pytest.mark.parametrize("kind", ["riemannian", "geometric"])
def test_subspaces(kind):
    M = Grassmann(6, 2)
    Y = M.random_point(rng=0)
    V = 0.2 * M.random_tangent(Y, rng=1)
    points = np.stack([Y, M.exp(Y, V), M.exp(Y, 2 * V)])
    vectors = np.stack([V, M.transport(Y, V, V), M.transport(Y, 2 * V, V)])
    t, options = np.arange(3.0), {"kind": kind, "manifold": M}
    exact = CubicHermite(t, points, vectors, **options)
    found = CubicHermite(t, single(points), single(vectors), **options)
    assert M.dist(found(0.7), exact(0.7)) < 1e-5
    with pytest.raises(InvalidInputError, match="knot 0"):
        CubicHermite(t, rounded(points), vectors, **options)
    found = CubicHermite(t, rounded(points), rounded(vectors), project=True, **options)
    assert M.dist(found(0.7), exact(0.7)) < 1e-3


def test_what_is_too_far_is_refused_with_what_is_allowed():
    _, points, vectors = problem(5, 2, "real")
    far = points * 1.2
    with pytest.raises(InvalidInputError, match=r"knot 0: S: .* exceeds 1.000e-1") as error:
        CubicSpline(np.arange(3.0), far, project=True)
    assert error.value.knot == 0
    with pytest.raises(InvalidInputError, match=r"S0: .* exceeds 1.000e-5"):
        Geodesic(single(points[0] * 1.001), points[1])
    skewed = vectors[0] + 0.5 * points[0]
    with pytest.raises(InvalidInputError, match=r"V0: not tangent, .* exceeds 1.0"):
        GeometricCubic(points[0], skewed, points[1], vectors[1], project=True)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_numbers_that_are_not_finite_are_refused(bad):
    _, points, _vectors = problem(5, 2, "real")
    broken = points.copy()
    broken[1, 0, 0] = bad
    for make in (
        lambda: CubicSpline(np.arange(3.0), broken, project=True),
        lambda: Geodesic(single(broken[1]), points[0]),
    ):
        with pytest.raises(InvalidInputError, match="finite"):
            make()


@pytest.mark.parametrize("field", FIELDS)
def test_methods_take_single_precision(field):
    M, points, vectors = problem(5, 2, field)
    S0, S1, V = *points[:2], vectors[0]
    assert np.abs(M.exp(single(S0), single(V)) - S1).max() < 1e-6
    assert np.abs(M.log(single(S0), single(S1)) - V).max() < 1e-6
    # A single one of the arguments.
    assert np.abs(M.transport(single(S0), V, V) - vectors[1]).max() < 1e-6
    batch = single(points)
    assert np.abs(M.norm(batch, single(vectors)) - 0.4).max() < 1e-6
    M.check_point(batch)
    with pytest.raises(InvalidInputError):
        M.check_point(batch.astype(S0.dtype))
    np.testing.assert_array_equal(M.is_point(np.stack([S0, rounded(S0)])), [True, False])
    assert M.is_point(single(S0)) and not M.is_point(rounded(S0)) and M.is_point(rounded(S0), atol=1e-3)
    assert M.is_tangent(single(S0), single(V)) and not M.is_tangent(S0, V + S0)
    assert not M.is_point(np.full_like(S0, np.nan))
    # Any matrix has a projection.
    far = single(S0 * 1.5)
    assert np.abs(M.project(far) - S0).max() < 1e-6


def test_errors_of_shape_name_the_right_argument():
    wide = np.ones((2, 4), dtype=np.float32)
    for kind in (np.float32, np.float64):
        with pytest.raises(InvalidInputError, match=r"^S: expected shape"):
            QuasiGeodesic.from_velocity(wide.astype(kind), wide.astype(kind), project=True)


def test_advice_fits():
    _, points, vectors = problem(5, 2, "real")
    with pytest.raises(InvalidInputError) as error:
        CubicSpline(np.arange(3.0), 1.2 * points, project=True)
    assert "project=True" not in str(error.value) and "`project` of the manifold gives the nearest point" in str(
        error.value
    )
    with pytest.raises(InvalidInputError, match="`project_tangent` gives the tangent part"):
        CubicHermite(np.arange(3.0), points, rounded(vectors))


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("coarse", [single, rounded])
def test_closed_data_stay_closed(coarse, field):
    M, points, _ = problem(5, 2, field)
    S = np.concatenate([points, points[:1]])
    data = coarse(S)
    data[-1] += 1e-7 if coarse is single else 1e-4
    options = {"project": coarse is rounded}
    spline = CubicSpline(np.arange(4.0), data, "periodic", **options)
    np.testing.assert_array_equal(spline.points[-1], spline.points[0])
    M.check_point(spline.points)
    V = estimate_velocities(np.arange(4.0), data, closed=True, **options)
    np.testing.assert_array_equal(V[-1], V[0])
    far = data.copy()
    far[-1] = far[1]
    with pytest.raises(InvalidInputError, match="from the first point"):
        CubicSpline(np.arange(4.0), far, "periodic", **options)


@pytest.mark.parametrize("kind", [np.complex64, np.complex128])
def test_complex_points_are_points_where_methods_take_them(kind):
    for M in (Stiefel(4, 2, field="complex"), Grassmann(4, 2, field="complex")):
        S = M.random_point(rng=3)
        V = 0.3 * M.random_tangent(S, rng=4)
        unit = 1e-9 if kind is np.complex128 else 1e-5
        # Methods take complex128 within 7e-10.
        for part in (0.1, 0.6, 1.5):
            # The defect is twice the stretch of a column.
            point = S.copy()
            point[:, 0] *= 1 + part * unit / 2
            point, vector = point.astype(kind), V.astype(kind)
            try:
                M.exp(point, vector)
            except InvalidInputError:
                assert not M.is_point(point)
            else:
                assert M.is_point(point) and M.is_tangent(point, vector)
        assert M.is_point(S.astype(kind)) is True


def test_a_large_batch_of_single_precision():
    M, points, vectors = problem(5, 2, "real")
    S, V = (np.broadcast_to(x[0], (5000, 5, 2)) for x in (points, vectors))
    found = M.exp(single(S), single(V))
    assert np.ptp(found, axis=0).max() == 0.0
    bad = single(S)
    bad[4321] *= 1.001
    with pytest.raises(InvalidInputError, match=r"exceeds 1.000e-5.*batch member 4321"):
        M.exp(bad, single(V))
