"""Pickles and copies of curves: the very same curve comes back, and what was tampered with is refused."""

import copy
import pickle

import numpy as np
import pytest

from stiefel_rs import (
    GeometricCubic,
    GeometricPolynomial,
    InvalidInputError,
    RiemannianCubic,
    Stiefel,
    StiefelError,
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
    """Bit-equal inside of the interval and outside."""
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


def tampered():
    curve = RiemannianCubic.from_initial(*data(9, 2))
    _, (sizes, frame, numbers, times, report) = curve.__reduce__()

    def with_numbers(i, change):
        changed = [np.array(x) for x in numbers]
        changed[i] = change(changed[i])
        return sizes, frame, changed, times, report

    def infinite(x):
        x[len(x) // 2] = np.inf
        return x

    shape, tolerance = sizes
    for i in range(4):
        yield with_numbers(i, lambda x: x[:-1] if len(x) % 3 == 0 else x[:-3])
        yield with_numbers(i, lambda x: x[:0])
        yield with_numbers(i, infinite)
        yield with_numbers(i, lambda x: np.concatenate([x, x]))
    yield with_numbers(0, lambda x: x[::-1])
    for j in range(3):
        for size in (-1, 0, 2**62, shape[j] + 1):
            wrong = list(shape)
            wrong[j] = size
            yield (wrong, tolerance), frame, numbers, times, report
    for wrong in (np.nan, 0.0, -1.0, 0.5):
        yield (shape, wrong), frame, numbers, times, report
    for wrong in (None, frame[:, :-1], frame[:-1], np.full_like(frame, np.nan)):
        yield sizes, wrong, numbers, times, report
    clock, span = times
    for wrong in ([np.nan, 0, 0], [0.0, 0, 0], [1.0, np.inf, 0], [1.0, 0, -np.inf]):
        yield sizes, frame, numbers, (wrong, span), report
    for wrong in ([1.0, 0.0], [0.0, np.nan], [0.0, 0.0], [-1e308, 1e308]):
        yield sizes, frame, numbers, (clock, wrong), report


def test_tampered_pickles_are_refused():
    build = RiemannianCubic.from_initial(*data(9, 2)).__reduce__()[0]
    count = 0
    for arguments in tampered():
        count += 1
        with pytest.raises(StiefelError):
            build(*arguments)
    assert count == 16 + 1 + 12 + 4 + 4 + 8
    sizes, frame, numbers, times, report = RiemannianCubic.from_initial(*data(9, 2)).__reduce__()[1]
    with pytest.raises(TypeError):
        build(sizes, frame, [x + 0j for x in numbers], times, report)


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
