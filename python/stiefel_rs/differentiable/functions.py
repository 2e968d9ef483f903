"""The functions of `stiefel_rs.jax` and `stiefel_rs.torch`, for the arrays of either library.

Some functions are operations, the others compositions of operations. The retraction of quasi-geodesics is
`R_S(V) = e^X S e^Omega` with `Omega = S^T V` and `X = K S^T - S K^T`, where `K = V - S Omega`; its inverse has
`X = log((I - 2 S1 S1^T)(I - 2 S0 S0^T)) / 2` and `Omega = log(S0^T e^-X S1)`; and the geometric cubic is de Casteljau's
algorithm with the curves `R_S(t V)`. For complex frames, transposes are conjugate transposes.

Source: Krakowski, Machado, Silva Leite, Batista (2017), J. Comput. Appl. Math. 311, 84-99 (quasi-geodesics, and de
Casteljau's algorithm with them).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import AbstractContextManager
from itertools import pairwise, zip_longest
from types import ModuleType
from typing import Any, Generic, TypeVar

from .._core import Grassmann, Stiefel
from ..errors import InvalidInputError
from . import cubics, geodesics, matrix_functions, splines, subspaces
from .arguments import Frame, Shape
from .operation import Operation, on_pairs
from .splines import BcType

T = TypeVar("T")
Manifold = Stiefel | Grassmann | None
# The parameter of the canonical metric.
CANONICAL = 0.0


class Functions(ABC, Generic[T]):
    """The functions, for arrays `T` of a library."""

    @abstractmethod
    def arrays(self, arguments: Sequence[Any]) -> list[Any]:
        """Convert arguments to arrays of the library with a common precision, real or complex."""

    @abstractmethod
    def flat(self, t: Any) -> tuple[Any, Shape]:
        """Return times as a vector, and their original shape."""

    @abstractmethod
    def is_complex(self, array: Any) -> bool:
        """Whether an array is complex."""

    @abstractmethod
    def pairs(self, array: Any) -> Any:
        """Return real and imaginary parts on a new last axis; imaginary parts are zero for a real array."""

    @abstractmethod
    def of_pairs(self, array: Any) -> Any:
        """Return the complex array of real and imaginary parts on the last axis."""

    @abstractmethod
    def broadcast(self, arrays: list[Any], axes: tuple[int, ...]) -> list[Any]:
        """Broadcast the axes before the last `axes` ones of each array."""

    @abstractmethod
    def evaluate(self, operation: Operation, arrays: list[Any]) -> Any:
        """Evaluate an operation, with derivatives."""

    @abstractmethod
    def identity(self, like: Any) -> Any:
        """Return the identity matrix with the number of rows and the dtype of `like`."""

    @abstractmethod
    def exact_products(self) -> AbstractContextManager[Any]:
        """Return a context in which matrices are multiplied in the precision of their entries."""

    def apply(self, operation: Operation, *arguments: Any) -> Any:
        """Apply an operation to arrays after broadcasting their leading axes."""
        arrays = self.arrays(arguments)
        shapes: list[Shape] = []
        for argument, array, axes in zip(operation.arguments, arrays, operation.axes, strict=True):
            if self.is_complex(array) and not argument.may_be_complex:
                raise TypeError(f"{argument.name}: expected real numbers, found {array.dtype}")
            if array.ndim < axes:
                expected = f"at least {axes} axes" if axes > 1 else "at least one axis"
                raise InvalidInputError(f"{argument.name}: expected {expected}, found shape {tuple(array.shape)}")
            shape = tuple(array.shape)[array.ndim - axes :]
            argument.check_shape(shape, shapes)
            shapes.append(shape)
        _check_batches([argument.name for argument in operation.arguments], arrays, operation.axes)
        if not any(map(self.is_complex, arrays)):
            return self.evaluate(operation, self.broadcast(arrays, operation.axes))
        operation = on_pairs(operation)
        pairs = zip(operation.arguments, arrays, strict=True)
        arrays = [self.pairs(array) if argument.may_be_complex else array for argument, array in pairs]
        return self.of_pairs(self.evaluate(operation, self.broadcast(arrays, operation.raw_axes)))

    def _of(self, manifold: Manifold, frames: ModuleType, *points: Any) -> ModuleType:
        """Return the operations on what the points are: those given for frames, or those on subspaces."""
        if manifold is None:
            return frames
        if not isinstance(manifold, (Stiefel, Grassmann)):
            raise TypeError(f"manifold: expected a Stiefel or a Grassmann, found {type(manifold).__name__}")
        if isinstance(manifold, Stiefel) and manifold.alpha != CANONICAL:
            raise InvalidInputError(f"manifold: expected the canonical metric, found {manifold!r}")
        arrays = self.arrays(points)
        if (shape := tuple(arrays[0].shape))[-2:] != (manifold.n, manifold.k):
            raise InvalidInputError(f"manifold: {manifold!r} has no points of shape {shape}")
        if any(map(self.is_complex, arrays)) and manifold.field == "real":
            raise InvalidInputError(f"manifold: {manifold!r} has no complex points; field='complex' has")
        return subspaces if isinstance(manifold, Grassmann) else frames

    def _at_times(self, operation: Operation, *arguments: Any, own: int) -> Any:
        """Apply an operation whose last argument is an array of times; each value has `own` axes."""
        times, shape = self.flat(arguments[-1])
        return _in_shape(self.apply(operation, *arguments[:-1], times), shape, own)

    def _frame(self, s: Any, name: str) -> Any:
        return self.apply(matrix_functions.nearest_frame(name), s)

    def _tangent(self, s: Any, v: Any, names: tuple[str, str]) -> Any:
        return self.apply(matrix_functions.nearest_tangent(*names), s, v)

    def skew_exp(self, A: Any) -> T:
        """Return the exponential of skew-symmetric or skew-Hermitian matrices, shape (..., m, m)."""
        found: T = self.apply(matrix_functions.SKEW_EXP, A)
        return found

    def orthogonal_log(self, Q: Any) -> T:
        """Return the principal logarithm of rotations or unitary matrices, shape (..., m, m)."""
        found: T = self.apply(matrix_functions.ORTHOGONAL_LOG, Q)
        return found

    def exp(self, S: Any, V: Any, *, manifold: Manifold = None) -> T:
        """Return the Riemannian exponential of ``V`` at ``S``, shapes (..., n, k).

        For frames with the canonical metric, or for subspaces with ``manifold=Grassmann(n, k)``.
        """
        found: T = self.apply(self._of(manifold, geodesics, S, V).EXP, S, V)
        return found

    def log(self, S0: Any, S1: Any, *, manifold: Manifold = None) -> T:
        """Return the Riemannian logarithm of ``S1`` at ``S0``, shapes (..., n, k).

        For frames with the canonical metric, or for subspaces with ``manifold=Grassmann(n, k)``.
        """
        found: T = self.apply(self._of(manifold, geodesics, S0, S1).LOG, S0, S1)
        return found

    def retract(self, S: Any, V: Any) -> T:
        """Return the end of the quasi-geodesic from ``S`` with initial velocity ``V``, shapes (..., n, k)."""
        s, v = self.arrays([S, V])
        with self.exact_products():
            found: T = self._retract(self._frame(s, "S"), self._tangent(s, v, ("S", "V")))
        return found

    def inverse_retract(self, S0: Any, S1: Any) -> T:
        """Return the initial velocity of the quasi-geodesic from ``S0`` to ``S1``, shapes (..., n, k).

        Points whose frames differ by a reflection raise `OutsideDomainError`, with an angle of pi, although
        `Stiefel.inverse_retract` joins them: of random pairs on St(5, 2), none up to a distance of 1.5, and three of
        four at a distance of 2.
        """
        s0, s1 = self.arrays([S0, S1])
        with self.exact_products():
            found: T = self._inverse_retract(*self._pair(s0, s1))
        return found

    def _retract(self, s: Any, v: Any) -> Any:
        omega = 0.5 * _twice_skew(_transposed(s) @ v)
        x = _twice_skew((v - s @ omega) @ _transposed(s))
        return self.skew_exp(x) @ s @ self.skew_exp(omega)

    def _pair(self, s0: Any, s1: Any) -> tuple[Any, Any]:
        """Project two frames, S0 and S1, of the same shape."""
        _check_batches(["S0", "S1"], [s0, s1], (2, 2))
        frames = self._frame(s0, "S0"), self._frame(s1, "S1")
        shapes = [tuple(s.shape[-2:]) for s in frames]
        Frame("S1", like=0).check_shape(shapes[1], shapes[:1])
        return frames

    def _inverse_retract(self, s0: Any, s1: Any) -> Any:
        one = self.identity(s0)
        reflections = [one - 2.0 * s @ _transposed(s) for s in (s1, s0)]
        log: Any = self.orthogonal_log(reflections[0] @ reflections[1])
        x = 0.5 * log
        omega = self.orthogonal_log(_transposed(s0) @ _transposed(self.skew_exp(x)) @ s1)
        return x @ s0 + s0 @ omega

    def geometric_cubic(self, S0: Any, V0: Any, S1: Any, V1: Any, t: Any) -> T:
        """Evaluate the geometric cubic with given end points and end velocities.

        Control points that `inverse_retract` does not join raise `OutsideDomainError`.

        Parameters
        ----------
        S0, V0, S1, V1 : array, shape (..., n, k)
            Points and velocities at times 0 and 1.
        t : array, shape T
            Times.

        Returns
        -------
        array, shape (...) + T + (n, k)
        """
        flat, shape = self.flat(t)
        s0, v0, s1, v1, times = self.arrays([S0, V0, S1, V1, flat])
        _check_batches(["S0", "V0", "S1", "V1"], [s0, v0, s1, v1], (2, 2, 2, 2))
        with self.exact_products():
            first, last = self._pair(s0, s1)
            points = [
                first,
                self._retract(first, self._tangent(s0, v0, ("S0", "V0")) / 3.0),
                self._retract(last, self._tangent(s1, v1, ("S1", "V1")) / -3.0),
                last,
            ]
            weights = self.apply(matrix_functions.TIMES, times)[:, None, None]
            points = [point[..., None, :, :] + 0.0 * weights for point in points]
            while len(points) > 1:
                points = [self._retract(p, weights * self._inverse_retract(p, q)) for p, q in pairwise(points)]
        found: T = _in_shape(points[0], shape, 2)
        return found

    def riemannian_cubic(self, S0: Any, V0: Any, S1: Any, V1: Any, t: Any, *, manifold: Manifold = None) -> T:
        """Evaluate the Riemannian cubic with given end points and end velocities.

        Parameters
        ----------
        S0, V0, S1, V1 : array, shape (..., n, k)
            Points and velocities at times 0 and 1.
        t : array, shape T
            Times.
        manifold : Stiefel or Grassmann, optional
            What the points are: by default frames. On a `Grassmann` they are bases of subspaces; the curve returns
            bases that turn as little as possible, from the first given one on, and derivatives are those of these.

        Returns
        -------
        array, shape (...) + T + (n, k)
        """
        operation = self._of(manifold, cubics, S0, V0, S1, V1).RIEMANNIAN_CUBIC
        found: T = self._at_times(operation, S0, V0, S1, V1, t, own=2)
        return found

    def cubic_initial(self, S: Any, V: Any, A: Any, J: Any, t: Any, *, manifold: Manifold = None) -> T:
        """Evaluate the Riemannian cubic with given initial data.

        Parameters
        ----------
        S, V, A, J : array, shape (..., n, k)
            Point, velocity, covariant acceleration and covariant jerk at time 0.
        t : array, shape T
            Times, all of the same sign.
        manifold : Stiefel or Grassmann, optional
            What the points are, as for `riemannian_cubic`.

        Returns
        -------
        array, shape (...) + T + (n, k)
        """
        operation = self._of(manifold, cubics, S, V, A, J).CUBIC_INITIAL
        found: T = self._at_times(operation, S, V, A, J, t, own=2)
        return found

    def cubic_spline(
        self, t_knots: Any, S: Any, t: Any, bc_type: BcType = "natural", *, manifold: Manifold = None
    ) -> T:
        """Evaluate the spline of Riemannian cubics through frames or subspaces.

        Parameters
        ----------
        t_knots : array, shape (..., N)
            Increasing times of the frames.
        S : array, shape (..., N, n, k)
            Frames, or bases.
        t : array, shape T
            Times.
        bc_type : {"natural", "clamped", "periodic"}
            End conditions, as for `CubicSpline`. Directions of closed ones move both ends by their mean.
        manifold : Stiefel or Grassmann, optional
            What the points are, as for `riemannian_cubic`.

        Returns
        -------
        array, shape (...) + T + (n, k)
        """
        operation = self._of(manifold, splines, S).cubic_spline(bc_type)
        found: T = self._at_times(operation, t_knots, S, t, own=2)
        return found

    def rotation_spline(self, t_knots: Any, quaternions: Any, t: Any, bc_type: BcType = "natural") -> T:
        """Evaluate the spline through rotations, as unit quaternions, between the first and the last knot.

        Parameters
        ----------
        t_knots : array, shape (..., N)
            Increasing times of the rotations.
        quaternions : array, shape (..., N, 4)
            Rotations as quaternions, scalar last, of any nonzero length.
        t : array, shape T
            Times.
        bc_type : {"natural", "clamped", "periodic"}
            End conditions, as for `RotationSpline`. Directions of closed ones move both ends by their mean.

        Returns
        -------
        array, shape (...) + T + (4,)
            Quaternions of continuous sign; at the first knot the given sign.
        """
        found: T = self._at_times(splines.rotation_spline(bc_type), t_knots, quaternions, t, own=1)
        return found


def _check_batches(names: Sequence[str], arrays: Sequence[Any], axes: Sequence[int]) -> None:
    """Check that the axes before the last `axes` ones of each argument broadcast."""
    shapes = [tuple(x.shape) for x in arrays]
    leads = [shape[: len(shape) - own] for shape, own in zip(shapes, axes, strict=True)]
    sizes = zip_longest(*(lead[::-1] for lead in leads), fillvalue=1)
    if all(len(set(size) - {1}) <= 1 for size in sizes):
        return
    batched = [i for i, lead in enumerate(leads) if lead]
    found = ", ".join(str(shapes[i]) for i in batched)
    raise InvalidInputError(
        f"{', '.join(names[i] for i in batched)}: leading axes cannot be broadcast together, found shapes {found}"
    )


def _transposed(matrix: Any) -> Any:
    return matrix.swapaxes(-1, -2).conj()


def _twice_skew(matrix: Any) -> Any:
    return matrix - _transposed(matrix)


def _in_shape(found: Any, shape: tuple[int, ...], own: int) -> Any:
    """Reshape the axis of the times, before the last `own` axes, to the shape of the times."""
    place = found.ndim - own - 1
    return found.reshape(*found.shape[:place], *shape, *found.shape[place + 1 :])
