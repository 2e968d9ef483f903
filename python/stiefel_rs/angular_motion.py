"""Angular rates of splines of rotations and of poses."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Literal, TypeAlias, cast, get_args

from numpy.typing import ArrayLike

from ._core import _in_library_of
from .array_input import Array
from .errors import InvalidInputError

Frame: TypeAlias = Literal["body", "world"]


def check_frame(frame: str) -> Frame:
    """Check the name of a frame.

    Raises
    ------
    InvalidInputError
        The name is neither ``"body"`` nor ``"world"``.
    """
    if not isinstance(frame, str) or frame not in get_args(Frame):
        raise InvalidInputError(f"frame: expected 'body' or 'world', found {frame!r}")
    return frame  # type: ignore[return-value]


class AngularMotion(ABC):
    """Angular rates ``w`` of a rotation ``R``, ``R' = R hat(w)``, for splines of rotations and of poses."""

    @abstractmethod
    def _angular(self, t: ArrayLike, order: int, frame: Frame) -> Array:
        """Return the rate (1), acceleration (2) or jerk (3), shape ``(...) + T + (3,)``, in rad/s^order."""

    def angular_velocity(self, t: ArrayLike, frame: Frame = "body") -> Array:
        """Return the angular rate.

        Parameters
        ----------
        t : array_like, shape T
            Times, in s.
        frame : {"body", "world"}
            Axes along which it is expressed: the axes of the rotated body, ``w``, or of the world, ``R w``.

        Returns
        -------
        ndarray, shape (...) + T + (3,)
            In rad/s.

        Raises
        ------
        InvalidInputError
            Times that are not finite, or outside ``t_span`` if `extrapolate` is False; unknown frame.
        ConvergenceError
            Times so far outside ``t_span`` that the integration of the end piece takes more than 100000 steps.

        Examples
        --------
        >>> import numpy as np
        >>> from stiefel_rs import RotationSpline
        >>> spline = RotationSpline([0.0, 2.0], [[0, 0, 0, 1], [0, 0, np.sin(0.3), np.cos(0.3)]])
        >>> spline.angular_velocity(1.0).round(12) + 0.0
        array([0. , 0. , 0.3])
        """
        return cast("Array", _in_library_of(t, self._angular(t, 1, frame)))

    def angular_acceleration(self, t: ArrayLike, frame: Frame = "body") -> Array:
        """Return the angular acceleration, the derivative of the angular rate in either frame.

        Parameters
        ----------
        t : array_like, shape T
            Times, in s.
        frame : {"body", "world"}
            Axes along which it is expressed: ``w'``, or ``R w'``.

        Returns
        -------
        ndarray, shape (...) + T + (3,)
            In rad/s^2.

        Raises
        ------
        InvalidInputError
            Times that are not finite, or outside ``t_span`` if `extrapolate` is False; unknown frame.
        ConvergenceError
            Times so far outside ``t_span`` that the integration of the end piece takes more than 100000 steps.

        Examples
        --------
        >>> from stiefel_rs import RotationSpline
        >>> spline = RotationSpline([0, 1, 2], [[0, 0, 0, 1], [0, 0, 1, 1], [0, 0, 0, 1]])
        >>> spline.angular_acceleration([0.0, 1.0])[:, 2].round(6) + 0.0
        array([ 0.      , -4.712389])
        """
        return cast("Array", _in_library_of(t, self._angular(t, 2, frame)))

    def angular_jerk(self, t: ArrayLike, frame: Frame = "body") -> Array:
        """Return the angular jerk, the second derivative of the angular rate in the body frame.

        Parameters
        ----------
        t : array_like, shape T
            Times, in s; at a knot, where the jerk jumps, the value of the following piece.
        frame : {"body", "world"}
            Axes along which it is expressed: ``w''``, or ``R w''``. The latter is constant on each piece of a spline
            without tension, and differs from the derivative of the world acceleration, ``R (w'' + w x w')``.

        Returns
        -------
        ndarray, shape (...) + T + (3,)
            In rad/s^3.

        Raises
        ------
        InvalidInputError
            Times that are not finite, or outside ``t_span`` if `extrapolate` is False; unknown frame.
        ConvergenceError
            Times so far outside ``t_span`` that the integration of the end piece takes more than 100000 steps.

        Examples
        --------
        >>> from stiefel_rs import RotationSpline
        >>> spline = RotationSpline([0, 1, 2], [[0, 0, 0, 1], [0, 0, 1, 1], [0, 0, 0, 1]])
        >>> spline.angular_jerk([0.5, 1.5])[:, 2].round(6) + 0.0
        array([-4.712389,  4.712389])
        """
        return cast("Array", _in_library_of(t, self._angular(t, 3, frame)))
