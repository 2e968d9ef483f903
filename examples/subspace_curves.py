"""Curves through subspaces, for reduced_model.py: of the library, and others that it is compared with."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from scipy import interpolate

from plume import MODES, Array, N
from stiefel_rs import CubicSpline, Grassmann, StiefelError

M = Grassmann(N, MODES)
NEAREST, GEODESICS, NATURAL, ENDS = "nearest", "geodesics", "spline, natural", "spline, end velocities"
TANGENT, TANGENT_NATURAL = "tangent space, not-a-knot", "tangent space, natural"
POLYNOMIAL, LINEAR = "tangent space, polynomial", "tangent space, linear"
FRAMES, ALIGNED = "raw frames", "aligned frames"
Way = Callable[[float], Array]


def end_velocity(winds: Array, points: Array) -> Array:
    """Velocity at the first point of the cubic polynomial through the first four, in the tangent space there."""
    return np.asarray(interpolate.CubicSpline(winds[:4], M.log(points[0], points[:4]))(winds[0], 1))


def geodesics(winds: Array, points: Array) -> Way:
    """The geodesic from each point to the next."""
    velocities = [M.log(*pair) / step for pair, step in zip(pairwise(points), np.diff(winds), strict=True)]

    def at(wind: float) -> Array:
        i = int(np.clip(np.searchsorted(winds, wind) - 1, 0, len(velocities) - 1))
        return np.asarray(M.exp(points[i], (wind - winds[i]) * velocities[i]))

    return at


def ways(winds: Array, points: Array) -> dict[str, Way]:
    """Ways to have modes in between. Tangent spaces are those of the point in the middle (Amsallem, Farhat 2008)."""
    middle = points[len(points) // 2]
    logarithms = M.log(middle, points)
    ends = end_velocity(winds, points), end_velocity(winds[::-1], points[::-1])
    conditions = tuple((1, velocity) for velocity in ends)

    def mapped(curve: Callable[[float], Any]) -> Way:
        return lambda wind: np.asarray(M.exp(middle, curve(wind)))

    return {
        NEAREST: lambda wind: points[np.abs(winds - wind).argmin()],
        LINEAR: mapped(interpolate.make_interp_spline(winds, logarithms, 1)),
        GEODESICS: geodesics(winds, points),
        POLYNOMIAL: mapped(interpolate.BarycentricInterpolator(winds, logarithms)),
        TANGENT_NATURAL: mapped(interpolate.CubicSpline(winds, logarithms, bc_type="natural")),
        TANGENT: mapped(interpolate.CubicSpline(winds, logarithms)),
        NATURAL: CubicSpline(winds, points, manifold=M),
        ENDS: CubicSpline(winds, points, conditions, manifold=M),
    }


def of_frames(winds: Array, points: Array) -> dict[str, Way | str]:
    """Splines on St(1600, 6): of the modes with the signs that they have, and turned to be near to their neighbours."""
    near = [points[0]]
    for each in points[1:]:
        near.append(M.align(near[-1], each))
    found: dict[str, Way | str] = {}
    for name, frames in ((FRAMES, points), (ALIGNED, np.stack(near))):
        try:
            found[name] = CubicSpline(winds, frames)
        except StiefelError as error:
            found[name] = str(error)
    return found
