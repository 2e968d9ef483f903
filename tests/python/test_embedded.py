"""integrate_embedded: the exact cubic, order, shapes, invariants, errors."""

import numpy as np
import pytest
from covariant import EPS, NAMES, data

from stiefel_rs import ConvergenceError, InvalidInputError, RiemannianCubic, Stiefel, integrate_embedded

SHAPES = [(1, 1), (2, 1), (3, 1), (3, 2), (5, 2), (4, 4), (20, 2)]


@pytest.mark.parametrize("shape", [(3, 1), (3, 2), (5, 2), (4, 4)])
def test_the_cubic_is_met_with_order_two(shape):
    initial = data(*shape)
    exact = RiemannianCubic.from_initial(*initial)
    expected = [exact(1.0), exact(1.0, 1), exact.acceleration(1.0), exact.jerk(1.0)]
    errors = []
    for steps in (40, 80, 160):
        trajectory = integrate_embedded(*initial, steps)
        ends = [getattr(trajectory, name)[-1] for name in NAMES]
        errors.append(max(np.linalg.norm(a - b) for a, b in zip(ends, expected, strict=True)))
    assert errors[-1] < 1e-3
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all(np.abs(orders - 2) <= 0.2), orders


@pytest.mark.parametrize("shape", SHAPES)
def test_shapes_and_invariants(shape):
    n, k = shape
    initial = data(n, k)
    trajectory = integrate_embedded(*initial, 30, 2.0)
    largest = max(np.linalg.norm(getattr(trajectory, name), axis=(1, 2)).max() for name in NAMES)
    for name, start in zip(NAMES, initial, strict=True):
        values = getattr(trajectory, name)
        assert values.shape == (31, n, k) and values.dtype == np.float64 and not values.flags.writeable
        assert np.max(np.abs(values[0] - start)) <= 16 * n * EPS
    assert trajectory.t.shape == trajectory.energy.shape == (31,)
    assert trajectory.t[-1] == 2.0
    gram = np.swapaxes(trajectory.point, 1, 2) @ trajectory.point
    assert np.max(np.abs(gram - np.eye(k))) <= 16 * n * EPS
    inner = np.swapaxes(trajectory.point, 1, 2) @ trajectory.velocity
    assert np.max(np.abs(inner + np.swapaxes(inner, 1, 2))) <= 16 * n * EPS * largest
    # Five and eight times the constants in `tests/embedded.rs`, since the data differ.
    assert 0.0 <= trajectory.constraint_drift <= 8 * n * EPS * largest
    assert 0.0 <= trajectory.momentum_drift <= 8 * n * EPS * largest
    assert repr(trajectory) == f"<CubicTrajectory of shape (31, {n}, {k})>"


def test_energy_is_that_of_the_state():
    S, V, A, J = data(5, 2)
    M = Stiefel(5, 2)
    energy = integrate_embedded(S, V, A, J, 10).energy
    assert abs(energy[0] - (M.inner(S, A, A) / 2 - M.inner(S, J, V))) <= 64 * EPS
    assert np.ptp(energy) < 1e-2


def test_the_same_steps_lead_back():
    initial = data(5, 2)
    there = integrate_embedded(*initial, 15)
    back = integrate_embedded(*(getattr(there, name)[-1] for name in NAMES), 15, -1.0)
    for name, start in zip(NAMES, initial, strict=True):
        assert np.max(np.abs(getattr(back, name)[-1] - start)) <= 1e-12, name


def test_arguments_of_any_layout():
    S, V, A, J = data(6, 3)
    expected = integrate_embedded(S, V, A, J, 5).point
    layouts = (np.asfortranarray(S), np.repeat(V, 2, axis=0)[::2], A[::-1].copy()[::-1], J.tolist())
    assert np.array_equal(integrate_embedded(*layouts, 5, map="midpoint").point, expected)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"steps": 0}, "steps"),
        ({"steps": -3}, "steps"),
        ({"steps": 2**62}, "steps"),
        ({"t_end": 0.0}, "t_end: must be not zero"),
        ({"t_end": np.nan}, "t_end"),
        ({"t_end": np.inf}, "t_end"),
        ({"map": "initial_point"}, "map: must be 'midpoint', found 'initial_point'"),
        ({"map": ""}, "map"),
    ],
)
def test_bad_scalars(change, text):
    S, V, A, J = data(4, 2)
    with pytest.raises(InvalidInputError, match=text):
        integrate_embedded(**{"S": S, "V": V, "A": A, "J": J, "steps": 5, **change})


def test_a_step_that_is_too_long():
    with pytest.raises(ConvergenceError) as caught:
        integrate_embedded(*data(4, 2), 1, 20.0)
    report = caught.value.report
    assert not report.converged and report.reason in {"diverged", "max_iterations"}
