"""Two ends with velocities: the exact Riemannian cubic and the geometric cubic between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from .._core import Curve, GeometricCubic, RiemannianCubic, skew_exp
from ..errors import InvalidInputError, StiefelError
from .sampling import Array, Found, Smooth

CURVES: Final[dict[str, Callable[..., Curve]]] = {"cubic": RiemannianCubic.from_boundary, "gcp": GeometricCubic}
MAX_VELOCITY: Final = 20.0
SPAN: Final = np.array([0.0, 1.0])
# Axes of the start's frame as columns, and the direction about which the end is turned from it.
START: Final = skew_exp(np.array([[0.0, 0.5, -0.35], [-0.5, 0.0, -0.3], [0.35, 0.3, 0.0]]))
AXIS: Final = np.array([0.3, -0.35, 0.9]) / np.linalg.norm([0.3, -0.35, 0.9])


@dataclass(frozen=True)
class Ends:
    """A scene: parameters of a velocity, the range of their sliders in rad/s, the angle between the ends in rad."""

    title: str
    k: int
    parameters: tuple[str, ...]
    limit: float
    angle: float
    velocities: tuple[tuple[float, ...], tuple[float, ...]]

    def described(self) -> dict[str, Any]:
        """Return the scene as the page wants it."""
        return {
            "family": "ends",
            "title": self.title,
            "columns": self.k,
            "parameters": self.parameters,
            "limit": self.limit,
            "angle": self.angle,
            "velocities": self.velocities,
            "curves": {"cubic": "exact cubic", "gcp": "geometric cubic"},
        }


KINDS: Final = {
    "sphere": Ends("Point to point", 1, ("along", "across"), 7.0, 1.6, ((-1.0, 3.0), (-1.0, -3.0))),
    "frame": Ends(
        "Frame to frame", 2, ("about x", "about y", "about z"), 6.0, 1.2, ((0.0, 1.5, 1.5), (-1.5, 1.5, -1.5))
    ),
}


@dataclass(frozen=True)
class End:
    """Point of shape ``(3, k)`` and basis of its tangent space, shape ``(parameters, 3, k)``."""

    point: Array
    basis: Array

    def described(self) -> dict[str, Any]:
        """Return the end as the page wants it."""
        return {"point": self.point.tolist(), "basis": self.basis.tolist()}


def _cross(w: Array) -> Array:
    """Matrix of the cross product with `w`."""
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def ends(kind: Ends, angle: float) -> tuple[End, End]:
    """Start and end, `angle` apart.

    On the sphere a velocity has a part along the great circle through both ends, and a part across it. For frames it
    is an angular velocity about the axes of the frame, the third of which is the cross product of its columns.
    """
    if not (np.isfinite(angle) and 0 < angle <= np.pi):
        raise InvalidInputError(f"angle: from 0 (excluded) to pi expected, found {angle}")
    found = []
    for sign in (-1, 1):
        c, s = np.cos(angle / 2), sign * np.sin(angle / 2)
        if kind.k == 1:
            along, across = np.array([[-s], [c], [0.0]]), np.array([[0.0], [0.0], [1.0]])
            found.append(End(np.array([[c], [s], [0.0]]), np.stack([along, across])))
        else:
            axes = skew_exp(_cross(sign * angle / 2 * AXIS)) @ START
            found.append(End(axes[:, :2], np.stack([_cross(axis) @ axes[:, :2] for axis in axes.T])))
    return found[0], found[1]


def _velocity(end: End, parameters: Any, name: str) -> Array:
    try:
        found = np.asarray(parameters, dtype=np.float64)
    except (TypeError, ValueError) as wrong:
        raise InvalidInputError(f"{name}: numbers expected ({wrong})") from None
    if found.shape != (len(end.basis),):
        raise InvalidInputError(f"{name}: {len(end.basis)} numbers expected, found shape {found.shape}")
    if not np.isfinite(found).all():
        raise InvalidInputError(f"{name}: not finite")
    if np.abs(found).max() > MAX_VELOCITY:
        raise InvalidInputError(f"{name}: at most {MAX_VELOCITY:g} expected, found {np.abs(found).max():g}")
    return np.asarray(np.tensordot(found, end.basis, 1))


def find(kind: Ends, angle: float, v0: Any, v1: Any) -> Found:
    """Both curves with the given velocities at the ends; where there is none, the error that says why.

    Raises
    ------
    InvalidInputError
        The angle or the velocities are not such.
    """
    start, end = ends(kind, angle)
    data = (start.point, _velocity(start, v0, "v0"), end.point, _velocity(end, v1, "v1"))
    found: Found = {}
    for name, make in CURVES.items():
        try:
            found[name] = Smooth(make(*data))
        except StiefelError as error:
            found[name] = error
    return found
