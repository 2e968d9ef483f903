"""Smooth curves through rotations, given as SciPy's `Rotation`, as quaternions or as matrices."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ._core import CubicHermite, CubicSpline, RotationCurve, SmoothingSpline
from .angular_motion import Frame, check_frame
from .array_input import Array, either, vectors_at_knots
from .end_conditions import BcType, read_bc_type
from .errors import InvalidInputError
from .rotation_curves import each_member, flat_batch
from .rotation_input import KINDS, RotationKind, matrices_of, read_rotations, unit
from .rotation_motion import RotationMotion

if TYPE_CHECKING:
    from collections.abc import Sequence

Curve: TypeAlias = CubicSpline | SmoothingSpline | CubicHermite

__all__ = ["RotationSpline"]


class RotationSpline(RotationMotion):
    """Interpolate rotations by a cubic spline on the rotation group.

    Angular rate and angular acceleration are continuous. Among all curves through the rotations with the given ends,
    the spline makes the integral of the squared angular acceleration stationary. It takes the place of
    `scipy.spatial.transform.RotationSpline`, and returns the kind of rotations that it was made from.

    Parameters
    ----------
    t : array_like, shape (N,) or (..., N)
        Times of the rotations, increasing, two or more, in s. With leading axes, each spline of a batch has its own.
    rotations : Rotation, or array_like, shape (..., N, 4) or (..., N, 3, 3)
        SciPy's rotations, N of them; quaternions, scalar last, of any length but zero; or matrices, orthonormal to 1e-9
        (float32: 1e-5), of determinant 1. Quaternions and matrices with leading axes make many splines at once.
    bc_type : str or pair, default "natural"
        Conditions at the ends: ``"natural"``, no angular acceleration; ``"clamped"``, no angular rate; ``"periodic"``,
        the last rotation is the first one, and rate and acceleration agree there. Or a pair of conditions for the first
        and the last rotation: each ``"natural"``, ``"clamped"``, ``(1, w)`` with an angular rate in rad/s or ``(2, a)``
        with an angular acceleration in rad/s^2, of shape (3,), in the body frame.
    times : array_like, optional
        Another name of `t`, which SciPy's class has.
    extrapolate : bool, default True
        Whether the first and the last piece go on outside of ``[t[0], t[-1]]``. If False, times there raise; a time
        within 4 units in the last place of the larger end counts as that end.
    project : bool, default False
        Whether matrices that are not orthonormal are replaced by the nearest rotations.
    tol : float, default 1e-12
        Largest angle, in rad, by which a piece may miss its knot, and largest jump of the acceleration, in units of the
        piece's duration.
    max_iterations : int, default 200
        Limit of the iterations.
    tension : float, default 0.0
        Weight of the squared rate against the squared acceleration, in 1/s^2, as for `CubicSpline`.
    num_threads : int, optional
        Threads; by default those of the global pool.

    Raises
    ------
    InvalidInputError
        Shapes or numbers that do not match, not finite, times that do not increase, a quaternion of length zero, a
        matrix that is no rotation (with its defect). Names the knot, and carries it as ``knot``.
    OutsideDomainError
        Neighbours half a turn apart, between which no shortest way is unique; carries ``knot``, the first of the two,
        and ``angle`` in rad.
    ConvergenceError
        No spline was found; carries ``report``.
    TypeError
        Complex numbers, dates, objects.

    See Also
    --------
    PoseSpline : rotations with positions.
    CubicSpline : the same on any Stiefel manifold.

    Notes
    -----
    With the body rate ``w``, defined by ``R' = R hat(w)`` and ``hat(w) x = w x x``, the pieces solve ``w''' = w'' x w``
    (Noakes, Heinzinger, Paden 1989). Rotations about one axis give the cubic spline of their angle.

    In the world frame, vectors are expressed along the axes of the world: ``R w``, ``R w'`` and ``R w''``. The first
    two are the world rate and its derivative. The derivative of the world acceleration is ``R (w'' + w x w')``.

    ``spline.curve.save(path)`` writes a file; ``RotationSpline.from_curve(stiefel_rs.load(path))`` reads it. Neither
    needs SciPy, which is imported only for rotations of its own.

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

    Quaternions come out as quaternions, with no jumps of sign. Here, half a turn about z in two steps:

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
        t = either(t, times)
        kind, quaternions = read_rotations(rotations, project=project)
        ends = read_bc_type(bc_type, (3,))
        options: Any = {"tol": tol, "max_iterations": max_iterations, "tension": tension, "num_threads": num_threads}
        if quaternions.ndim == 2:
            curves = [RotationCurve(t, quaternions, ends, **options)]
        else:
            curves = RotationCurve.batch(*flat_batch(t, quaternions), ends, **options)
        self._set(curves, quaternions.shape[:-2], kind, extrapolate, ends)

    @classmethod
    def _made(cls, curves: Sequence[Curve], rotations: Array, kind: RotationKind, extrapolate: bool) -> RotationSpline:
        """Make splines of curves near rotations, shape (..., N, 4), whose sign at the first knot they have."""
        starts = rotations[..., 0, :].reshape(-1, 4)
        members = [RotationCurve.of_curve(*each) for each in zip(curves, starts, strict=True)]
        self = cls.__new__(cls)
        self._set(members, rotations.shape[:-2], kind, extrapolate, None)
        return self

    @classmethod
    def from_curve(
        cls, curve: Curve, *, kind: RotationKind = "quaternions", extrapolate: bool | None = None
    ) -> RotationSpline:
        """Make a spline of rotations from a curve on St(3, 3).

        Parameters
        ----------
        curve : CubicSpline, SmoothingSpline or CubicHermite
            Of Riemannian cubics, through matrices of determinant 1.
        kind : {"quaternions", "matrices", "Rotation"}
            Kind of rotations that the spline returns.
        extrapolate : bool, optional
            As for the class; by default as the curve has it.

        Returns
        -------
        RotationSpline

        Raises
        ------
        InvalidInputError
            Another curve, or another kind.

        Examples
        --------
        >>> import numpy as np
        >>> from stiefel_rs import CubicSpline, RotationSpline
        >>> curve = CubicSpline([0.0, 1.0], np.stack([np.eye(3), np.diag([1.0, -1.0, -1.0])[[0, 2, 1]] * [1, -1, 1]]))
        >>> RotationSpline.from_curve(curve)(1.0).round(6) + 0.0
        array([0.707107, 0.      , 0.      , 0.707107])
        """
        if kind not in KINDS:
            raise InvalidInputError(f"kind: expected one of {KINDS}, found {kind!r}")
        member = RotationCurve.of_curve(curve)
        beyond = curve.extrapolate if extrapolate is None else extrapolate
        self = cls.__new__(cls)
        self._set([member], (), kind, beyond, None)
        return self

    @classmethod
    def smoothing(
        cls,
        t: ArrayLike,
        rotations: Any,
        *,
        lam: float | None = None,
        weights: ArrayLike | None = None,
        extrapolate: bool = True,
        project: bool = False,
        tol: float = 1e-11,
        max_iterations: int = 200,
        num_threads: int | None = None,
    ) -> RotationSpline:
        """Fit a spline near rotations rather than through them.

        Makes ``sum_i weights[i] angle_i^2 + lam J`` stationary: ``angle_i``, in rad, is the angle from rotation i to
        the curve, and ``J`` the integral of the squared angular acceleration, in rad^2/s^3.

        Parameters
        ----------
        t : array_like, shape (N,) or (..., N)
            Times in order, in s; they may repeat.
        rotations : Rotation, or array_like, shape (..., N, 4) or (..., N, 3, 3)
            As for the class.
        lam : float, optional
            Weight of the acceleration, 0 or more, in s^3; 0 interpolates. By default the value that generalised
            cross-validation finds, for three rotations or more.
        weights : array_like, shape (N,), optional
            Positive, without unit; all 1 by default.
        extrapolate, project : bool
            As for the class.
        tol : float, default 1e-11
            As for `SmoothingSpline`.
        max_iterations : int, default 200
            Limit of the iterations.
        num_threads : int, optional
            Threads; by default those of the global pool.

        Returns
        -------
        RotationSpline
            With the attribute ``lam``. Its knots are the distinct times, its ``rotations`` those of the curve there.

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
        options: Any = {"extrapolate": True, "tol": tol, "max_iterations": max_iterations, "num_threads": num_threads}
        kind, quaternions = read_rotations(rotations, project=project)
        members = each_member(t, quaternions)
        curves = [SmoothingSpline(times, matrices_of(unit(q)), weights, lam, **options) for times, q in members]
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

        The rate is continuous; the acceleration jumps at the rotations. Between rotations half a turn apart the rates
        decide which way the curve goes; where they do not, a rotation in between does.

        Parameters
        ----------
        t : array_like, shape (N,) or (..., N)
            Times, increasing, in s.
        rotations : Rotation, or array_like, shape (..., N, 4) or (..., N, 3, 3)
            As for the class.
        rates : array_like, shape (..., N, 3)
            Angular rates at the rotations, in rad/s.
        frame : {"body", "world"}
            Frame of the rates.
        extrapolate, project : bool
            As for the class.
        num_threads : int, optional
            Threads; by default those of the global pool.

        Returns
        -------
        RotationSpline

        Raises
        ------
        InvalidInputError, OutsideDomainError, ConvergenceError, TypeError
            As for the class.

        Examples
        --------
        >>> from stiefel_rs import RotationSpline
        >>> spline = RotationSpline.hermite([0.0, 1.0], [[0, 0, 0, 1], [0, 0, 1, 1]], [[0, 0, 1], [0, 0, 1]])
        >>> spline([0.0, 1.0], 1).round(12) + 0.0  # rad/s
        array([[0., 0., 1.],
               [0., 0., 1.]])
        """
        kind, quaternions = read_rotations(rotations, project=project)
        points = matrices_of(unit(quaternions))
        velocities = points @ _hat(_body_rates(rates, points, frame))
        count = points.shape[-3]
        S, V = (matrices.reshape(-1, count, 3, 3) for matrices in (points, velocities))
        times = [member for member, _ in each_member(t, quaternions)]
        options: Any = {"extrapolate": True, "num_threads": num_threads}
        curves = [CubicHermite(*each, **options) for each in zip(times, S, V, strict=True)]
        return cls._made(curves, quaternions, kind, extrapolate)


def _body_rates(rates: ArrayLike, rotations: Array, frame: Frame) -> Array:
    """Read rates at rotations, shape (..., N, 3, 3), and express them in the body frame."""
    w = vectors_at_knots(rates, "rates", rotations.shape[:-1])
    return np.einsum("...ji,...j->...i", rotations, w) if check_frame(frame) == "world" else w


def _hat(w: Array) -> Array:
    """Return the skew matrices with ``hat(w) x = w x x``."""
    out = np.zeros((*w.shape, 3))
    out[..., 2, 1], out[..., 0, 2], out[..., 1, 0] = w[..., 0], w[..., 1], w[..., 2]
    return out - np.swapaxes(out, -1, -2)
