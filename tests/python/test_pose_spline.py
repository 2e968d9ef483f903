"""Splines of poses: both parts, twists compared with differences of matrices, kinds, smoothing, and bad input."""

import copy
import pickle

import numpy as np
import pytest
from rotation_problems import A, W, inner, product, random_quaternion, same, slope, vee, wander
from scipy.interpolate import BSpline, make_smoothing_spline
from scipy.interpolate import CubicSpline as Flat
from scipy.spatial import transform
from scipy.spatial.transform import Rotation

import stiefel_rs
from stiefel_rs import ConvergenceError, InvalidInputError, OutsideDomainError, PoseSpline, RotationSpline
from stiefel_rs.rotation_input import matrices_of, rotated

MET = 1e-11
# Linear velocities and accelerations, in m/s and m/s^2, to go with A and W.
V, B = np.array([1.0, 2.0, -3.0]), np.array([0.5, -0.1, 4.0])
HAS_RIGID = hasattr(transform, "RigidTransform")


def poses(count=6, seed=0, step=0.8):
    """Times, quaternions and positions."""
    t, q = wander(count, seed, step)
    return t, q, np.cumsum(np.random.default_rng(seed).standard_normal((count, 3)), axis=0)


def homogeneous(q, p):
    """Matrices of poses."""
    T = np.zeros((*np.shape(p)[:-1], 4, 4))
    T[..., :3, :3], T[..., :3, 3], T[..., 3, 3] = matrices_of(q), p, 1
    return T


@pytest.fixture
def curve():
    """A spline of matrices, and times within its pieces."""
    t, q, p = poses()
    return PoseSpline(t, homogeneous(q, p)), inner(t)


# The two parts

ENDS = {
    "natural": ("natural", "natural", "natural"),
    "clamped": ("clamped", "clamped", "clamped"),
    "velocities": (((1, (W, V)), (1, (A, B))), ((1, W), (1, A)), ((1, V), (1, B))),
    "accelerations": (((2, (W, V)), (2, (A, B))), ((2, W), (2, A)), ((2, V), (2, B))),
    "mixed": (((2, np.array([W, V])), "clamped"), ((2, W), "clamped"), ((2, V), "clamped")),
    "words": (("natural", "clamped"), ("natural", "clamped"), ("natural", "clamped")),
}


@pytest.mark.parametrize("ends", ENDS)
def test_poses_are_rotations_and_positions_with_the_same_ends(ends):
    t, q, p = poses()
    both, turning, moving = ENDS[ends]
    spline, at = PoseSpline(t, (q, p), both), np.linspace(t[0] - 0.5, t[-1] + 0.5, 40)
    rotations, positions = RotationSpline(t, q, turning), Flat(t, p, bc_type=moving)
    found = spline(at)
    assert isinstance(found, tuple)
    assert np.array_equal(found[0], rotations(at))
    assert np.array_equal(found[1], positions(at))
    assert np.array_equal(spline.rotation(at), rotations(at))
    assert np.array_equal(spline.position(at), positions(at))
    for order, name in enumerate(["velocity", "acceleration", "jerk"], 1):
        linear, angular = getattr(spline, f"linear_{name}"), getattr(spline, f"angular_{name}")
        assert np.array_equal(linear(at), positions(at, order))
        same(linear(at, "body"), Rotation.from_quat(found[0]).inv().apply(positions(at, order)), 1e-12)
        assert np.array_equal(angular(at), rotations(at, order))
        assert np.array_equal(angular(at, frame="world"), getattr(rotations, f"angular_{name}")(at, "world"))
    assert repr(spline.bc_type) == repr(PoseSpline(t, (q, p), spline.bc_type).bc_type)


def test_ends_are_angular_in_the_body_and_linear_in_the_world():
    t, q, p = poses()
    spline = PoseSpline(t, (q, p), ((1, (W, V)), (2, (A, B))))
    same(spline.angular_velocity(t[0], "body"), W, MET)
    same(spline.linear_velocity(t[0], "world"), V, MET)
    same(spline.angular_acceleration(t[-1], "body"), A, MET)
    same(spline.linear_acceleration(t[-1], "world"), B, MET)


