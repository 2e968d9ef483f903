"""Gradients in JAX: derivatives compared with differences and formulas, transformations, single precision, errors."""

import importlib
import os
import subprocess
import sys

import numpy as np
import pytest
from beside import HANGS

jax = pytest.importorskip("jax")

import jax.numpy as jnp  # noqa: E402
from jax.test_util import check_grads  # noqa: E402

import stiefel_rs  # noqa: E402
from stiefel_rs import (  # noqa: E402
    CubicSpline,
    GeometricCubic,
    Grassmann,
    InvalidInputError,
    RiemannianCubic,
    RotationSpline,
    Stiefel,
)
from stiefel_rs import jax as sj  # noqa: E402
from stiefel_rs.differentiable import cubics, solved, splines  # noqa: E402
from stiefel_rs.differentiable.arguments import Plain  # noqa: E402
from stiefel_rs.differentiable.operation import Operation  # noqa: E402

SHAPES = [(3, 1), (3, 3), (5, 2), (4, 4), (12, 3)]
TIMES = np.array([0.0, 0.3, 1.0])
KNOTS = np.array([0.0, 0.7, 1.6, 2.2])


@pytest.fixture(autouse=True)
def double_precision():
    # Under its later name, or under the name in releases for Python 3.10.
    enable = jax.enable_x64 if hasattr(jax, "enable_x64") else importlib.import_module("jax.experimental").enable_x64
    with enable(True):
        yield


@pytest.fixture(
    params=[*SHAPES, *((*shape, "complex") for shape in SHAPES)], ids=lambda words: "_".join(map(str, words))
)
def manifold(request):
    n, k, *field = request.param
    return Stiefel(n, k, field=field[0] if field else "real")


def near(manifold, rng, length=0.5):
    """A point, a tangent vector there, another point, a tangent vector there."""
    S0 = manifold.random_point(rng)
    S1 = manifold.exp(S0, vector(manifold, S0, rng, length))
    return S0, vector(manifold, S0, rng), S1, vector(manifold, S1, rng)


def vector(manifold, S, rng, length=0.6):
    V = manifold.random_tangent(S, rng)
    return length * V / manifold.norm(S, V)


def frames(manifold, rng, count=4):
    points = [manifold.random_point(rng)]
    while len(points) < count:
        points.append(manifold.exp(points[-1], vector(manifold, points[-1], rng, 0.5)))
    return np.array(points)


def quaternions(rng, count=4):
    q = rng.normal(size=(count, 4))
    return np.array([1.0, -0.5, 0.2, 2.0]) + 0.4 * q


def check(function, arguments):
    """Both modes compared with central differences, whose error is about 1e-9."""
    check_grads(function, arguments, order=1, modes=["fwd", "rev"], atol=1e-6, rtol=1e-6, eps=1e-5)


def test_matrix_functions(rng):
    for m in (1, 2, 3, 4, 7):
        A = rng.normal(size=(m, m))
        A = (A - A.T) / np.linalg.norm(A)
        check(sj.skew_exp, (A,))
        check(sj.orthogonal_log, (stiefel_rs.skew_exp(A),))


def test_complex_matrix_functions(rng):
    for m in (1, 2, 3, 5):
        A = rng.normal(size=(m, m)) + 1j * rng.normal(size=(m, m))
        A = (A - A.conj().T) / np.linalg.norm(A)
        check(sj.skew_exp, (A,))
        check(sj.orthogonal_log, (stiefel_rs.skew_exp(A),))
    # The derivative of a real function of a complex matrix follows JAX's convention.
    gradient = jax.grad(lambda A: sj.skew_exp(A).real.sum())(A)
    by_entries = jax.grad(lambda re, im: jnp.sum(sj.skew_exp(re + 1j * im).real), argnums=(0, 1))(A.real, A.imag)
    np.testing.assert_allclose(gradient, by_entries[0] - 1j * by_entries[1], rtol=0, atol=1e-14)


def test_maps_of_points_and_vectors(manifold, rng):
    S0, V, S1, _ = near(manifold, rng)
    for function in (sj.exp, sj.retract):
        check(function, (S0, V))
    for function in (sj.log, sj.inverse_retract):
        check(function, (S0, S1))


