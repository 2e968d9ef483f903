"""Curves through many points: beside SciPy's on the circle, the protocol of curves, and errors that name the knot."""

import datetime
import pickle

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline, make_smoothing_spline
from scipy.interpolate import CubicSpline as Flat

from stiefel_rs import (
    ConvergenceError,
    CubicHermite,
    CubicSpline,
    GeometricCubic,
    InvalidInputError,
    OutsideDomainError,
    PiecewiseCurve,
    RiemannianCubic,
    SmoothingSpline,
    Stiefel,
)

# Legs that miss their knot or jump by at most 1e-12, and evaluation.
MET = 1e-11
# Second derivatives: 1e-12 over the square of the shortest leg, and sums of them.
SMOOTH = 1e-10

T = np.array([0.0, 0.7, 1.5, 3.0, 3.8, 5.0])
ANGLES = np.array([0.1, 0.5, 1.4, 0.9, 0.3, 0.1])


def circle(angle):
    """Points of St(2, 1)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)[..., None]


def turning(angle, rate):
    """Their velocities."""
    return rate[..., None, None] * np.stack([-np.sin(angle), np.cos(angle)], axis=-1)[..., None]


def walk(n, k, count, step=0.6, seed=0):
    """Points that wander, at unequal times."""
    manifold, rng = Stiefel(n, k), np.random.default_rng(seed + n + 100 * k)
    points = [manifold.random_point(rng)]
    for _ in range(count - 1):
        V = manifold.random_tangent(points[-1], rng)
        points.append(manifold.exp(points[-1], step * V / manifold.norm(points[-1], V)))
    return np.cumsum(rng.uniform(0.5, 1.5, count)), np.stack(points)


def velocities(points, seed=5):
    """Of length 1 at every point."""
    manifold = Stiefel(*points.shape[1:])
    V = manifold.random_tangent(points, np.random.default_rng(seed))
    return V / manifold.norm(points, V)[:, None, None]


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
    """SciPy's condition on an angle as one on the circle."""
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
    # Evaluated in any order and shape, the values are those one at a time.
    times = np.random.default_rng(1).uniform(t[0], t[-1], (4, 25))
    for read in [curve, lambda t: curve(t, 3), curve.acceleration, curve.jerk]:
        values = read(times)
        assert values.shape == (4, 25, *size)
        assert np.abs(values[2, 3] - read(times[2, 3])).max() <= 1e-13 * max(1, np.abs(values).max())


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
    assert repr(curve) == f"<{name} on St(3, 2), 4 knots, t_span ({float(t[0])!r}, {float(t[-1])!r})>"
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


def makers(t, S):
    V = velocities(S)
    return [
        lambda t=t, S=S: CubicSpline(t, S),
        lambda t=t, S=S: CubicHermite(t, S, V),
        lambda t=t, S=S: CubicHermite(t, S, V, "geometric"),
    ]


def test_bad_times_name_the_knot():
    t, S = walk(3, 2, 4, 0.3)
    for make in makers(t, S):
        for bad in (t[1], t[1] - 0.1, t[0]):
            wrong = t.copy()
            wrong[2] = bad
            with pytest.raises(InvalidInputError, match="knot 2: t: must be greater than the time before it") as caught:
                make(t=wrong)
            assert caught.value.knot == 2
        for bad in (np.nan, np.inf, -np.inf):
            wrong = t.copy()
            wrong[2] = bad
            with pytest.raises(InvalidInputError, match="t: entry 2 is not finite") as caught:
                make(t=wrong)
            assert caught.value.knot == 2
        for wrong in (t[:-1], np.append(t, 9), [], t[:1]):
            with pytest.raises(InvalidInputError, match="one time for each of the 4 points"):
                make(t=wrong)
        for wrong in (t[None], t[:, None], 1.0):
            with pytest.raises(InvalidInputError, match=r"t: expected shape \(N,\)"):
                make(t=wrong)
    with pytest.raises(InvalidInputError, match="at least two"):
        CubicSpline(t[:1], S[:1])
    with pytest.raises(InvalidInputError, match="at least two"):
        CubicSpline([], S[:0])


def test_bad_points_name_the_knot():
    t, S = walk(3, 2, 4, 0.3)
    for make in makers(t, S):
        for bad, match in ((np.nan, "not finite"), (S[1, 0, 0] + 1e-3, "not orthonormal")):
            wrong = S.copy()
            wrong[1, 0, 0] = bad
            with pytest.raises(InvalidInputError, match=f"knot 1: S: .*{match}") as caught:
                make(S=wrong)
            assert caught.value.knot == 1
        for wrong in (S[0], S[None], 1.0, S[:, :, :0]):
            with pytest.raises(InvalidInputError, match="shape"):
                make(S=wrong)
    with pytest.raises(InvalidInputError, match="one time for each"):
        CubicSpline(t, S[:3])


def test_numbers_among_objects_are_told_how_to_convert():
    t, S = walk(3, 2, 4, 0.3)
    with pytest.raises(TypeError, match=r"t: .* dtype object; .*astype\(float\)"):
        CubicSpline(t.astype(object), S)
    with pytest.raises(TypeError, match=r"S: .* dtype object; .*astype\(float\)"):
        CubicSpline(t, S.astype(object))


