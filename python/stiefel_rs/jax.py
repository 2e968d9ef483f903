"""Functions of frames, rotations and curves for JAX, with derivatives. Needs the extra `jax`.

`jit`, `vmap`, `grad`, `jvp`, `jacfwd` and `jacrev` work for all functions, and can be combined. Exponentials,
logarithms and solves are computed on the host in double precision; arrays in single precision are converted there and
back. Solves are differentiated by the implicit function theorem: nothing is unrolled, and a gradient costs one
transposed solve for any number of times. Points are first projected to the manifold, and vectors to its tangent space,
so that derivatives in any direction are defined; a defect above 1e-3 raises. Second derivatives are not available.

Functions raise the exceptions of the package. Under `jit`, JAX raises an error of its own for wrong values, whose
message ends with that of the package: a `JaxRuntimeError`, but after a successful call the same compiled function may
raise a plain `ValueError` instead. Catch both.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from functools import partial
from typing import Any, Final

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir

from .differentiable.functions import Functions
from .differentiable.operation import Operation

__all__ = [
    "cubic_initial",
    "cubic_spline",
    "exp",
    "geometric_cubic",
    "inverse_retract",
    "log",
    "orthogonal_log",
    "retract",
    "riemannian_cubic",
    "rotation_spline",
    "skew_exp",
]

# A function, its derivative in a direction, and the transpose of the derivative: linear in the arguments after its own.
_VALUE: Final = Primitive("stiefel_rs")
_VARIATION: Final = Primitive("stiefel_rs_variation")
_PULLBACK: Final = Primitive("stiefel_rs_pullback")
_PULLBACK.multiple_results = True


def _beside(array: Any, arguments: Sequence[Any]) -> jax.Array:
    """Put a result on the device of the arguments, if they are on a single one."""
    # Constants are NumPy's where JAX evaluates a part of a function in advance.
    devices = {device for x in arguments if isinstance(x, jax.Array) for device in x.devices()}
    return jax.device_put(array, devices.pop() if len(devices) == 1 else None)


def _on_host(primitive: Primitive, operation: Operation, wanted: tuple[bool, ...] | None = None) -> Callable[..., Any]:
    """Return the function of NumPy arrays that a primitive represents; a transpose computes the wanted gradients."""
    count = len(operation.arguments)

    def value(*arrays: Any) -> Any:
        return operation.values(*arrays).astype(arrays[0].dtype)

    def variation(*arrays: Any) -> Any:
        return operation.variations(arrays[:count], arrays[count:]).astype(arrays[0].dtype)

    def pullback(*arrays: Any) -> Any:
        found = operation.pullbacks(arrays[:count], arrays[count], wanted)
        return [x.astype(arrays[0].dtype) for x in found]

    return {_VALUE: value, _VARIATION: variation, _PULLBACK: pullback}[primitive]


def _define(primitive: Primitive) -> None:
    """Define evaluation, abstract evaluation, compilation and batching of a primitive."""
    is_pullback = primitive is _PULLBACK

    def evaluate(*arrays: Any, **parameters: Any) -> Any:
        found = _on_host(primitive, **parameters)(*map(np.asarray, arrays))
        return [_beside(x, arrays) for x in found] if is_pullback else _beside(found, arrays)

    def abstract(*arrays: Any, operation: Operation, **_: Any) -> Any:
        data = arrays[: len(operation.arguments)]
        if is_pullback:
            return [jax.core.ShapedArray(x.shape, x.dtype) for x in data]
        return jax.core.ShapedArray(operation.value_shape([x.shape for x in data]), arrays[0].dtype)

    def compiled(context: Any, *arrays: Any, **parameters: Any) -> Any:
        host = _on_host(primitive, **parameters)

        def call(*numbers: Any) -> Any:
            found = host(*map(np.asarray, numbers))
            return tuple(found) if is_pullback else (found,)

        # Not `jax.pure_callback`, which first transfers the numbers to a device again and waits for it: a deadlock if
        # the calling thread is the only thread of the device.
        found, _, _ = mlir.emit_python_callback(
            context, call, None, list(arrays), context.avals_in, context.avals_out, has_side_effect=False
        )
        return found

    def batched(arrays: Sequence[Any], axes: Sequence[Any], **parameters: Any) -> Any:
        pairs = list(zip(arrays, axes, strict=True))
        size = next(x.shape[axis] for x, axis in pairs if axis is not None)
        stacked = [
            jnp.broadcast_to(x, (size, *x.shape)) if axis is None else jnp.moveaxis(x, axis, 0) for x, axis in pairs
        ]
        found = primitive.bind(*stacked, **parameters)
        return found, [0] * len(found) if is_pullback else 0

    primitive.def_impl(evaluate)
    primitive.def_abstract_eval(abstract)
    mlir.register_lowering(primitive, compiled)
    batching.primitive_batchers[primitive] = batched


for _primitive in (_VALUE, _VARIATION, _PULLBACK):
    _define(_primitive)


def _value_jvp(arrays: Sequence[Any], tangents: Sequence[Any], *, operation: Operation) -> Any:
    moves = [ad.instantiate_zeros(tangent) for tangent in tangents]
    value = _VALUE.bind(*arrays, operation=operation)
    return value, _VARIATION.bind(*arrays, *moves, operation=operation)


def _linear_jvp(primitive: Primitive) -> Callable[..., Any]:
    """Return the derivative of a primitive with respect to its last arguments, in which it is linear."""

    def rule(arrays: Sequence[Any], tangents: Sequence[Any], *, operation: Operation, **parameters: Any) -> Any:
        count = len(operation.arguments)
        if not all(isinstance(tangent, ad.Zero) for tangent in tangents[:count]):
            raise operation.no_second()
        bind = partial(primitive.bind, operation=operation, **parameters)
        moves = [ad.instantiate_zeros(tangent) for tangent in tangents[count:]]
        return bind(*arrays), bind(*arrays[:count], *moves)

    return rule


def _variation_transpose(cotangent: Any, *arrays: Any, operation: Operation) -> Any:
    count = len(operation.arguments)
    wanted = tuple(ad.is_undefined_primal(x) for x in arrays[count:])
    pulled = _PULLBACK.bind(*arrays[:count], ad.instantiate_zeros(cotangent), operation=operation, wanted=wanted)
    return [None] * count + [x if is_wanted else None for x, is_wanted in zip(pulled, wanted, strict=True)]


def _pullback_transpose(cotangents: Sequence[Any], *arrays: Any, operation: Operation, **_: Any) -> Any:
    # Gradients that are not wanted are not used, and have no cotangents.
    count = len(operation.arguments)
    moves = [ad.instantiate_zeros(cotangent) for cotangent in cotangents]
    return [None] * count + [_VARIATION.bind(*arrays[:count], *moves, operation=operation)]


ad.primitive_jvps[_VALUE] = _value_jvp
ad.primitive_jvps[_VARIATION] = _linear_jvp(_VARIATION)
ad.primitive_jvps[_PULLBACK] = _linear_jvp(_PULLBACK)
ad.primitive_transposes[_VARIATION] = _variation_transpose
ad.primitive_transposes[_PULLBACK] = _pullback_transpose


class _OnJax(Functions[jax.Array]):
    """The functions for JAX arrays."""

    def arrays(self, arguments: Sequence[Any]) -> list[Any]:
        arrays = [jnp.asarray(argument) for argument in arguments]
        # Integers and booleans take the dtype of the others; without others, the default dtype of JAX.
        inexact = [x for x in arrays if jnp.issubdtype(x.dtype, jnp.inexact)]
        common = jnp.finfo(jnp.result_type(*inexact or [float])).dtype
        kind = jnp.promote_types(common, jnp.float32)
        complex_kind = jnp.result_type(kind, jnp.complex64)
        return [x.astype(complex_kind if self.is_complex(x) else kind) for x in arrays]

    def flat(self, t: Any) -> tuple[jax.Array, tuple[int, ...]]:
        times = jnp.asarray(t)
        return times.reshape(-1), times.shape

    def is_complex(self, array: Any) -> bool:
        return jnp.issubdtype(array.dtype, jnp.complexfloating)

    def pairs(self, array: Any) -> jax.Array:
        return jnp.stack([array.real, array.imag], axis=-1)

    def of_pairs(self, array: Any) -> jax.Array:
        return jax.lax.complex(array[..., 0], array[..., 1])

    def broadcast(self, arrays: list[Any], axes: tuple[int, ...]) -> list[Any]:
        pairs = list(zip(arrays, axes, strict=True))
        lead = jnp.broadcast_shapes(*(x.shape[: x.ndim - own] for x, own in pairs))
        return [jnp.broadcast_to(x, (*lead, *x.shape[x.ndim - own :])) for x, own in pairs]

    def evaluate(self, operation: Operation, arrays: list[Any]) -> jax.Array:
        found: jax.Array = _VALUE.bind(*arrays, operation=operation)
        return found

    def identity(self, like: Any) -> jax.Array:
        return jnp.eye(like.shape[-2], dtype=like.dtype)

    def exact_products(self) -> AbstractContextManager[Any]:
        # Some accelerators multiply in lower precision by default.
        context: AbstractContextManager[Any] = jax.default_matmul_precision("highest")
        return context


_FUNCTIONS: Final = _OnJax()

skew_exp = _FUNCTIONS.skew_exp
orthogonal_log = _FUNCTIONS.orthogonal_log
exp = _FUNCTIONS.exp
log = _FUNCTIONS.log
retract = _FUNCTIONS.retract
inverse_retract = _FUNCTIONS.inverse_retract
geometric_cubic = _FUNCTIONS.geometric_cubic
riemannian_cubic = _FUNCTIONS.riemannian_cubic
cubic_initial = _FUNCTIONS.cubic_initial
cubic_spline = _FUNCTIONS.cubic_spline
rotation_spline = _FUNCTIONS.rotation_spline