def test_periodic_poses_close():
    t, q, p = poses()
    q[-1], p[-1] = -q[0], p[0] * (1 + 1e-13)
    spline = PoseSpline(t, (q, p), "periodic")
    assert spline.bc_type == "periodic"
    first, last = t[[0, -1]]
    same(spline.twist(first), spline.twist(last), 1e-10)
    same(spline.linear_acceleration(first), spline.linear_acceleration(last), 1e-10)
    same(spline.angular_acceleration(first), spline.angular_acceleration(last), 1e-10)
    # Far from the origin: coordinates of closed curves differ by their round-off, and their size does not hide a gap.
    far = p + 5e6
    far[-1] = far[0] + np.spacing(5e6)
    PoseSpline(t, (q, far), "periodic")
    far[-1, 1] += 1e-3
    refuse("knot 5: positions: .*periodic.* gap of 0.001", PoseSpline, t, (q, far), "periodic", knot=5)
    p[-1, 1] += 1e-3
    refuse("knot 5: positions: .*periodic.* gap of 0.001", PoseSpline, t, (q, p), "periodic", knot=5)


def test_a_screw_has_a_constant_spatial_twist():
    # Constant rate about a vertical axis through (1, 0, 0), rising: positions move around a circle.
    t = np.linspace(0, 2, 201)
    q = np.stack([0 * t, 0 * t, np.sin(t / 2), np.cos(t / 2)], axis=-1)
    p = np.stack([1 - np.cos(t), -np.sin(t), 0.3 * t], axis=-1)
    ends = ((1, ((0, 0, 1), (0, -1, 0.3))), (1, ((0, 0, 1), (np.sin(2), -np.cos(2), 0.3))))
    spline, at = PoseSpline(t, (q, p), ends), np.linspace(0, 2, 37)
    # w x (x - c): the origin of the world moves with -w x c.
    same(spline.twist(at, "world"), np.broadcast_to([0, 0, 1, 0, -1, 0.3], (37, 6)), 1e-6)
    same(spline.twist(at), np.broadcast_to([0, 0, 1, 0, -1, 0.3], (37, 6)), 1e-6)


# Twists and rates against differences


def test_twists_are_those_of_the_matrices(curve):
    spline, at = curve
    T, dT = spline(at), slope(spline, at)
    for frame, X in (("body", np.linalg.solve(T, dT)), ("world", dT @ np.linalg.inv(T))):
        twist = spline.twist(at, frame)
        assert twist.shape == (*at.shape, 6)
        same(twist[:, :3], vee(X[:, :3, :3]), 1e-8)
        same(twist[:, 3:], X[:, :3, 3], 1e-8)
        same(X[:, 3], 0.0, 1e-8)
    assert np.array_equal(spline.twist(at), spline.twist(at, frame="body"))
    same(spline.twist(at)[:, 3:], spline.linear_velocity(at, "body"), 1e-14)
    world = spline.twist(at, "world")
    assert np.array_equal(world[:, :3], spline.angular_velocity(at, "world"))
    same(world[:, 3:] + np.cross(world[:, :3], spline.position(at)), spline.linear_velocity(at), 1e-13)


def test_twists_are_related_by_the_adjoint(curve):
    spline, at = curve
    R, p, body = spline.rotation(at), spline.position(at), spline.twist(at)
    w, v = (np.einsum("tij,tj->ti", R, part) for part in (body[:, :3], body[:, 3:]))
    same(spline.twist(at, "world"), np.concatenate([w, v + np.cross(p, w)], axis=-1), 1e-12)


