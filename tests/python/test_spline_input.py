"""Splines from invalid times, points, velocities and ends: errors that name the knot; numbers of any kind."""

import datetime
import pickle

import numpy as np
import pytest
from spline_problems import MET, velocities, walk

from stiefel_rs import (
    ConvergenceError,
    CubicHermite,
    CubicSpline,
    InvalidInputError,
    OutsideDomainError,
    PiecewiseCurve,
)


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
    with pytest.raises(InvalidInputError, match="N >= 2"):
        CubicSpline(t[:1], S[:1])
    with pytest.raises(InvalidInputError, match="N >= 2"):
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
        InvalidInputError, match=r"knot 2: V, times the duration of its piece: must be short enough"
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
    # Given velocities determine the direction.
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
    for bad in (
        (None, "natural"),
        ((1, "word"), "natural"),
        ((1.5, V[0]), "natural"),
        ((1, V[0].astype(str)), "natural"),
    ):
        with pytest.raises(TypeError):
            CubicSpline(t, S, bad)
    with pytest.raises(InvalidInputError, match="knot 3: bc_type: not tangent") as caught:
        CubicSpline(t, S, ((1, V[0]), (2, S[3])))
    assert caught.value.knot == 3
    with pytest.raises(InvalidInputError, match="knot 3: S: must be at distance 0 from the first point") as caught:
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
    """The array interface of pandas objects."""

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
            match = r"t: (datetimes|durations) are not numbers; convert them to seconds: "
            with pytest.raises(TypeError, match=match) as caught:
                CubicSpline(t, S)
            assert str(caught.value).endswith(words)
            if not isinstance(t, ArrayLike):
                # The code in the message's advice runs.
                converted.append(eval(words, {"np": np, "t": np.asarray(t) if "np." in words else t}))
    for seconds in converted:
        assert np.array_equal(CubicSpline(seconds, S).t, 86400.0 * np.array([0, 1, 2, 5]))


def test_pandas():
    pandas = pytest.importorskip("pandas")
    S = walk(3, 2, 4)[1]
    seconds = pandas.Series([0.0, 1.0, 2.0, 5.0], index=[3, 1, 2, 0])
    for t in (seconds, pandas.Index(seconds), seconds.astype("Int64").astype(float)):
        assert np.array_equal(CubicSpline(t, S).t, [0, 1, 2, 5])
    dates = pandas.date_range("2024-04-19", periods=4, tz="UTC")
    for t in (dates, dates.tz_localize(None), pandas.Series(dates), dates - dates[0], list(dates)):
        with pytest.raises(TypeError, match="are not numbers; convert them to seconds"):
            CubicSpline(t, S)
