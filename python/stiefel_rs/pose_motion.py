"""Evaluation of splines of poses: poses, velocities and twists at times."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from ._core import _in_library_of
from .angular_motion import AngularMotion, Frame, check_frame
from .array_input import Array, finite_array, real_array, times_within
from .end_conditions import BcType
from .pose_input import PoseKind, give_back_poses
from .positions import derivative
from .rotation_input import inverse, rotated

if TYPE_CHECKING:
    from .rotation_motion import RotationMotion


class PoseMotion(AngularMotion):
    """Curve of poses: the methods of `PoseSpline` except its constructors."""

    def _set(
        self,
        kind: PoseKind,
        rotations: RotationMotion,
        positions: Any,
        bc_type: BcType | None,
        lam: tuple[float | None, float | None] | None,
    ) -> None:
        self._kind, self._bc_type, self._lam = kind, bc_type, lam
        self._rotations, self._positions = rotations, positions

    def __call__(self, t: ArrayLike, *, extrapolate: bool | None = None) -> Any:
        """Evaluate poses, of the same kind as the input of the spline.

        Parameters
        ----------
        t : array_like, shape T
            Times, in s; for SciPy's classes at most one axis.
        extrapolate : bool, optional
            Whether times outside ``t_span`` are allowed in this call; by default as for the spline.

        Returns
        -------
        RigidTransform, ndarray or tuple
            Matrices have shape ``T + (4, 4)``; a tuple holds rotations of the same kind as the input, and positions of
            shape ``T + (3,)``. Positions, also as the last column of a matrix or the translation of a `RigidTransform`,
            are in m (the unit of the given positions).

        Raises
        ------
        InvalidInputError
            Times that are not finite, or outside ``t_span`` if `extrapolate` is False.
        ConvergenceError
            Times so far outside ``t_span`` that the integration of the end piece takes more than 100000 steps.
        """
        times = real_array(t, "t")
        allowed = self.extrapolate if extrapolate is None else extrapolate
        rotations = self._rotations(times, extrapolate=allowed)
        poses = give_back_poses(self._kind, rotations, self._linear(times, 0, "world", extrapolate=allowed))
        return _in_library_of(t, poses)

    def rotation(self, t: ArrayLike) -> Any:
        """Evaluate rotations.

        Parameters
        ----------
        t : array_like, shape T
            Times, in s.

        Returns
        -------
        Rotation or ndarray
            A `Rotation` for a spline of `RigidTransform`, matrices of shape ``T + (3, 3)`` for matrices, and for a pair
            the kind of its rotations.

        Raises
        ------
        InvalidInputError
            Times that are not finite, or outside ``t_span`` if `extrapolate` is False.
        ConvergenceError
            Times so far outside ``t_span`` that the integration of the end piece takes more than 100000 steps.
        """
        return self._rotations(t)

    def position(self, t: ArrayLike) -> Array:
        """Evaluate positions in the world frame.

        Parameters
        ----------
        t : array_like, shape T
            Times, in s.

        Returns
        -------
        ndarray, shape T + (3,)
            In m (the unit of the given positions).

        Raises
        ------
        InvalidInputError
            Times that are not finite, or outside ``t_span`` if `extrapolate` is False.
        """
        return cast("Array", _in_library_of(t, self._linear(t, 0, "world")))

    def linear_velocity(self, t: ArrayLike, frame: Frame = "world") -> Array:
        """Return the velocity of the position, ``p'``.

        Parameters
        ----------
        t : array_like, shape T
            Times, in s.
        frame : {"world", "body"}
            Axes along which it is expressed: ``p'``, or ``R^T p'``.

        Returns
        -------
        ndarray, shape T + (3,)
            In m/s.

        Raises
        ------
        InvalidInputError
            Times that are not finite, or outside ``t_span`` if `extrapolate` is False; unknown frame.
        ConvergenceError
            In the body frame: times so far outside ``t_span`` that the integration of the end piece takes more than
            100000 steps.
        """
        return cast("Array", _in_library_of(t, self._linear(t, 1, frame)))

    def linear_acceleration(self, t: ArrayLike, frame: Frame = "world") -> Array:
        """Return the acceleration of the position, ``p''``.

        Parameters
        ----------
        t : array_like, shape T
            Times, in s.
        frame : {"world", "body"}
            Axes along which it is expressed: ``p''``, or ``R^T p''`` (an accelerometer measures the latter minus
            gravity).

        Returns
        -------
        ndarray, shape T + (3,)
            In m/s^2.

        Raises
        ------
        InvalidInputError
            Times that are not finite, or outside ``t_span`` if `extrapolate` is False; unknown frame.
        ConvergenceError
            In the body frame: times so far outside ``t_span`` that the integration of the end piece takes more than
            100000 steps.
        """
        return cast("Array", _in_library_of(t, self._linear(t, 2, frame)))

    def linear_jerk(self, t: ArrayLike, frame: Frame = "world") -> Array:
        """Return the jerk of the position, ``p'''``, which is constant on each piece.

        Parameters
        ----------
        t : array_like, shape T
            Times, in s; at a knot, where the jerk jumps, the value of the following piece.
        frame : {"world", "body"}
            Axes along which it is expressed: ``p'''``, or ``R^T p'''``.

        Returns
        -------
        ndarray, shape T + (3,)
            In m/s^3.

        Raises
        ------
        InvalidInputError
            Times that are not finite, or outside ``t_span`` if `extrapolate` is False; unknown frame.
        ConvergenceError
            In the body frame: times so far outside ``t_span`` that the integration of the end piece takes more than
            100000 steps.
        """
        return cast("Array", _in_library_of(t, self._linear(t, 3, frame)))

    def twist(self, t: ArrayLike, frame: Frame = "body") -> Array:
        """Return the twist: angular and linear velocity of the body, angular part first.

        With ``T = [[R, p], [0, 1]]``, the twist ``(w, v)`` stands for the matrix ``[[hat(w), v], [0, 0]]``, which is
        ``T^-1 T'`` for the body twist and ``T' T^-1`` for the spatial twist (frame "world").

        Parameters
        ----------
        t : array_like, shape T
            Times, in s.
        frame : {"body", "world"}
            The body twist ``(w_body, R^T p')``, or the spatial twist ``(w_world, p' - w_world x p)``. The linear part
            of the spatial twist is the velocity of the point of the body at the origin of the world; `linear_velocity`
            returns ``p'``.

        Returns
        -------
        ndarray, shape T + (6,)
            Three numbers in rad/s, then three in m/s.

        Raises
        ------
        InvalidInputError
            Times that are not finite, or outside ``t_span`` if `extrapolate` is False; unknown frame.
        ConvergenceError
            Times so far outside ``t_span`` that the integration of the end piece takes more than 100000 steps.

        Notes
        -----
        Lynch, Park (2017), Modern Robotics, section 3.3.2.
        """
        w, v = self._angular(t, 1, frame), self._linear(t, 1, frame)
        if frame == "world":
            v = v - np.cross(w, self._linear(t, 0, "world"))
        return cast("Array", _in_library_of(t, np.concatenate([w, v], axis=-1)))

    @property
    def rotation_spline(self) -> RotationMotion:
        """The `RotationSpline` of the rotations, with times in s and rates in rad/s."""
        return self._rotations

    @property
    def position_spline(self) -> Any:
        """SciPy spline of the positions, which extrapolates: a `CubicSpline`, or a `BSpline` if smoothed.

        It takes times in s, and returns positions in m and their derivatives in m/s^order, in the world frame.
        """
        return self._positions

    @property
    def t(self) -> Array:
        """Times of the knots, in s, shape (N,)."""
        return self._rotations.t

    @property
    def t_span(self) -> tuple[float, float]:
        """First and last time, in s."""
        return self._rotations.t_span

    @property
    def kind(self) -> PoseKind:
        """Kind of the poses returned: ``"RigidTransform"``, ``"matrices"`` or ``"pair"``."""
        return self._kind

    @property
    def extrapolate(self) -> bool:
        """Whether the end pieces are continued outside ``t_span``."""
        return self._rotations.extrapolate

    @property
    def bc_type(self) -> BcType | None:
        """End conditions as given; None for smoothing splines.

        Vectors are read-only, of shape (2, 3): an angular rate in rad/s and a velocity in m/s, or an angular
        acceleration in rad/s^2 and a linear one in m/s^2.
        """
        return self._bc_type

    @property
    def lam(self) -> tuple[float | None, float | None] | None:
        """Weights of the accelerations of rotations and positions, in s^3; None unless smoothed.

        The second is None if SciPy's cross-validation chose a weight for each coordinate, which it does not return.
        """
        return self._lam

    def __repr__(self) -> str:
        first, last = self.t_span
        curve = f"{type(self._rotations.curve).__name__} on St(3, 3)"
        return f"<PoseSpline of {self._kind}, {curve} and R^3, {len(self.t)} knots, t_span ({first!r}, {last!r})>"

    def _angular(self, t: ArrayLike, order: int, frame: Frame) -> Array:
        return self._rotations._angular(t, order, frame)

    def _linear(self, t: ArrayLike, order: int, frame: Frame, *, extrapolate: bool | None = None) -> Array:
        in_body = check_frame(frame) == "body"
        times = finite_array(t, "t")
        if not (self.extrapolate if extrapolate is None else extrapolate):
            times = times_within(times, *self.t_span)
        world = derivative(self._positions, times, order)
        return rotated(inverse(self._rotations._curves.quaternions(times)), world) if in_body else world
