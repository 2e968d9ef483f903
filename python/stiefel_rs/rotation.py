"""Smooth curves through rotations, given as SciPy's `Rotation`, as quaternions or as matrices."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ._core import (
    CubicHermite,
    CubicSpline,
    RotationCurve,
    SmoothingSpline,
    Stiefel,
    interpolated_rotations,
    rotations_with_rates,
    smoothed_rotations,
)
from .angular_motion import Frame, check_frame
from .array_input import Array, check_lam, either, either_weights, flag, vectors_at_knots
from .end_conditions import BcType, in_body_frame, read_bc_type
from .errors import InvalidInputError
from .rotation_curves import RotationCurves, flat_batch
from .rotation_input import KINDS, RotationKind, inverse, read_rotations, rotated, unit
from .rotation_motion import RotationMotion

if TYPE_CHECKING:
    from collections.abc import Sequence

Curve: TypeAlias = CubicSpline | SmoothingSpline | CubicHermite

__all__ = ["RotationSpline"]


class RotationSpline(RotationMotion):
    """Interpolate rotations by a cubic spline on the rotation group.

    Angular rate and angular acceleration are continuous. Among all curves through the rotations with the given end
    conditions, the integral of the squared angular acceleration is stationary. The class can replace
    `scipy.spatial.transform.RotationSpline`. It returns rotations of the same kind as its input.

    Parameters
    ----------
    t : array_like, shape (N,) or (..., N)
        At least two increasing times, in s; another unit of time takes the place of s in all units of the spline. With
        leading axes, each spline of a batch has its own times.
    rotations : Rotation, or array_like, shape (..., N, 4) or (..., N, 3, 3)
        N rotations: a SciPy `Rotation`; quaternions, scalar last, of any nonzero length; or matrices, orthonormal to
        1e-9 (float32: 1e-5), with determinant 1. Quaternions and matrices with leading axes make a batch of splines.
    bc_type : str or pair, default "natural"
        End conditions: ``"natural"``, zero angular acceleration; ``"clamped"``, zero angular rate; ``"periodic"``,
        the last rotation equals the first, and rate and acceleration agree there. Or a pair of conditions for the first
        and the last rotation: each ``"natural"``, ``"clamped"``, ``(1, w)`` with an angular rate in rad/s or ``(2, a)``
        with an angular acceleration in rad/s^2, of shape (3,), in the body frame.
    times : array_like, optional
        Alias of `t`, in s, as in SciPy.
    extrapolate : bool, default True
        If True, the first and the last piece are continued outside ``[t[0], t[-1]]``. If False, such times raise,
        except within 4 ulp of an end (of the larger end in absolute value), which count as that end. The pieces are
        continued by integration in at most 100000 steps: times too far outside raise `ConvergenceError`.
    project : bool, default False
        If True, matrices that are not orthonormal are replaced by the nearest rotations.
    tol : float, default 1e-12
        Largest angle, in rad, between the end of a piece and its knot, and largest jump of the acceleration, with the
        duration of the piece as the unit of time.
    max_iterations : int, default 200
        Largest number of iterations.
    tension : float, default 0.0
        Weight of the squared rate relative to the squared acceleration, in 1/s^2, as for `CubicSpline`.
    num_threads : int, optional
        Number of threads; by default the size of the global pool.

    Raises
    ------
    InvalidInputError
        Mismatched shapes or numbers, non-finite entries, times that do not increase, a quaternion of length zero, a
        matrix that is not a rotation (with its defect). Names the knot; carries ``knot``.
    OutsideDomainError
        Two consecutive rotations are half a turn apart, so that the shortest path is not unique: their angle is within
        2.7e-15 rad of pi, 12 times the machine epsilon. Carries ``knot``, the index of the first, and ``angle`` in rad.
    ConvergenceError
        No spline was found; carries ``report``, and ``knot`` if the interval after it is much longer than a neighbour
        and the curve would be fast there.
    TypeError
        Complex numbers, dates, objects.

    See Also
    --------
    PoseSpline : splines of rotations with positions.
    CubicSpline : splines on any Stiefel manifold.

    Notes
    -----
    With the body rate ``w``, defined by ``R' = R hat(w)`` and ``hat(w) x = w x x``, the pieces solve ``w''' = w'' x w``
    (Noakes, Heinzinger, Paden 1989). For rotations about a fixed axis the spline is the cubic spline of the angle, if
    neighbours are at most 1.4 rad apart and intervals differ by at most a factor of three.

    With neighbours farther apart, or at more uneven times, there are several such curves, and the cheapest that was
    found is returned. It may turn the long way between two rotations, also between near ones beside distant ones;
    ``arc_length(t[i], t[i + 1])`` shows it. Rotations added in between, so that neighbours are at most 1.4 rad apart
    and intervals differ by at most a factor of three, as a rule prevent that.

    In the world frame, vectors are expressed along the axes of the world: ``R w``, ``R w'`` and ``R w''``. The first
    two are the world rate and its derivative, but the derivative of the second is ``R (w'' + w x w')``.

    Results are float64, also for input in float32.

    ``spline.curve.save(path)`` writes a file; ``RotationSpline.from_curve(stiefel_rs.load(path))`` reads it. SciPy is
    imported only for `Rotation` objects.

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.spatial.transform import Rotation
    >>> from stiefel_rs import RotationSpline
    >>> t = [0.0, 1.0, 2.0, 4.0]
    >>> rotations = Rotation.from_euler("XYZ", [[-10, 20, 30], [0, 15, 40], [-30, 45, 30], [20, 45, 90]], degrees=True)
    >>> spline = RotationSpline(t, rotations)
    >>> spline(1.0).as_euler("XYZ", degrees=True).round(6) + 0.0
    array([ 0., 15., 40.])
    >>> spline([0.5, 1.5], 1).shape  # body rates, rad/s
    (2, 3)

    Quaternions in give quaternions out, without jumps of sign. Here, half a turn about z in two steps:

    >>> spline = RotationSpline([0.0, 1.0, 2.0], [[0, 0, 0, 1], [0, 0, 1, 1], [0, 0, -1, 0]], bc_type="clamped")
    >>> spline(2.0).round(12) + 0.0
    array([0., 0., 1., 0.])
    >>> spline.angular_velocity(1.0, frame="world").round(6) + 0.0
    array([0.      , 0.      , 2.356194])
    """

    def __init__(
        self,
        t: ArrayLike | None = None,
        rotations: Any = None,
        bc_type: BcType = "natural",
        *,
        times: ArrayLike | None = None,
        extrapolate: bool = True,
        project: bool = False,
        tol: float = 1e-12,
        max_iterations: int = 200,
        tension: float = 0.0,
        num_threads: int | None = None,
    ) -> None:
        t, extrapolate = either(t, times), flag("extrapolate", extrapolate)
        kind, quaternions = read_rotations(rotations, project=project)
        ends = read_bc_type(bc_type, (3,))
        options: Any = {"tol": tol, "max_iterations": max_iterations, "tension": tension, "extrapolate": extrapolate}
        options["num_threads"] = num_threads
        if quaternions.ndim == 2:
            curves = [RotationCurve(t, quaternions, ends, **options)]
        else:
            curves = interpolated_rotations(*flat_batch(t, quaternions), ends, **options)
        self._set(RotationCurves(tuple(curves), *_axes(quaternions), extrapolate), kind, ends)

    @classmethod
    def _made(
        cls, members: Sequence[RotationCurve], rotations: Array, kind: RotationKind, extrapolate: bool
    ) -> RotationSpline:
        """Make splines from curves near rotations, shape (..., N, 4)."""
        self = cls.__new__(cls)
        self._set(RotationCurves(tuple(members), *_axes(rotations), extrapolate), kind, None)
        return self

    @classmethod
    def from_curve(
        cls, curve: Curve, *, kind: RotationKind = "quaternions", extrapolate: bool | None = None
    ) -> RotationSpline:
        """Make a spline of rotations from a curve on St(3, 3).

        Parameters
        ----------
        curve : CubicSpline, SmoothingSpline or CubicHermite
            A curve of Riemannian cubics through matrices of determinant 1, with times in s.
        kind : {"quaternions", "matrices", "Rotation"}
            Kind of rotations that the spline returns.
        extrapolate : bool, optional
            As for the class; by default ``curve.extrapolate``. If it differs, the spline has a copy of the curve.

        Returns
        -------
        RotationSpline
            Spline with the end conditions of the curve, ``bc_type``, in the body frame.

        Raises
        ------
        InvalidInputError
            The curve or the kind is not supported.

        Examples
        --------
        >>> import numpy as np
        >>> from stiefel_rs import CubicSpline, RotationSpline
        >>> curve = CubicSpline([0.0, 1.0], np.stack([np.eye(3), np.diag([1.0, -1.0, -1.0])[[0, 2, 1]] * [1, -1, 1]]))
        >>> RotationSpline.from_curve(curve)(1.0).round(6) + 0.0
        array([0.707107, 0.      , 0.      , 0.707107])
        """
        if not isinstance(kind, str) or kind not in KINDS:
            raise InvalidInputError(f"kind: expected one of {KINDS}, found {kind!r}")
        beyond = extrapolate if extrapolate is None else flag("extrapolate", extrapolate)
        member = RotationCurve.of_curve(curve)
        if not isinstance(curve.manifold, Stiefel):
            raise InvalidInputError(f"curve: expected a curve on St(3, 3), found one on {curve.manifold!r}")
        if beyond not in {None, curve.extrapolate}:
            member = RotationCurve.of_curve(_continued(curve, beyond))
        self = cls.__new__(cls)
        ends = in_body_frame(getattr(curve, "bc_type", None), curve.points[[0, -1]])
        self._set(RotationCurves((member,), (), len(member.t), member.curve.extrapolate), kind, ends)
        return self

    @classmethod
    def smoothing(
        cls,
        t: ArrayLike,
        rotations: Any,
        *,
        lam: float | None = None,
        weights: ArrayLike | None = None,
        w: ArrayLike | None = None,
        extrapolate: bool = True,
        project: bool = False,
        tol: float = 1e-11,
        max_iterations: int = 200,
        num_threads: int | None = None,
    ) -> RotationSpline:
        """Fit a smoothing spline near rotations.

        Makes ``sum_i weights[i] angle_i^2 + lam J`` stationary, where ``angle_i`` is the angle from rotation i to the
        curve, in rad, and ``J`` the integral of the squared angular acceleration, in rad^2/s^3.

        Parameters
        ----------
        t : array_like, shape (N,) or (..., N)
            Nondecreasing times, in s.
        rotations : Rotation, or array_like, shape (..., N, 4) or (..., N, 3, 3)
            As for the class.
        lam : float, optional
            Weight of the acceleration, at least 0, in s^3; 0 interpolates, ``numpy.inf`` gives the straightest curve, a
            rotation at constant rate that makes the sum of squared angles stationary. By default chosen by generalised
            cross-validation, which needs at least three rotations.
        weights : array_like, shape (N,), optional
            Positive weights, by default 1. They may be dimensionless, or 1 / variance in rad^-2: then ``lam`` is in
            s^3/rad^2, and the curve is the same.
        w : array_like, optional
            Alias of `weights`, as in SciPy.
        extrapolate, project : bool
            As for the class.
        tol : float, default 1e-11
            As for `SmoothingSpline`.
        max_iterations : int, default 200
            Largest number of iterations.
        num_threads : int, optional
            Number of threads; by default the size of the global pool.

        Returns
        -------
        RotationSpline
            Spline with the attributes ``lam``, ``misfit`` and ``degrees_of_freedom``. Its knots are the distinct times;
            ``rotations`` are those of the curve. If members of a batch have different numbers of knots, the properties
            ``t`` and ``rotations`` raise `InvalidInputError`.

        Raises
        ------
        InvalidInputError, OutsideDomainError, ConvergenceError, TypeError
            As for the class; weights that are not positive.

        Examples
        --------
        >>> import numpy as np
        >>> from stiefel_rs import RotationSpline
        >>> t, rng = np.linspace(0, 1, 30), np.random.default_rng(0)
        >>> half = t**2 / 2 + 0.005 * rng.standard_normal(30)
        >>> quaternions = np.stack([0 * t, 0 * t, np.sin(half), np.cos(half)], axis=-1)
        >>> spline = RotationSpline.smoothing(t, quaternions)
        >>> bool(abs(spline.angular_velocity(0.5)[2] - 1.0) < 0.1), spline.lam > 0  # rad/s, s^3
        (True, True)
        """
        extrapolate = flag("extrapolate", extrapolate)
        options: Any = {
            "extrapolate": extrapolate,
            "tol": tol,
            "max_iterations": max_iterations,
            "num_threads": num_threads,
        }
        check_lam(lam)
        weights = either_weights(weights, w)
        kind, quaternions = read_rotations(rotations, project=project)
        options["named"] = quaternions.ndim > 2
        curves = smoothed_rotations(*flat_batch(t, quaternions), weights, lam, **options)
        return cls._made(curves, quaternions, kind, extrapolate)

    @classmethod
    def hermite(
        cls,
        t: ArrayLike,
        rotations: Any,
        rates: ArrayLike,
        *,
        frame: Frame = "body",
        extrapolate: bool = True,
        project: bool = False,
        num_threads: int | None = None,
    ) -> RotationSpline:
        """Interpolate rotations with given angular rates.

        The rate is continuous; the acceleration jumps at the knots. Between rotations half a turn apart the rates
        decide the direction of rotation; if they do not, add a rotation in between.

        Parameters
        ----------
        t : array_like, shape (N,) or (..., N)
            Increasing times, in s.
        rotations : Rotation, or array_like, shape (..., N, 4) or (..., N, 3, 3)
            As for the class.
        rates : array_like, shape (..., N, 3)
            Angular rates at the rotations, in rad/s.
        frame : {"body", "world"}
            Frame of the rates.
        extrapolate, project : bool
            As for the class.
        num_threads : int, optional
            Number of threads; by default the size of the global pool.

        Returns
        -------
        RotationSpline

        Raises
        ------
        OutsideDomainError
            Two consecutive rotations are half a turn apart, to 2.7e-15 rad, and the sum of their rates has no component
            along the axis: the turn at the mean of both rates along it is at most 2.7e-15 rad times one plus the turn
            at the mean of their norms, in rad. Carries ``knot``, the index of the first, and ``angle`` in rad.
        InvalidInputError, ConvergenceError, TypeError
            As for the class.

        Examples
        --------
        >>> from stiefel_rs import RotationSpline
        >>> spline = RotationSpline.hermite([0.0, 1.0], [[0, 0, 0, 1], [0, 0, 1, 1]], [[0, 0, 1], [0, 0, 1]])
        >>> spline([0.0, 1.0], 1).round(12) + 0.0  # rad/s
        array([[0., 0., 1.],
               [0., 0., 1.]])
        """
        extrapolate = flag("extrapolate", extrapolate)
        kind, quaternions = read_rotations(rotations, project=project)
        w = _body_rates(rates, unit(quaternions), frame)
        options: Any = {"extrapolate": extrapolate, "num_threads": num_threads, "named": quaternions.ndim > 2}
        times, members = flat_batch(t, quaternions)
        curves = rotations_with_rates(times, members, w.reshape(*members.shape[:-1], 3), **options)
        return cls._made(curves, quaternions, kind, extrapolate)


def _continued(curve: Curve, extrapolate: object) -> Curve:
    """Return the same curve that continues its end pieces, or raises beyond them."""
    reduced: Any = curve.__reduce__()
    restore, (form,) = reduced
    continued: Curve = restore({**form, "extrapolate": np.array([float(bool(extrapolate))])})
    return continued


def _axes(quaternions: Array) -> tuple[tuple[int, ...], int]:
    """Return the leading axes of a batch and the number of knots, from an array of shape (..., N, 4)."""
    *shape, knots, _ = quaternions.shape
    return tuple(shape), knots


def _body_rates(rates: ArrayLike, quaternions: Array, frame: Frame) -> Array:
    """Read rates at unit quaternions, shape (..., N, 4), and express them in the body frame."""
    w = vectors_at_knots(rates, "rates", (*quaternions.shape[:-1], 3))
    return rotated(inverse(quaternions), w) if check_frame(frame) == "world" else w
