"""Smooth curves through poses: rotations with positions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import positions as position_splines
from .end_conditions import BcType, part, read_bc_type
from .errors import InvalidInputError
from .pose_input import Poses, read_poses
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
        Times, increasing, two or more, in s.
    poses : RigidTransform, or array_like, shape (N, 4, 4), or tuple of (rotations, positions)
        SciPy's rigid transforms (SciPy 1.16 or newer), N of them; matrices ``[[R, p], [0, 1]]``; or rotations of any
        kind that `RotationSpline` takes, and positions of shape (N, 3). The same kind comes out. Positions are in any
        unit of length; it is called m here.
    bc_type : str or pair, default "natural"
        Conditions at the ends: ``"natural"``, no acceleration; ``"clamped"``, no velocity; ``"periodic"``, the last
        pose is the first one, and velocities and accelerations agree there. Or a pair of conditions for the first and
        the last pose: each ``"natural"``, ``"clamped"``, ``(1, (w, v))`` with angular rate and linear velocity, or
        ``(2, (a, b))`` with angular and linear acceleration. Angular vectors, of shape (3,), are in the BODY frame, in
        rad/s and rad/s^2. Linear ones, of shape (3,), are in the WORLD frame, derivatives of the position, in m/s and
        m/s^2.
    extrapolate : bool, default True
        Whether the first and the last piece go on outside of ``[t[0], t[-1]]``. If False, times there raise; a time
        within 4 units in the last place of the larger end counts as that end.
    project : bool, default False
        Whether rotation matrices that are not orthonormal are replaced by the nearest rotations.
    tol, max_iterations, num_threads
        As for `RotationSpline`.

    Raises
    ------
    InvalidInputError
        Shapes or numbers that do not match, not finite, times that do not increase, a matrix that is no pose (with what
        is wrong). Names the knot, and carries it as ``knot``.
    OutsideDomainError
        Neighbours half a turn apart; carries ``knot``, the first of the two, and ``angle`` in rad.
    ConvergenceError
        No spline of the rotations was found; carries ``report``.
    TypeError
        Complex numbers, dates, objects.
    ImportError
        SciPy is not installed.

    See Also
    --------
    RotationSpline : rotations alone, and batches of them.

    Notes
    -----
    In the metric that adds both parts, cubics of poses are cubics of rotations and of positions. A curve through poses
    does not depend on the choice of the world frame. It does depend on the point of the body that the positions are of.

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
        found = read_poses(poses)
        ends = read_bc_type(bc_type, (2, 3))
        rotations = RotationSpline(
            t,
            found.rotations,
            part(ends, 0),
            extrapolate=extrapolate,
            project=project,
            tol=tol,
            max_iterations=max_iterations,
            num_threads=num_threads,
        )
        _check_counts(rotations, found)
        positions = position_splines.interpolating(rotations.t, found.positions, part(ends, 1))
        self._set(found.kind, rotations, positions, ends, None)

    @classmethod
    def smoothing(
        cls,
        t: ArrayLike,
        poses: Any,
        *,
        lam: float | tuple[float | None, float | None] | None = None,
        weights: ArrayLike | None = None,
        extrapolate: bool = True,
        project: bool = False,
        tol: float = 1e-11,
        max_iterations: int = 200,
        num_threads: int | None = None,
    ) -> PoseSpline:
        """Fit a spline near poses rather than through them.

        Rotations are smoothed by `RotationSpline.smoothing`, positions by `scipy.interpolate.make_smoothing_spline`:
        the minimum of ``sum_i weights[i] |p(t[i]) - p_i|^2 + lam J``, with the integral ``J`` of ``|p''|^2``, in
        m^2/s^3.

        Parameters
        ----------
        t : array_like, shape (N,)
            Times, increasing, five or more, in s.
        poses : RigidTransform, or array_like, shape (N, 4, 4), or tuple of (rotations, positions)
            As for the class.
        lam : float or pair, optional
            Weight of the acceleration, 0 or more, in s^3: one number, or one for rotations and one for positions, each
            a number or None; 0 interpolates. By default, and for None, generalised cross-validation finds one for the
            rotations and one for each coordinate of the positions.
        weights : array_like, shape (N,), optional
            Positive, without unit, for rotations and positions alike; all 1 by default.
        extrapolate, project : bool
            As for the class.
        tol, max_iterations, num_threads
            As for `RotationSpline.smoothing`.

        Returns
        -------
        PoseSpline
            With the attribute ``lam``.

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
        found = read_poses(poses)
        lam_rotations, lam_positions = _two(lam)
        rotations = RotationSpline.smoothing(
            t,
            found.rotations,
            lam=lam_rotations,
            weights=weights,
            extrapolate=extrapolate,
            project=project,
            tol=tol,
            max_iterations=max_iterations,
            num_threads=num_threads,
        )
        positions = position_splines.smoothing(t, found.positions, lam_positions, weights)
        _check_counts(rotations, found)
        self = cls.__new__(cls)
        self._set(found.kind, rotations, positions, None, (rotations.lam, lam_positions))
        return self


def _two(lam: Any) -> tuple[float | None, float | None]:
    if lam is None or np.ndim(lam) == 0:
        return lam, lam
    if len(lam) != 2:
        raise InvalidInputError(f"lam: expected a number or a pair, for rotations and positions, found {lam!r}")
    return lam[0], lam[1]


def _check_counts(rotations: RotationSpline, poses: Poses) -> None:
    if rotations.t.shape != (len(poses.positions),):
        raise InvalidInputError(
            f"positions: expected shape ({', '.join(map(str, rotations.t.shape))}, 3), found {poses.positions.shape}"
        )