def test_rates_are_derivatives(curve):
    spline, at = curve
    for lower, higher in (
        (spline.position, spline.linear_velocity),
        (spline.linear_velocity, spline.linear_acceleration),
        (spline.linear_acceleration, spline.linear_jerk),
        (spline.angular_velocity, spline.angular_acceleration),
        (spline.angular_acceleration, spline.angular_jerk),
    ):
        same(higher(at), slope(lower, at), 1e-8)


def test_moving_the_world_moves_the_curve():
    (t, q, p), g, d = poses(), random_quaternion(3), np.array([1.0, -2.0, 3.0])
    spline = PoseSpline(t, (q, p))
    moved, at = PoseSpline(t, (product(g, q), rotated(g, p) + d)), inner(t)
    same(moved.position(at), rotated(g, spline.position(at)) + d, MET)
    same(moved.twist(at), spline.twist(at), 1e-10)


# Kinds


@pytest.mark.skipif(not HAS_RIGID, reason="this SciPy has no RigidTransform")
def test_rigid_transforms_come_out():
    t, q, p = poses()
    given = transform.RigidTransform.from_components(p, Rotation.from_quat(q))
    spline, at = PoseSpline(t, given), inner(t)
    assert spline.kind == "RigidTransform"
    assert isinstance(spline(at), transform.RigidTransform)
    assert spline(at[0]).single
    assert isinstance(spline.rotation(at), Rotation)
    same(spline(at).as_matrix(), PoseSpline(t, homogeneous(q, p))(at), 1e-12)
    same(spline(t).as_matrix(), given.as_matrix(), MET)
    refuse("at most one axis of times", spline, at.reshape(5, -1))
    refuse("poses: expected N poses, found a single pose", PoseSpline, t, given[0])


def test_matrices_and_pairs_come_out():
    t, q, p = poses()
    by_matrix, at = PoseSpline(t, homogeneous(q, p)), np.linspace(*t[[0, -1]], 12).reshape(3, 4)
    assert (by_matrix.kind, by_matrix.rotation_spline.kind) == ("matrices", "matrices")
    assert by_matrix(at).shape == (3, 4, 4, 4)
    assert by_matrix(1.5).shape == (4, 4)
    assert by_matrix.twist(at).shape == (3, 4, 6)
    assert by_matrix.twist(1.5, "world").shape == (6,)
    assert np.array_equal(by_matrix(at)[..., 3, :], np.broadcast_to([0, 0, 0, 1], (3, 4, 4)))
    same(by_matrix(t), homogeneous(q, p), MET)
    for given, kind in ((Rotation.from_quat(q), "Rotation"), (q, "quaternions"), (matrices_of(q), "matrices")):
        spline = PoseSpline(t, (given, p.tolist()))
        rotations, positions = spline(at[0])
        assert (spline.kind, spline.rotation_spline.kind) == ("pair", kind)
        assert isinstance(rotations, type(given))
        same(positions, by_matrix(at[0])[:, :3, 3], MET)
    # Two matrices, in any container, are poses.
    for given in (tuple(homogeneous(q, p)[:2]), list(homogeneous(q, p)[:2])):
        assert PoseSpline(t[:2], given).kind == "matrices"
    single = PoseSpline(t, homogeneous(q, p).astype(np.float32))
    same(single(t), homogeneous(q, p), 1e-5)
    times = t.astype(np.float32)
    assert {found.dtype for found in (single(times), single.twist(times), single.position(times))} == {np.dtype(float)}
    whole = PoseSpline([0, 1], np.stack([np.eye(4, dtype=int)] * 2))
    same(whole(0.5), np.eye(4), 1e-15)


def test_attributes_and_text(curve):
    spline, _ = curve
    t = poses()[0]
    assert np.array_equal(spline.t, t)
    assert spline.t_span == (t[0], t[-1])
    assert spline.extrapolate
    assert spline.lam is None
    assert spline.bc_type == "natural"
    assert isinstance(spline.rotation_spline, RotationSpline)
    assert isinstance(spline.position_spline, Flat)
    assert repr(spline).startswith("<PoseSpline of matrices, CubicSpline on St(3, 3) and R^3, 6 knots, t_span (0.79971")