def test_values_are_those_of_the_package(manifold, rng):
    S0, V0, S1, V1 = near(manifold, rng)
    zero, A, J = (vector(manifold, S0, rng, length) for length in (0.0, 1.0, 2.0))
    points = frames(manifold, rng)
    pairs = [
        (sj.exp(S0, V0), manifold.exp(S0, V0)),
        (sj.exp(S0, zero), S0),
        (sj.log(S0, S1), manifold.log(S0, S1)),
        (sj.retract(S0, V0), manifold.retract(S0, V0)),
        (sj.inverse_retract(S0, S1), manifold.inverse_retract(S0, S1)),
        (sj.geometric_cubic(S0, V0, S1, V1, TIMES), GeometricCubic(S0, V0, S1, V1)(TIMES)),
        (sj.riemannian_cubic(S0, V0, S1, V1, TIMES), RiemannianCubic.from_boundary(S0, V0, S1, V1)(TIMES)),
        (sj.cubic_initial(S0, V0, A, J, TIMES), RiemannianCubic.from_initial(S0, V0, A, J)(TIMES)),
        (sj.cubic_spline(KNOTS, points, TIMES), CubicSpline(KNOTS, points)(TIMES)),
    ]
    for found, wanted in pairs:
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-13)


def test_curves(manifold, rng):
    S0, V0, S1, V1 = near(manifold, rng)
    inside = np.array([0.1, 0.4, 0.9])
    for function in (sj.geometric_cubic, sj.riemannian_cubic):
        check(function, (S0, V0, S1, V1, inside))
    A, J = vector(manifold, S0, rng), vector(manifold, S0, rng)
    # The last time is the end of the curve, which differences must not cross.
    check(lambda *data: sj.cubic_initial(*data, jnp.append(inside, 1.0)), (S0, V0, A, J))
    check(lambda t: sj.cubic_initial(S0, V0, A, J, jnp.append(t, 1.0)), (inside,))


def test_back_in_time(rng):
    manifold = Stiefel(4, 2)
    S, V, *_ = near(manifold, rng)
    A, J = vector(manifold, S, rng), vector(manifold, S, rng)
    t = np.array([-0.9, -0.3, 0.0])
    found = sj.cubic_initial(S, V, A, J, t)
    np.testing.assert_allclose(found, RiemannianCubic.from_initial(S, V, A, J, t_end=-1.0)(t), rtol=0, atol=1e-14)
    check(lambda *data: sj.cubic_initial(*data, t), (S, V, A, J))
    check(lambda t: sj.cubic_initial(S, V, A, J, jnp.append(t, -1.0)), (t[:2],))


@pytest.mark.parametrize("bc_type", ["natural", "clamped"])
def test_splines(manifold, rng, bc_type):
    points = frames(manifold, rng)
    check(lambda knots, S, t: sj.cubic_spline(knots, S, t, bc_type), (KNOTS, points, np.array([0.2, 1.0, 2.1])))


@pytest.mark.parametrize("bc_type", ["natural", "clamped", "periodic"])
def test_splines_of_rotations(rng, bc_type):
    q = quaternions(rng)

    def spline(knots, q, t):
        if bc_type == "periodic":
            q = jnp.concatenate([q[:-1], q[:1]])
        return sj.rotation_spline(knots, q, t, bc_type)

    check(spline, (KNOTS, q, np.array([0.2, 1.0, 2.1])))
    if bc_type != "periodic":
        t = np.array([[0.0, 0.7], [1.3, 2.2]])
        found = sj.rotation_spline(KNOTS, q, t, bc_type)
        np.testing.assert_allclose(found, RotationSpline(KNOTS, q, bc_type)(t), rtol=0, atol=1e-15)


@pytest.mark.parametrize("kind", ["frames", "subspaces", "complex subspaces", "rotations"])
def test_closed_splines_move_with_the_mean_of_both_ends(kind, rng):
    t = np.array([0.2, 1.0, 2.1])
    if kind == "rotations":
        points, others = quaternions(rng), lambda points: np.concatenate([points[:-1], -3.0 * points[:1]])

        def spline(points):
            return sj.rotation_spline(KNOTS, points, t, "periodic")
    else:
        field = "complex" if "complex" in kind else "real"
        manifold = Grassmann(5, 2, field=field) if "subspaces" in kind else Stiefel(5, 2)
        points, others = frames(manifold, rng), lambda points: np.concatenate([points[:-1], points[:1]])

        def spline(points):
            return sj.cubic_spline(KNOTS, points, t, "periodic", manifold=manifold)

    data = others(points)
    moves = [rng.normal(size=data.shape) + (1j * rng.normal(size=data.shape) if "complex" in kind else 0.0)]
    # The same direction, with both ends moved alike.
    ends = moves[0][0], moves[0][-1] / (-3.0 if kind == "rotations" else 1.0)
    mean = 0.5 * (ends[0] + ends[1])
    moves.append(np.concatenate([mean[None], moves[0][1:-1], others(mean[None].repeat(2, axis=0))[1:]]))
    found, alike = (jax.jvp(spline, (data,), (move.astype(data.dtype),))[1] for move in moves)
    if "subspaces" not in kind:
        np.testing.assert_allclose(found, alike, rtol=0, atol=1e-12)
    weights = np.cos(np.arange(found.size)).reshape(found.shape)
    value, pull_back = jax.vjp(spline, data)
    (gradient,) = pull_back(weights.astype(value.dtype))
    forward, back = np.sum(weights * found), np.sum(gradient * moves[0])
    assert complex(back).real == pytest.approx(complex(forward).real, abs=1e-11)


