"""Splines of rotations from invalid input, with one error at a time: typed errors that name the knot."""

import datetime
import pickle
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rotation_problems import about, product, wander
from scipy.spatial.transform import Rotation

from stiefel_rs import (
    ConvergenceError,
    CubicSpline,
    Grassmann,
    InvalidInputError,
    OutsideDomainError,
    QuasiGeodesic,
    RotationSpline,
    load,
)
from stiefel_rs.rotation_input import matrices_of

MAKERS = {
    "spline": RotationSpline,
    "smoothing": lambda t, q: RotationSpline.smoothing(t, q, lam=0.1),
    "hermite": lambda t, q: RotationSpline.hermite(t, q, np.zeros((4, 3))),
}


@pytest.fixture(params=MAKERS)
def make(request):
    return MAKERS[request.param]


@pytest.fixture
def data():
    return wander(4)


def refuse(match, call, *arguments, knot=None, **options):
    with pytest.raises(InvalidInputError, match=match) as caught:
        call(*arguments, **options)
    assert isinstance(caught.value, ValueError)
    assert caught.value.knot == knot


def test_bad_times(make, data):
    t, q = data
    for bad in (np.nan, np.inf):
        refuse("t: entry 2 is not finite", make, [*t[:2], bad, t[3]], q, knot=2)
    refuse("knot 2: t: must", make, [*t[:2], t[0], t[3]], q, knot=2)
    for wrong in (t[:3], np.append(t, 9), []):
        refuse("one time for each of the 4 points", make, wrong, q)
    for wrong in (t[None], 1.0):
        refuse(r"t: expected shape \(N,\)", make, wrong, q)
    with pytest.raises(TypeError, match="t: "):
        make([datetime.datetime(2024, 1, i) for i in range(1, 5)], q)
    with pytest.raises(TypeError, match="t: "):
        make(t + 0j, q)


def test_times_must_differ_to_interpolate(data):
    t, q = data
    refuse("knot 2: t: must be greater", RotationSpline, [*t[:2], t[1], t[3]], q, knot=2)


def test_bad_shapes(make, data):
    t, q = data
    for wrong in (q[0], q[:, :3], matrices_of(q)[0], matrices_of(q)[:, :2], 1.0, np.zeros((4, 3, 4))[..., :2]):
        refuse("rotations: expected a Rotation, quaternions", make, t, wrong)
    refuse("rotations: ", make, t, [[0, 0, 0, 1], [0, 0, 1]])


def test_too_few():
    refuse("N >= 2", RotationSpline, [0.0], [[0, 0, 0, 1]])
    refuse("N >= 2", RotationSpline, [], np.zeros((0, 4)))


def test_bad_quaternions(make, data):
    t, q = data
    for bad in (np.nan, -np.inf):
        wrong = q.copy()
        wrong[2, 1] = bad
        refuse("knot 2: rotations: not finite", make, t, wrong, knot=2)
    wrong[2] = 0
    refuse("knot 2: rotations: a quaternion of length zero", make, t, wrong, knot=2)
    refuse(r"knot 2: .*length zero \(batch member 1\)", make, t, np.stack([q, wrong]), knot=2)
    refuse("rotations: 1 of 16 entries is masked", make, t, np.ma.masked_equal(q, q[1, 1]))


def test_bad_matrices(make, data):
    t, R = data[0], matrices_of(data[1])
    wrong = R.copy()
    wrong[1, 0] *= 1 + 1e-8
    refuse(r"knot 1: .*not orthonormal, by [12](\.\d+)?e-08 \(tolerance 1e-09", make, t, wrong, knot=1)
    make(t, wrong.astype(np.float32))
    wrong[1, 0] *= 1 + 1e-4
    refuse(r"knot 1: .*not orthonormal, by .*tolerance 1e-05", make, t, wrong.astype(np.float32), knot=1)
    wrong[1] *= 1e200
    refuse("knot 1: .*not orthonormal, by (inf|nan)", make, t, wrong, knot=1)
    wrong[1, 0, 0] = np.nan
    refuse("knot 1: rotations: not finite", make, t, wrong, knot=1)
    mirrored = R.copy()
    mirrored[3] = -mirrored[3]
    refuse("knot 3: .*reflection, its determinant is -1", make, t, mirrored, knot=3)
    refuse("knot 3: .*reflection", RotationSpline, t, mirrored, project=True, knot=3)