def test_pickles_and_copies():
    t, q, p = poses()
    for spline in (
        PoseSpline(t, homogeneous(q, p), "clamped", extrapolate=False),
        PoseSpline(t, (Rotation.from_quat(q), p), ((1, (W, V)), "natural")),
        PoseSpline.smoothing(t, homogeneous(q, p), lam=0.1),
    ):
        at = np.linspace(*t[[0, -1]], 20)
        for again in (pickle.loads(pickle.dumps(spline)), copy.deepcopy(spline)):
            assert np.array_equal(again.twist(at), spline.twist(at))
            assert np.array_equal(again.position(at), spline.position(at))
            assert (repr(again), repr(again.bc_type), again.lam) == (repr(spline), repr(spline.bc_type), spline.lam)


# Beyond the ends


def test_without_extrapolation_all_parts_refuse():
    t, q, p = poses()
    spline = PoseSpline(t, (q, p), extrapolate=False)
    just = t[-1] + 4 * np.spacing(t[-1])
    assert np.array_equal(spline.position(just), spline.position(t[-1]))
    assert np.array_equal(spline.twist(just), spline.twist(t[-1]))
    for method in (spline, spline.position, spline.rotation, spline.linear_velocity, spline.angular_jerk, spline.twist):
        refuse("t: must be between the first and the last knot", method, t[-1] + 1e-9)
        refuse("t: must be between", method, [t[0], t[0] - 1])


# Smoothing


def test_smoothing_without_weight_interpolates():
    t, q, p = poses(8, step=0.3)
    near, through, at = PoseSpline.smoothing(t, (q, p), lam=0), PoseSpline(t, (q, p)), inner(t)
    same(near.position(at), through.position(at), 1e-9)
    same(matrices_of(near.rotation(at)), matrices_of(through.rotation(at)), 1e-9)
    assert near.lam == (0, 0)
    assert near.bc_type is None


def test_smoothing_is_that_of_the_parts():
    t, q, p = poses(12, step=0.3)
    weights, at = np.linspace(1, 2, 12), inner(t)
    spline = PoseSpline.smoothing(t, (q, p), lam=(0.3, 0.02), weights=weights)
    assert spline.lam == (0.3, 0.02)
    assert isinstance(spline.position_spline, BSpline)
    rotations = RotationSpline.smoothing(t, q, lam=0.3, weights=weights)
    assert np.array_equal(spline.rotation(at), rotations(at))
    for i in range(3):
        expected = make_smoothing_spline(t, p[:, i], w=weights, lam=0.02)
        same(spline.position(at)[:, i], expected(at), 1e-12)
        same(spline.linear_acceleration(at)[:, i], expected(at, 2), 1e-10)


def test_smoothing_by_cross_validation_removes_noise():
    t, rng = np.linspace(0, 3, 60), np.random.default_rng(1)
    q = np.stack([0 * t, 0 * t, np.sin(t / 2), np.cos(t / 2)], axis=-1) + 0.01 * rng.standard_normal((60, 4))
    p = np.stack([np.sin(t), np.cos(t), t], axis=-1)
    spline = PoseSpline.smoothing(t, (q, p + 0.01 * rng.standard_normal((60, 3))))
    assert spline.lam[0] > 0
    assert spline.lam[1] is None
    assert np.sqrt(np.mean((spline.position(t) - p) ** 2)) < 0.006
    same(spline.angular_velocity(t[10:-10]), np.broadcast_to([0, 0, 1.0], (40, 3)), 0.15)