def cotangents(function, *arguments):
    value, pull_back = jax.vjp(function, *arguments)
    return pull_back(jnp.cos(jnp.arange(value.size, dtype=float)).reshape(value.shape))


def test_special_points_have_finite_derivatives():
    for n, k in SHAPES:
        S, zero, one = np.eye(n)[:, :k], np.zeros((n, k)), np.eye(n)
        permuted = one[:, ::-1][:, :k]
        found = [
            *cotangents(sj.skew_exp, 0.0 * one),
            *cotangents(sj.orthogonal_log, one),
            *cotangents(sj.exp, S, zero),
            *cotangents(sj.log, S, S),
            *cotangents(sj.retract, permuted, zero),
            *cotangents(sj.inverse_retract, permuted, permuted),
            *cotangents(sj.geometric_cubic, S, zero, S, zero, TIMES),
            *cotangents(sj.riemannian_cubic, S, zero, S, zero, TIMES),
            *cotangents(sj.cubic_initial, permuted, zero, zero, zero, TIMES),
            *cotangents(sj.cubic_spline, KNOTS, np.array(4 * [S]), TIMES),
        ]
        for gradient in found:
            assert np.isfinite(gradient).all()
            assert np.abs(gradient).max(initial=0.0) < 1e2


def test_derivatives_at_the_identity_are_those_of_flat_space():
    E = np.array([[0.0, 1.0, -2.0], [-1.0, 0.0, 0.5], [2.0, -0.5, 0.0]])
    for function, at in ((sj.skew_exp, np.zeros((3, 3))), (sj.orthogonal_log, np.eye(3))):
        _, moved = jax.jvp(function, (at,), (E,))
        np.testing.assert_allclose(moved, E, rtol=0, atol=1e-15)


@pytest.mark.parametrize("gap", [1e-9, 1e-6])
def test_next_to_a_half_turn(gap):
    angle = np.pi - gap
    axis = np.array([0.6, 0.0, 0.8])
    A = angle * np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    (gradient,) = cotangents(sj.orthogonal_log, stiefel_rs.skew_exp(A))
    assert np.isfinite(gradient).all()
    # There the logarithm is the inverse of the exponential.
    E = np.array([[0.0, 1.0, -2.0], [-1.0, 0.0, 0.5], [2.0, -0.5, 0.0]])
    _, moved = jax.jvp(lambda A: sj.orthogonal_log(sj.skew_exp(A)), (A,), (E,))
    np.testing.assert_allclose(moved, E, rtol=0, atol=1e-8)
    q = np.array([[0.0, 0, 0, 1], [*(np.sin(angle / 2) * axis), np.cos(angle / 2)], [0.1, 0.2, 0.9, 0.3]])
    for gradient in cotangents(sj.rotation_spline, np.array([0.0, 1.0, 2.0]), q, np.array([0.5, 1.5])):
        assert np.isfinite(gradient).all()


