"""Arrays of other libraries: results are arrays of the arguments' library, and equal those for NumPy arrays."""

import array_api_strict as strict
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stiefel_rs import (
    Chart,
    CubicSpline,
    Geodesic,
    GeometricCubic,
    Grassmann,
    PoseSpline,
    RiemannianCubic,
    RotationSpline,
    Stiefel,
    estimate_velocities,
    orthogonal_log,
    skew_exp,
    solve_boundary,
)

M = Stiefel(5, 2)
S = M.random_point(rng=0)
V, W = 0.3 * M.random_tangent(S, rng=1), M.random_tangent(S, rng=2)
S1 = M.exp(S, V)
REST = np.zeros_like(S)
G = Grassmann(5, 2)
H = 0.3 * G.random_tangent(S, rng=3)
KNOTS = np.arange(3.0)
POINTS = np.stack([S, S1, M.exp(S, 2 * V)])
STATE = np.array([1.0, 0.2, 0.3, -0.4, 0.1, 0.2, -0.3, 0.5])
QUATERNIONS = Rotation.from_euler("xyz", [[0, 0, 0], [20, 5, 0], [30, -10, 15]], degrees=True).as_quat()
POSES = (QUATERNIONS, np.arange(9.0).reshape(3, 3) ** 2)
TIMES = np.array([0.1, 0.7])
CUBIC = RiemannianCubic.from_boundary(S, V, S1, REST)
SPLINE = CubicSpline(KNOTS, POINTS)

CALLS = {
    "skew_exp": (skew_exp, [np.array([[0.0, -1.0], [1.0, 0.0]])]),
    "skew_exp, complex": (skew_exp, [np.array([[1j, 0.0], [0.0, -0.5j]])]),
    "orthogonal_log": (orthogonal_log, [np.eye(4)]),
    "orthogonal_log, complex": (orthogonal_log, [np.diag([1j, 1.0])]),
    "project": (M.project, [S + 0.1]),
    "project_tangent": (M.project_tangent, [S, W]),
    "inner": (M.inner, [S, V, W]),
    "norm": (M.norm, [S, V]),
    "is_point": (M.is_point, [S]),
    "decompose": (M.decompose, [S, V]),
    "compose": (M.compose, [S, *M.decompose(S, V)]),
    "retract": (M.retract, [S, V]),
    "inverse_retract": (M.inverse_retract, [S, S1]),
    "exp": (M.exp, [S, V]),
    "log": (M.log, [S, S1]),
    "dist": (M.dist, [S, S1]),
    "transport": (M.transport, [S, V, W]),
    "curvature": (M.curvature, [S, V, W, V]),
    "sectional_curvature": (M.sectional_curvature, [S, V, W]),
    "gradient": (M.euclidean_to_riemannian_gradient, [S, W]),
    "hessian": (M.euclidean_to_riemannian_hessian, [S, W, W, V]),
    "subspaces: exp": (G.exp, [S, H]),
    "subspaces: dist": (G.dist, [S, S1]),
    "subspaces: angles": (G.principal_angles, [S, S1]),
    "subspaces: align": (G.align, [S, S1]),
    "subspaces: projector": (G.projector, [S]),
    "embed": (Chart.sphere().embed, [STATE[:2]]),
    "derivatives": (Chart.sphere().derivatives, [STATE]),
    "hamiltonian": (Chart.sphere().hamiltonian, [STATE]),
    "curve": (CUBIC, [TIMES]),
    "curve, one time": (SPLINE, [np.array(0.5)]),
    "velocity": (SPLINE.velocity, [TIMES]),
    "acceleration": (GeometricCubic(S, V, S1, REST).acceleration, [TIMES]),
    "point_pullback": (CUBIC.point_pullback, [TIMES, np.stack([S, S1])]),
    "spline pullback": (lambda t, W: SPLINE.point_pullback(t, W)[:2], [TIMES, np.stack([S, S1])]),
    "spline variation": (SPLINE.point_variation, [TIMES, np.zeros_like(POINTS)]),
    "estimate_velocities": (estimate_velocities, [KNOTS, POINTS]),
    "solve_boundary": (solve_boundary, [S, V, S1, REST]),
    "rotations": (RotationSpline(KNOTS, QUATERNIONS), [TIMES]),
    "rates": (RotationSpline(KNOTS, QUATERNIONS).angular_velocity, [TIMES]),
    "poses": (PoseSpline(KNOTS, POSES), [TIMES]),
    "twist": (PoseSpline(KNOTS, POSES).twist, [TIMES]),
}