def test_cross_validation_does_not_depend_on_units():
    rng, t = np.random.default_rng(5), np.linspace(0, 10, 60)
    q, p = np.tile([0, 0, 0, 1.0], (60, 1)), np.stack([np.sin(t), np.cos(t), 0.1 * t], axis=1)
    noisy, weights = p + 0.02 * rng.standard_normal(p.shape), rng.uniform(0.5, 2, 60)
    expected = PoseSpline.smoothing(t, (q, noisy), lam=(1, None), weights=weights).position(t)
    assert np.sqrt(np.mean((expected - p) ** 2)) < 0.012
    for unit in (1e-100, 1e-6, 1e-2, 60.0, 1e6):
        found = PoseSpline.smoothing(unit * t, (q, noisy), lam=(unit**3, None), weights=weights).position(unit * t)
        same(found, expected, 1e-9)
    for size in (1e-300, 1e-9, 1e9, 1e300):
        same(PoseSpline.smoothing(t, (q, noisy), lam=(size, None), weights=size * weights).position(t), expected, 1e-9)


# Bad input


def refuse(match, call, *arguments, knot=None, **options):
    with pytest.raises(InvalidInputError, match=match) as caught:
        call(*arguments, **options)
    assert caught.value.knot == knot


@pytest.mark.parametrize("make", [PoseSpline, PoseSpline.smoothing])
def test_bad_poses(make):
    t, q, p = poses()
    T = homogeneous(q, p)
    for wrong in (T[0], T[None], T[:, :3], p, 1.0):
        refuse(r"poses: expected a RigidTransform, matrices \(N, 4, 4\) or a tuple", make, t, wrong)
    for row in ([0, 0, 0, 2], [1e-3, 0, 0, 1]):
        wrong = T.copy()
        wrong[3, 3] = row
        refuse(r"knot 3: poses: the last row must be \(0, 0, 0, 1\), found", make, t, wrong, knot=3)
    wrong = T.copy()
    wrong[2, 1, 3] = np.nan
    refuse("knot 2: poses: not finite", make, t, wrong, knot=2)
    wrong = T.copy()
    wrong[4, :3, :3] *= 1.001
    refuse("knot 4: rotations: the matrix is not orthonormal, by 0.002", make, t, wrong, knot=4)
    same(make(t, wrong, project=True).rotation(t)[4].T @ make(t, wrong, project=True).rotation(t)[4], np.eye(3), 1e-12)
    wrong[4, :3, :3] *= -1
    refuse("knot 4: .*reflection", make, t, wrong, project=True, knot=4)
    for wrong in (T + 0j, T.astype(object), "poses", None):
        with pytest.raises(TypeError, match="poses: expected real numbers"):
            make(t, wrong)
    if HAS_RIGID:
        with pytest.raises(TypeError, match="list of RigidTransform objects; join them"):
            make(t, [transform.RigidTransform.identity()] * len(t))
    refuse(r"or a tuple \(rotations, positions\), found items of different shapes", make, t, [q, p])


@pytest.mark.parametrize("make", [PoseSpline, PoseSpline.smoothing])
def test_bad_pairs(make):
    t, q, p = poses()
    refuse(r"positions: expected shape \(6, 3\), found \(7, 3\)", make, t, (q, np.zeros((7, 3))))
    for wrong in (p[:, :2], p[0], p[None]):
        refuse(r"positions: expected shape \(N, 3\)", make, t, (q, wrong))
    wrong = p.copy()
    wrong[1, 2] = np.inf
    refuse("knot 1: positions: not finite", make, t, (q, wrong), knot=1)
    with pytest.raises(TypeError, match="positions: expected real numbers"):
        make(t, (q, p + 0j))
    refuse("knot 0: rotations: a quaternion of length zero", make, t, (0 * q, p), knot=0)
    refuse(r"rotations: expected N rotations, found leading axes \(2, 6\)", make, t, (np.stack([q, q]), p))


