"""Functions of frames, rotations and curves for PyTorch, with derivatives. Needs the extra `torch`.

`backward`, `torch.func.grad`, `jvp`, `vmap` and `jacrev` work for all functions, and can be combined. Exponentials,
logarithms and solves are computed in double precision; tensors in single precision are converted there and back.
Tensors must be on the CPU; nothing is traced or compiled. Solves are differentiated by the implicit function theorem:
nothing is unrolled, and a gradient costs one transposed solve for any number of times. Points are first projected to
the manifold, and vectors to its tangent space, so that derivatives in any direction are defined; a defect above 1e-3
raises. Second derivatives are not available.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import Any, Final, TypeAlias

import numpy as np
import torch
from torch.fx.experimental.proxy_tensor import get_proxy_mode

from .differentiable.functions import Functions
from .differentiable.operation import Operation
from .errors import InvalidInputError

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


Tensor: TypeAlias = torch.Tensor


def _numpy(tensors: Sequence[Tensor]) -> list[Any]:
    if get_proxy_mode() is not None:
        raise NotImplementedError("values are computed by NumPy, which cannot be traced: torch.func.linearize, make_fx")
    return [tensor.detach().resolve_neg().numpy() for tensor in tensors]


def _tensor(array: Any, like: Tensor) -> Tensor:
    return torch.as_tensor(np.ascontiguousarray(array), dtype=like.dtype, device="cpu")


def _stacked(size: int, dims: Sequence[int | None], tensors: Sequence[Tensor]) -> list[Tensor]:
    """Move the batch axis to the front, and broadcast tensors without one."""
    return [
        tensor.expand(size, *tensor.shape) if dim is None else tensor.movedim(dim, 0)
        for tensor, dim in zip(tensors, dims, strict=True)
    ]


def _linear_moves(ctx: Any, tangents: Sequence[Tensor | None]) -> list[Tensor]:
    """Return the arguments, and the tangents of the inputs in which a derivative is linear."""
    count, tensors = len(ctx.operation.arguments), ctx.saved_tensors
    if any(tangent is not None for tangent in tangents[:count]):
        raise ctx.operation.no_second()
    pairs = zip(tensors[count:], tangents[count:], strict=True)
    return [*tensors[:count], *(torch.zeros_like(x) if move is None else move for x, move in pairs)]


class _Value(torch.autograd.Function):
    """A function."""

    @staticmethod
    def forward(operation: Operation, *tensors: Tensor) -> Tensor:
        return _tensor(operation.values(*_numpy(tensors)), tensors[0])

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        ctx.operation, *tensors = inputs
        ctx.save_for_backward(*tensors)
        ctx.save_for_forward(*tensors)

    @staticmethod
    def backward(ctx: Any, *cotangents: Tensor) -> Any:
        wanted = ctx.needs_input_grad[1:]
        return None, *_Pullback.apply(ctx.operation, wanted, *ctx.saved_tensors, cotangents[0])

    @staticmethod
    def jvp(ctx: Any, _: Any, *tangents: Tensor | None) -> Tensor:
        tensors = ctx.saved_tensors
        pairs = zip(tensors, tangents, strict=True)
        moves = [torch.zeros_like(x) if tangent is None else tangent for x, tangent in pairs]
        moved: Tensor = _Variation.apply(ctx.operation, *tensors, *moves)
        return moved

    @staticmethod
    def vmap(info: Any, dims: Sequence[Any], operation: Operation, *tensors: Tensor) -> Any:
        return _Value.apply(operation, *_stacked(info.batch_size, dims[1:], tensors)), 0


class _Variation(torch.autograd.Function):
    """The derivative of a function in a direction."""

    @staticmethod
    def forward(operation: Operation, *tensors: Tensor) -> Tensor:
        count = len(operation.arguments)
        arrays = _numpy(tensors)
        return _tensor(operation.variations(arrays[:count], arrays[count:]), tensors[0])

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        ctx.operation, *tensors = inputs
        ctx.save_for_backward(*tensors)
        ctx.save_for_forward(*tensors)
        # None marks inputs that do not move.
        ctx.set_materialize_grads(False)

    @staticmethod
    def backward(ctx: Any, *cotangents: Tensor) -> Any:
        count = len(ctx.operation.arguments)
        if any(ctx.needs_input_grad[1 : count + 1]):
            raise ctx.operation.no_second()
        if cotangents[0] is None:
            return (None,) * (1 + 2 * count)
        wanted = ctx.needs_input_grad[count + 1 :]
        pulled = _Pullback.apply(ctx.operation, wanted, *ctx.saved_tensors[:count], cotangents[0])
        return None, *[None] * count, *pulled

    @staticmethod
    def jvp(ctx: Any, _: Any, *tangents: Tensor | None) -> Tensor:
        moved: Tensor = _Variation.apply(ctx.operation, *_linear_moves(ctx, tangents))
        return moved

    @staticmethod
    def vmap(info: Any, dims: Sequence[Any], operation: Operation, *tensors: Tensor) -> Any:
        return _Variation.apply(operation, *_stacked(info.batch_size, dims[1:], tensors)), 0


class _Pullback(torch.autograd.Function):
    """The transpose of the derivative of a function, for the arguments whose gradients are wanted."""

    @staticmethod
    def forward(operation: Operation, wanted: Sequence[bool], *tensors: Tensor) -> tuple[Tensor, ...]:
        count = len(operation.arguments)
        *arrays, cotangent = _numpy(tensors)
        found = operation.pullbacks(arrays, cotangent, wanted)
        return tuple(_tensor(x, like) for x, like in zip(found, tensors[:count], strict=True))

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        ctx.operation, ctx.wanted, *tensors = inputs
        ctx.save_for_backward(*tensors)
        ctx.save_for_forward(*tensors)
        # None marks inputs that do not move.
        ctx.set_materialize_grads(False)

    @staticmethod
    def backward(ctx: Any, *cotangents: Tensor) -> Any:
        count = len(ctx.operation.arguments)
        if any(ctx.needs_input_grad[2 : count + 2]):
            raise ctx.operation.no_second()
        # Gradients that are not wanted are not used, and have no cotangents.
        pairs = zip(ctx.saved_tensors[:count], cotangents, strict=True)
        moves = [torch.zeros_like(x) if move is None else move for x, move in pairs]
        moved = _Variation.apply(ctx.operation, *ctx.saved_tensors[:count], *moves)
        return None, None, *[None] * count, moved

    @staticmethod
    def jvp(ctx: Any, _: Any, __: Any, *tangents: Tensor | None) -> Any:
        return _Pullback.apply(ctx.operation, ctx.wanted, *_linear_moves(ctx, tangents))

    @staticmethod
    def vmap(info: Any, dims: Sequence[Any], operation: Operation, wanted: Sequence[bool], *tensors: Tensor) -> Any:
        found = _Pullback.apply(operation, wanted, *_stacked(info.batch_size, dims[2:], tensors))
        return found, tuple(0 for _ in found)


def _known(thing: Any) -> Tensor | None:
    """Return a tensor for a tensor, a list of tensors or a NumPy array (copied); None for Python numbers."""
    if isinstance(thing, np.ndarray):
        # PyTorch cannot share read-only arrays, nor arrays with negative strides.
        return torch.as_tensor(np.array(thing, order="C"), device="cpu")
    if isinstance(thing, (list, tuple)) and any(isinstance(x, torch.Tensor) for x in thing):
        thing = torch.stack([torch.as_tensor(x) for x in thing])
    if not isinstance(thing, torch.Tensor):
        return None
    if thing.device.type != "cpu":
        found = f"found a tensor on {thing.device}"
        raise InvalidInputError(f"{found}: values are computed on the CPU; move it with .cpu()")
    return thing


def _real_kind(kinds: Sequence[torch.dtype]) -> torch.dtype:
    """Return the real dtype of results for tensors of the given dtypes; at least single precision.

    Python numbers take the dtype of the tensors, and integers and booleans that of the others. Without others, integer
    tensors take the default dtype of PyTorch; Python numbers alone have double precision.
    """
    if not kinds:
        return torch.float64
    inexact = [kind for kind in kinds if kind.is_floating_point or kind.is_complex]
    common = torch.float32
    for kind in inexact or [torch.get_default_dtype()]:
        common = torch.promote_types(common, kind)
    return common.to_real()


class _OnTorch(Functions[Tensor]):
    """The functions for PyTorch tensors."""

    def arrays(self, arguments: Sequence[Any]) -> list[Any]:
        known = [_known(argument) for argument in arguments]
        kind = _real_kind([x.dtype for x in known if x is not None])
        pairs = zip(arguments, known, strict=True)
        tensors = [
            torch.as_tensor(np.asarray(thing, dtype=float), device="cpu") if x is None else x for thing, x in pairs
        ]
        return [x.to(kind.to_complex() if x.is_complex() else kind) for x in tensors]

    def flat(self, t: Any) -> tuple[Any, tuple[int, ...]]:
        times = _known(t)
        if times is not None:
            return times.reshape(-1), tuple(times.shape)
        numbers = np.asarray(t, dtype=float)
        return numbers.reshape(-1).tolist(), numbers.shape

    def is_complex(self, array: Any) -> bool:
        return bool(array.is_complex())

    def pairs(self, array: Any) -> Tensor:
        whole = array if array.is_complex() else torch.complex(array, torch.zeros_like(array))
        return torch.view_as_real(whole.resolve_conj())

    def of_pairs(self, array: Any) -> Tensor:
        return torch.view_as_complex(array.contiguous())

    def broadcast(self, arrays: list[Any], axes: tuple[int, ...]) -> list[Any]:
        pairs = list(zip(arrays, axes, strict=True))
        lead = torch.broadcast_shapes(*(x.shape[: x.ndim - own] for x, own in pairs))
        return [x.expand(*lead, *x.shape[x.ndim - own :]) for x, own in pairs]

    # torch.compile must not trace this.
    @torch.compiler.disable  # type: ignore[untyped-decorator]
    def evaluate(self, operation: Operation, arrays: list[Any]) -> Tensor:
        found: Tensor = _Value.apply(operation, *arrays)
        return found

    def identity(self, like: Any) -> Tensor:
        return torch.eye(like.shape[-2], dtype=like.dtype, device="cpu")

    def exact_products(self) -> AbstractContextManager[Any]:
        # Autocast would multiply in half precision.
        context: AbstractContextManager[Any] = torch.autocast("cpu", enabled=False)
        return context


_FUNCTIONS: Final = _OnTorch()

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
