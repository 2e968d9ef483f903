"""Input checks shared by both chart-free integrators of cubics: refused arrays, overflowing values."""

import numpy as np
import pytest
from covariant import data

import stiefel_rs
from stiefel_rs import InvalidInputError, integrate_cubic, integrate_embedded

both = pytest.mark.parametrize("integrate", [integrate_cubic, integrate_embedded])


@both
@pytest.mark.parametrize("index", range(4))
def test_bad_arrays(integrate, index):
    arguments = list(data(4, 2))
    good = arguments[index]
    for wrong in (good * np.nan, good[:3], np.stack([good, good]), good[:, 0], 1.5 * arguments[0]):
        arguments[index] = wrong
        with pytest.raises(InvalidInputError, match="SVAJ"[index]):
            integrate(*arguments, 5)
    arguments[index] = good.astype(str)
    with pytest.raises(TypeError):
        integrate(*arguments, 5)


@both
def test_huge_values_raise_or_are_right(integrate):
    for shape in [(3, 1), (4, 2)]:
        for speed, t_end in [(1e200, 1.0), (1.0, 1e300), (1e8, 1e8)]:
            try:
                trajectory = integrate(*data(*shape, speed=speed), 3, t_end=t_end)
            except stiefel_rs.StiefelError:
                continue
            assert np.all(np.isfinite(trajectory.jerk))
