"""Arguments of the functions for JAX: dtypes, knots, leading axes, refused members, and where no derivative exists."""

import numpy as np
import pytest

jax = pytest.importorskip("jax")

import jax.numpy as jnp  # noqa: E402

import stiefel_rs  # noqa: E402
from stiefel_rs import Grassmann, InvalidInputError, OutsideDomainError, Stiefel  # noqa: E402
from stiefel_rs import jax as sj  # noqa: E402

QUARTER = np.array([[0, -1], [1, 0]])
S = np.eye(3)[:, :2]
KNOTS = np.array([0.0, 0.7, 1.6])
# Each 0.3 rad from the one before it.
ROTATIONS = np.array([[0.0, 0.0, np.sin(0.15 * i), np.cos(0.15 * i)] for i in range(3)])


@pytest.fixture(autouse=True, params=[True, False], ids=["x64", "x32"])
def default(request):
    """The default dtype, with and without double precision."""
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", request.param)
    yield np.float64 if request.param else np.float32
    jax.config.update("jax_enable_x64", before)


@pytest.mark.parametrize(
    "A",
    [QUARTER, QUARTER.tolist(), QUARTER.astype(np.int8), np.zeros((2, 2), dtype=bool)],
    ids=["int64", "list", "int8", "bool"],
)
def test_integers_and_booleans_have_the_default_precision(A, default):
    found = sj.skew_exp(A)
    assert found.dtype == default
    np.testing.assert_allclose(found, stiefel_rs.skew_exp(A), rtol=0, atol=4 * np.finfo(default).eps)


def test_numbers_without_a_dtype_have_the_default_precision(default):
    """As `jnp.where` returns them for two Python numbers."""
    assert sj.skew_exp(jnp.where(jnp.eye(2) > 2, 1.0, 0.0)).dtype == default


def test_integers_do_not_change_the_precision_of_others(default):
    kinds = [(jnp.float16, jnp.float32), (jnp.bfloat16, jnp.float32)]
    kinds += [(kind, kind) for kind in (jnp.float32, jnp.complex64)]
    if default == np.float64:
        kinds += [(kind, kind) for kind in (jnp.float64, jnp.complex128)]
    for given, wanted in kinds:
        V = jnp.zeros((3, 2), dtype=given)
        for frame in (S.astype(int), S.astype(np.int8), S.astype(bool)):
            assert sj.exp(frame, V).dtype == wanted
        assert sj.exp(V + S.astype(int), np.zeros((3, 2), dtype=int)).dtype == wanted


def splines(knots, t):
    """Splines with the given knots."""
    frames = np.broadcast_to(S, (len(knots), 3, 2))
    return [
        lambda: sj.cubic_spline(knots, frames, t),
        lambda: sj.cubic_spline(knots, frames, t, manifold=Grassmann(3, 2)),
        lambda: sj.rotation_spline(knots, ROTATIONS[: len(knots)], t),
    ]


@pytest.mark.parametrize(
    ("knots", "knot", "message"),
    [
        ([0, -1, -2], 1, r"knot 1: t_knots: must be greater than the time before it, 0\.0, found -1\.0$"),
        ([0, 1, 1], 2, r"knot 2: t_knots: must be greater than the time before it, 1\.0, found 1\.0$"),
        ([0, np.nan, 1], 1, "knot 1: t_knots: not finite$"),
        ([0, 1, np.inf], 2, "knot 2: t_knots: not finite$"),
        ([0], None, r"t_knots: expected shape \(..., N\) with N >= 2, found \(1,\)$"),
    ],
)
@pytest.mark.parametrize("t", [-0.5, 0.5, 7.0])
def test_knots_are_checked_before_the_times(knots, knot, message, t):
    for call in splines(knots, t):
        with pytest.raises(InvalidInputError, match=message) as caught:
            call()
        assert caught.value.knot == knot


def test_knots_of_a_member_of_a_batch():
    knots = np.array([KNOTS, [0.0, 1.0, 1.0]])
    with pytest.raises(InvalidInputError, match=r"^knot 2: t_knots: .* 1\.0, found 1\.0 \(batch member 1\)$") as caught:
        sj.rotation_spline(knots, ROTATIONS, 0.5)
    assert caught.value.knot == 2


