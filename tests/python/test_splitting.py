"""integrate_cubic: reference values, shapes, invariants, errors, interrupt."""

import json
from pathlib import Path

import numpy as np
import pytest
from covariant import EPS, NAMES, data

from stiefel_rs import InvalidInputError, integrate_cubic

CUBICS = json.loads((Path(__file__).parents[1] / "data" / "cubics.json").read_text())


@pytest.mark.parametrize("curve", CUBICS, ids=lambda curve: f"St{curve['n']}_{curve['k']}")
def test_reference_values_are_met(curve):
    initial = [np.array(curve["initial"][name]) for name in NAMES]
    trajectory = integrate_cubic(*initial, 80, order=8)
    for t, exact in curve["at"].items():
        i = round(80 * float(t))
        assert trajectory.t[i] == float(t)
        for name in NAMES:
            values = np.array(exact[name])
            error = np.max(np.abs(getattr(trajectory, name)[i] - values))
            assert error <= 1e-12 * max(1.0, np.max(np.abs(values))), (name, t, error)


@pytest.mark.parametrize("shape", [(1, 1), (2, 1), (3, 1), (3, 2), (4, 2), (5, 5), (20, 2)])
@pytest.mark.parametrize("order", [2, 4, 6, 8])
def test_shapes_and_invariants(shape, order):
    S, V, A, J = data(*shape)
    trajectory = integrate_cubic(S, V, A, J, 30, 2.0, order)
    n, k = shape
    for name in NAMES:
        values = getattr(trajectory, name)
        assert values.shape == (31, n, k) and values.dtype == np.float64
    for name, start in zip(NAMES, (S, V, A, J), strict=True):
        assert np.max(np.abs(getattr(trajectory, name)[0] - start)) <= 16 * n * EPS
    assert trajectory.t.shape == trajectory.energy.shape == (31,)
    assert trajectory.t[-1] == 2.0
    gram = np.swapaxes(trajectory.point, 1, 2) @ trajectory.point
    assert np.max(np.abs(gram - np.eye(k))) <= 16 * n * EPS
    assert 0.0 <= trajectory.momentum_drift <= 200 * n * EPS
    assert 0.0 <= trajectory.constraint_drift <= 1000 * n * EPS
    assert repr(trajectory) == f"<CubicTrajectory of shape (31, {n}, {k})>"


def test_default_order_is_six():
    arguments = data(5, 2)
    default = integrate_cubic(*arguments, 7).point
    assert np.array_equal(default, integrate_cubic(*arguments, 7, order=6).point)


def test_arguments_of_any_layout():
    S, V, A, J = data(6, 3)
    expected = integrate_cubic(S, V, A, J, 5).point
    padded = np.zeros((12, 6))
    padded[::2, ::2] = V
    layouts = (np.asfortranarray(S), padded[::2, ::2], A[::-1].copy()[::-1], J.tolist())
    assert np.array_equal(integrate_cubic(*layouts, 5).point, expected)
    integers = [np.array(x) for x in ([[1], [0], [0]], [[0], [1], [0]], [[0], [0], [1]], [[0], [0], [0]])]
    assert integrate_cubic(*integers, 5).point.shape == (6, 3, 1)


def test_long_and_short_calls_give_the_same_bits():
    arguments = data(4, 2)
    long = integrate_cubic(*arguments, 20_000, t_end=20.0)
    short = integrate_cubic(*arguments, 20, t_end=0.02)
    assert np.allclose(long.point[20], short.point[20], rtol=0, atol=1e-14)
    assert np.array_equal(long.point, integrate_cubic(*arguments, 20_000, t_end=20.0).point)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"steps": 0}, "steps"),
        ({"steps": -3}, "steps"),
        ({"steps": 2**62}, "steps"),
        ({"steps": 2**64}, "steps: must be few enough"),
        ({"steps": -(2**64)}, "steps: must be at least 1"),
        ({"order": 2**64}, "order"),
        ({"t_end": 0.0}, "t_end: must be not zero"),
        ({"t_end": 1e4}, "steps: too few, one exponential would turn by .* radians"),
        ({"order": 5}, "order"),
        ({"order": 0}, "order"),
        ({"t_end": np.nan}, "t_end"),
        ({"t_end": np.inf}, "t_end"),
    ],
)
def test_bad_scalars(change, text):
    S, V, A, J = data(4, 2)
    with pytest.raises(InvalidInputError, match=text):
        integrate_cubic(**{"S": S, "V": V, "A": A, "J": J, "steps": 5, **change})