def test_matrices_are_projected_on_request(data):
    t, R = data[0], matrices_of(data[1])
    rough = np.round(R, 3)
    refuse("project=True uses the nearest", RotationSpline, t, rough, knot=1)
    U, _, Vt = np.linalg.svd(rough)
    for spline in (RotationSpline(t, rough, project=True), RotationSpline.smoothing(t, rough, lam=0, project=True)):
        assert np.abs(spline(t) - U @ Vt).max() < 1e-10


def test_scipys_rotations_have_one_axis(make, data):
    t, q = data
    refuse("found a single one", make, t, Rotation.from_quat(q[0]))
    with pytest.raises(TypeError, match=r"Rotation\.concatenate"):
        make(t, [Rotation.from_quat(each) for each in q])


def test_what_is_no_number(make, data):
    t, q = data
    for wrong in (q + 0j, q.astype(str), q.astype(object)):
        with pytest.raises(TypeError, match="rotations: expected real numbers"):
            make(t, wrong)
    with pytest.raises(TypeError, match=r"rotations: expected a Rotation, quaternions .*, found None"):
        make(t, None)


def test_batches_with_wrong_times(data):
    t, q = data
    batch = np.stack([q, q, q])
    refuse(r"t: expected shape \(4,\) or \(3, 4\), found \(2, 4\)", RotationSpline, np.stack([t, t]), batch)
    refuse("t: .*not finite", RotationSpline, np.stack([t, t * [1, np.nan, 1, 1], t]), batch, knot=1)
    whole = np.arange(4) + np.array([[0], [2**60], [0]])
    refuse("t: .*not exactly a float", RotationSpline, whole, batch, knot=1)
    refuse("t: 3 of 12 entries are masked", RotationSpline, np.ma.masked_equal(np.stack([t] * 3), t[1]), batch)


@pytest.mark.parametrize(
    ("bc_type", "match"),
    [
        ("not-a-knot", "expected 'natural', 'clamped', 'periodic' or a pair, found 'not-a-knot'"),
        (("natural", "periodic"), "or a pair for one end, found 'periodic'"),
        (("natural",), "two end conditions.*1 items"),
        (("natural", (3, np.zeros(3))), "must be 1 .* or 2 .*, found 3"),
        (("natural", (1,)), "an order and a vector.*1 items"),
        (("natural", (1, np.zeros(4))), r"shape \(3,\), found \(4,\)"),
        (((1, [0, np.nan, 0]), "natural"), "bc_type: entry 1 is not finite"),
    ],
)
def test_bad_end_conditions(bc_type, match, data):
    refuse(match, RotationSpline, *data, bc_type)


@pytest.mark.parametrize("bc_type", [1, None, ("natural", 2), ("natural", (1.5, np.zeros(3)))])
def test_end_conditions_of_another_type(bc_type, data):
    with pytest.raises(TypeError):
        RotationSpline(*data, bc_type)


def test_end_conditions_without_order_or_values(data):
    ends = {"natural": 1, "clamped": 2}
    for wrong in (ends, set(ends), ends.keys(), ("natural", {1: 0, 2: 0})):
        with pytest.raises(TypeError, match="bc_type: expected a pair"):
            RotationSpline(*data, wrong)


def test_orders_of_end_conditions_are_whole_numbers(data):
    w = np.array([0.1, -0.2, 0.3])
    expected = RotationSpline(*data, ((1, w), (2, w)))
    for one, two in ((1.0, 2.0), (np.float32(1), np.int8(2))):
        found = RotationSpline(*data, ((one, w), (two, w)))
        assert np.array_equal(found(data[0], 1), expected(data[0], 1))
        assert [type(order) for order, _ in found.bc_type] == [int, int]
    for wrong in (1.5, np.nan, "1", None, 1j):
        with pytest.raises(TypeError, match="bc_type: the order of an end condition must be 1 or 2, found"):
            RotationSpline(*data, ((wrong, w), "natural"))
    refuse("must be 1 .* or 2 .*, found 3", RotationSpline, *data, ((3.0, w), "natural"))


def test_truth_values_and_words(make, data):
    t, q = data
    hermite = partial(RotationSpline.hermite, rates=np.zeros((4, 3)))
    for project in ("yes", 1, None):
        for call in (RotationSpline, RotationSpline.smoothing, hermite):
            with pytest.raises(TypeError, match="project: expected True or False"):
                call(t, q, project=project)
    spline = make(t, q)
    for frame in (np.array(["world", "body"]), ["world"], None, 1):
        refuse("frame: expected 'body' or 'world', found", spline.angular_velocity, 0.5, frame)
    refuse("kind: expected one of", RotationSpline.from_curve, spline.curve, kind=np.array(["quaternions", "matrices"]))