def test_leading_axes_that_do_not_broadcast():
    two, three = (np.broadcast_to(S, (count, 3, 2)) for count in (2, 3))
    shapes = r"leading axes cannot be broadcast together, found shapes \(2, 3, 2\), \(3, 3, 2\)(\n|$)"
    cases = [
        (lambda: sj.exp(two, 0 * three), f"^S, V: {shapes}"),
        (lambda: sj.exp(two, 0 * three, manifold=Grassmann(3, 2)), f"^S, V: {shapes}"),
        (lambda: sj.retract(two, 0 * three), f"^S, V: {shapes}"),
        (lambda: sj.log(two, three), f"^S0, S1: {shapes}"),
        (lambda: sj.inverse_retract(two, three), f"^S0, S1: {shapes}"),
        (lambda: sj.geometric_cubic(S, 0 * two, S, 0 * three, 0.5), f"^V0, V1: {shapes}"),
        (lambda: sj.riemannian_cubic(two, 0 * S, S, 0 * three, [0.2, 0.5]), f"^S0, V1: {shapes}"),
        (
            lambda: sj.rotation_spline(np.tile(KNOTS, (2, 1)), np.tile(ROTATIONS, (5, 3, 1, 1)), 0.5),
            r"^t_knots, quaternions: .* found shapes \(2, 3\), \(5, 3, 3, 4\)(\n|$)",
        ),
    ]
    for call, message in cases:
        with pytest.raises(InvalidInputError, match=message):
            call()
        # Shapes are known while a function is being traced. JAX appends a note to the message.
        with pytest.raises(InvalidInputError, match=message):
            jax.jit(call)()
    # Axes of length one, and missing axes, broadcast.
    assert sj.exp(two[:, None], 0 * three).shape == (2, 3, 3, 2)
    assert sj.exp(two[:0, None], 0 * three).shape == (0, 3, 3, 2)


def test_refusals_name_the_member_of_a_batch():
    frames, zero = np.array([S, S, 1.1 * S, 1.2 * S]), np.zeros((3, 2))
    # In transformations, JAX appends a note to the message.
    message = r"columns are not orthonormal, .* 0\.1, .* \(batch member 2\)(\n|$)"
    cases = [
        (lambda S: sj.exp(S, zero), f"^S: {message}"),
        (lambda S: sj.log(frames[0], S), f"^S1: {message}"),
        (lambda S: sj.retract(S, zero), f"^S: {message}"),
        (lambda S: sj.inverse_retract(S, frames[0]), f"^S0: {message}"),
        (lambda S: sj.riemannian_cubic(S, zero, frames[0], zero, [0.1, 0.2, 0.5]), f"^S0: {message}"),
    ]
    for function, wanted in cases:
        for call in (function, jax.vmap(function), jax.grad(lambda S, function=function: function(S).sum())):
            with pytest.raises(InvalidInputError, match=wanted):
                call(frames)
        # The place in a batch of more than one axis is that in C order, as in the core.
        with pytest.raises(InvalidInputError, match=wanted):
            function(frames.reshape(2, 2, 3, 2))
        with pytest.raises(InvalidInputError, match=r"Stiefel\.project returns the nearest frame$"):
            function(frames[2])


def test_refused_vectors_and_solves_name_the_member_of_a_batch():
    with pytest.raises(InvalidInputError, match=r"^A: not skew: .* = 1, more than 0\.001 \(batch member 1\)$"):
        sj.skew_exp(np.array([QUARTER, np.eye(2)]))
    with pytest.raises(InvalidInputError, match=r"^V: not tangent: .* = 1, .* \(batch member 1\)$"):
        sj.exp(S, np.array([0 * S, S]))
    turned = np.array([S, S, -S])
    with pytest.raises(OutsideDomainError, match=r"joins the points.* \(batch member 2\)$"):
        sj.log(S, turned)
    with pytest.raises(OutsideDomainError, match=r"no principal logarithm.* \(batch member 1\)$") as caught:
        sj.orthogonal_log(np.array([np.eye(2), -np.eye(2)]))
    assert "batch member 1) (" not in str(caught.value)


