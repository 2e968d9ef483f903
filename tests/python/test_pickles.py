"""Pickles and copies of curves are bit-identical, and modified ones are refused."""

import copy
import pickle

import numpy as np
import pytest

from stiefel_rs import (
    Geodesic,
    GeometricCubic,
    GeometricPolynomial,
    InvalidInputError,
    QuasiGeodesic,
    RiemannianCubic,
    Stiefel,
    integrate_cubic,
)


def data(n, k, speed=0.5):
    """A point and three tangent vectors."""
    manifold = Stiefel(n, k)
    rng = np.random.default_rng(n + 100 * k)
    S = manifold.random_point(rng)
    vectors = [manifold.random_tangent(S, rng) for _ in range(3)]
    # St(1, 1) has no directions.
    return S, *(speed * V / max(manifold.norm(S, V), 1e-300) for V in vectors)


def ends(n, k):
    """Boundary data of a cubic."""
    curve = RiemannianCubic.from_initial(*data(n, k))
    return curve(0.0), curve.velocity(0.0), curve(1.0), curve.velocity(1.0)


def assert_same(again, original):
    """Bit-identical inside the interval and outside."""
    assert type(again) is type(original)
    assert again.t_span == original.t_span
    start, end = original.t_span
    t = start + (end - start) * np.linspace(-0.25, 1.25, 13)
    for nu in range(3):
        assert np.array_equal(again(t[2:-2], nu), original(t[2:-2], nu))
    assert np.array_equal(again(t[2]), original(t[2]))
    assert again.cost() == original.cost()


SIZES = [(3, 1), (1, 1), (3, 2), (3, 3), (9, 2), (50, 3)]


@pytest.mark.parametrize("protocol", range(2, pickle.HIGHEST_PROTOCOL + 1))
@pytest.mark.parametrize("size", SIZES)
def test_riemannian_cubics(size, protocol):
    curve = RiemannianCubic.from_initial(*data(*size), 2.0)
    both = RiemannianCubic.from_boundary(*ends(*size))
    forms = [
        curve,
        both,
        curve.reversed(),
        curve.restricted(-1, 3),
        curve.reparametrised(-5, -4).reversed(),
        RiemannianCubic.from_initial(*data(*size), -2.0, tol=1e-5),
    ]
    for original in forms:
        again = pickle.loads(pickle.dumps(original, protocol))
        assert_same(again, original)
        assert again.steps == original.steps
        assert repr(again.report) == repr(original.report)
        for found, expected in zip(again.initial, original.initial, strict=True):
            assert np.array_equal(found, expected)
        beyond = original.t_span[1] + 0.5
        assert np.array_equal(again(beyond), original(beyond))
        assert_same(pickle.loads(pickle.dumps(again)), original)


def test_curves_that_are_no_initial_data_to_round_off():
    loose = RiemannianCubic.from_initial(*data(5, 2, 4.0), 3.0, tol=1e-6)
    rough = RiemannianCubic.from_initial(*data(5, 2, 4.0), 3.0, tol=0.1)
    fast = RiemannianCubic.from_initial(*data(5, 2)).reparametrised(0, 1e-150)
    for original in (loose.reversed(), rough.restricted(1, 2)):
        assert_same(pickle.loads(pickle.dumps(original)), original)
    again = pickle.loads(pickle.dumps(fast))
    t = np.linspace(0, 1e-150, 7)
    assert np.array_equal(again(t), fast(t))


def tampered(curve):
    """Stored forms with one error each."""
    (form,) = curve.__reduce__()[1]
    arrays = {name: value for name, value in form.items() if isinstance(value, np.ndarray)}

    for name in form:
        yield {key: value for key, value in form.items() if key != name}
    for name, array in arrays.items():
        flat = array.ravel()
        for wrong in (np.append(flat, 1.0), flat[:-1], flat[:0], np.full_like(array, np.nan)):
            if wrong.size != flat.size or wrong.size:
                yield {**form, name: wrong}
    for name in ("shape", "ranks", "steps", "frame_of", "frame_ranks"):
        for wrong in (-1.0, 0.5, 2.0**62, 1e300, arrays[name][-1] + 1):
            changed = arrays[name].copy()
            changed[-1] = wrong
            yield {**form, name: changed}
    for wrong in (0.0, -1.0, 0.5):
        yield {**form, "tolerances": np.array([wrong])}
    for wrong in ([1.0, 0.0], [0.0, 0.0], [-1e308, 1e308]):
        yield {**form, "spans": np.array(wrong)}
    yield {**form, "clocks": np.array([0.0, 0.0, 0.0])}
    yield {**form, "intervals": arrays["intervals"][::-1]}
    yield {**form, "reports": np.array([9.0, 0.0, 0.0, 0.0])}
    yield {**form, "reports": np.array([1.0, 0.5, 0.0, 0.0])}
    for wrong in (1.0, 4.0, -1.0, 0.5):
        # The curve has no report, or the strategy is unknown.
        yield {**form, "strategies": np.array([wrong])}
    yield {**form, "reports": np.array([1.0, 1.0, 0.0, 1.0]), "strategies": np.array([4.0])}
    yield {**form, "reports": np.array([2.0, 1.0, 1.0, 0.1]), "strategies": np.array([1.0])}
    yield {**form, "more": np.zeros(3)}
    yield {**form, "more": "word"}
    yield {**form, "format": "another"}
    for wrong in (0, 2, -1, 10**30, "1", 1.5):
        yield {**form, "version": wrong}
    for wrong in ("QuasiGeodesic", "GeometricCubic", "CubicSpline", "Curve", ""):
        yield {**form, "kind": wrong}


