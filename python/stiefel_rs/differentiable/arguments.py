"""Arguments of differentiable functions, projected to the manifold, with derivatives of the projection.

Derivatives with respect to a frame or a tangent vector are derivatives along the manifold. The projection extends a
function to nearby arrays, so that derivatives in any direction are defined. Each kind of argument has a value, a
variation and a pullback, for arrays with any number of leading axes. Matrices are real or complex; for complex ones
transposes are conjugate transposes, and inner products are real parts of Hermitian products.

Source: Higham (2008), "Functions of Matrices", section 8.2 (the polar factor, and that its derivative solves a
Sylvester equation).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..array_input import at_knot, check_knots_finite, times_within
from ..errors import InvalidInputError

Array = NDArray[Any]
Shape = tuple[int, ...]

# Larger defects are not due to single precision or to a step of an optimiser, but to wrong input.
LARGEST_DEFECT = 1e-3

# Columns with a defect of at most this, times their length, are orthonormal and are not projected, nor are vectors that
# are tangent to that: otherwise value and gradient of a boundary problem on St(3, 1) would take 1.2 times as long.
ROUND_OFF = 4 * float(np.finfo(np.float64).eps)

# Up to this norm of S^H S - I the polar factor is summed as a series; errors are 3e-19, and 2e-12 in its derivative.
# With singular value decompositions, value and gradient of a spline of 200 rotations take 1.1 times as long.
NEAR = 1e-6


@dataclass(frozen=True)
class Argument(ABC):
    """A kind of argument; `exact` are the projected arguments before it, and `moved` their variations."""

    name: str
    # Whether the numbers may be complex, and whether a projection may change them.
    may_be_complex: ClassVar[bool] = True
    is_projected: ClassVar[bool] = True

    @property
    def depends_on(self) -> int | None:
        """Number of the argument on which the projection depends, if there is one."""
        return None

    @abstractmethod
    def check_shape(self, shape: Shape, before: Sequence[Shape]) -> None:
        """Check the shape of the argument without its batch, given the shapes of the arguments before it."""

    @abstractmethod
    def value(self, raw: Array, exact: tuple[Array, ...]) -> Array:
        """Project the argument."""

    @abstractmethod
    def variation(self, raw: Array, exact: tuple[Array, ...], tangent: Array, moved: tuple[Array, ...]) -> Array:
        """Return the variation of the projection for a variation of the argument."""

    @abstractmethod
    def pullback(self, raw: Array, exact: tuple[Array, ...], cotangent: Array, others: list[Array]) -> Array:
        """Apply the transpose of `variation`; the parts of earlier arguments are added to `others`."""


@dataclass(frozen=True)
class Plain(Argument):
    """Real numbers without constraints; vectors with `columns` entries if this is given."""

    may_be_complex: ClassVar[bool] = False
    is_projected: ClassVar[bool] = False
    columns: int | None = None

    def check_shape(self, shape: Shape, before: Sequence[Shape]) -> None:
        """Check the number of entries."""
        if self.columns is not None and shape[-1] != self.columns:
            raise _unexpected(self.name, f"(..., {self.columns})", shape)

    def value(self, raw: Array, exact: tuple[Array, ...]) -> Array:
        """Project the argument."""
        if not np.isfinite(raw).all():
            raise InvalidInputError(f"{self.name}: not finite")
        return raw

    def variation(self, raw: Array, exact: Any, tangent: Array, moved: Any) -> Array:
        """Return the variation of the projection for a variation of the argument."""
        return tangent

    def pullback(self, raw: Array, exact: Any, cotangent: Array, others: Any) -> Array:
        """Apply the transpose of `variation`."""
        return cotangent


@dataclass(frozen=True)
class Knots(Plain):
    """Increasing times, at least two."""

    def check_shape(self, shape: Shape, before: Sequence[Shape]) -> None:
        """Check the number of times."""
        if shape[-1] < 2:
            raise _unexpected(self.name, "(..., N) with N >= 2", shape)

    def value(self, raw: Array, exact: tuple[Array, ...]) -> Array:
        """Check that the times are finite and increase."""
        check_knots_finite(raw, self.name, 0)
        increases = raw[1:] > raw[:-1]
        if not increases.all():
            knot = int(np.argmin(increases)) + 1
            before, found = raw[knot - 1 : knot + 1]
            raise at_knot(f"{self.name}: must be greater than the time before it, {before}, found {found}", knot)
        return raw


@dataclass(frozen=True)
class Inside(Plain):
    """Times between the first and the last of the knots that are argument number `knots`: nothing is extrapolated."""

    knots: int = 0

    def value(self, raw: Array, exact: tuple[Array, ...]) -> Array:
        """Check the times; those that miss an end by rounding are moved there."""
        times, knots = super().value(raw, exact), exact[self.knots]
        return times_within(times, float(knots[0]), float(knots[-1]), advice="")


@dataclass(frozen=True)
class SkewMatrix(Argument):
    """A skew-symmetric or skew-Hermitian matrix; the projection is the skew part."""

    def check_shape(self, shape: Shape, before: Sequence[Shape]) -> None:
        """Check that the matrix is square."""
        _check_square(self.name, shape)

    def value(self, raw: Array, exact: Any) -> Array:
        """Project the argument."""
        _check(self.name, symmetric_part(raw), raw, "not skew: |A + A^H| / 2")
        return skew_part(raw)

    def variation(self, raw: Array, exact: Any, tangent: Array, moved: Any) -> Array:
        """Return the variation of the projection for a variation of the argument."""
        return skew_part(tangent)

    def pullback(self, raw: Array, exact: Any, cotangent: Array, others: Any) -> Array:
        """Apply the transpose of `variation`."""
        return skew_part(cotangent)


@dataclass(frozen=True)
class Frame(Argument):
    """A matrix with orthonormal columns; the projection is the polar factor, the nearest such matrix.

    It has the shape of argument number `like` if this is given.
    """

    square: bool = False
    like: int | None = None

    def check_shape(self, shape: Shape, before: Sequence[Shape]) -> None:
        """Check that the matrix may have orthonormal columns."""
        n, k = shape[-2:]
        if self.square:
            _check_square(self.name, shape)
        elif not 1 <= k <= n:
            raise _unexpected(self.name, "(..., n, k) with 1 <= k <= n", shape)
        if self.like is not None and shape != before[self.like]:
            raise _unexpected(self.name, f"{before[self.like]}", shape)

    def value(self, raw: Array, exact: Any) -> Array:
        """Project the argument."""
        if not np.isfinite(raw).all():
            raise InvalidInputError(f"{self.name}: not finite")
        excess = _gram_excess(raw)
        if _is_round_off(excess, raw):
            return raw
        if _is_near(excess):
            near: Array = raw @ _inverse_root(excess)
            return near
        left, sizes, right = np.linalg.svd(raw, full_matrices=False)
        defect = float(np.abs(sizes - 1.0).max(initial=0.0))
        if defect > LARGEST_DEFECT:
            raise InvalidInputError(
                f"{self.name}: columns are not orthonormal, singular values differ from 1 by {defect:.3g}, more than "
                f"{LARGEST_DEFECT:g}; Stiefel.project returns the nearest frame"
            )
        projected: Array = left @ right
        return projected

    def variation(self, raw: Array, exact: Any, tangent: Array, moved: Any) -> Array:
        """Return the variation of the projection for a variation of the argument."""
        excess = _gram_excess(raw)
        if _is_round_off(excess, raw):
            along: Array = tangent - raw @ symmetric_part(transposed(raw) @ tangent)
            return along
        if _is_near(excess):
            # With S^H S = I + D and F = (I + D)^(-1/2), the projection is S F, and its variation Z F + S dF.
            inner = transposed(raw) @ tangent
            change = inner + transposed(inner)
            root_change = 0.375 * (change @ excess + excess @ change) - 0.5 * change
            near: Array = tangent @ _inverse_root(excess) + raw @ root_change
            return near
        # With raw = S P and inner = S^T Z: dS = S X + (Z - S S^T Z) P^-1, where P X + X P = inner - inner^T.
        left, sizes, right = np.linalg.svd(raw, full_matrices=False)
        frame = left @ right
        inner = transposed(frame) @ tangent
        normal = tangent - frame @ inner
        basis = transposed(right)
        twisted = right @ (inner - transposed(inner)) @ basis / (sizes[..., :, None] + sizes[..., None, :])
        moved_frame: Array = frame @ (basis @ twisted @ right) + normal @ (basis / sizes[..., None, :]) @ right
        return moved_frame

    def pullback(self, raw: Array, exact: Any, cotangent: Array, others: Any) -> Array:
        """Apply the transpose of `variation`."""
        # The derivative of the polar factor is symmetric, since the factor is the gradient of the nuclear norm.
        return self.variation(raw, (), cotangent, ())


@dataclass(frozen=True)
class Tangent(Argument):
    """A tangent vector at argument number `at`, a frame; the projection is `V - S sym(S^T V)`."""

    at: int

    @property
    def depends_on(self) -> int:
        """Number of the argument on which the projection depends."""
        return self.at

    def check_shape(self, shape: Shape, before: Sequence[Shape]) -> None:
        """Check that the vector has the shape of its frame."""
        if shape != before[self.at]:
            raise _unexpected(self.name, f"{before[self.at]}, the shape of its frame", shape)

    def value(self, raw: Array, exact: tuple[Array, ...]) -> Array:
        """Project the argument."""
        frame = exact[self.at]
        defect = symmetric_part(transposed(frame) @ raw)
        if np.abs(defect).max(initial=0.0) <= ROUND_OFF * raw.shape[-2] * np.abs(raw).max(initial=0.0):
            return raw
        _check(self.name, defect, raw, "not tangent: |S^H V + V^H S| / 2")
        projected: Array = raw - frame @ defect
        return projected

    def variation(self, raw: Array, exact: tuple[Array, ...], tangent: Array, moved: tuple[Array, ...]) -> Array:
        """Return the variation of the projection for a variation of the argument."""
        frame, move = exact[self.at], moved[self.at]
        defect = symmetric_part(transposed(frame) @ raw)
        change = symmetric_part(transposed(move) @ raw + transposed(frame) @ tangent)
        moved_vector: Array = tangent - move @ defect - frame @ change
        return moved_vector

    def pullback(self, raw: Array, exact: tuple[Array, ...], cotangent: Array, others: list[Array]) -> Array:
        """Apply the transpose of `variation`."""
        frame = exact[self.at]
        defect = symmetric_part(transposed(frame) @ raw)
        inner = symmetric_part(transposed(frame) @ cotangent)
        others[self.at] = others[self.at] - cotangent @ defect - raw @ inner
        pulled: Array = cotangent - frame @ inner
        return pulled


@dataclass(frozen=True)
class Horizontal(Argument):
    """A tangent vector at the subspace of the basis that is argument number `at`: `V - Y Y^H V`."""

    at: int

    @property
    def depends_on(self) -> int:
        """Number of the argument on which the projection depends."""
        return self.at

    def check_shape(self, shape: Shape, before: Sequence[Shape]) -> None:
        """Check that the vector has the shape of its basis."""
        if shape != before[self.at]:
            raise _unexpected(self.name, f"{before[self.at]}, that of its basis", shape)

    def value(self, raw: Array, exact: tuple[Array, ...]) -> Array:
        """Project the argument."""
        basis = exact[self.at]
        defect = transposed(basis) @ raw
        _check(self.name, defect, raw, "not horizontal: |Y^H V|")
        projected: Array = raw - basis @ defect
        return projected

    def variation(self, raw: Array, exact: tuple[Array, ...], tangent: Array, moved: tuple[Array, ...]) -> Array:
        """Move the projection as the argument does."""
        basis, move = exact[self.at], moved[self.at]
        change = transposed(move) @ raw + transposed(basis) @ tangent
        moved_vector: Array = tangent - move @ (transposed(basis) @ raw) - basis @ change
        return moved_vector

    def pullback(self, raw: Array, exact: tuple[Array, ...], cotangent: Array, others: list[Array]) -> Array:
        """Transpose `variation`."""
        basis = exact[self.at]
        inner = transposed(basis) @ cotangent
        others[self.at] = others[self.at] - cotangent @ (transposed(raw) @ basis) - raw @ transposed(inner)
        pulled: Array = cotangent - basis @ inner
        return pulled


def transposed(matrix: Array) -> Array:
    """Return the conjugate transpose in the last two axes."""
    flipped: Array = matrix.swapaxes(-1, -2)
    return flipped.conj() if flipped.dtype.kind == "c" else flipped


def skew_part(matrix: Array) -> Array:
    """Return half the difference between a matrix and its transpose."""
    part: Array = 0.5 * (matrix - transposed(matrix))
    return part


def symmetric_part(matrix: Array) -> Array:
    """Return half the sum of a matrix and its transpose."""
    part: Array = 0.5 * (matrix + transposed(matrix))
    return part


def inner_products(one: Array, other: Array) -> Array:
    """Return the real inner products of the matrices of two arrays of shape (N, n, k)."""
    products: Array = np.einsum("inl,inl->i", one.conj(), other).real
    return products


@cache
def _identity(size: int) -> Array:
    return np.eye(size)


def _gram_excess(raw: Array) -> Array:
    """Return `S^H S - I`."""
    with np.errstate(over="ignore", invalid="ignore"):
        excess: Array = transposed(raw) @ raw - _identity(raw.shape[-1])
    return excess


def _is_round_off(excess: Array, raw: Array) -> bool:
    """Whether columns are orthonormal to round-off, so that projection would not improve them."""
    return bool(np.abs(excess).max(initial=0.0) <= ROUND_OFF * raw.shape[-2])


def _is_near(excess: Array) -> bool:
    """Whether two terms of the series of the polar factor suffice."""
    # The norm of large entries overflows.
    if not np.abs(excess).max(initial=0.0) <= NEAR:
        return False
    return bool(np.linalg.norm(excess, axis=(-2, -1)).max(initial=0.0) <= NEAR)


def _inverse_root(excess: Array) -> Array:
    """Return `(I + D)^(-1/2) = I - D / 2 + 3 D^2 / 8 - ...` for a small `D`."""
    root: Array = _identity(excess.shape[-1]) - 0.5 * excess + 0.375 * (excess @ excess)
    return root


def _unexpected(name: str, expected: str, found: Shape) -> InvalidInputError:
    return InvalidInputError(f"{name}: expected shape {expected}, found {found}")


def _check_square(name: str, shape: Shape) -> None:
    if shape[-1] != shape[-2] or shape[-1] == 0:
        raise _unexpected(name, "(..., m, m) with m >= 1", shape)


def _check(name: str, defect: Array, whole: Array, meaning: str) -> None:
    """Check the defect of each matrix, relative to its own largest entry."""
    if not np.isfinite(whole).all():
        raise InvalidInputError(f"{name}: not finite")
    largest = np.abs(defect).max(axis=(-2, -1), initial=0.0)
    if largest.max(initial=0.0) <= LARGEST_DEFECT:
        return
    allowed = LARGEST_DEFECT * np.abs(whole).max(axis=(-2, -1), initial=1.0)
    if (largest > allowed).any():
        worst = np.argmax(largest / allowed)
        raise InvalidInputError(f"{name}: {meaning} = {largest.flat[worst]:.3g}, more than {allowed.flat[worst]:.3g}")
