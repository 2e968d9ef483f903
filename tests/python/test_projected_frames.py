"""The projection of arrays near frames and its derivative: against singular value decompositions and differences."""

import numpy as np
import pytest

from stiefel_rs import InvalidInputError
from stiefel_rs.differentiable.arguments import NEAR, Frame

FRAME = Frame("S")
SHAPES = [(1, 1), (3, 1), (3, 3), (5, 2), (20, 5)]


def numbers(shape, rng, field):
    found = rng.normal(size=shape)
    return found + 1j * rng.normal(size=shape) if field == "complex" else found


@pytest.fixture(params=["real", "complex"])
def field(request):
    return request.param


@pytest.fixture(params=SHAPES, ids=str)
def near(request, field, rng):
    """Arrays with a given norm of `S^H S - I`, two frames in each."""
    n, k = request.param
    S = np.linalg.qr(numbers((2, n, k), rng, field))[0]
    stretch = numbers((2, k, k), rng, field)
    stretch = stretch + np.swapaxes(stretch, 1, 2).conj()
    stretch /= np.linalg.norm(stretch, axis=(1, 2), keepdims=True)
    return lambda defect: S @ (np.eye(k) + 0.5 * defect * stretch)


# Round-off, the series, and its limit from both sides.
DEFECTS = [0.0, 1e-13, 1e-9, 0.99 * NEAR, 1.01 * NEAR, 1e-4]


@pytest.mark.parametrize("defect", DEFECTS)
def test_the_projection_is_the_polar_factor(near, defect):
    raw = near(defect)
    left, _, right = np.linalg.svd(raw, full_matrices=False)
    assert np.abs(FRAME.value(raw, ()) - left @ right).max() < 2e-14


@pytest.mark.parametrize("defect", DEFECTS)
def test_its_derivative_is_that_of_the_polar_factor(near, defect, rng, field):
    """Differences of order four, of projections by singular value decompositions."""
    raw = near(defect)
    Z = numbers(raw.shape, rng, field)
    Z /= np.linalg.norm(Z)
    h = 1e-3

    def projected(s):
        left, _, right = np.linalg.svd(raw + s * h * Z, full_matrices=False)
        return left @ right

    differences = (8 * (projected(1) - projected(-1)) - (projected(2) - projected(-2))) / (12 * h)
    assert np.abs(FRAME.variation(raw, (), Z, ()) - differences).max() < 1e-11


def test_the_derivative_does_not_jump_where_the_series_ends(near, rng, field):
    below, above = near((1 - 1e-9) * NEAR), near((1 + 1e-9) * NEAR)
    Z = numbers(below.shape, rng, field)
    Z /= np.linalg.norm(Z)
    jump = FRAME.variation(below, (), Z, ()) - FRAME.variation(above, (), Z, ())
    # 1.4e-13 in 1500 cases.
    assert np.abs(jump).max() < 1e-12


@pytest.mark.parametrize("defect", DEFECTS)
def test_the_derivative_is_symmetric(near, defect, rng, field):
    raw = near(defect)
    Z, W = (numbers(raw.shape, rng, field) for _ in range(2))
    inner = [np.sum(one.conj() * FRAME.variation(raw, (), other, ())).real for one, other in ((W, Z), (Z, W))]
    # 1.2e-14 in 9000 cases.
    assert inner[0] == pytest.approx(inner[1], rel=1e-13, abs=1e-13)


def test_coordinate_columns_are_their_own_projection():
    raw = np.eye(4)[:, [2, 0]]
    Z = np.arange(8.0).reshape(4, 2)
    assert np.array_equal(FRAME.value(raw, ()), raw)
    assert np.array_equal(FRAME.value(raw * (1 + 1e-9), ()), raw)
    moved = FRAME.variation(raw, (), Z, ())
    inner = raw.T @ moved
    assert np.abs(inner + inner.T).max() == 0
    assert np.array_equal(moved[[1, 3]], Z[[1, 3]])


def test_arrays_far_from_frames_are_refused(near):
    with pytest.raises(InvalidInputError, match="columns are not orthonormal"):
        FRAME.value(1.1 * near(0.0), ())


def test_axes_of_a_batch_may_be_in_any_order(near, field):
    S = np.stack([near(0.0), near(0.0), near(0.0)]).swapaxes(0, 1)
    assert not S.flags.c_contiguous
    assert FRAME.value(S, ()) is S
    with pytest.raises(InvalidInputError, match="columns are not orthonormal"):
        FRAME.value(1e-4 * S, ())


@pytest.mark.parametrize("size", [1e-200, 1e-4, 0.9, 1e10, 1e100, 1e200])
def test_arrays_of_any_size_are_refused_without_a_warning(near, size):
    with pytest.raises(InvalidInputError, match="columns are not orthonormal"):
        FRAME.value(size * near(0.0), ())