@pytest.mark.parametrize("shape", [(3, 1), (3, 3), (5, 2)])
def test_transformations_mix(shape, rng):
    manifold = Stiefel(*shape)
    S0, V0, S1, V1 = near(manifold, rng)
    batch = np.array([V0, 0.5 * V0, 0.0 * V0])

    def reach(V, t):
        return jnp.sum(jnp.sin(sj.riemannian_cubic(S0, V, S1, V1, t)))

    gradient = jax.grad(reach)
    one_by_one = np.array([gradient(V, TIMES) for V in batch])
    mixed = jax.jit(jax.vmap(gradient, in_axes=(0, None)))(batch, TIMES)
    np.testing.assert_allclose(mixed, one_by_one, rtol=0, atol=1e-13)
    # The last axis instead of the first, and both modes.
    moved = jax.vmap(gradient, in_axes=(2, None), out_axes=2)(np.moveaxis(batch, 0, 2), TIMES)
    np.testing.assert_allclose(np.moveaxis(moved, 2, 0), one_by_one, rtol=0, atol=1e-13)
    curve = jax.jit(lambda V: sj.riemannian_cubic(S0, V, S1, V1, TIMES))
    np.testing.assert_allclose(jax.jacfwd(curve)(V0), jax.jacrev(curve)(V0), rtol=0, atol=1e-12)
    # A batch gives the results of its members.
    stacked = sj.riemannian_cubic(S0, batch, S1, V1, TIMES)
    assert stacked.shape == (3, 3, *S0.shape)
    np.testing.assert_allclose(stacked[1], sj.riemannian_cubic(S0, batch[1], S1, V1, TIMES), rtol=0, atol=1e-15)


def test_two_batches(rng):
    A = rng.normal(size=(2, 3, 4, 4))
    A -= np.swapaxes(A, -1, -2)
    found = jax.vmap(jax.vmap(sj.skew_exp))(A)
    np.testing.assert_allclose(found, stiefel_rs.skew_exp(A), rtol=0, atol=1e-14)


def test_single_precision_in_and_out(rng):
    manifold = Stiefel(5, 2)
    data = [x.astype(np.float32) for x in near(manifold, rng)]
    for function in (sj.riemannian_cubic, sj.geometric_cubic):
        found = function(*data, TIMES.astype(np.float32))
        assert found.dtype == np.float32
        double = function(*(x.astype(float) for x in data), TIMES.astype(np.float32).astype(float))
        np.testing.assert_allclose(found, double, rtol=0, atol=2e-6)
    gradient = jax.grad(lambda S: sj.riemannian_cubic(S, *data[1:], TIMES.astype(np.float32))[1, 0, 0])(data[0])
    assert gradient.dtype == np.float32


def test_arguments_off_their_constraints():
    S = np.eye(4)[:, :2]
    with pytest.raises(InvalidInputError, match=r"S: columns are not orthonormal, .* 0\.1,"):
        sj.exp(1.1 * S, 0 * S)
    with pytest.raises(InvalidInputError, match=r"V: not tangent.* = 1,"):
        sj.retract(S, S)
    with pytest.raises(InvalidInputError, match="A: not skew"):
        sj.skew_exp(np.eye(3))
    with pytest.raises(InvalidInputError, match="S1: columns are not orthonormal"):
        sj.inverse_retract(S, 1.1 * S)
    with pytest.raises(InvalidInputError, match="V1: not tangent"):
        sj.geometric_cubic(S, 0 * S, S, S, 0.5)
    with pytest.raises(InvalidInputError, match="S0: not finite"):
        sj.log(np.nan * S, S)
    with pytest.raises(InvalidInputError, match="A: not skew"):
        sj.skew_exp(np.eye(2) + 0j)
    with pytest.raises(TypeError, match="t: expected real numbers, found complex128"):
        sj.riemannian_cubic(S, 0 * S, S, 0 * S, np.array([0.5j]))
    with pytest.raises(TypeError, match="quaternions: expected real numbers, found complex128"):
        sj.rotation_spline(KNOTS, np.eye(4) + 0j, TIMES)
    with pytest.raises(InvalidInputError, match="S0: expected at least 2 axes"):
        sj.log(S[0], S)
    with pytest.raises(InvalidInputError, match="bc_type: expected one of"):
        sj.rotation_spline(KNOTS, np.eye(4), TIMES, "not-a-knot")
    # Under jit, JAX raises an error of its own.
    with pytest.raises(Exception, match="columns are not orthonormal"):
        jax.jit(sj.exp)(1.1 * S, 0 * S).block_until_ready()


