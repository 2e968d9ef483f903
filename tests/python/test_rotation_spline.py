"""Splines of rotations: closed forms, rates, kinds, batches, and invariance."""

import itertools

import numpy as np
import pytest
from rotation_problems import (
    ANGLE,
    AXIS,
    A,
    T,
    W,
    about,
    as_matrices,
    inner,
    product,
    random_quaternion,
    same,
    slope,
    turned,
    vee,
    wander,
)
from scipy.interpolate import CubicSpline as Flat
from scipy.spatial.transform import Rotation

import stiefel_rs
from stiefel_rs import CubicHermite, CubicSpline, RotationSpline, SmoothingSpline
from stiefel_rs.rotation_input import inverse, matrices_of, rotated

EPS = np.finfo(float).eps
# Defects and jumps of pieces of at most 1e-12, and round-off of the evaluation.
MET = 1e-11


# Closed forms


def test_constant_rate_about_one_axis():
    spline, t = RotationSpline(T, turned(1.3 * T)), np.linspace(-1, 5, 50)
    same(spline(t), turned(1.3 * t), 1e-13)
    same(spline(t, 1), np.broadcast_to(1.3 * AXIS, (50, 3)), MET)
    same(spline(t, 2), np.zeros((50, 3)), MET)
    same(spline(t, 3), np.zeros((50, 3)), MET)
    assert abs(spline.cost()) < 1e-20
    assert abs(spline.arc_length() - 1.3 * 4) < 1e-12
    assert abs(spline.arc_length(1.0, 2.0) - 1.3) < 1e-12


def test_two_rotations_are_joined_at_constant_rate():
    q = np.stack([random_quaternion(3), random_quaternion(4)])
    spline = RotationSpline([1.0, 3.0], q)
    w = Rotation.from_quat(product(inverse(q[0]), q[1])).as_rotvec() / 2
    t = np.linspace(0, 4, 9)
    same(spline(t, 1), np.broadcast_to(w, (9, 3)), 1e-12)
    expected = product(q[0], about((t[:, None] - 1) * w))
    same(spline(t), expected, 1e-12)


# End conditions of rotations about one axis, and of their angle.
ENDS = {
    "natural": ("natural", "natural"),
    "clamped": ("clamped", "clamped"),
    "periodic": ("periodic", "periodic"),
    "rates": (((1, 0.3 * AXIS), (1, -0.8 * AXIS)), ((1, 0.3), (1, -0.8))),
    "accelerations": (((2, 0.3 * AXIS), (2, -0.8 * AXIS)), ((2, 0.3), (2, -0.8))),
    "mixed": (((2, 0.3 * AXIS), "clamped"), ((2, 0.3), (1, 0.0))),
    "words": (("natural", "clamped"), ((2, 0.0), (1, 0.0))),
}


@pytest.mark.parametrize("ends", ENDS)
@pytest.mark.parametrize("kind", ["Rotation", "quaternions", "matrices"])
def test_rotations_about_one_axis_follow_the_spline_of_their_angle(ends, kind):
    ours, theirs = ENDS[ends]
    angle = np.append(ANGLE[:-1], ANGLE[0]) if ends == "periodic" else ANGLE
    flat, t = Flat(T, angle, bc_type=theirs), np.linspace(*T[[0, -1]], 41)
    data = {"Rotation": Rotation.from_quat, "matrices": matrices_of}.get(kind, lambda q: q)
    spline = RotationSpline(T, data(turned(angle)), bc_type=ours)
    assert spline.kind == kind
    same(as_matrices(spline(t)), matrices_of(turned(flat(t))), MET)
    for order in (1, 2):
        same(spline(t, order), flat(t, order)[:, None] * AXIS, 10 * MET)
    # At knots the jerk jumps.
    same(spline(inner(T), 3), flat(inner(T), 3)[:, None] * AXIS, 100 * MET)


def test_ends_are_met_in_the_body_frame():
    t, q = wander(6)
    spline = RotationSpline(t, q, bc_type=((1, W), (2, A)))
    same(spline.angular_velocity(t[0]), W, MET)
    same(spline.angular_acceleration(t[-1]), A, MET)
    first, last = spline.bc_type
    assert (first[0], last[0]) == (1, 2)
    assert np.array_equal(first[1], W)
    assert not last[1].flags.writeable
    clamped = RotationSpline(t, q, "clamped")
    same(clamped(t[[0, -1]], 1), np.zeros((2, 3)), MET)
    assert clamped.bc_type == "clamped"


