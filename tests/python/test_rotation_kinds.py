"""Splines of rotations for every input kind: conversion, batches, pickles, and when SciPy is imported."""

import copy
import pickle
import subprocess
import sys
from functools import partial

import numpy as np
import pytest
from rotation_problems import ANGLE, T, W, as_matrices, same, turned, wander
from scipy.spatial.transform import Rotation

from stiefel_rs import ConvergenceError, InvalidInputError, RotationSpline
from stiefel_rs.rotation_input import matrices_of, quaternions_of, rotated

EPS = np.finfo(float).eps
# Defects and jumps of pieces of at most 1e-12, and round-off of the evaluation.
MET = 1e-11


# Kinds of input


def test_the_same_kind_comes_out():
    t, q = wander(4)
    by_rotation, by_matrix = RotationSpline(t, Rotation.from_quat(q)), RotationSpline(t, matrices_of(q))
    by_quaternion, at = RotationSpline(t, q), np.linspace(*t[[0, -1]], 9)
    assert isinstance(by_rotation(at), Rotation)
    assert by_rotation(at[0]).single
    assert by_matrix(at).shape == (9, 3, 3)
    assert by_matrix(at[0]).shape == (3, 3)
    assert by_quaternion(at).shape == (9, 4)
    assert by_quaternion(at.reshape(3, 1, 3)).shape == (3, 1, 3, 4)
    assert by_quaternion(at.reshape(3, 3), 2).shape == (3, 3, 3)
    assert by_quaternion([]).shape == (0, 4)
    assert by_quaternion(at[0], 1).shape == (3,)
    same(by_rotation(at).as_quat(), by_quaternion(at), 4 * EPS)
    same(by_matrix(at), matrices_of(by_quaternion(at)), MET)
    assert isinstance(by_rotation.rotations, Rotation)
    same(by_rotation.rotations.as_matrix(), matrices_of(q), MET)
    same(by_matrix.rotations, matrices_of(q), MET)
    assert np.array_equal(by_rotation.times, t)
    assert np.array_equal(by_rotation.t, t)
    assert by_rotation.t_span == (t[0], t[-1])
    assert isinstance(by_rotation.t_span[0], float)


def test_quaternions_of_any_length_and_sign_are_the_same_rotations():
    t, q = wander(6)
    spline, at = RotationSpline(t, q), np.linspace(0, 7, 50)
    for factor in (7.0, 1e-3, 1e200, 1e-200, np.array([[1.0], [-2.0], [3.0], [-1e5], [1.0], [9.0]])):
        same(RotationSpline(t, q * factor)(at), spline(at), 1e-11)
    same(RotationSpline(t, -q)(at), -spline(at), 1e-11)


def test_single_precision():
    t, q = wander(6)
    at = np.linspace(0, 7, 50)
    for data in (q.astype(np.float32), matrices_of(q).astype(np.float32)):
        found = RotationSpline(t.astype(np.float32), data)(at)
        assert found.dtype == float
        same(as_matrices(found), matrices_of(RotationSpline(t, q)(at)), 1e-5)
    whole = RotationSpline([0, 1, 2], [[0, 0, 0, 1], [0, 0, 1, 1], [0, 0, 1, 0]])
    same(whole(1), np.array([0, 0, 1, 1]) / np.sqrt(2), MET)


def test_arrays_of_any_layout():
    t, q = wander(5)
    expected = RotationSpline(t, q)(t)
    padded = np.zeros((10, 8))
    padded[::2, ::2] = q
    read_only = q.copy()
    read_only.flags.writeable = False
    for data in (np.asfortranarray(q), padded[::2, ::2], q[::-1].copy()[::-1], q.tolist(), read_only):
        assert np.array_equal(RotationSpline(list(t), data)(t), expected)