def test_shapes_that_do_not_fit():
    S, S1 = np.eye(3)[:, :2], np.eye(3)[:, 1:]
    cases = [
        (lambda: sj.riemannian_cubic(S, S[:, :1], S1, S1, 0.5), r"V0: expected shape \(3, 2\), the shape of its frame"),
        (lambda: sj.retract(np.eye(3)[:2], np.zeros((2, 3))), r"S: expected shape \(..., n, k\) with 1 <= k <= n"),
        (lambda: sj.skew_exp(np.zeros((2, 3))), r"A: expected shape \(..., m, m\)"),
        (lambda: sj.inverse_retract(S, S1[:, :1]), r"S1: expected shape \(3, 2\), found \(3, 1\)"),
        (lambda: sj.log(S, S1[:, :1]), r"S1: expected shape \(3, 2\)"),
        (lambda: sj.rotation_spline(KNOTS, np.ones((4, 3)), 0.5), r"quaternions: expected shape \(..., 4\)"),
        (lambda: sj.cubic_spline(KNOTS, np.array(3 * [S]), 0.5), "t_knots: expected one time for each of the 3 knots"),
    ]
    for call, message in cases:
        with pytest.raises(InvalidInputError, match=message):
            call()
    # Shapes are known while a function is being traced.
    with pytest.raises(InvalidInputError, match="S1: expected shape"):
        jax.jit(sj.log)(S, S1[:, :1])
    with pytest.raises(InvalidInputError, match="t: not finite"):
        sj.geometric_cubic(S, 0 * S, S1, 0 * S, np.nan)


def test_traced_rotations_name_the_functions_to_use(rng):
    q = quaternions(rng)
    for make in (RotationSpline, RotationSpline.smoothing):
        with pytest.raises(TypeError, match=r"rotations: traced by JAX; use the functions of stiefel_rs\.jax"):
            jax.grad(lambda q, make=make: make(KNOTS, q)(0.3).sum())(q)


def test_times_outside_of_the_knots_raise():
    for function in (sj.rotation_spline, jax.grad(lambda *data: jnp.sum(sj.rotation_spline(*data)))):
        with pytest.raises(InvalidInputError, match=r"between|outside"):
            function(KNOTS, np.array([1.0, 0.0, 0.0, 2.0]) + np.eye(4), 2.5)
    # Compiled, the gradient is computed without the value.
    compiled = jax.jit(
        jax.grad(lambda t: jnp.sum(sj.rotation_spline(KNOTS, np.array([1.0, 0.0, 0.0, 2.0]) + np.eye(4), t)))
    )
    with pytest.raises(Exception, match=r"between the first and the last knot, 0\.0 and 2\.2, found 2\.5"):
        compiled(2.5)


def test_equal_members_of_a_batch_are_solved_once(rng, monkeypatch):
    manifold = Stiefel(3, 1)
    S0, V0, S1, V1 = near(manifold, rng)
    calls = []
    boundary = cubics._BETWEEN
    solve = boundary._solve
    monkeypatch.setattr(boundary, "_solve", lambda *data: calls.append(1) or solve(*data))
    lengths = np.linspace(0.51, 1.53, 5)[:, None, None]
    value, pull_back = jax.vjp(lambda V: sj.riemannian_cubic(S0, V, S1, V1, TIMES), lengths * V0)
    assert len(calls) == 5
    jax.vmap(pull_back)(rng.normal(size=(3, *value.shape)))
    assert len(calls) == 5


def test_arguments_are_projected_once_and_copied():
    class Counted(Plain):
        def value(self, raw, exact):
            calls.append(self.name)
            return super().value(raw, exact)

    calls = []
    square = Operation(
        "square",
        arguments=(Counted("x"),),
        axes=(1,),
        shape=lambda x: x,
        value=lambda x: x**2,
        variation=lambda x, dx: 2 * x[0] * dx[0],
        pullback=lambda x, w: (2 * x[0] * w,),
    )
    lent = np.array([[1.0, 2.0], [3.0, 4.0]])
    np.testing.assert_array_equal(square.values(lent), lent**2)
    np.testing.assert_array_equal(square.pullbacks((lent,), np.ones((2, 2)))[0], 2 * lent)
    assert len(calls) == 2
    lent[:] = 5.0
    np.testing.assert_array_equal(square.values(np.array([[1.0, 2.0]])), [[1.0, 4.0]])
    np.testing.assert_array_equal(square.values(lent), np.full((2, 2), 25.0))
    assert len(calls) == 3


def test_what_is_kept_has_a_limit(monkeypatch):
    monkeypatch.setattr(solved, "KEPT", 50)
    kept = solved.Solved(lambda x: x.sum(), lambda x: x.size)
    found = [kept((np.full(10, i, dtype=float),)) for i in (0, 1, 0, 2, 3)]
    assert found == [0.0, 10.0, 0.0, 20.0, 30.0]
    assert len(kept._kept) == 2