def test_batches_without_members_have_no_problem_to_solve():
    fast = ((1, [1e3, 0.0, 0.0]), "natural")
    assert RotationSpline(np.arange(5.0), np.zeros((0, 5, 4)), fast)(0.5).shape == (0, 4)


def test_batches_without_members_are_checked(data):
    t, empty, rates = data[0], np.zeros((0, 4, 4)), np.zeros((0, 4, 3))
    makers = (
        lambda t, **options: RotationSpline(t, empty, **options),
        lambda t, **options: RotationSpline.smoothing(t, empty, **options),
        lambda t, **options: RotationSpline.hermite(t, empty, rates, **options),
    )
    for make in makers:
        assert make(t).t.shape == make(np.zeros((0, 4))).t.shape == (0, 4)
        refuse("knot 1: t: must be", make, t[::-1], knot=1)
        refuse("knot 2: t: entry 2 is not finite", make, [0, 1, np.nan, 3], knot=2)
        refuse("one time for each of the 4 points, found \\(3,\\)", make, t[:3])
        refuse(r"t: expected shape \(4,\) or \(0, 4\), found \(1, 4\)", make, t[None])
        refuse("num_threads", make, t, num_threads=0)
        with pytest.raises(TypeError, match="t: datetimes are not numbers"):
            make(np.datetime64("2024-01-01") + np.arange(4))
        for wrong in (["a", "b", "c", "d"], np.zeros((0, 4), dtype="M8[s]"), np.zeros((0, 4), dtype=str)):
            with pytest.raises(TypeError, match="t: expected real numbers"):
                make(wrong)
    plain, smoothing, hermite = makers
    # Rates that no spline through equal rotations needs to have.
    fast = ((1, np.array([1e3, 0, 0])), "natural")
    assert plain(t, bc_type=fast, tension=1.0).bc_type[0][0] == 1
    for options in ({"tension": -1.0}, {"tol": -1.0}, {"max_iterations": 0}):
        refuse(next(iter(options)), plain, t, **options)
    refuse("lam: must be at least 0", smoothing, t, lam=-1)
    refuse("knot 1: weights: must be positive", smoothing, t, weights=[1, 0, 1, 1], knot=1)
    refuse("frame: expected", hermite, t, frame="spatial")


def test_members_with_different_numbers_of_knots(data):
    t, q = data
    spline = RotationSpline.smoothing([t, [t[0], t[1], t[1], t[3]]], np.stack([q, q]), lam=0.1)
    assert [len(curve.t) for curve in spline.curve] == [4, 3]
    assert spline([1.0, 2.0]).shape == (2, 2, 4)
    for name in ("t", "times", "rotations"):
        refuse("t: the members of this batch have different numbers of knots", getattr, spline, name)


def test_periodic_ends_must_close(data):
    t, q = data
    refuse("knot 3: .*periodic", RotationSpline, t, q, "periodic", knot=3)
    closed = np.concatenate([q[:3], -q[:1]])
    assert RotationSpline(t, closed, "periodic").bc_type == "periodic"


def test_half_turns_name_the_pair():
    t = np.arange(4.0)
    q = np.array([[0, 0, 0, 1], [0, 0, 0.1, 1], [0, 0, -1, 0.1], [0, 0, -1, 0.2]])
    for data in (q, Rotation.from_quat(q), matrices_of(q / np.linalg.norm(q, axis=-1, keepdims=True))):
        with pytest.raises(OutsideDomainError, match="knots 1 and 2: ") as caught:
            RotationSpline(t, data)
        again = pickle.loads(pickle.dumps(caught.value))
        for error in (caught.value, again):
            assert error.knot == 1
            assert abs(error.angle - np.pi) < 1e-12
    # Given rates determine the direction of rotation.
    RotationSpline.hermite(t, q, np.full((4, 3), [0, 0, 1.0]))


def test_bad_rates(data):
    t, q = data
    refuse(r"rates: expected shape \(4, 3\), found \(3, 3\)", RotationSpline.hermite, t, q, np.zeros((3, 3)))
    rates = np.zeros((4, 3))
    rates[3, 1] = np.inf
    refuse("knot 3: rates: not finite", RotationSpline.hermite, t, q, rates, knot=3)
    refuse("frame: expected 'body' or 'world'", RotationSpline.hermite, t, q, np.zeros((4, 3)), frame="spatial")


def test_bad_smoothing(data):
    for lam in (-1.0, np.nan):
        refuse("lam", RotationSpline.smoothing, *data, lam=lam)
    for weights in ([1, 1, 0, 1], [1, 1, -1, 1], [1, 1, 1]):
        with pytest.raises(InvalidInputError, match="weights"):
            RotationSpline.smoothing(*data, weights=weights)