# Rates


@pytest.mark.parametrize("tension", [0.0, 2.0])
def test_rates_are_those_of_the_rotations(tension):
    t, q = wander(7)
    spline, at = RotationSpline(t, matrices_of(q), tension=tension), inner(t)
    R = spline(at)
    same(spline(at, 1), vee(np.swapaxes(R, -1, -2) @ slope(spline, at)), 1e-8)
    same(spline.angular_velocity(at, "world"), vee(slope(spline, at) @ np.swapaxes(R, -1, -2)), 1e-8)
    for order in (2, 3):
        same(spline(at, order), slope(lambda s, order=order: spline(s, order - 1), at), 1e-8)
    same(spline.angular_acceleration(at, "world"), slope(lambda s: spline.angular_velocity(s, "world"), at), 1e-8)


def test_frames_are_axes():
    t, q = wander(5)
    spline = RotationSpline(t, q)
    R = matrices_of(spline(t))
    methods = (spline.angular_velocity, spline.angular_acceleration, spline.angular_jerk)
    for order, method in enumerate(methods, 1):
        assert np.array_equal(method(t), spline(t, order))
        same(method(t, frame="world"), np.einsum("tij,tj->ti", R, spline(t, order)), 1e-13)
    # The docstring's statement about the derivative of the world acceleration.
    at = inner(t)
    w, a, j = (spline(at, order) for order in (1, 2, 3))
    found = slope(lambda s: spline.angular_acceleration(s, "world"), at)
    same(found, rotated(spline(at), j + np.cross(w, a)), 1e-8)


def test_the_pieces_are_cubics_and_their_world_jerk_is_constant():
    t, q = wander(5)
    spline = RotationSpline(t, q)
    jerk = spline.angular_jerk(inner(t), "world").reshape(4, 5, 3)
    same(jerk, jerk[:, :1], 1e-9)


def test_cost_and_arc_length_are_integrals_of_the_rates():
    t, q = wander(5)
    spline = RotationSpline(t, q)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    half = np.diff(t)[:, None] / 2
    at, by = (t[:-1, None] + half * (1 + nodes)).ravel(), (half * weights).ravel()
    assert abs(spline.cost() - by @ np.sum(spline(at, 2) ** 2, axis=-1)) < 1e-9
    assert abs(spline.arc_length() - by @ np.linalg.norm(spline(at, 1), axis=-1)) < 1e-6


def test_matrix_curve_and_quaternions_agree():
    t, q = wander(20)
    spline = RotationSpline(t, q)
    curve, at = CubicSpline(t, matrices_of(q)), np.linspace(*t[[0, -1]], 200)
    same(matrices_of(spline(at)), curve(at), 1e-12)
    same(matrices_of(spline(at)), spline.curve(at), 1e-12)
    assert abs(spline.cost() - curve.cost()) < 1e-10 * curve.cost()


# Invariance


def test_rotating_space_rotates_the_curve():
    (t, q), g, at = wander(6), random_quaternion(9), np.linspace(0, 7, 40)
    spline, moved = RotationSpline(t, q), RotationSpline(t, product(g, q))
    same(moved(at), product(g, spline(at)), 1e-11)
    for order in (1, 2, 3):
        same(moved(at, order), spline(at, order), 1e-10)


def test_rotating_the_body_rotates_its_rates():
    (t, q), g, at = wander(6), random_quaternion(9), np.linspace(0, 7, 40)
    spline, moved = RotationSpline(t, q), RotationSpline(t, product(q, g))
    same(moved(at), product(spline(at), g), 1e-11)
    same(moved(at, 1), rotated(inverse(g), spline(at, 1)), 1e-10)
    same(moved.angular_velocity(at, "world"), spline.angular_velocity(at, "world"), 1e-10)