ON_ONE_CORE = """
import os
os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
import jax, jax.numpy as jnp, numpy as np
from stiefel_rs.jax import rotation_spline
jax.config.update("jax_enable_x64", True)
rng = np.random.default_rng(0)
q = np.cumsum(0.05 * rng.normal(size=(1000, 4)), axis=0) + [1, 0.3, 0.2, 2.0]
knots, t = np.arange(1000.0), np.linspace(0, 999, 4000)
f = jax.jit(jax.value_and_grad(lambda q: rotation_spline(knots, q, t).sum()))
for i in range(6):
    jax.block_until_ready(f(jnp.asarray(q) + 1e-6 * i))
"""


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="the system does not bind programs to cores")
def test_compiled_functions_do_not_wait_for_themselves():
    subprocess.run([sys.executable, "-c", ON_ONE_CORE], check=True, timeout=HANGS)


def test_second_derivatives_say_that_there_are_none(rng):
    A = np.array([[0.0, -0.3], [0.3, 0.0]])
    with pytest.raises(NotImplementedError, match="skew_exp: second derivatives are not available"):
        jax.hessian(lambda A: jnp.sum(sj.skew_exp(A)))(A)


def test_derivatives_do_not_depend_on_the_raw_arguments_off_the_manifold(rng):
    # Nearby arrays that project to the same frame.
    S = Stiefel(5, 2).random_point(rng)
    stretched = S @ np.diag([1.0002, 0.9997])
    W = rng.normal(size=(5, 2))
    np.testing.assert_allclose(sj.exp(stretched, 0 * S), S, rtol=0, atol=1e-14)
    gradient = jax.grad(lambda S: jnp.sum(W * sj.exp(S, 0 * S)))(stretched)
    # No change along the fibre.
    assert abs(np.sum(gradient * (S @ np.diag([1.0, 0.0])))) < 1e-12


def test_constants_may_be_numpy_arrays():
    """Where JAX evaluates a part of a function in advance, and where it transposes a derivative."""
    S, V = np.eye(3)[:, :2], np.array([[0.0, -0.3], [0.3, 0.0], [0.1, 0.2]])
    total = float(np.sum(sj.exp(S, V)))
    slope = jax.grad(jax.checkpoint(lambda x: (x * sj.exp(S, V)).sum()))(1.0)
    assert slope == pytest.approx(total, rel=1e-13)
    q = np.array([[0.0, 0.0, 0.0, 1.0], [0.2, 0.0, 0.1, 1.0], [0.3, 0.3, 0.0, 1.0], [0.0, 0.4, 0.2, 1.0]])
    knots, t = np.arange(4.0), np.array([0.3, 2.1])

    def along(dt):
        return jax.jvp(lambda t: sj.rotation_spline(knots, q, t), (t,), (dt,))[1]

    w = np.cos(np.arange(8.0)).reshape(2, 4)
    (found,) = jax.linear_transpose(along, t)(w)
    expected = [np.sum(w * np.asarray(along(unit))) for unit in np.eye(2)]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)


def test_gradients_by_times_are_zero_unless_they_are_wanted():
    turn = np.array([[0.0, -0.5, 0.2], [0.5, 0.0, 0.3], [-0.2, -0.3, 0.0]])
    knots, S = np.arange(4.0), stiefel_rs.skew_exp(np.array([0.0, 1.0, 0.5, 2.0])[:, None, None] * turn)
    t, w = np.array([0.3, 2.1]), np.cos(np.arange(18.0)).reshape(2, 3, 3)
    operation = splines.cubic_spline("natural")
    all_three = operation.pullbacks((knots, S, t), w)
    two = operation.pullbacks((knots, S, t), w, (True, True, False))
    for one, other in zip(all_three[:2], two[:2], strict=True):
        np.testing.assert_array_equal(one, other)
    assert np.abs(all_three[2]).min() > 1e-3
    assert not two[2].any()


@pytest.mark.parametrize("size", [1e-300, 1e-160, 1e160, 1e300])
def test_quaternions_of_any_length(size, rng):
    q, times = rng.standard_normal((4, 4)), np.array([0.0, 0.7, 1.5, 3.0])

    def value(x):
        return sj.rotation_spline(times, x, 0.3)[0]

    expected, move = jax.grad(value)(q), rng.standard_normal((4, 4))
    assert np.abs(size * jax.grad(value)(size * q) - expected).max() < 1e-12
    _, change = jax.jvp(value, (size * q,), (size * move,))
    assert abs(change - (expected * move).sum()) < 1e-11
