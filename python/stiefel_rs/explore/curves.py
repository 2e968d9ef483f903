"""The two curves of the page, their costs, lengths and distance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .._core import Curve, GeometricCubic, RiemannianCubic, Stiefel, skew_exp
from ..errors import InvalidInputError, StiefelError

Array = NDArray[np.float64]
CURVES: Final[dict[str, Callable[..., Curve]]] = {"gcp": GeometricCubic, "cubic": RiemannianCubic.from_boundary}
MAX_VELOCITY: Final = 20.0
# Samples of a curve: as many as keep its chords below 0.05, even if it is quickest between those that are counted from.
CHORD: Final = 0.045
MIN_SAMPLES: Final = 101
MAX_SAMPLES: Final = 2001
# Axes of the start's frame as columns, and the direction about which the end is turned from it.
START: Final = skew_exp(np.array([[0.0, 0.5, -0.35], [-0.5, 0.0, -0.3], [0.35, 0.3, 0.0]]))
AXIS: Final = np.array([0.3, -0.35, 0.9]) / np.linalg.norm([0.3, -0.35, 0.9])


@dataclass(frozen=True)
class Kind:
    """A manifold of the page: parameters of a velocity, their slider's range, angle between the ends."""

    name: str
    title: str
    k: int
    parameters: tuple[str, ...]
    limit: float
    angle: float
    velocities: tuple[tuple[float, ...], tuple[float, ...]]


KINDS: Final = {
    kind.name: kind
    for kind in (
        Kind("sphere", "sphere St(3,1)", 1, ("along", "across"), 7.0, 1.6, ((-1.0, 3.0), (-1.0, -3.0))),
        Kind(
            "frame",
            "frames St(3,2)",
            2,
            ("about axis 1", "about axis 2", "about axis 3"),
            6.0,
            1.2,
            ((0.0, 1.5, 1.5), (-1.5, 1.5, -1.5)),
        ),
    )
}


@dataclass(frozen=True)
class End:
    """Point of shape ``(3, k)`` and basis of its tangent space, shape ``(parameters, 3, k)``."""

    point: Array
    basis: Array


def _cross(w: Array) -> Array:
    """Matrix of the cross product with `w`."""
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def ends(kind: Kind, angle: float) -> tuple[End, End]:
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


@dataclass(frozen=True)
class Sampled:
    """One curve at the times of the page.

    Attributes
    ----------
    points : ndarray, shape (T, 3, k)
    speed, acceleration : ndarray, shape (T,)
        Lengths in the canonical metric, the acceleration covariant.
    cost : float
    """

    points: Array
    speed: Array
    acceleration: Array
    cost: float


def _norm(curve: Curve, S: Array, V: Array) -> Array:
    return np.asarray(Stiefel(curve.n, curve.k).norm(S, V))


def _sample(curve: Curve, t: Array) -> Sampled:
    S = curve(t)
    return Sampled(S, _norm(curve, S, curve.velocity(t)), _norm(curve, S, curve.acceleration(t)), curve.cost())


def find(kind: Kind, angle: float, v0: Any, v1: Any) -> dict[str, Curve | StiefelError]:
    """Both curves with the given velocities at the ends; where there is none, the error that says why.

    Raises
    ------
    InvalidInputError
        The angle or the velocities are not such.
    """
    start, end = ends(kind, angle)
    data = (start.point, _velocity(start, v0, "v0"), end.point, _velocity(end, v1, "v1"))
    found: dict[str, Curve | StiefelError] = {}
    for name, make in CURVES.items():
        try:
            found[name] = make(*data)
        except StiefelError as error:
            found[name] = error
    return found


def times(found: dict[str, Curve | StiefelError]) -> Array:
    """Equidistant times for drawing the curves, as close as the quickest of them needs.

    The canonical length of a velocity is at least the speed of each column on the sphere.
    """
    t = np.linspace(0, 1, MIN_SAMPLES)
    curves = [curve for curve in found.values() if not isinstance(curve, StiefelError)]
    speed = max((_norm(curve, curve(t), curve.velocity(t)).max() for curve in curves), default=0.0)
    return np.linspace(0, 1, int(np.clip(np.ceil(speed / CHORD) + 1, MIN_SAMPLES, MAX_SAMPLES)))


def sample(found: dict[str, Curve | StiefelError], t: Array) -> dict[str, Sampled | StiefelError]:
    """Both curves at the given times."""
    return {name: curve if isinstance(curve, StiefelError) else _sample(curve, t) for name, curve in found.items()}


def compute(kind: Kind, angle: float, v0: Any, v1: Any, t: Array) -> dict[str, Sampled | StiefelError]:
    """`sample` of what `find` gives."""
    return sample(find(kind, angle, v0, v1), t)


def distance(found: dict[str, Sampled | StiefelError]) -> Array | None:
    """Frobenius distance of both curves, shape ``(T,)``; None where one of them is missing."""
    gcp, cubic = found["gcp"], found["cubic"]
    if not isinstance(gcp, Sampled) or not isinstance(cubic, Sampled):
        return None
    return np.asarray(np.linalg.norm(gcp.points - cubic.points, axis=(1, 2)))


def described(end: End) -> dict[str, Any]:
    """Return an end as the page wants it."""
    return {"point": end.point.tolist(), "basis": end.basis.tolist()}


def message(error: StiefelError) -> str:
    """Text of an error with the name of its type."""
    return f"{type(error).__name__}: {error}"
