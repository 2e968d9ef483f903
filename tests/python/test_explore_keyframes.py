"""Keyframes of `stiefel-rs explore`: the spline and the shortest paths through them, and invalid keyframes."""

import re

import numpy as np
import pytest
from explore_problem import spline
from scipy.spatial.transform import Rotation, Slerp

from stiefel_rs import ConvergenceError, InvalidInputError, OutsideDomainError
from stiefel_rs.explore import keyframes, messages, sampling
from stiefel_rs.explore.keyframes import KINDS


def first(kind):
    return keyframes.read(KINDS[kind], KINDS[kind].t, KINDS[kind].values)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("ends", keyframes.END_CONDITIONS)
def test_the_spline_is_that_of_the_library(kind, ends):
    t, values = first(kind)
    found = keyframes.find(KINDS[kind], t, values, ends)
    path, profile = sampling.path_times(found, t), sampling.profile_times(t)
    sampled, curve = found["spline"].sampled(path, profile), spline(kind, t, values, ends)
    assert np.array_equal(sampled.points, curve(path))
    assert np.allclose(sampled.speed, np.linalg.norm(curve.velocity(profile), axis=(1, 2)) / np.sqrt(curve.k // 3 + 1))
    assert sampled.cost == curve.cost()
    assert sampled.length == pytest.approx(curve.arc_length(), rel=1e-5)
    assert (sampled.speed[[0, -1]] < 1e-9).all() == (ends == "clamped")


def test_slerp_of_rotations_is_that_of_scipy():
    t, values = first("rotations")
    # Opposite signs are the same rotations.
    signs = np.array([1, -1, 1, 1, -1])
    one = keyframes.Slerp(t, signs[:, None] * values)
    path = np.linspace(t[0], t[-1], 101)
    expected = Slerp(t, Rotation.from_quat(values))(path).as_matrix()
    assert np.allclose(one.points(path), expected, atol=1e-14)
    turned = Rotation.from_quat(values)[:-1].inv() * Rotation.from_quat(values)[1:]
    assert one.sampled(path, path).length == pytest.approx(turned.magnitude().sum(), abs=1e-13)


def test_great_circle_arcs_have_constant_speed_on_each_piece():
    t, values = first("points")
    one = keyframes.Slerp(t, values)
    profile = sampling.profile_times(t)
    sampled = one.sampled(profile, profile)
    angles = np.arccos(np.sum(values[1:] * values[:-1], axis=1))
    # Times of inner keyframes stand twice: the first is of the piece before.
    starts = np.flatnonzero(np.diff(profile) == 0)
    assert np.allclose(sampled.speed[[0, *starts + 1]], angles / np.diff(t), atol=1e-13)
    assert np.allclose(sampled.speed[[*starts, -1]], angles / np.diff(t), atol=1e-13)
    assert np.allclose(np.linalg.norm(sampled.points, axis=1), 1, atol=1e-14)
    assert np.allclose(one.points(t)[..., 0], values, atol=1e-14)
    assert sampled.length == pytest.approx(angles.sum(), abs=1e-13)
    assert sampled.cost is None and sampled.acceleration is None


def test_equal_neighbours_are_a_rest():
    one = keyframes.Slerp(np.array([0.0, 1.0]), np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]))
    t = np.linspace(0, 1, 3)
    assert np.array_equal(one.points(t)[..., 0], [[0, 0, 1]] * 3)
    assert np.array_equal(one.sampled(t, t).speed, np.zeros(3))


def test_opposite_points_are_named():
    values = np.array([[1.0, 0, 0], [0, 1.0, 0], [0, -1.0, 0]])
    found = keyframes.find(KINDS["points"], np.array([0.0, 1.0, 2.0]), values, "natural")
    for name, error in found.items():
        assert isinstance(error, OutsideDomainError)
        assert ": keyframes 2 and 3 are half a turn apart, " in messages.plain(name, error)


def test_rotations_half_a_turn_apart_have_no_spline_but_slerp():
    t, values = np.array([0.0, 1.0, 2.0]), np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 1.0, 0, 0]])
    found = keyframes.find(KINDS["rotations"], t, values, "natural")
    assert "keyframes 1 and 2 are half a turn apart" in messages.plain("spline", found["spline"])
    assert found["slerp"].sampled(t, t).length == pytest.approx(np.pi)


def test_a_search_without_a_result_is_said_in_words():
    error = ConvergenceError("spline: no convergence after 5 iterations with residual 4.641e0", None)
    text = messages.plain("spline", error)
    assert text == "No cubic spline was found here. Move a keyframe, or give it more time."
    assert messages.plain("cubic", error) == "No exact cubic was found here. Try shorter arrows."


@pytest.mark.parametrize(
    ("t", "values", "message"),
    [
        ([0], [[1, 0, 0]], "t: 2 to 8 times expected"),
        (list(range(9)), [[1, 0, 0]] * 9, "t: 2 to 8 times expected"),
        ([0, 1], [[1, 0, 0]], "values: shape (2, 3) expected"),
        ([0, 1], [[1, 0, 0, 0]] * 2, "values: shape (2, 3) expected"),
        ([0, 1], [[1, 0, 0], [1, 0]], "keyframes: numbers expected"),
        ([0, np.inf], [[1, 0, 0]] * 2, "keyframes: not finite"),
        ([1, 1], [[1, 0, 0]] * 2, "t: increasing times from 0 to 6 expected"),
        ([-1, 1], [[1, 0, 0]] * 2, "t: increasing times from 0 to 6 expected"),
        ([0, 7], [[1, 0, 0]] * 2, "t: increasing times from 0 to 6 expected"),
        ([0, 1], [[1, 0, 0], [0, 2, 0]], "values: unit vectors expected, found length 2"),
        ([0, 1], [[1, 0, 0], [0, 0, 0]], "values: unit vectors expected, found length 0"),
    ],
)
def test_what_is_no_keyframe_is_refused(t, values, message):
    with pytest.raises(InvalidInputError, match=re.escape(message)):
        keyframes.read(KINDS["points"], t, values)