def test_refused_derivatives_name_the_member_of_a_batch():
    # The ends differ from conjugate ones by 1e-12.
    jax.config.update("jax_enable_x64", True)
    pole = np.array([[0.0], [0.0], [1.0]])
    ends = np.array([[[np.sin(angle)], [0.0], [np.cos(angle)]] for angle in (1.0, np.pi - 1e-12)])
    for differentiate in (jax.jacfwd, jax.grad):
        with pytest.raises(OutsideDomainError, match=r"conjugate along the curve.* \(batch member 1\)"):
            differentiate(lambda x: sj.log(pole, x).sum())(ends)


def test_large_members_do_not_hide_defects_of_others():
    A = np.array([1e4 * QUARTER, QUARTER + 0.5 * np.eye(2)])
    for call in (sj.skew_exp, jax.vmap(sj.skew_exp)):
        with pytest.raises(InvalidInputError, match=r"= 0\.5, more than 0\.001 \(batch member 1\)"):
            call(A)
    assert np.isfinite(sj.skew_exp(np.array([1e4 * QUARTER + np.eye(2), QUARTER]))).all()


def test_compiled_functions_repeat_the_message(rng):
    """At the first call, after a failure, and after a success: JAX's own error differs."""
    point = Stiefel(3, 2).random_point(rng)
    compiled = jax.jit(lambda S: sj.exp(S, 0.0 * S))
    for scale in (1.1, 1.0, 1.1, 1.0, 1.1):
        if scale == 1.0:
            compiled(point).block_until_ready()
            continue
        # JaxRuntimeError is a RuntimeError.
        with pytest.raises((RuntimeError, ValueError), match=r"S: columns are not orthonormal, .* by 0\.1, more than"):
            compiled(scale * point).block_until_ready()


def gradients(function, *arguments):
    value, pull_back = jax.vjp(function, *arguments)
    return pull_back(jnp.cos(jnp.arange(value.size, dtype=value.dtype)).reshape(value.shape))


def test_conjugate_ends_raise():
    jax.config.update("jax_enable_x64", True)
    # Antipodes on the sphere, along a great circle from which others branch off.
    S0, S1 = np.array([[0.0], [0.0], [1.0]]), np.array([[0.0], [0.0], [-1.0]])
    with pytest.raises(OutsideDomainError, match="pi"):
        gradients(sj.log, S0, S1)
    # Near that point the logarithm still exists, but rotates by a radian when the end moves by 1e-12.
    near_to_it = np.array([[np.sin(1e-12)], [0.0], [-np.cos(1e-12)]])
    assert np.isfinite(sj.log(S0, near_to_it)).all()
    with pytest.raises(OutsideDomainError, match="conjugate along the curve"):
        gradients(sj.log, S0, near_to_it)


@pytest.mark.parametrize("function", [sj.orthogonal_log, lambda Q: sj.inverse_retract(np.eye(4), Q)])
@pytest.mark.parametrize("field", ["real", "complex"])
def test_several_half_turns_have_a_derivative_up_to_a_distance(function, field):
    """Two angles next to pi, or one next to pi and one next to -pi: the logarithm is not smooth beside them."""
    jax.config.update("jax_enable_x64", True)
    turns = (1.0, 1.0) if field == "real" else (1.0, -1.0)

    def rotation(gap):
        angles = [turn * (np.pi - gap) for turn in turns]
        if field == "complex":
            return np.diag(np.exp(1j * np.array([*angles, 0.3, 0.0])))
        blocks = [[[np.cos(x), -np.sin(x)], [np.sin(x), np.cos(x)]] for x in angles]
        return np.block([[np.array(blocks[0]), np.zeros((2, 2))], [np.zeros((2, 2)), np.array(blocks[1])]])

    for gradient in gradients(function, rotation(1e-9)):
        assert np.isfinite(gradient).all()
    with pytest.raises(
        OutsideDomainError, match=r"not differentiable: two rotation angles have a mean size of 3\.14159"
    ):
        gradients(function, rotation(1e-13))