def test_bad_evaluation(data):
    spline = RotationSpline(*data)
    for order in (-1, 4, 1.5, "1", None):
        refuse("order: must be 0, 1, 2 or 3", spline, 0.5, order)
    refuse("t: entry 1 is not finite", spline, [0.5, np.nan])
    refuse("t: entry 0 is not finite", spline, np.inf, 1)
    for wrong in (1j, "1", None, datetime.datetime(2024, 1, 1)):
        with pytest.raises(TypeError, match="t: expected real numbers"):
            spline(wrong)
    for method in (spline.angular_velocity, spline.angular_acceleration, spline.angular_jerk):
        refuse("frame: expected 'body' or 'world', found 'inertial'", method, 0.5, frame="inertial")
    scipy = RotationSpline(data[0], Rotation.from_quat(data[1]))
    refuse(r"at most one axis of times, found shape \(2, 2\)", scipy, np.zeros((2, 2)))
    assert scipy.angular_velocity(np.zeros((2, 2))).shape == (2, 2, 3)


def test_bad_curves(data):
    t, q = data
    with pytest.raises(InvalidInputError, match="kind: expected one of"):
        RotationSpline.from_curve(CubicSpline(t, matrices_of(q)), kind="euler")
    reflected = matrices_of(q) * [1, 1, -1]
    for curve in (CubicSpline(t, reflected), CubicSpline(t, matrices_of(q)[..., :2])):
        with pytest.raises(InvalidInputError):
            RotationSpline.from_curve(curve)
    with pytest.raises((InvalidInputError, TypeError, AttributeError)):
        RotationSpline.from_curve(QuasiGeodesic(matrices_of(q)[0], matrices_of(q)[1]))


VECTORS = st.lists(st.floats(-1.5, 1.5), min_size=3, max_size=3).map(np.array)


@given(st.lists(VECTORS, min_size=1, max_size=5), st.lists(st.floats(0.1, 10), min_size=6, max_size=6), st.booleans())
def test_any_rotations_are_interpolated(turns, steps, clamped):
    q = [np.array([0.0, 0, 0, 1])]
    for w in turns:
        q.append(product(q[-1], about(0.6 * w)))
    # Next to fast rotations, a long interval would have to spin.
    steps = np.clip(steps, 0.7, 1.4)
    t, q = np.cumsum(steps[: len(q)]), np.array(q)
    spline = RotationSpline(t, q, "clamped" if clamped else "natural")
    assert np.abs(matrices_of(spline(t)) - matrices_of(q / np.linalg.norm(q, axis=-1, keepdims=True))).max() < 1e-11
    dense = spline(np.linspace(t[0], t[-1], 500))
    assert np.abs(np.linalg.norm(dense, axis=-1) - 1).max() < 1e-14
    assert np.sum(dense[1:] * dense[:-1], axis=-1).min() > 0


def test_keywords_of_scipy(data):
    t, q = data
    spline = RotationSpline(times=t, rotations=Rotation.from_quat(q))
    assert np.array_equal(spline(times=t[1], order=1), spline(t[1], 1))
    with pytest.raises(TypeError, match="pass either t or times"):
        RotationSpline(t, q, times=t)
    with pytest.raises(TypeError, match="pass either t or times"):
        spline(0.5, times=0.5)


def test_times_of_batches_are_not_cut_up(data):
    _, q = data
    refuse("one time for each of the 4 points, found \\(8,\\)", RotationSpline, np.arange(8.0), np.stack([q, q]))
    refuse("N >= 2", RotationSpline, [], np.zeros((3, 0, 4)))
    refuse("N >= 2", RotationSpline, [0.0], np.ones((3, 1, 4)))


def test_lists_in_single_precision_count_as_such(data):
    t, q = data
    matrices = list(Rotation.from_quat(q).as_matrix().astype(np.float32))
    assert RotationSpline(t, matrices)(t).shape == (4, 3, 3)


def test_curves_of_subspaces_are_no_rotations():
    turns = CubicSpline(
        [0.0, 1.0], [np.eye(3), Rotation.from_rotvec([0, 0, 1.0]).as_matrix()], manifold=Grassmann(3, 3)
    )
    with pytest.raises(InvalidInputError, match=r"curve: expected a curve on St\(3, 3\)"):
        RotationSpline.from_curve(turns)


