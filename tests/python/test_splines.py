"""Curves through many points: compared with SciPy on the circle, the curve protocol, and errors that name the knot."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline, make_smoothing_spline
from scipy.interpolate import CubicSpline as Flat
from scipy.spatial.transform import Rotation
from spline_problems import MET, velocities, walk

from stiefel_rs import (
    ConvergenceError,
    CubicHermite,
    CubicSpline,
    GeometricCubic,
    InvalidInputError,
    PiecewiseCurve,
    RiemannianCubic,
    SmoothingSpline,
    Stiefel,
)

# Second derivatives: 1e-12 divided by the square of the shortest leg, and sums of them.
SMOOTH = 1e-10

T = np.array([0.0, 0.7, 1.5, 3.0, 3.8, 5.0])
ANGLES = np.array([0.1, 0.5, 1.4, 0.9, 0.3, 0.1])


def circle(angle):
    """Points of St(2, 1)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)[..., None]


def turning(angle, rate):
    """Their velocities."""
    return rate[..., None, None] * np.stack([-np.sin(angle), np.cos(angle)], axis=-1)[..., None]


BOUNDARY = {
    "natural": ("natural", "natural"),
    "clamped": ("clamped", "clamped"),
    "periodic": ("periodic", "periodic"),
    "words": (("natural", "clamped"), ("natural", "clamped")),
    "first": (((1, 0.4), (1, -0.3)), [(1, 0.4), (1, -0.3)]),
    "second": (((2, 0.5), (2, -0.7)), [(2, 0.5), (2, -0.7)]),
    "mixed": (((1, 0.4), "natural"), [(1, 0.4), "natural"]),
}


def on_circle(condition, angle):
    """SciPy's end condition on an angle, converted to the circle."""
    if isinstance(condition, str):
        return condition
    return (condition[0], turning(np.asarray(angle), np.asarray(condition[1])))


@pytest.mark.parametrize("name", BOUNDARY)
def test_the_circle_is_flat(name):
    flat_ends, ends = BOUNDARY[name]
    if not isinstance(ends, str):
        ends = tuple(on_circle(end, angle) for end, angle in zip(ends, ANGLES[[0, -1]], strict=True))
    flat = Flat(T, ANGLES, bc_type=flat_ends)
    curve = CubicSpline(T, circle(ANGLES), ends)
    t = np.linspace(T[0], T[-1], 101)
    angle, rate, bend = flat(t), flat(t, 1), flat(t, 2)
    assert np.abs(curve(t) - circle(angle)).max() < SMOOTH
    assert np.abs(curve.velocity(t) - turning(angle, rate)).max() < SMOOTH
    assert np.abs(curve(t, 1) - turning(angle, rate)).max() < SMOOTH
    assert np.abs(curve.acceleration(t) - turning(angle, bend)).max() < SMOOTH
    # The second derivative is linear between knots.
    left, right = flat(T[:-1], 2), flat(np.nextafter(T[1:], 0), 2)
    cost = np.sum(np.diff(T) * (left**2 + left * right + right**2) / 3)
    assert abs(curve.cost() - cost) < SMOOTH * max(cost, 1)
    assert curve.report.converged


@pytest.mark.parametrize("kind", ["riemannian", "geometric"])
def test_hermite_on_the_circle(kind):
    rates = np.array([0.3, -0.2, 0.1, 0.5, 0.0, 0.4])
    flat = CubicHermiteSpline(T, ANGLES, rates)
    curve = CubicHermite(T, circle(ANGLES), turning(ANGLES, rates), kind)
    t = np.linspace(T[0], T[-1], 101)
    assert np.abs(curve(t) - circle(flat(t))).max() < SMOOTH
    assert np.abs(curve.velocity(t) - turning(flat(t), flat(t, 1))).max() < SMOOTH
    assert curve.report is None
    assert curve.kind == kind