def test_bad_times():
    t, q, p = poses()
    refuse("knot 3: t: must be greater", PoseSpline, [*t[:3], t[2], *t[4:]], (q, p), knot=3)
    refuse("one time for each of the 6 points", PoseSpline, t[:5], (q, p))
    refuse("t: entry 0 is not finite", PoseSpline, [np.nan, *t[1:]], (q, p), knot=0)
    spline = PoseSpline(t, (q, p))
    refuse("t: entry 1 is not finite", spline, [0.0, np.nan])
    refuse("t: entry 0 is not finite", spline.position, np.inf)
    for method in (spline.twist, spline.linear_velocity, spline.angular_velocity):
        refuse("frame: expected 'body' or 'world', found 'spatial'", method, 0.5, frame="spatial")


def test_bad_smoothing():
    t, q, p = poses()
    refuse("smoothing needs at least 5 poses, found 4", PoseSpline.smoothing, t[:4], (q[:4], p[:4]))
    repeated = [*t[:3], t[2], *t[4:]]
    refuse("knot 3: t: must be greater", PoseSpline.smoothing, repeated, (q, p), knot=3)
    for lam in (-1.0, np.nan, (0.1, np.inf), (0.1, -1.0), (1, 2, 3)):
        refuse("lam", PoseSpline.smoothing, t, (q, p), lam=lam)
    for weights in (np.ones(5), np.zeros(6), -np.ones(6)):
        with pytest.raises(InvalidInputError, match="weights"):
            PoseSpline.smoothing(t, (q, p), weights=weights)


def test_positions_are_checked_before_rotations_are_solved(monkeypatch):
    t, q, p = poses()
    # Any call of it fails.
    monkeypatch.setattr(stiefel_rs.pose, "RotationSpline", None)
    few = r"positions: expected shape \(6, 3\), found \(5, 3\)"
    closed = np.concatenate([q[:-1], q[:1]])
    refuse(few, PoseSpline, t, (q, p[:-1]))
    refuse("knot 5: positions: the last must equal the first", PoseSpline, t, (closed, p), "periodic", knot=5)
    refuse(few, PoseSpline.smoothing, t, (q, p[:-1]), lam=1e-3)
    refuse("smoothing needs at least 5 poses, found 4", PoseSpline.smoothing, t[:4], (q[:4], p[:4]))
    for lam, found in ((np.inf, "inf"), ((None, -1), "-1"), ((1.0, np.nan), "nan")):
        match = f"lam: expected a finite number of at least 0 for positions, found {found}"
        refuse(match, PoseSpline.smoothing, t, (q, p), lam=lam)
    with pytest.raises(TypeError, match="lam: expected a number, or None for cross-validation, found str"):
        PoseSpline.smoothing(t, (q, p), lam=(1.0, "gcv"))
    for times in ([0, 1, 2, 2, 4, 5], np.array([0, 1, 2, 2, 4, 5], dtype=np.uint8)):
        refuse("knot 3: t: must be greater .*, found 2", PoseSpline.smoothing, times, (q, p), knot=3)
    for make in (PoseSpline, PoseSpline.smoothing):
        with pytest.raises(TypeError, match="project: expected True or False, found 'yes'"):
            make(t, (q, p), project="yes")
        with pytest.raises(TypeError, match="extrapolate: expected True or False, found 1"):
            make(t, (q, p), extrapolate=1)


def test_times_that_are_no_numbers():
    _, q, p = poses()
    dates = np.datetime64("2024-01-01") + np.arange(6)
    for make in (PoseSpline, PoseSpline.smoothing):
        with pytest.raises(TypeError, match="t: datetimes are not numbers; convert them to seconds"):
            make(dates, (q, p))
        refuse("N >= 2|smoothing needs at least 5", make, [], (q[:0], p[:0]))
    refuse("N >= 2", PoseSpline, [], (q[:0], p[:0]), "periodic")


