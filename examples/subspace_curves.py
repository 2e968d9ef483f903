"""Curves through subspaces, for reduced_model.py: splines of the library, and what they are compared with.

Interpolation in a tangent space: Amsallem, Farhat (2008), "Interpolation method for adapting reduced-order models and
application to aeroelasticity", AIAA Journal 46, 1803-1813, <https://doi.org/10.2514/1.35374>.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from scipy import interpolate

from plume import MODES, PERIOD, Array, N
from stiefel_rs import ConvergenceError, CubicSpline, Grassmann

M = Grassmann(N, MODES)
NEAREST, GEODESICS, SPLINE, ENDS = "nearest", "geodesics", "spline", "spline, end velocities"
LINEAR, POLYNOMIAL = "tangent space at the middle, linear", "tangent space at the middle, polynomial"
TANGENT, MEAN, LOCAL = "tangent space at the middle", "tangent space at the mean", "tangent space at the nearest"
FRAMES, ALIGNED = "frames as they are", "aligned frames"
MEAN_STEPS, MEAN_TOLERANCE = 200, 1e-9
Way = Callable[[float], Array]


def is_closed(winds: Array) -> bool:
    """Whether the last wind direction is the first one, a full circle later."""
    return bool(winds[-1] - winds[0] == PERIOD)


def end_velocity(winds: Array, points: Array) -> Array:
    """Velocity at the first point of the cubic polynomial through four points, in the tangent space of the first."""
    polynomial = interpolate.BarycentricInterpolator(winds[:4], M.log(points[0], points[:4]))
    return np.asarray(polynomial.derivative(winds[0]))


def geodesics(winds: Array, points: Array) -> Way:
    """The geodesic from each point to the next."""
    velocities = [M.log(*pair) / step for pair, step in zip(pairwise(points), np.diff(winds), strict=True)]

    def at(wind: float) -> Array:
        i = int(np.clip(np.searchsorted(winds, wind) - 1, 0, len(velocities) - 1))
        return np.asarray(M.exp(points[i], (wind - winds[i]) * velocities[i]))

    return at


def local_cubics(winds: Array, points: Array) -> Way:
    """The cubic polynomial through the four nearest points, in the tangent space of the nearest: not continuous."""
    last = len(winds) - 1

    def at(wind: float) -> Array:
        first = int(np.searchsorted(winds, wind)) - 2
        places = np.arange(4) + (first if is_closed(winds) else np.clip(first, 0, last - 3))
        near, turns = points[places % last if is_closed(winds) else places], places // last * is_closed(winds)
        x = winds[places - last * turns] + PERIOD * turns
        base = near[np.abs(x - wind).argmin()]
        return np.asarray(M.exp(base, interpolate.BarycentricInterpolator(x, M.log(base, near))(wind)))

    return at


def mean(winds: Array, points: Array) -> Array:
    """Karcher mean, by fixed point iteration."""
    found, each = points[len(points) // 2], points[1:] if is_closed(winds) else points
    for _ in range(MEAN_STEPS):
        step = M.log(found, each).mean(axis=0)
        if np.linalg.norm(step) < MEAN_TOLERANCE:
            break
        found = M.exp(found, step)
    return np.asarray(found)


def in_tangent_space(base: Array, points: Array, curve: Callable[[Array], Any]) -> Way:
    """A curve through the logarithms of the points, entry by entry, taken back."""
    logarithms = curve(M.log(base, points))
    return lambda wind: np.asarray(M.exp(base, logarithms(wind)))


def ways(winds: Array, points: Array) -> dict[str, Way]:
    """Ways to have modes in between."""
    middle, closed = points[len(points) // 2], is_closed(winds)
    spline = partial(interpolate.CubicSpline, winds, bc_type="periodic" if closed else "not-a-knot")
    found = {
        NEAREST: lambda wind: points[np.abs(winds - wind).argmin()],
        LINEAR: in_tangent_space(middle, points, partial(interpolate.make_interp_spline, winds, k=1)),
        GEODESICS: geodesics(winds, points),
        POLYNOMIAL: in_tangent_space(middle, points, partial(interpolate.BarycentricInterpolator, winds)),
        TANGENT: in_tangent_space(middle, points, spline),
        MEAN: in_tangent_space(mean(winds, points), points, spline),
        LOCAL: local_cubics(winds, points),
        SPLINE: CubicSpline(winds, points, "periodic" if closed else "natural", manifold=M),
    }
    if not closed:
        velocities = end_velocity(winds, points), end_velocity(winds[::-1], points[::-1])
        found[ENDS] = CubicSpline(winds, points, ((1, velocities[0]), (1, velocities[1])), manifold=M)
    return found


def of_frames(winds: Array, points: Array) -> tuple[dict[str, Way], dict[str, str]]:
    """Splines on St(n, k) through the modes as they are, and turned to be near to their neighbours; what was raised."""
    near = [points[0]]
    for each in points[1:]:
        near.append(M.align(near[-1], each))
    found: dict[str, Way] = {}
    raised: dict[str, str] = {}
    for name, frames in ((FRAMES, points), (ALIGNED, np.stack(near))):
        try:
            found[name] = CubicSpline(winds, frames)
        except ConvergenceError as error:
            raised[name] = str(error)
    return found, raised