def test_lengths_end_where_times_do(data):
    spline = RotationSpline(*data, extrapolate=False)
    assert spline.arc_length(data[0][0], data[0][-1]) == spline.arc_length()
    with pytest.raises(InvalidInputError, match="must be between the first and the last knot"):
        spline.arc_length(data[0][0] - 1)
    t, quaternions = data
    rates = np.zeros((4, 3))
    for wrong in ("periodic", None, 1.0):
        # Refused before anything is solved: times that decrease are an InvalidInputError.
        for make in (RotationSpline, RotationSpline.smoothing, lambda *d, **o: RotationSpline.hermite(*d, rates, **o)):
            with pytest.raises(TypeError, match="extrapolate: expected True or False"):
                make(-t, quaternions, extrapolate=wrong)
    with pytest.raises(TypeError, match="extrapolate: expected True or False"):
        spline(0.5, extrapolate="periodic")


@pytest.mark.parametrize("extrapolate", [False, True])
def test_curves_end_where_their_splines_do(extrapolate, data, tmp_path):
    t, quaternions = data
    batch = np.array([quaternions, quaternions[::-1]])
    splines = [
        RotationSpline(t, quaternions, extrapolate=extrapolate),
        RotationSpline.smoothing(t, quaternions, lam=0.1, extrapolate=extrapolate),
        RotationSpline.hermite(t, quaternions, np.zeros((4, 3)), extrapolate=extrapolate),
    ]
    curves = [spline.curve for spline in splines]
    curves += [pickle.loads(pickle.dumps(spline)).curve for spline in splines]
    curves += list(RotationSpline(t, batch, extrapolate=extrapolate).curve)
    for curve in curves:
        assert curve.extrapolate == extrapolate
        curve.save(tmp_path / "curve.npz")
        again = RotationSpline.from_curve(load(tmp_path / "curve.npz"))
        assert again.extrapolate == extrapolate
        other = RotationSpline.from_curve(curve, extrapolate=not extrapolate)
        assert other.extrapolate == other.curve.extrapolate == (not extrapolate)
        assert np.array_equal(other(t), again(t))
        assert repr(other.curve.report) == repr(curve.report)
    beyond = splines[0](t[-1] + 0.5, extrapolate=True)
    assert np.array_equal(beyond, RotationSpline(t, quaternions)(t[-1] + 0.5))


def test_errors_of_batches_name_the_member(data):
    t, quaternions = data
    times = np.array([t, t, t])
    times[1, 2] = times[1, 1] - 1
    batch = np.array([quaternions] * 3)
    for name, make in MAKERS.items():
        rates = np.zeros((3, 4, 3))
        call = (lambda t, q: RotationSpline.hermite(t, q, rates)) if name == "hermite" else make  # noqa: B023
        refuse(r"\(batch member 1\)", call, times, batch, knot=2)


def test_a_spline_that_is_not_found_names_the_interval():
    vectors = [[0, 0, 0], [2, 0, 0], [0, 2, 0.5], [1, -1, 2]]
    rotations = Rotation.from_rotvec(np.array(vectors, dtype=float))
    match = r"^knots 1 and 2: .*no convergence.*1000\.0 times as long as .*: add points within it"
    with pytest.raises(ConvergenceError, match=match) as caught:
        RotationSpline([0.0, 1.0, 1001.0, 1002.0], rotations)
    assert caught.value.knot == 1
    assert not caught.value.report.converged


def test_limits_set_by_the_times_of_a_member_name_it(data):
    t, quaternions = data
    batch = np.array([quaternions] * 2)
    refuse(r"tension: .*\(batch member 1\)", RotationSpline, np.array([t / 100, t]), batch, tension=1e3)
    with pytest.raises(InvalidInputError) as caught:
        RotationSpline(t, batch, tension=1e3)
    assert "member" not in str(caught.value)


def test_errors_of_shared_arguments_name_no_member(data):
    t, quaternions = data
    batch, rates = np.array([quaternions] * 3), np.zeros((3, 4, 3))
    for make in (
        lambda: RotationSpline(t, batch, tol=-1.0),
        lambda: RotationSpline(t, batch, tension=-1.0),
        lambda: RotationSpline.smoothing(t, batch, lam=-1.0),
        lambda: RotationSpline.smoothing(t, batch, lam=1.0, tol=-1.0),
        lambda: RotationSpline.smoothing(t, batch, weights=[1.0, 1, 1, -1]),
        lambda: RotationSpline.smoothing(t[::-1], batch),
        lambda: RotationSpline.hermite(t, batch, rates, num_threads=0),
        lambda: RotationSpline.hermite(t[::-1], batch, rates),
    ):
        with pytest.raises(InvalidInputError) as caught:
            make()
        assert "member" not in str(caught.value)