@pytest.mark.parametrize("frame", ["body", "world"])
def test_far_outside_the_poses(frame):
    t, q, p = poses()
    spline = PoseSpline(t, (q, p))
    for method in (spline.twist, spline.angular_velocity, spline.angular_acceleration, spline.angular_jerk):
        with pytest.raises(ConvergenceError, match="too long or too fast, needs more than 100000 steps"):
            method(1e9, frame)
    for method in (spline, spline.rotation):
        with pytest.raises(ConvergenceError, match="too long or too fast"):
            method(1e9)
    # Positions in the world frame are polynomials.
    assert np.isfinite(spline.position(1e9)).all()
    assert np.isfinite(spline.linear_velocity(1e9)).all()
    for method in (spline.linear_velocity, spline.linear_acceleration, spline.linear_jerk):
        with pytest.raises(ConvergenceError, match="too long or too fast"):
            method(1e9, "body")


@pytest.mark.parametrize(
    ("bc_type", "match"),
    [
        ("not-a-knot", "bc_type: expected"),
        (((1, W), "natural"), r"shape \(2, 3\), found \(3,\)"),
        (((1, np.zeros(6)), "natural"), r"shape \(2, 3\), found \(6,\)"),
        (((3, (W, V)), "natural"), "must be 1 .* or 2"),
        (("natural", (2, (W, [0, np.inf, 0]))), "bc_type: entry 4 is not finite"),
    ],
)
def test_bad_ends(bc_type, match):
    t, q, p = poses()
    refuse(match, PoseSpline, t, (q, p), bc_type)


def test_half_turns_name_the_pair():
    q = [[0, 0, 0, 1], [0, 0, 0.1, 1], [0, 0, -1, 0.1]]
    with pytest.raises(OutsideDomainError, match="knots 1 and 2: ") as caught:
        PoseSpline(np.arange(3.0), (q, np.zeros((3, 3))))
    assert caught.value.knot == 1
    assert abs(caught.value.angle - np.pi) < 1e-12


@pytest.mark.parametrize("lam", [1e8, 1e14, 1e100])
def test_positions_with_a_large_weight_tend_to_a_line(lam):
    count = 200
    t, rng = np.linspace(2, 3, count), np.random.default_rng(3)
    q, p, w = np.tile([0, 0, 0, 1.0], (count, 1)), rng.uniform(-1, 1, (count, 3)), rng.uniform(0.1, 3, count)
    spline = PoseSpline.smoothing(t, (q, p), lam=(1.0, lam), weights=w)
    line = np.stack([np.polyval(np.polyfit(t - 2.5, column, 1, w=np.sqrt(w)), t - 2.5) for column in p.T], axis=-1)
    # The deviation from the line falls as 1 / lam, to round-off.
    assert np.abs(spline.position(t) - line).max() < 0.1 / lam + 1e-13
    with pytest.raises(InvalidInputError, match=r"lam \(1e\+307\) too large"):
        PoseSpline.smoothing(t, (q, p), lam=(1.0, 1e307), weights=w)


def test_an_infinite_weight_makes_the_rate_constant():
    t, q, p = poses(step=0.3)
    spline, at = PoseSpline.smoothing(t, (q, p), lam=(np.inf, 1e-3)), inner(t)
    assert spline.lam == (np.inf, 1e-3)
    same(spline.angular_velocity(at), np.tile(spline.angular_velocity(t[0]), (len(at), 1)), 1e-10)
    assert np.abs(spline.linear_acceleration(at)).max() > 0.1


def test_positions_too_large_for_a_float():
    t, q, p = poses()
    with pytest.raises(InvalidInputError, match="positions: too large"):
        PoseSpline(t, (q, 1.7e308 * (p / np.abs(p).max())))


def test_ragged_arguments():
    t, q, p = poses()
    ragged = [[1, 2, 3], [1, 2], [1]]
    refuse("positions: found items of different shapes", PoseSpline, t, (q, ragged))
    refuse("lam: expected a number or a pair", PoseSpline.smoothing, t, (q, p), lam=(1, np.array([1, 2.0])))
    with pytest.raises(TypeError, match="extrapolate: expected True or False, found 'no'"):
        PoseSpline(t, (q, p), extrapolate="no")