def test_reversing_time_reverses_the_curve():
    (t, q), at = wander(6), np.linspace(0, 7, 40)
    ends = ((1, W), (2, A))
    spline, back = RotationSpline(t, q, ends), RotationSpline(-t[::-1], q[::-1], ((2, A), (1, -W)))
    same(matrices_of(back(-at)), matrices_of(spline(at)), 1e-10)
    for order in (1, 2):
        same(back(-at, order), (-1) ** order * spline(at, order), 1e-9)


def test_scaling_time_scales_rates():
    (t, q), at = wander(6), np.linspace(0, 7, 40)
    spline, slow = RotationSpline(t, q), RotationSpline(1000 * t, q)
    for order in (1, 2, 3):
        same(slow(1000 * at, order) * 1000.0**order, spline(at, order), 1e-9)


# Beyond the ends


def test_a_curve_at_rest_is_exactly_at_rest(rng):
    for q in rng.standard_normal((20, 4)):
        spline = RotationSpline([0.0, 1.0, 2.5, 3.0], np.tile(q, (4, 1)))
        assert np.array_equal(spline([-1e9, 0.3, 1e9], 1), np.zeros((3, 3)))
        same(spline(1e9), q / np.linalg.norm(q), 1e-15)


def test_end_pieces_go_on():
    spline = RotationSpline(T, turned(ANGLE))
    assert spline.extrapolate
    flat, t = Flat(T, ANGLE, bc_type="natural"), np.array([-1.0, -0.2, 4.1, 5.0])
    same(spline(t), turned(flat(t)), 1e-10)
    same(spline(t, 1), flat(t, 1)[:, None] * AXIS, 1e-9)


def test_without_extrapolation_ends_count_to_round_off():
    t = np.array([0.1, 0.7, 1.3])
    spline = RotationSpline(t, turned([0.0, 0.4, 0.1]), extrapolate=False)
    assert not spline.extrapolate
    first, last = spline(t[0]), spline(t[-1])
    assert np.array_equal(spline(t[0] - 4 * np.spacing(0.1)), first)
    assert np.array_equal(spline([t[-1] + 4 * np.spacing(1.3)])[0], last)
    for outside in (t[0] - 8 * np.spacing(1.3), t[-1] + 8 * np.spacing(1.3), -np.inf, 7):
        for order in (0, 1):
            with pytest.raises(stiefel_rs.InvalidInputError, match="t: "):
                spline([0.5, outside], order)


@pytest.mark.parametrize(("tension", "spans"), [(0.0, 1e4), (30.0, 4.0)])
def test_far_outside_the_integration_is_given_up(tension, spans):
    spline = RotationSpline([0, 1, 2], [[0, 0, 0, 1], [0, 0.1, 1, 1], [0, 0, 1, 0]], tension=tension)
    far = 2 * (1 + spans)
    methods = (spline, spline.angular_velocity, spline.angular_acceleration, spline.angular_jerk)
    for method in (*methods, lambda t: spline(t, 3), lambda t: spline.arc_length(0, t)):
        with pytest.raises(stiefel_rs.ConvergenceError, match="too long or too fast, needs more than 100000 steps"):
            method(far)


# Other constructors


def test_smoothing_limits():
    t, q = wander(8, step=0.3)
    through = RotationSpline(t, q)
    at = np.linspace(*t[[0, -1]], 50)
    near = RotationSpline.smoothing(t, q, lam=0)
    same(matrices_of(near(at)), matrices_of(through(at)), 1e-9)
    assert near.lam == 0
    assert through.lam is None
    assert near.bc_type is None
    distances = [
        np.abs(matrices_of(RotationSpline.smoothing(t, q, lam=lam)(t)) - matrices_of(q)).max()
        for lam in (1e-2, 1e-4, 1e-6, 1e-8)
    ]
    assert all(a > 10 * b for a, b in itertools.pairwise(distances[1:])), distances
    # In least squares, a curve of constant rate.
    stiff = RotationSpline.smoothing(t, q, lam=np.inf)
    same(stiff(at, 2), np.zeros((50, 3)), 1e-8)


