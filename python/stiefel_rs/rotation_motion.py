"""Evaluation of splines of rotations: rotations and rates at times, and properties of the whole curve."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from ._core import SmoothingSpline, _in_library_of
from .angular_motion import AngularMotion, Frame, check_frame
from .array_input import Array, either
from .end_conditions import BcType
from .errors import InvalidInputError
from .rotation_curves import RotationCurves
from .rotation_input import RotationKind, give_back, rotated

MAX_ORDER: Final = 3
# Largest number of axes of times that scipy.spatial.transform.RotationSpline accepts.
SCIPY_AXES: Final = 1


class RotationMotion(AngularMotion):
    """Curve of rotations, or a batch of curves: the methods of `RotationSpline` except its constructors."""

    _curves: RotationCurves
    _kind: RotationKind
    _bc_type: BcType | None

    def _set(self, curves: RotationCurves, kind: RotationKind, bc_type: BcType | None) -> None:
        self._curves, self._kind, self._bc_type = curves, kind, bc_type

    def __call__(
        self,
        t: ArrayLike | None = None,
        order: int = 0,
        *,
        times: ArrayLike | None = None,
        extrapolate: bool | None = None,
    ) -> Any:
        """Evaluate rotations, or their rates in the body frame.

        Parameters
        ----------
        t : array_like, shape T
            Times, in s, shared by all splines of a batch; for SciPy's `Rotation` at most one axis.
        order : {0, 1, 2, 3}
            0 for rotations; 1, 2 and 3 for angular rate in rad/s, acceleration in rad/s^2 and jerk in rad/s^3.
        times : array_like, optional
            Alias of `t`, in s, as in SciPy.
        extrapolate : bool, optional
            Whether times outside ``t_span`` are allowed in this call; by default as for the spline.

        Returns
        -------
        Rotation or ndarray
            Rotations of the same kind as the input of the spline: unit quaternions of shape ``(...) + T + (4,)``,
            scalar last, continuous in ``t`` and, if interpolated, with the given sign at the first knot; or matrices of
            shape ``(...) + T + (3, 3)``. Rates of shape ``(...) + T + (3,)``, in rad/s^order, in the body frame.
            ``(...)`` are the leading axes of a batch.

        Raises
        ------
        InvalidInputError
            Times that are not finite, or outside ``t_span`` if `extrapolate` is False; unknown order.
        ConvergenceError
            Times so far outside ``t_span`` that the integration of the end piece takes more than 100000 steps.
        """
        t = either(t, times)
        if np.ndim(order) or order not in range(MAX_ORDER + 1):
            raise InvalidInputError(f"order: must be 0, 1, 2 or 3, found {order!r}")
        if self._kind == "Rotation" and np.ndim(t) > SCIPY_AXES:
            raise InvalidInputError(f"t: Rotation objects allow at most one axis of times, found shape {np.shape(t)}")
        curves = self._curves if extrapolate is None else self._curves.extended(extrapolate)
        if order:
            return _in_library_of(t, curves.rates(t, int(order)))
        return _in_library_of(t, give_back(self._kind, curves.quaternions(t)))

    def cost(self) -> Any:
        """Return the integral of the squared angular acceleration over ``t_span``.

        For a spline in tension, the integral of ``|a|^2 + tension |w|^2``.

        Returns
        -------
        float or ndarray, shape (...)
            In rad^2/s^3; an array for a batch.
        """
        return self._curves.values(member.curve.cost() for member in self._curves.members)

    def arc_length(self, t0: float | None = None, t1: float | None = None) -> Any:
        """Return the angle turned between two times, the integral of the norm of the angular rate.

        Parameters
        ----------
        t0, t1 : float, optional
            Times, in s; by default the ends.

        Returns
        -------
        float or ndarray, shape (...)
            In rad; an array for a batch.

        Raises
        ------
        InvalidInputError
            A time outside ``t_span`` if `extrapolate` is False.
        ConvergenceError
            A time so far outside ``t_span`` that the integration of the end piece takes more than 100000 steps.
        """
        return self._curves.values(self._curves.arc_length(member, t0, t1) for member in self._curves.members)

    @property
    def curve(self) -> Any:
        """Curve on St(3, 3): a `CubicSpline`, `SmoothingSpline` or `CubicHermite`; an object array for a batch.

        Its times are in s. Its norms, of the canonical metric, are those of the rates: ``curve.derivative_bounds()``
        bounds ``|w|`` in rad/s, ``|w'|`` in rad/s^2 and, as the jerk, ``|w'' + (w x w') / 2|`` in rad/s^3.
        """
        return self._curves.objects([member.curve for member in self._curves.members])

    @property
    def report(self) -> Any:
        """Outcome of the solver, a `SolverReport` or None; an object array for a batch."""
        return self._curves.objects([member.report for member in self._curves.members])

    @property
    def lam(self) -> Any:
        """Weight of the acceleration of a smoothing spline, in s^3, shape (...); None for other splines."""
        return self._of_smoothing("lam")

    @property
    def misfit(self) -> Any:
        """Sum of the weighted squared angles from a smoothing spline to its data, in rad^2, shape (...); else None."""
        return self._of_smoothing("misfit")

    @property
    def degrees_of_freedom(self) -> Any:
        """Effective number of rotations that a smoothing spline retains, shape (...); None for other splines.

        Between 2 and N, dimensionless. With weights 1 the variance of an angle about each axis, in rad^2, is about
        ``misfit / (3 * (N - degrees_of_freedom))``.
        """
        return self._of_smoothing("degrees_of_freedom")

    def _of_smoothing(self, name: str) -> Any:
        curves = [member.curve for member in self._curves.members]
        found = [getattr(curve, name) for curve in curves if isinstance(curve, SmoothingSpline)]
        return self._curves.values(found) if len(found) == len(curves) else None

    @property
    def t(self) -> Array:
        """Times of the knots, in s, shape (N,); for a batch shape (..., N).

        Raises
        ------
        InvalidInputError
            Members of a batch have different numbers of knots: a smoothing spline has one for each distinct time. For
            their knots, use ``t`` of each of ``curve``.
        """
        return self._curves.t

    @property
    def times(self) -> Array:
        """Alias of `t`, in s, as in SciPy; raises as `t` does."""
        return self.t

    @property
    def rotations(self) -> Any:
        """Rotations at the knots, of the same kind as the input; quaternions have length 1 and continuous sign.

        Raises
        ------
        InvalidInputError
            Members of a batch have different numbers of knots, as for `t`.
        """
        return give_back(self._kind, self._curves.at_knots())

    @property
    def t_span(self) -> tuple[Any, Any]:
        """First and last time, in s: two floats, or two arrays of shape (...) for a batch."""
        return self._curves.t_span

    @property
    def kind(self) -> RotationKind:
        """Kind of the rotations returned: ``"Rotation"``, ``"quaternions"`` or ``"matrices"``."""
        return self._kind

    @property
    def extrapolate(self) -> bool:
        """Whether the end pieces are continued outside ``t_span``."""
        return self._curves.extrapolate

    @property
    def bc_type(self) -> BcType | None:
        """End conditions as given; None for smoothing and Hermite splines.

        Vectors are read-only: rates in rad/s and accelerations in rad/s^2, in the body frame.
        """
        return self._bc_type

    def __repr__(self) -> str:
        members, shape = self._curves.members, self._curves.shape
        batch = f"batch of shape {shape}, " if shape else ""
        if not members:
            return f"<RotationSpline of {self._kind}, {batch}empty>"
        first, last = min(float(member.t[0]) for member in members), max(float(member.t[-1]) for member in members)
        curve = f"{type(members[0].curve).__name__} on St(3, 3)"
        knots = f"{len(members[0].t)} knots, t_span ({first!r}, {last!r})"
        return f"<RotationSpline of {self._kind}, {batch}{curve}, {knots}>"

    def _angular(self, t: ArrayLike, order: int, frame: Frame) -> Array:
        in_world = check_frame(frame) == "world"
        body = self._curves.rates(t, order)
        return rotated(self._curves.quaternions(t), body) if in_world else body