def test_tampered_pickles_are_refused():
    # More dimensions than four per column: there is a basis.
    curve = RiemannianCubic.from_initial(*data(9, 2), 3.0)
    build, (form,) = curve.__reduce__()
    assert np.array_equal(build(form)(0.3), curve(0.3))
    count = 0
    for wrong in tampered(curve):
        count += 1
        with pytest.raises(InvalidInputError, match="stored curve: "):
            build(wrong)
            pytest.fail(f"{ {name: value for name, value in wrong.items() if value is not form.get(name)} } was taken")
    assert count > 100
    for wrong in (form["points"] + 0j, None, object(), form["points"].astype(str)):
        with pytest.raises(TypeError):
            build({**form, "points": wrong})
    with pytest.raises(TypeError):
        build(None)


def test_lines_and_geodesics():
    S, V, W, _ = data(9, 2)
    for original in (
        QuasiGeodesic.from_velocity(S, V),
        QuasiGeodesic(S, Stiefel(9, 2).exp(S, W)),
        Geodesic.from_velocity(S, V),
        Geodesic.from_velocity(S, V, metric="euclidean"),
    ):
        again = pickle.loads(pickle.dumps(original))
        assert type(again) is type(original)
        for nu in range(4):
            assert np.array_equal(again([-2, 0.3, 5], nu), original([-2, 0.3, 5], nu))
        assert getattr(again, "length", None) == getattr(original, "length", None)
        assert np.array_equal(copy.deepcopy(original)(0.3), original(0.3))


POLYNOMIALS = {
    "cubic": lambda e: GeometricCubic(*e),
    "cubic of geodesics": lambda e: GeometricCubic(*e, pieces="geodesic"),
    "cubic by control points": lambda e: GeometricCubic.from_control_points(GeometricCubic(*e).control_points),
    "polynomial": lambda e: GeometricPolynomial(GeometricCubic(*e).control_points[:3]),
    "polynomial of geodesics": lambda e: GeometricPolynomial(GeometricCubic(*e).control_points[:3], pieces="geodesic"),
    "minimal cost": lambda e: GeometricPolynomial.minimal_cost(*e, degree=4),
    "quintic": lambda e: GeometricPolynomial.quintic(e[0], e[1], 0 * e[0], e[2], e[3], 0 * e[0]),
}


@pytest.mark.parametrize("size", [(3, 1), (3, 2), (20, 2)])
@pytest.mark.parametrize("name", POLYNOMIALS)
def test_polynomials(name, size):
    original = POLYNOMIALS[name](ends(*size))
    assert copy.copy(original) is original
    assert copy.deepcopy([original])[0] is original
    again = pickle.loads(pickle.dumps(original))
    assert type(again) is type(original)
    assert again.pieces == original.pieces
    assert np.array_equal(again.control_points, original.control_points)
    assert repr(again.report) == repr(original.report)
    t = np.linspace(0, 1, 9)
    for nu in range(4):
        assert np.array_equal(again(t, nu), original(t, nu))


TRAJECTORY = ["t", "point", "velocity", "acceleration", "jerk", "energy"]


def test_trajectories_are_read_only_and_pickled():
    original = integrate_cubic(*data(5, 2), 8)
    assert copy.copy(original) is original
    assert copy.deepcopy([original])[0] is original
    again = pickle.loads(pickle.dumps(original))
    for name in TRAJECTORY:
        for trajectory in (original, again):
            with pytest.raises(ValueError, match="read-only"):
                getattr(trajectory, name)[0] = 7
        assert np.array_equal(getattr(again, name), getattr(original, name))
    assert again.momentum_drift == original.momentum_drift
    assert again.constraint_drift == original.constraint_drift


def test_tampered_trajectories_are_refused():
    build, (arrays, *drifts) = integrate_cubic(*data(5, 2), 8).__reduce__()
    for i in range(6):
        for wrong in (arrays[i][:-1], arrays[i] * np.nan, arrays[i][None], np.array(1.0)):
            changed = [*arrays]
            changed[i] = wrong
            with pytest.raises(InvalidInputError):
                build(changed, *drifts)