SIZES = [(3, 1), (3, 2), (3, 3), (4, 2), (30, 2)]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("count", [2, 5])
def test_natural_splines(size, count):
    t, S = walk(*size, count)
    curve = CubicSpline(t, S)
    assert isinstance(curve, PiecewiseCurve)
    assert curve.t_span == (t[0], t[-1])
    assert (curve.n, curve.k) == size
    assert np.abs(curve(t) - S).max() < MET
    for end in t[[0, -1]]:
        assert np.abs(curve.acceleration(end)).max() < SMOOTH
    before, after = t[1:-1] - 1e-13, t[1:-1]
    assert np.abs(curve.velocity(before) - curve.velocity(after)).max(initial=0) < SMOOTH
    assert np.abs(curve.acceleration(before) - curve.acceleration(after)).max(initial=0) < SMOOTH
    # Evaluation in any order and shape gives the same values as one at a time.
    times = np.random.default_rng(1).uniform(t[0], t[-1], (4, 25))
    for read in [curve, lambda t: curve(t, 3), curve.acceleration, curve.jerk]:
        values = read(times)
        assert values.shape == (4, 25, *size)
        assert np.abs(values[2, 3] - read(times[2, 3])).max() <= 1e-13 * max(1, np.abs(values).max())


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_long_chains_of_rotations_take_as_few_steps_as_short_ones(seed):
    # Some of the many legs overshoot: in the spline of flat space they turn by more than three radians.
    rng, count = np.random.default_rng(seed), 2000
    turns = rng.normal(size=(count - 1, 3))
    turns *= (rng.uniform(0.3, 1.2, count - 1) / np.linalg.norm(turns, axis=1))[:, None]
    S = np.empty((count, 3, 3))
    S[0] = np.eye(3)
    for i, turn in enumerate(Rotation.from_rotvec(turns).as_matrix()):
        S[i + 1] = S[i] @ turn
    t = np.cumsum(rng.uniform(0.5, 1.5, count))
    S = Stiefel(3, 2).project(S[:, :, :2])
    curve = CubicSpline(t, S)
    assert curve.report.iterations <= 25
    assert np.abs(curve(t) - S).max() < MET
    before, after = t[1:-1] - 1e-12, t[1:-1]
    # Relative to jerks of up to 1000.
    jumps = curve.acceleration(before) - curve.acceleration(after)
    assert np.abs(jumps).max() < 10 * SMOOTH


def test_between_two_points_the_spline_is_the_geodesic():
    t, S = walk(4, 2, 2)
    curve = CubicSpline(t, S)
    V = Stiefel(4, 2).log(S[0], S[1])
    assert np.abs(curve((t[0] + t[1]) / 2) - Stiefel(4, 2).exp(S[0], V / 2)).max() < MET
    assert curve.cost() < 1e-20
    still = CubicSpline([0, 1], S, "clamped")
    assert np.abs(still.velocity([0, 1])).max() < MET
    assert still.cost() > 1


def test_clamped_splines_through_a_cubic_are_that_cubic():
    M, rng = Stiefel(5, 2), np.random.default_rng(3)
    S = M.random_point(rng)
    V, A, J = (x * 0.3 * M.random_tangent(S, rng) for x in (1, 2, 3))
    cubic = RiemannianCubic.from_initial(S, V, A, J, 2.0)
    t = np.array([0, 0.4, 0.7, 1.4, 2.0])
    for order, ends in ((1, cubic.velocity(t[[0, -1]])), (2, cubic.acceleration(t[[0, -1]]))):
        curve = CubicSpline(t, cubic(t), ((order, ends[0]), (order, ends[1])))
        fine = np.linspace(0, 2, 41)
        assert np.abs(curve(fine) - cubic(fine)).max() < 1e-10
        given = curve.bc_type
        assert [end[0] for end in given] == [order, order]
        assert np.array_equal(given[0][1], ends[0])
        assert not given[0][1].flags.writeable


@pytest.mark.parametrize("kind", ["riemannian", "geometric"])
@pytest.mark.parametrize("size", SIZES)
def test_hermite(size, kind):
    t, S = walk(*size, 4, 0.4)
    V = velocities(S)
    curve = CubicHermite(t, S, V, kind)
    for side in (t, np.nextafter(t, t.mean())):
        assert np.abs(curve(side) - S).max() < 1e-10
        assert np.abs(curve.velocity(side) - V).max() < 1e-10
    assert np.array_equal(curve.velocities, V)


