"""Smooth curves through poses: rotations with positions."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from . import positions as position_splines
from .array_input import either_weights, flag, shape_of
from .end_conditions import BcType, part, read_bc_type
from .errors import InvalidInputError
from .pose_input import read_poses
from .pose_motion import PoseMotion
from .rotation import RotationSpline

__all__ = ["PoseSpline"]


class PoseSpline(PoseMotion):
    """Interpolate poses: rotations by `RotationSpline`, positions by SciPy's cubic spline.

    A pose takes a point ``x`` of the body to ``R x + p`` in the world. Velocities and accelerations, linear and
    angular, are continuous. Needs SciPy.

    Parameters
    ----------
    t : array_like, shape (N,)
        At least two increasing times, in s; another unit of time takes the place of s in all units of the spline.
    poses : RigidTransform, or array_like, shape (N, 4, 4), or tuple of (rotations, positions)
        N poses: a SciPy `RigidTransform` (SciPy 1.16 or newer); matrices ``[[R, p], [0, 1]]``; or rotations of any kind
        that `RotationSpline` accepts, with positions of shape (N, 3). The spline returns the same kind. The unit of
        length is arbitrary; it is called m here. Poses with leading axes, a batch, raise `InvalidInputError`: make one
        spline for each path.
    bc_type : str or pair, default "natural"
        End conditions: ``"natural"``, zero acceleration; ``"clamped"``, zero velocity; ``"periodic"``, the last pose
        equals the first, and velocities and accelerations agree there. Or a pair of conditions for the first and
        the last pose: each ``"natural"``, ``"clamped"``, ``(1, (w, v))`` with angular rate and linear velocity, or
        ``(2, (a, b))`` with angular and linear acceleration. Angular vectors, of shape (3,), are in the BODY frame, in
        rad/s and rad/s^2. Linear ones, of shape (3,), are in the WORLD frame, derivatives of the position, in m/s and
        m/s^2.
    extrapolate : bool, default True
        If True, the first and the last piece are continued outside ``[t[0], t[-1]]``. If False, such times raise,
        except within 4 ulp of an end (of the larger end in absolute value), which count as that end. The pieces are
        continued by integration in at most 100000 steps: times too far outside raise `ConvergenceError`.
    project : bool, default False
        If True, rotation matrices that are not orthonormal are replaced by the nearest rotations.
    tol, max_iterations, num_threads
        As for `RotationSpline`.

    Raises
    ------
    InvalidInputError
        Mismatched shapes or numbers, non-finite entries, times that do not increase, a matrix that is not a pose.
        Names the knot; carries ``knot``.
    OutsideDomainError
        Two consecutive rotations are half a turn apart, as for `RotationSpline`; carries ``knot``, the index of the
        first, and ``angle`` in rad.
    ConvergenceError
        No spline of the rotations was found; carries ``report``, and ``knot`` as for `RotationSpline`.
    TypeError
        Complex numbers, dates, objects.
    ImportError
        SciPy is not installed.

    See Also
    --------
    RotationSpline : splines of rotations without positions, also in batches.

    Notes
    -----
    In the product metric, cubics of poses consist of a cubic of rotations and a cubic of positions. The curve does not
    depend on the choice of the world frame, but on the reference point of the body whose positions are given. A
    smoothing spline by cross-validation also depends on the directions of the axes: each coordinate has its own weight.

    Results are float64, also for input in float32.

    Examples
    --------
    >>> import numpy as np
    >>> from stiefel_rs import PoseSpline
    >>> t, angle = np.arange(5.0), 0.5 * np.arange(5.0)
    >>> rotations = np.stack([0 * t, 0 * t, np.sin(angle / 2), np.cos(angle / 2)], axis=-1)
    >>> positions = np.stack([np.cos(angle), np.sin(angle), 0 * t], axis=-1)
    >>> spline = PoseSpline(t, (rotations, positions))
    >>> rotation, position = spline(2.0)
    >>> position.round(6)
    array([0.540302, 0.841471, 0.      ])
    >>> spline.twist(2.0).round(2) + 0.0  # rad/s and m/s
    array([0.  , 0.  , 0.5 , 0.  , 0.51, 0.  ])
    """

    def __init__(
        self,
        t: ArrayLike,
        poses: Any,
        bc_type: BcType = "natural",
        *,
        extrapolate: bool = True,
        project: bool = False,
        tol: float = 1e-12,
        max_iterations: int = 200,
        num_threads: int | None = None,
    ) -> None:
        extrapolate = flag("extrapolate", extrapolate)
        kind, turns, points = read_poses(poses, project=project)
        ends = read_bc_type(bc_type, (2, 3))
        if ends == "periodic":
            points = position_splines.closed(points)
        rotations = RotationSpline(
            t,
            turns,
            part(ends, 0),
            extrapolate=extrapolate,
            tol=tol,
            max_iterations=max_iterations,
            num_threads=num_threads,
        )
        positions = position_splines.interpolating(rotations.t, points, part(ends, 1))
        self._set(kind, rotations, positions, ends, None)

    @classmethod
    def smoothing(
        cls,
        t: ArrayLike,
        poses: Any,
        *,
        lam: float | tuple[float | None, float | None] | None = None,
        weights: ArrayLike | None = None,
        w: ArrayLike | None = None,
        extrapolate: bool = True,
        project: bool = False,
        tol: float = 1e-11,
        max_iterations: int = 200,
        num_threads: int | None = None,
    ) -> PoseSpline:
        """Fit a smoothing spline near poses.

        Rotations are smoothed by `RotationSpline.smoothing`, positions by `scipy.interpolate.make_smoothing_spline`,
        which minimises ``sum_i weights[i] |p(t[i]) - p_i|^2 + lam J``, where ``J`` is the integral of ``|p''|^2``, in
        m^2/s^3.

        Parameters
        ----------
        t : array_like, shape (N,)
            At least five increasing times, in s.
        poses : RigidTransform, or array_like, shape (N, 4, 4), or tuple of (rotations, positions)
            As for the class.
        lam : float or pair, optional
            Weight of the acceleration, at least 0, in s^3: one number, or a pair for rotations and positions, each a
            number or None; 0 interpolates. The weight of the rotations may be ``numpy.inf``, which makes their angular
            rate constant; the weight of the positions must be finite, and a large one makes their curve straight. By
            default, and for None, generalised cross-validation chooses one weight for the rotations and one for each
            coordinate of the positions.
        weights : array_like, shape (N,), optional
            Positive weights, dimensionless, for both rotations and positions; by default 1.
        w : array_like, optional
            Alias of `weights`, as in SciPy.
        extrapolate, project : bool
            As for the class.
        tol, max_iterations, num_threads
            As for `RotationSpline.smoothing`.

        Returns
        -------
        PoseSpline
            Spline with the attribute ``lam``.

        Raises
        ------
        InvalidInputError, OutsideDomainError, ConvergenceError, TypeError, ImportError
            As for the class; weights that are not positive, fewer than five poses.

        Examples
        --------
        >>> import numpy as np
        >>> from stiefel_rs import PoseSpline
        >>> t, rng = np.linspace(0, 1, 30), np.random.default_rng(0)
        >>> rotations = [0, 0, 0, 1] + 0.01 * rng.standard_normal((30, 4))
        >>> positions = np.stack([t, t**2, 0 * t], axis=-1) + 0.01 * rng.standard_normal((30, 3))
        >>> spline = PoseSpline.smoothing(t, (rotations, positions), lam=1e-3)
        >>> bool(np.abs(spline.position(0.5) - [0.5, 0.25, 0]).max() < 0.01)  # m
        True
        """
        weights = either_weights(weights, w)
        extrapolate = flag("extrapolate", extrapolate)
        kind, turns, points = read_poses(poses, project=project)
        lam_rotations, lam_positions = _two(lam)
        position_splines.check_smoothing(t, len(points), lam_positions)
        rotations = RotationSpline.smoothing(
            t,
            turns,
            lam=lam_rotations,
            weights=weights,
            extrapolate=extrapolate,
            tol=tol,
            max_iterations=max_iterations,
            num_threads=num_threads,
        )
        positions = position_splines.smoothing(t, points, lam_positions, weights)
        self = cls.__new__(cls)
        self._set(kind, rotations, positions, None, (rotations.lam, lam_positions))
        return self


def _two(lam: Any) -> tuple[float | None, float | None]:
    if lam is None or shape_of(lam) == ():
        return lam, lam
    if len(lam) != 2 or any(shape_of(each) != () for each in lam):
        raise InvalidInputError(f"lam: expected a number or a pair, for rotations and positions, found {lam!r}")
    return lam[0], lam[1]
