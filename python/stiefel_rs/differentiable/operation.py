"""Functions of arrays with their derivatives and transposed derivatives, for batches on leading axes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any

import numpy as np

from ..errors import StiefelError
from .arguments import Argument, Array, Shape
from .solved import Solved

# Numbers that the arrays and the key of projected arguments take beside their entries: 150000 members on St(3, 1) take
# 163 MB.
ENTRY = 130

# A gradient, or a function that computes it.
Gradient = Array | Callable[[], Array]


@dataclass(frozen=True, eq=False)
class Operation:
    """A function of projected arguments, and its derivatives with respect to all of them.

    Attributes
    ----------
    name : str
    arguments : sequence of Argument
        Kinds of the arguments, with their projections.
    axes : tuple of int
        Number of axes of each argument for one value; the axes before are the batch, the same for all arguments.
    shape : callable
        Shape of a value, from the shapes of the arguments without the batch.
    value, variation, pullback : callable
        ``value(*data)``; ``variation(data, tangents)``; ``pullback(data, cotangent)``, a tuple; for one member.
        Gradients that need additional work may be functions, which are called if the gradients are wanted; not those
        of arguments that depend on others.
    is_batched : bool
        Whether these functions take all members at once.
    has_tangent_gradients : bool
        Whether gradients are tangent vectors: projections that change nothing leave them as they are.
    on_pairs : bool
        Whether raw arrays hold real and imaginary parts of complex matrices on a last axis of length 2, so that
        gradients are gradients with respect to real numbers.
    """

    name: str
    arguments: tuple[Argument, ...]
    axes: tuple[int, ...]
    shape: Callable[..., Shape]
    value: Callable[..., Array]
    variation: Callable[[Sequence[Array], Sequence[Array]], Array]
    pullback: Callable[[Sequence[Array], Array], Sequence[Gradient]]
    is_batched: bool = False
    has_tangent_gradients: bool = False
    on_pairs: bool = False

    @property
    def raw_axes(self) -> tuple[int, ...]:
        """Number of axes of the raw arrays for one value."""
        pairs = zip(self.arguments, self.axes, strict=True)
        return tuple(axes + (self.on_pairs and argument.may_be_complex) for argument, axes in pairs)

    def batch(self, shapes: Sequence[Shape]) -> Shape:
        """Return the leading axes of arguments of the given shapes."""
        return shapes[0][: len(shapes[0]) - self.axes[0]]

    def value_shape(self, shapes: Sequence[Shape]) -> Shape:
        """Return the shape of the value for raw arrays of the given shapes, which have the same leading axes."""
        pairs = zip(shapes, self.axes, self.raw_axes, strict=True)
        shapes = [shape[: len(shape) + own - raw] for shape, own, raw in pairs]
        last = (2,) if self.on_pairs else ()
        return (*self._value_shape(shapes), *last)

    def _value_shape(self, shapes: Sequence[Shape]) -> Shape:
        lead = len(self.batch(shapes))
        return (*self.batch(shapes), *self.shape(*(shape[lead:] for shape in shapes)))

    def values(self, *raw: Any) -> Array:
        """Evaluate the function for raw arrays."""
        data = self._read(raw)
        out = self._empty(data)
        for at in self._members(data):
            with self._naming(at, data):
                out[at] = self.value(*self._exact([x[at] for x in data]))
        return self._plain(out)

    def variations(self, raw: Sequence[Any], tangents: Sequence[Any]) -> Array:
        """Evaluate the derivative in a direction."""
        data, moves = self._read(raw), self._read(tangents)
        out = self._empty(data)
        for at in self._members(data):
            with self._naming(at, data):
                out[at] = self._variation([x[at] for x in data], [move[at] for move in moves])
        return self._plain(out)

    def _variation(self, member: Sequence[Array], moves: Sequence[Array]) -> Array:
        exact = self._exact(member)
        moved: tuple[Array, ...] = ()
        for argument, x, move in zip(self.arguments, member, moves, strict=True):
            moved = (*moved, argument.variation(x, exact, move, moved))
        return self.variation(exact, moved)

    def pullbacks(self, raw: Sequence[Any], cotangent: Any, wanted: Sequence[bool] | None = None) -> tuple[Array, ...]:
        """Evaluate the transpose of the derivative; gradients that are not wanted are zero."""
        data, cotangents = self._read(raw), self._of_plain(cotangent)
        out = [np.empty_like(x) for x in data]
        for at in self._members(data):
            with self._naming(at, data):
                pulled = self._pullback([x[at] for x in data], cotangents[at], wanted)
            for whole, gradient in zip(out, pulled, strict=True):
                whole[at] = gradient
        return tuple(self._plain(x) if x.dtype.kind == "c" else x for x in out)

    def _pullback(self, member: Sequence[Array], cotangent: Array, wanted: Sequence[bool] | None) -> list[Array]:
        exact = self._exact(member)
        pulled = self.gradients(exact, cotangent, wanted)
        if not (self.has_tangent_gradients and self._projected(member)[1]):
            self._pull_back_projections(member, exact, pulled, wanted)
        if wanted is None:
            return pulled
        return [x if is_wanted else np.zeros_like(x) for x, is_wanted in zip(pulled, wanted, strict=True)]

    def _pull_back_projections(
        self, member: Sequence[Array], exact: tuple[Array, ...], pulled: list[Array], wanted: Sequence[bool] | None
    ) -> None:
        """Replace gradients with respect to projected arguments by those with respect to the arguments."""
        for i, argument in reversed(list(enumerate(self.arguments))):
            # Vectors at a frame add to its gradient, because their projections depend on it.
            needed = (i, argument.depends_on)
            if wanted is None or any(wanted[j] for j in needed if j is not None):
                pulled[i] = argument.pullback(member[i], exact, pulled[i], pulled)

    def gradients(self, data: Sequence[Array], cotangent: Array, wanted: Sequence[bool] | None = None) -> list[Array]:
        """Apply the pullback of one member; gradients that are not wanted are zero if they need additional work."""
        found: list[Array] = []
        for i, gradient in enumerate(self.pullback(data, cotangent)):
            if not callable(gradient):
                found.append(gradient)
            elif wanted is None or wanted[i]:
                found.append(gradient())
            else:
                found.append(np.zeros_like(data[i]))
        return found

    def no_second(self) -> NotImplementedError:
        """Return the error for a request of second derivatives."""
        return NotImplementedError(
            f"{self.name}: second derivatives are not available; use finite differences of first derivatives, or an "
            "optimiser that needs only these"
        )

    def _members(self, data: Sequence[Array]) -> list[Shape]:
        """Return the members of a batch; equal ones follow one another, and reuse the same solution."""
        batch = self.batch([x.shape for x in data])
        if self.is_batched or not batch:
            return [()]
        # In order of their first members, so that the first member that is refused is the one that raises.
        equal: dict[tuple[bytes, ...], list[Shape]] = {}
        for at in np.ndindex(batch):
            equal.setdefault(tuple(x[at].tobytes() for x in data), []).append(at)
        return [at for members in equal.values() for at in members]

    @contextmanager
    def _naming(self, at: Shape, data: Sequence[Array]) -> Iterator[None]:
        """Name the member of a batch in errors, by its place in C order as the core does."""
        try:
            yield
        except StiefelError as error:
            if at:
                place = np.ravel_multi_index(at, self.batch([x.shape for x in data]))
                error.args = (f"{error.args[0]} (batch member {place})", *error.args[1:])
            raise

    def _exact(self, member: Sequence[Array]) -> tuple[Array, ...]:
        return self._project_all(member) if self.is_batched else self._projected(member)[0]

    def _project_all(self, data: Sequence[Array]) -> tuple[Array, ...]:
        """Project the arguments of all members at once; if that is refused, one by one to find the member."""
        try:
            return self._project(*data)
        except StiefelError as error:
            refused = error
        for at in np.ndindex(self.batch([x.shape for x in data])):
            with self._naming(at, data):
                self._project(*(x[at] for x in data))
        raise refused

    @cached_property
    def _projected(self) -> Solved[tuple[tuple[Array, ...], bool]]:
        """Project the arguments of a member, and tell whether they were exact."""
        # Gradients need the arguments of their values again. Projected again, value and gradient of a boundary problem
        # on St(3, 1) take 1.65 instead of 1.25 times as long as the value.
        return Solved(self._lent, lambda *member: ENTRY + sum(x.size for x in member))

    def _lent(self, *member: Array) -> tuple[tuple[Array, ...], bool]:
        """Project arguments that may be views of memory that is only lent: to copies, which many calls share."""
        projected = self._project(*member)
        triples = zip(self.arguments, member, projected, strict=True)
        is_exact = all(x is y for argument, x, y in triples if argument.is_projected)
        exact = tuple(map(np.array, projected))
        for array in exact:
            array.flags.writeable = False
        return exact, is_exact

    def _project(self, *member: Array) -> tuple[Array, ...]:
        exact: tuple[Array, ...] = ()
        for argument, x in zip(self.arguments, member, strict=True):
            exact = (*exact, argument.value(x, exact))
        return exact

    def _read(self, raw: Sequence[Any]) -> list[Array]:
        """Convert raw arrays to real or complex arrays of the arguments."""
        pairs = zip(self.arguments, raw, strict=True)
        return [self._of_plain(x) if argument.may_be_complex else _double(x) for argument, x in pairs]

    def _of_plain(self, array: Any) -> Array:
        numbers = _double(array)
        return np.ascontiguousarray(numbers).view(np.complex128)[..., 0] if self.on_pairs else numbers

    def _plain(self, array: Array) -> Array:
        return array[..., None].view(np.float64) if self.on_pairs else array

    def _empty(self, data: Sequence[Array]) -> Array:
        return np.empty(self._value_shape([x.shape for x in data]), np.complex128 if self.on_pairs else np.float64)


def _double(array: Any) -> Array:
    return np.asarray(array, dtype=np.float64)


@cache
def on_pairs(operation: Operation) -> Operation:
    """Return the same operation for complex matrices."""
    return replace(operation, on_pairs=True)