def parts(value):
    return value if isinstance(value, tuple) else (value,)


@pytest.mark.parametrize("name", CALLS)
def test_results_are_arrays_of_the_library_of_the_arguments(name):
    function, arguments = CALLS[name]
    found = parts(function(*map(strict.asarray, arguments)))
    expected = parts(function(*arguments))
    assert len(found) == len(expected)
    for one, other in zip(found, expected, strict=True):
        assert one.__array_namespace__() is strict, type(one)
        assert np.asarray(one).dtype == np.asarray(other).dtype
        np.testing.assert_array_equal(np.asarray(one), other)


def test_curves_of_other_arrays_are_those_of_numpys():
    data = [S, V, S1, REST]
    one = GeometricCubic(*map(strict.asarray, data))
    np.testing.assert_array_equal(one(0.3), GeometricCubic(*data)(0.3))
    points, knots = strict.asarray(POINTS), strict.asarray(KNOTS)
    np.testing.assert_array_equal(CubicSpline(knots, points)(0.3), SPLINE(0.3))
    rotations = RotationSpline(knots, strict.asarray(QUATERNIONS))
    np.testing.assert_array_equal(rotations(0.3), RotationSpline(KNOTS, QUATERNIONS)(0.3))


def test_numpys_arrays_and_numbers_mix_with_any_library():
    assert M.exp(strict.asarray(S), V.tolist()).__array_namespace__() is strict
    assert isinstance(SPLINE(0.5), np.ndarray)
    assert isinstance(M.exp(jnp.asarray(S), V), jnp.ndarray)


def test_two_libraries_are_refused_by_name():
    with pytest.raises(TypeError, match=r"S and V: arrays of different libraries, array_api_strict and jax.numpy"):
        M.exp(strict.asarray(S), jnp.asarray(V))


def test_two_libraries_are_refused_before_any_work():
    # Invalid points: the libraries are checked first.
    with pytest.raises(TypeError, match="arrays of different libraries"):
        M.log(strict.asarray(0 * S), jnp.asarray(S))


def test_traced_arrays_are_sent_to_the_module_for_them():
    spline = RotationSpline(KNOTS, QUATERNIONS)
    for function in (lambda t: spline(t + 1), lambda t: SPLINE(t + 1), lambda t: M.exp(S, t * V)):
        with pytest.raises(TypeError, match=r"traced by JAX; use the functions of stiefel_rs\.jax"):
            jax.jit(function)(0.5)


def test_what_has_only_dlpack_is_read():
    class Exported:
        def __init__(self, array):
            self.array = array

        def __dlpack__(self, **options):
            return self.array.__dlpack__(**options)

        def __dlpack_device__(self):
            return self.array.__dlpack_device__()

    np.testing.assert_array_equal(M.exp(Exported(S), Exported(V)), S1)
    spline = RotationSpline(KNOTS, QUATERNIONS)
    np.testing.assert_array_equal(spline(Exported(TIMES)), spline(TIMES))


def test_single_precision_of_jax_is_projected():
    point, vector = jnp.asarray(S, dtype=jnp.float32), jnp.asarray(V, dtype=jnp.float32)
    found = M.exp(point, vector)
    assert isinstance(found, jnp.ndarray)
    assert np.abs(np.asarray(found) - S1).max() < 1e-6


def test_numbers_are_numbers():
    for number in (M.norm(S, V), M.dist(S, S1), G.dist(S, S1), M.sectional_curvature(S, V, W), G.inner(S, H, H)):
        assert isinstance(number, float)
    assert M.norm(np.stack([S, S1]), np.stack([V, REST])).shape == (2,)
    assert Geodesic(S, S1).length == pytest.approx(M.dist(S, S1), abs=1e-14)