def test_quaternions_are_continuous():
    # Five turns about one axis, with arbitrary signs, and one rotation with a sign opposite to its neighbours'.
    t = np.linspace(0, 1, 41)
    q = turned(10 * np.pi * t) * np.where(np.arange(41) % 3, 1.0, -1.0)[:, None]
    for data in (q, *(wander(30, seed)[1] for seed in range(3))):
        spline = RotationSpline(np.linspace(0, 1, len(data)), data)
        at = np.linspace(-0.1, 1.1, 6001)
        found = spline(at)
        same(np.linalg.norm(found, axis=-1), 1.0, 4 * EPS)
        assert np.sum(found[1:] * found[:-1], axis=-1).min() > 0.9
        same(spline(0.0), data[0], MET)
        same(np.abs(np.sum(spline.rotations * data, axis=-1)), 1.0, 1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_conversions(seed):
    R = Rotation.random(50, rng=seed)
    q = quaternions_of(R.as_matrix())
    same(np.abs(np.sum(q * R.as_quat(), axis=-1)), 1.0, 8 * EPS)
    same(matrices_of(q), R.as_matrix(), 16 * EPS)
    v = np.random.default_rng(seed).standard_normal((50, 3))
    same(rotated(q, v), R.apply(v), 64 * EPS)
    # The nearest rotations, up to the square of the defect.
    near = R.as_matrix() + 1e-6 * np.random.default_rng(seed).standard_normal((50, 3, 3))
    U, _, Vt = np.linalg.svd(near)
    same(matrices_of(quaternions_of(near)), U @ Vt, 1e-10)


def test_half_turns_convert():
    axes = np.concatenate([np.eye(3), np.full((1, 3), 1 / np.sqrt(3)), [[0.6, 0, -0.8], [0, -0.6, 0.8]]])
    R = 2 * axes[:, :, None] * axes[:, None] - np.eye(3)
    same(matrices_of(quaternions_of(R)), R, 8 * EPS)


# Batches


@pytest.mark.parametrize("lead", [(3,), (2, 3), (1,), (0,), (2, 0)])
@pytest.mark.parametrize("own_times", [False, True])
def test_batches_equal_singles(lead, own_times):
    count = int(np.prod(lead))
    data = [wander(6, seed) for seed in range(count)]
    q = np.array([q for _, q in data]).reshape(*lead, 6, 4)
    t = np.array([t for t, _ in data]).reshape(*lead, 6) if own_times else wander(6)[0]
    at = np.linspace(0, 7, 8).reshape(2, 4)
    for make in (RotationSpline, lambda t, q: RotationSpline.smoothing(t, q, lam=0.01), hermite):
        batch = make(t, q)
        singles = [make(t[i] if own_times else t, q[i]) for i in np.ndindex(lead)]
        assert batch(at).shape == (*lead, 2, 4, 4)
        for order, width in enumerate((4, 3, 3, 3)):
            expected = [single(at, order) for single in singles]
            assert np.array_equal(batch(at, order), np.reshape(expected, (*lead, 2, 4, width)))
        world = [single.angular_velocity(at, "world") for single in singles]
        assert np.array_equal(batch.angular_velocity(at, "world"), np.reshape(world, (*lead, 2, 4, 3)))
        assert np.array_equal(batch.cost(), np.reshape([single.cost() for single in singles], lead))
        assert np.array_equal(batch.arc_length(), np.reshape([single.arc_length() for single in singles], lead))
        assert batch.curve.shape == lead
        assert batch.report.shape == lead
        assert batch.t_span[0].shape == lead
        assert batch(0.5).shape == (*lead, 4)
        assert "batch of shape" in repr(batch)
        assert np.array_equal(batch.rotations, np.reshape([s.rotations for s in singles], (*lead, 6, 4)))
        assert batch.t.shape == (*lead, 6)


def test_batches_are_the_same_for_any_number_of_threads():
    # More than 64 pieces in all: the splines are shared among the threads.
    q = np.stack([wander(20, seed)[1] for seed in range(40)])
    t, at = wander(20)[0], np.linspace(0, 19, 101)
    for make in (RotationSpline, partial(RotationSpline.smoothing, lam=0.01), hermite):
        expected = make(t, q, num_threads=1)
        for threads in (2, 7, None):
            found = make(t, q, num_threads=threads)
            for order in range(4):
                assert np.array_equal(found(at, order), expected(at, order))


def hermite(t, q, **options):
    return RotationSpline.hermite(t, q, 0.1 * q[..., :3], **options)


def test_values_of_a_batch_are_the_same_beyond_its_ends():
    q = np.stack([wander(5, seed)[1] for seed in range(3)])
    t = wander(5)[0] + 0.1 * np.arange(3.0)[:, None]
    batch = RotationSpline(t, q)
    singles = [RotationSpline(*each) for each in zip(t, q, strict=True)]
    at = np.linspace(-1.0, 8.0, 10)
    assert np.array_equal(batch(at), [single(at) for single in singles])
    shared = np.array([t[-1, 0], t[0, -1]])
    assert np.array_equal(batch(shared, 1, extrapolate=False), [single(shared, 1) for single in singles])
    with pytest.raises(InvalidInputError, match="t: must be between"):
        batch(t[0, 0], extrapolate=False)
    with pytest.raises(ConvergenceError, match=r"\(batch member 0\)"):
        batch(1e4)


def test_batches_of_matrices():
    t, q = wander(6)
    q = np.stack([q, q[::-1]])
    batch = RotationSpline(t, matrices_of(q))
    assert batch([1.0, 2.0]).shape == (2, 2, 3, 3)
    assert np.array_equal(batch(1.0)[1], RotationSpline(t, matrices_of(q[1]))(1.0))


# Pickles, text, and SciPy


def assert_same(again, spline):
    at = np.linspace(-1, 8, 50)
    for order in range(4):
        a, b = again(at, order), spline(at, order)
        assert type(a) is type(b)
        assert np.array_equal(*(x.as_quat() if isinstance(x, Rotation) else x for x in (a, b)))
    assert (again.kind, again.extrapolate, repr(again)) == (spline.kind, spline.extrapolate, repr(spline))
    assert repr(again.bc_type) == repr(spline.bc_type)


@pytest.mark.parametrize("kind", ["Rotation", "quaternions", "matrices", "batch", "smoothing"])
def test_pickles_and_copies(kind):
    t, q = wander(5)
    spline = {
        "Rotation": lambda: RotationSpline(t, Rotation.from_quat(q), ((1, W), "natural")),
        "quaternions": lambda: RotationSpline(t, -q),
        "matrices": lambda: RotationSpline(t, matrices_of(q), "clamped"),
        "batch": lambda: RotationSpline(t, np.stack([q, q[::-1]])),
        "smoothing": lambda: RotationSpline.smoothing(t, q),
    }[kind]()
    for again in (pickle.loads(pickle.dumps(spline)), copy.copy(spline), copy.deepcopy(spline)):
        assert_same(again, spline)


def test_text():
    spline = RotationSpline(T, turned(ANGLE))
    assert repr(spline) == ("<RotationSpline of quaternions, CubicSpline on St(3, 3), 5 knots, t_span (0.0, 4.0)>")
    assert spline.report.converged


def test_scipy_is_imported_only_where_it_is_wanted():
    code = """
import sys, numpy as np, stiefel_rs
spline = stiefel_rs.RotationSpline([0, 1], [[0, 0, 0, 1], [0, 0, 1, 1]])
spline(0.5), spline(0.5, 1), stiefel_rs.RotationSpline([0, 1], [np.eye(3)] * 2)(0.5)
assert "scipy" not in sys.modules
sys.modules["scipy"] = None
try:
    stiefel_rs.RotationSpline.from_curve(spline.curve, kind="Rotation")(0.5)
except ImportError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("a Rotation needs SciPy, which is not installed with stiefel_rs"), done.stdout
    assert "pip install scipy" in done.stdout