@pytest.mark.parametrize("make", [CubicSpline, lambda t, S: CubicHermite(t, S, velocities(np.array(S)), "geometric")])
def test_attributes(make):
    t, S = walk(3, 2, 4, 0.4)
    curve = make(t.tolist(), list(S))
    assert np.array_equal(curve.t, t)
    assert np.array_equal(curve.points, S)
    for array in (curve.t, curve.points):
        assert not array.flags.writeable
    pieces = curve.pieces
    assert {type(piece) for piece in pieces} == {RiemannianCubic if curve.kind == "riemannian" else GeometricCubic}
    assert len(pieces) == 3
    for i, piece in enumerate(pieces):
        h = t[i + 1] - t[i]
        assert piece.t_span == (0, 1)
        assert np.abs(piece(0.4) - curve(t[i] + 0.4 * h)).max() < 1e-13
        assert np.abs(piece.velocity(0.4) / h - curve.velocity(t[i] + 0.4 * h)).max() < 1e-13
    costs = [piece.cost() / h**3 for piece, h in zip(pieces, np.diff(t), strict=True)]
    assert abs(sum(costs) - curve.cost()) <= 1e-13 * curve.cost()
    name = type(curve).__name__
    assert repr(curve) == f"<{name} on St(3, 2), {curve.kind}, 4 knots, t_span ({float(t[0])!r}, {float(t[-1])!r})>"
    t[0] = 7
    assert curve.t[0] != 7


def test_times_outside_are_errors_unless_asked_for():
    t, S = walk(3, 2, 4)
    V = velocities(S)
    for make in (
        lambda **ask: CubicSpline(t, S, **ask),
        lambda **ask: CubicHermite(t, S, V, **ask),
        lambda **ask: CubicHermite(t, S, V, "geometric", **ask),
    ):
        curve, longer = make(), make(extrapolate=True)
        assert not curve.extrapolate
        assert longer.extrapolate
        for outside in (t[0] - 1e-9, t[-1] + 0.1, [t[1], t[-1] + 1e-3]):
            with pytest.raises(InvalidInputError, match="t: must be between the first and the last knot"):
                curve(outside)
        before, after = t[0] - 0.1, t[-1] + 0.2
        first, last = longer.pieces[0], longer.pieces[-1]
        assert np.abs(longer(before) - first(-0.1 / (t[1] - t[0]))).max() < MET
        assert np.abs(longer(after) - last(1 + 0.2 / (t[-1] - t[-2]))).max() < MET
        assert np.array_equal(longer(t[:-1], 2), curve(t[:-1], 2))
        for bad in (np.nan, np.inf):
            with pytest.raises(InvalidInputError, match="not finite"):
                longer(bad)


@pytest.mark.parametrize("num_threads", [1, 2, 5])
def test_splines_are_bit_identical_for_any_number_of_threads(num_threads):
    t, S = walk(6, 2, 40, 0.4)
    V = velocities(S)
    fine = np.linspace(t[0], t[-1], 1001)
    for make in (
        lambda **ask: CubicSpline(t, S, **ask),
        lambda **ask: CubicHermite(t, S, V, **ask),
        lambda **ask: CubicHermite(t, S, V, "geometric", **ask),
    ):
        one, other = make(num_threads=num_threads), make()
        for nu in range(4):
            assert np.array_equal(one(fine, nu, num_threads=num_threads), other(fine, nu))


@pytest.mark.parametrize("lam", [1e-3, 0.1, 10.0])
def test_smoothing_on_the_circle_is_flat(lam):
    weights = np.array([1.0, 2.0, 0.5, 1.0, 3.0, 1.0])
    flat = make_smoothing_spline(T, ANGLES, weights, lam)
    curve = SmoothingSpline(T, circle(ANGLES), weights, lam)
    t = np.linspace(T[0], T[-1], 101)
    assert np.abs(curve(t) - circle(flat(t))).max() < 1e-9
    assert np.abs(curve.velocity(t) - turning(flat(t), flat.derivative()(t))).max() < 1e-8
    assert abs(curve.misfit - np.sum(weights * (flat(T) - ANGLES) ** 2)) < 1e-9
    assert curve.lam == lam
    assert 2 <= curve.degrees_of_freedom <= len(T)
    assert curve.report.converged
    assert np.abs(curve.points - circle(flat(T))).max() < 1e-9