def test_bad_velocities_name_the_knot():
    t, S = walk(3, 2, 4, 0.3)
    V = velocities(S)
    for kind in ("riemannian", "geometric"):
        wrong = V.copy()
        wrong[3] += S[3]
        with pytest.raises(InvalidInputError, match="knot 3: V: not tangent") as caught:
            CubicHermite(t, S, wrong, kind)
        assert caught.value.knot == 3
        wrong[3] = np.nan
        with pytest.raises(InvalidInputError, match=r"knot 3: V: .*not finite"):
            CubicHermite(t, S, wrong, kind)
        for wrong in (V[:3], V[0], V[..., :1]):
            with pytest.raises(InvalidInputError, match="V: expected"):
                CubicHermite(t, S, wrong, kind)
    fast = V.copy()
    fast[2] *= 60
    with pytest.raises(
        InvalidInputError, match=r"knot 2: V, times the length of its leg: must be short enough"
    ) as caught:
        CubicHermite(t, S, fast, "geometric")
    assert caught.value.knot == 2


def test_points_that_cannot_be_joined_are_a_pair():
    t, S = walk(3, 1, 4, 0.3)
    S[2:] = -S[1:3]
    spline, *hermite = makers(t, S)
    with pytest.raises(OutsideDomainError, match=r"knots 1 and 2: .*pi") as caught:
        spline()
    assert caught.value.knot == 1
    assert abs(caught.value.angle - np.pi) < 1e-12
    again = pickle.loads(pickle.dumps(caught.value))
    assert (again.knot, again.angle) == (1, caught.value.angle)
    # Velocities say which way to go.
    for make in hermite:
        assert np.abs(make()(t) - S).max() < MET
    t, S = walk(3, 3, 4, 0.3)
    S[3] *= -1
    for make in makers(t, S):
        with pytest.raises(OutsideDomainError, match=r"knots 2 and 3: .*different components of O\(3\)") as caught:
            make()
        assert caught.value.knot == 2
        assert caught.value.angle == np.pi


def test_bad_ends():
    t, S = walk(3, 2, 4, 0.3)
    V = velocities(S)
    for word in ("not-a-knot", "", "Natural"):
        with pytest.raises(InvalidInputError, match="bc_type: expected 'natural', 'clamped', 'periodic' or a pair"):
            CubicSpline(t, S, word)
    for bad in (None, 1, object()):
        with pytest.raises(TypeError, match="bc_type: expected a pair"):
            CubicSpline(t, S, bad)
    for bad, match in (
        (("natural",), "1 items"),
        (("natural",) * 3, "3 items"),
        (("natural", "periodic"), "found 'periodic'"),
        (((1,), "natural"), "1 items"),
        (((1, V[0], V[0]), "natural"), "3 items"),
        (((0, V[0]), "natural"), r"must be 1 \(velocity\) or 2 \(covariant acceleration\), found 0"),
        (((3, V[0]), "natural"), "found 3"),
        (((1, V[0, 0]), "natural"), r"bc_type: expected shape \(n, k\)"),
        (((1, V[0, :2]), "natural"), "bc_type: expected shape"),
    ):
        with pytest.raises(InvalidInputError, match=match):
            CubicSpline(t, S, bad)
    for bad in ((None, "natural"), ((1, "word"), "natural"), ((1.5, V[0]), "natural"), ((1, 1j * V[0]), "natural")):
        with pytest.raises(TypeError):
            CubicSpline(t, S, bad)
    with pytest.raises(InvalidInputError, match="knot 3: bc_type: not tangent") as caught:
        CubicSpline(t, S, ((1, V[0]), (2, S[3])))
    assert caught.value.knot == 3
    with pytest.raises(InvalidInputError, match="knot 3: S: must be the first point again") as caught:
        CubicSpline(t, S, "periodic")
    assert caught.value.knot == 3


def test_other_bad_arguments():
    t, S = walk(3, 2, 4, 0.9)
    for tol in (0.0, -1.0, np.nan, 1.0):
        with pytest.raises(InvalidInputError, match="tol: must be between"):
            CubicSpline(t, S, tol=tol)
    with pytest.raises(InvalidInputError, match="max_iterations"):
        CubicSpline(t, S, max_iterations=0)
    with pytest.raises(InvalidInputError, match="kind: expected"):
        CubicSpline(t, S, kind="cubic")
    with pytest.raises(InvalidInputError, match="kind: expected 'riemannian' or 'geometric', found \"cubic\""):
        CubicHermite(t, S, velocities(S), "cubic")
    with pytest.raises(InvalidInputError, match="num_threads"):
        CubicSpline(t, S, num_threads=0)
    with pytest.raises(ConvergenceError) as caught:
        CubicSpline(t, S, max_iterations=1)
    assert caught.value.report.iterations == 1
    assert caught.value.knot is None
    with pytest.raises(TypeError):
        PiecewiseCurve(t, S)


