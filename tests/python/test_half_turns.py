"""Half turns between rotations with given rates: the rates decide the direction, or an error names the pair."""

import numpy as np
import pytest
from rotation_problems import product, random_quaternion, same

from stiefel_rs import OutsideDomainError, RotationSpline

ROUND_OFF = 12 * np.finfo(float).eps
AXIS = np.array([0.0, 0.0, 1.0])
HALF_TURN = np.array([[0, 0, 0, 1.0], [0, 0, 1.0, 0]])


def undecided(t, q, rates, knot, match="the rates do not decide the direction", **options):
    with pytest.raises(OutsideDomainError, match=f"^knots {knot} and {knot + 1}: .*{match}") as caught:
        RotationSpline.hermite(t, q, rates, **options)
    assert caught.value.knot == knot
    assert abs(caught.value.angle - np.pi) < ROUND_OFF


@pytest.mark.parametrize("rates", [np.zeros((2, 3)), [AXIS, -AXIS], [[5, 0, 0], [0, -3, 0]], [[1, 2, 3], [2, 1, -3]]])
@pytest.mark.parametrize("frame", ["body", "world"])
def test_without_a_direction_they_are_refused(rates, frame):
    # About the axis of the turn, rates in the body and in the world are the same.
    undecided([0, 1], HALF_TURN, rates, 0, frame=frame)


@pytest.mark.parametrize("step", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("seed", range(5))
def test_the_sign_of_the_mean_rate_is_the_direction(seed, step):
    start, axis = random_quaternion(seed), random_quaternion(seed + 50)[:3]
    axis /= np.linalg.norm(axis)
    q = np.stack([start, product(start, np.append(axis, 0.0))])
    # The round-off of the angle is far below 1e-13 rad, and above 1e-17 rad.
    for size in (1.0, 1e-6, 1e-13):
        for sign in (1, -1):
            spline = RotationSpline.hermite([0, step], q, np.stack([0 * axis, 2 * sign * size * axis / step]))
            assert sign * (spline(step / 2, 1) @ axis) > 1 / step
    undecided([0, step], q, np.full((2, 3), 1e-17 * axis / step), 0)


def test_one_rate_is_enough():
    for rates in ([AXIS, 0 * AXIS], [0 * AXIS, AXIS], [[3, 0, 1], [0, 2, 0]]):
        assert RotationSpline.hermite([0, 1], HALF_TURN, rates)(0.5, 1)[2] > 0


def test_near_half_turns_have_a_direction():
    half = np.pi / 2 - ROUND_OFF
    q = [[0, 0, 0, 1], [0, 0, np.sin(half), np.cos(half)]]
    same(RotationSpline.hermite([0, 1], q, np.zeros((2, 3))).arc_length(), np.pi, 1e-9)


def test_the_first_pair_and_the_member_are_named():
    q = np.array([[0, 0, 0, 1], [0, 0, 1, 1], [0, 0, 1, -1], [0, 0, -1, -1]])
    rates = np.array([AXIS, AXIS, -AXIS, AXIS])
    undecided(np.arange(4.0), q, rates, 1)
    quarters = np.array([[0, 0, 0, 1], [0, 0, 1, 1], [0, 0, 1, 0], [0, 0, 1, -1]])
    batch, all_rates = np.stack([quarters, q]), np.stack([rates, rates])
    undecided(np.arange(4.0), batch, all_rates, 1, match=r"add a knot between them \(batch member 1\)")