@pytest.mark.parametrize("seed", range(4))
def test_cross_validation_on_the_circle_is_scipys(seed):
    rng = np.random.default_rng(seed)
    t = np.sort(rng.uniform(0.0, 5.0, 40))
    angles = np.sin(t) + rng.normal(0.0, 0.1, len(t))
    curve, flat = SmoothingSpline(t, circle(angles)), make_smoothing_spline(t, angles)
    fine = np.linspace(t[0], t[-1], 101)
    # Both search for the minimum of a flat score.
    assert np.abs(curve(fine) - circle(flat(fine))).max() < 1e-4


def test_smoothing_splines_lie_between_the_data_and_a_geodesic():
    t, S = walk(4, 2, 8, 0.3)
    through = SmoothingSpline(t, S, lam=0)
    assert np.abs(through([t[0], 0.5 * (t[0] + t[-1])]) - CubicSpline(t, S)([t[0], 0.5 * (t[0] + t[-1])])).max() < 1e-9
    costs = [SmoothingSpline(t, S, lam=lam) for lam in (1e-4, 1e-2, 1.0)]
    assert sorted((curve.cost() for curve in costs), reverse=True) == [curve.cost() for curve in costs]
    assert sorted(curve.misfit for curve in costs) == [curve.misfit for curve in costs]
    found = SmoothingSpline(t, S)
    assert found.lam > 0
    # The weights of repeated data add up.
    twice = SmoothingSpline(np.repeat(t, 2), np.repeat(S, 2, axis=0), lam=0.2)
    heavy = SmoothingSpline(t, S, np.full(8, 2.0), 0.2)
    assert np.array_equal(twice.t, t)
    assert np.abs(twice.points - heavy.points).max() < 1e-9
    with pytest.raises(InvalidInputError, match="t: must be between"):
        heavy(t[-1] + 1)
    assert SmoothingSpline(t, S, lam=0.2, extrapolate=True)(t[-1] + 1).shape == (4, 2)


def test_bad_arguments_of_smoothing_splines():
    t, S = walk(3, 2, 5, 0.3)
    for lam in (-1.0, np.nan, -np.inf):
        with pytest.raises(InvalidInputError, match="lam: must be at least 0, or infinite"):
            SmoothingSpline(t, S, lam=lam)
    for weights, match in (
        (np.ones(4), r"weights: expected shape \(5,\), one for each of the 5 points, found \(4,\)"),
        (np.ones((5, 1)), r"weights: expected shape \(N,\)"),
        ([1, 1, np.nan, 1, 1], "weights: entry 2 is not finite"),
        ([1, 1, 0, 1, 1], "weights: must be positive"),
        ([1, 1, -1, 1, 1], "knot 2: weights: must be positive"),
    ):
        with pytest.raises(InvalidInputError, match=match):
            SmoothingSpline(t, S, weights)
    with pytest.raises(InvalidInputError, match="t: "):
        SmoothingSpline(t[::-1], S)
    with pytest.raises(TypeError, match="datetimes are not numbers"):
        SmoothingSpline(np.arange(5).astype("M8[s]"), S)
    for tol in (0.0, np.nan):
        with pytest.raises(InvalidInputError, match="tol: must be between"):
            SmoothingSpline(t, S, tol=tol)


@pytest.mark.parametrize(
    "curve", [CubicSpline(T, circle(ANGLES)), CubicHermite(T, circle(ANGLES), turning(ANGLES, ANGLES))]
)
def test_few_times_and_many_give_the_same_bits(curve):
    # Many times are distributed to threads, few are not.
    t = np.linspace(*curve.t_span, 20_001)
    for many, one in ((curve(t), curve), (curve.acceleration(t), curve.acceleration)):
        assert np.array_equal(many[::500], one(t[::500]))
        assert np.array_equal(many[7777], one(t[7777]))


@pytest.mark.parametrize("tol", [1e-12, 1e-9])
def test_failures_say_the_tolerance_that_was_asked_for(tol):
    # Distant knots at times that differ by orders of magnitude, which one step does not solve.
    rng = np.random.default_rng(2)
    S, t = Stiefel(3, 1).project(rng.standard_normal((6, 3, 1))), np.cumsum(10 ** rng.uniform(-2, 0, 6))
    with pytest.raises(ConvergenceError) as caught:
        CubicSpline(t, S, tol=tol, max_iterations=1)
    report = caught.value.report
    assert report.tolerance == tol
    assert report.residual > tol