def test_smoothing_is_that_of_the_matrices():
    t, q = wander(12, step=0.3)
    ours, theirs = RotationSpline.smoothing(t, q), SmoothingSpline(t, matrices_of(q))
    same(matrices_of(ours(t)), theirs(t), 1e-12)
    assert abs(ours.lam - theirs.lam) < 1e-9 * theirs.lam
    assert ours.curve.misfit > 0
    weights = np.linspace(1, 2, 12)
    weighted = RotationSpline.smoothing(t, Rotation.from_quat(q), lam=0.1, weights=weights)
    same(weighted(t).as_matrix(), SmoothingSpline(t, matrices_of(q), weights, 0.1)(t), 1e-12)
    # Times may repeat.
    twice = RotationSpline.smoothing(np.repeat(t, 2), np.repeat(q, 2, axis=0), lam=0.1)
    assert len(twice.t) == 12
    assert len(twice.rotations) == 12


@pytest.mark.parametrize("frame", ["body", "world"])
def test_hermite_meets_its_rates(frame):
    t, q = wander(5)
    rates = np.random.default_rng(0).standard_normal((5, 3))
    spline = RotationSpline.hermite(t, q, rates, frame=frame)
    same(spline.angular_velocity(t, frame), rates, MET)
    same(matrices_of(spline(t)), matrices_of(q), MET)
    assert isinstance(spline.curve, CubicHermite)
    # With the rates of a spline, the Hermite curve is that spline.
    through = RotationSpline(t, q)
    again = RotationSpline.hermite(t, q, through.angular_velocity(t, frame), frame=frame)
    same(matrices_of(again(inner(t))), matrices_of(through(inner(t))), 1e-10)


def test_curves_in_files_make_the_spline_again(tmp_path):
    t, q = wander(6)
    for spline in (RotationSpline(t, q), RotationSpline.smoothing(t, q), RotationSpline.hermite(t, q, 0.1 * q[:, :3])):
        spline.curve.save(tmp_path / "curve.npz")
        again = RotationSpline.from_curve(stiefel_rs.load(tmp_path / "curve.npz"), kind="matrices", extrapolate=True)
        same(again(t), matrices_of(spline(t)), 1e-12)
        assert type(again.curve) is type(spline.curve)


def same_ends(found, expected):
    """Whether end conditions are the same, to round-off of the conversion between frames."""
    if isinstance(expected, str):
        assert found == expected
        return
    for here, there in zip(found, expected, strict=True):
        if isinstance(there, str):
            assert here == there
            continue
        assert here[0] == there[0]
        same(here[1], there[1], 8 * EPS)
        assert not here[1].flags.writeable


@pytest.mark.parametrize("ends", ENDS)
def test_curves_keep_the_end_conditions_of_the_spline(ends, tmp_path):
    t, q = wander(6)
    if ends == "periodic":
        q[-1] = q[0]
    spline = RotationSpline(t, q, ENDS[ends][0], extrapolate=False)
    spline.curve.save(tmp_path / "curve.npz")
    solved = CubicSpline(t, matrices_of(q), spline.curve.bc_type)
    for curve in (spline.curve, solved, stiefel_rs.load(tmp_path / "curve.npz")):
        for extrapolate in (None, True):
            same_ends(RotationSpline.from_curve(curve, extrapolate=extrapolate).bc_type, spline.bc_type)


def test_other_curves_have_no_end_conditions():
    t, q = wander(6)
    for spline in (RotationSpline.smoothing(t, q, lam=0.1), RotationSpline.hermite(t, q, 0.1 * q[:, :3])):
        assert RotationSpline.from_curve(spline.curve).bc_type is None


def test_smoothing_tells_misfit_and_degrees_of_freedom(rng):
    t = np.linspace(0.0, 4.0, 60)
    measured = Rotation.from_rotvec(np.outer(np.sin(t), [0.3, 0.5, 0.8]) + 0.02 * rng.normal(size=(60, 3)))
    spline = RotationSpline.smoothing(t, measured)
    angles = (measured.inv() * spline(t)).magnitude()
    assert spline.misfit == pytest.approx((angles**2).sum(), rel=1e-9)
    assert 2 < spline.degrees_of_freedom < 60
    assert np.sqrt(spline.misfit / (3 * (60 - spline.degrees_of_freedom))) == pytest.approx(0.02, rel=0.15)
    exact = RotationSpline(t, measured)
    assert exact.misfit is None and exact.degrees_of_freedom is None
    with pytest.raises(TypeError, match="lam: expected a number, or None"):
        RotationSpline.smoothing(t, measured, lam="gcv")