class ArrayLike:
    """What pandas's objects are to NumPy."""

    def __init__(self, values):
        self.values = values

    def __array__(self, dtype=None, copy=None):
        return np.asarray(self.values, dtype)


def test_numbers_of_any_kind_are_times():
    S = walk(3, 2, 4)[1]
    exact = CubicSpline([0.0, 1.0, 2.0, 5.0], S)
    whole = np.array([0, 1, 2, 5])
    for t in (
        whole,
        whole.astype("u1"),
        whole.astype(">i4"),
        whole.astype("f4"),
        [0, 1, 2, 5],
        (0, 1.0, 2, np.float32(5)),
        ArrayLike(whole),
        ArrayLike(whole * 1.0),
    ):
        curve = CubicSpline(t, S)
        assert curve.t.dtype == np.float64
        assert np.array_equal(curve([0, 1.5, 5]), exact([0, 1.5, 5]))
    for bad in (whole + 0j, whole.astype(str), whole.astype(object), None, "text"):
        with pytest.raises(TypeError):
            CubicSpline(bad, S)
    stamps = 1_700_000_000_000_000_001 + 1_000_000_000 * whole
    for t in (stamps, stamps.astype("u8"), stamps.tolist()):
        with pytest.raises(InvalidInputError, match=r"t: entry 0, 1700000000000000001, .*t - t\[0\]") as caught:
            CubicSpline(t, S)
        assert caught.value.knot == 0
    assert np.array_equal(CubicSpline(256 * (stamps // 256), S).t, 256.0 * (stamps // 256))


def test_dates_say_how_to_convert_them():
    S = walk(3, 2, 4)[1]
    dates = np.array(["2024-04-19", "2024-04-20", "2024-04-21", "2024-04-24"], "M8[ns]")
    times = [datetime.datetime(2024, 4, day, tzinfo=datetime.timezone.utc) for day in (19, 20, 21, 24)]
    durations = dates - dates[0]
    advice = {
        "(t - t[0]) / np.timedelta64(1, 's')": [dates, ArrayLike(dates), dates.astype("M8[D]"), list(dates)],
        "[(time - t[0]).total_seconds() for time in t]": [times, [time.date() for time in times]],
        "t / np.timedelta64(1, 's')": [durations, ArrayLike(durations)],
        "[time.total_seconds() for time in t]": [ArrayLike(np.array([t - times[0] for t in times], object))],
    }
    converted = []
    for words, ways in advice.items():
        for t in ways:
            with pytest.raises(TypeError, match=r"t: (datetimes|durations) are not numbers; give seconds: ") as caught:
                CubicSpline(t, S)
            assert str(caught.value).endswith(words)
            if not isinstance(t, ArrayLike):
                # What the message advises can be run.
                converted.append(eval(words, {"np": np, "t": np.asarray(t) if "np." in words else t}))
    for seconds in converted:
        assert np.array_equal(CubicSpline(seconds, S).t, 86400.0 * np.array([0, 1, 2, 5]))


def test_pandas():
    pandas = pytest.importorskip("pandas", reason="times in pandas' types; in the extra [test]")
    S = walk(3, 2, 4)[1]
    seconds = pandas.Series([0.0, 1.0, 2.0, 5.0], index=[3, 1, 2, 0])
    for t in (seconds, pandas.Index(seconds), seconds.astype("Int64").astype(float)):
        assert np.array_equal(CubicSpline(t, S).t, [0, 1, 2, 5])
    dates = pandas.date_range("2024-04-19", periods=4, tz="UTC")
    for t in (dates, dates.tz_localize(None), pandas.Series(dates), dates - dates[0], list(dates)):
        with pytest.raises(TypeError, match="are not numbers; give seconds"):
            CubicSpline(t, S)


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
    # Both look for the lowest of a flat score.
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
    # A weight for each of repeated data counts as often.
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
        with pytest.raises(InvalidInputError, match="lam: must be zero or more, or infinite"):
            SmoothingSpline(t, S, lam=lam)
    for weights, match in (
        (np.ones(4), "weights: expected shape one for each of the 5 points"),
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
    # Many are shared out among threads, few are not.
    t = np.linspace(*curve.t_span, 20_001)
    for many, one in ((curve(t), curve), (curve.acceleration(t), curve.acceleration)):
        assert np.array_equal(many[::500], one(t[::500]))
        assert np.array_equal(many[7777], one(t[7777]))


@pytest.mark.parametrize("tol", [1e-12, 1e-9])
def test_failures_say_the_tolerance_that_was_asked_for(tol):
    # Far knots at times that differ by orders of magnitude: given up on the way along easier splines.
    rng = np.random.default_rng(0)
    S, t = Stiefel(3, 1).project(rng.standard_normal((6, 3, 1))), np.cumsum(10 ** rng.uniform(-2, 0, 6))
    with pytest.raises(ConvergenceError) as caught:
        CubicSpline(t, S, tol=tol, max_iterations=60)
    report = caught.value.report
    assert report.tolerance == tol
    assert report.residual > tol
