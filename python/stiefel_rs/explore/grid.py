"""Curves computed before, on a grid of velocities, for a page without a server.

Entries of points are 16-bit integers, in units of 1/32767; lengths and distances too, in units of 1/32767 of the
largest of their profile. Costs are numbers of 64 bits.
"""

from __future__ import annotations

import base64
import itertools
from collections.abc import Callable, Iterator
from typing import Any, Final

import numpy as np

from .curves import KINDS, Array, Kind, Sampled, compute, described, distance, ends, message

# 2401 and 2025 nodes: with plotly.js (4.8 MB) the page is smaller than 8 MB.
AXES: Final[dict[str, tuple[Array, ...]]] = {
    "sphere": (np.linspace(-3, 3, 7), np.linspace(-3, 3, 7)),
    "frame": (np.linspace(-1.5, 1.5, 3), np.linspace(-1.5, 1.5, 3), np.linspace(-1.5, 1.5, 5)),
}
SAMPLES: Final = {"sphere": 33, "frame": 25}
UNIT: Final = 32767
PROFILES: Final = 5


def nodes(kind: Kind) -> Iterator[tuple[tuple[float, ...], tuple[float, ...]]]:
    """Velocities at start and end, the last parameter of the end running first."""
    one = list(itertools.product(*(axis.tolist() for axis in AXES[kind.name])))
    return itertools.product(one, one)


def size(kind: Kind) -> int:
    """Return the number of nodes."""
    return int(np.prod([len(axis) for axis in AXES[kind.name]])) ** 2


def _text(array: np.ndarray[Any, Any]) -> str:
    return base64.b64encode(array.astype(array.dtype.newbyteorder("<")).tobytes()).decode("ascii")


def _whole(values: Array) -> np.ndarray[Any, np.dtype[np.int16]]:
    return np.round(UNIT * values).astype(np.int16)


def build(name: str, progress: Callable[[], object]) -> dict[str, Any]:
    """Compute the grid of one kind; `progress` is called after each node."""
    kind, samples = KINDS[name], SAMPLES[name]
    t = np.linspace(0, 1, samples)
    count = size(kind)
    points = np.zeros((count, 2, samples, 3 * kind.k), dtype=np.int16)
    profiles = np.zeros((count, PROFILES, samples), dtype=np.int16)
    scales, costs = np.zeros((count, PROFILES), dtype=np.float64), np.zeros((count, 2), dtype=np.float64)
    errors: dict[int, dict[str, str]] = {}
    for node, (v0, v1) in enumerate(nodes(kind)):
        found = compute(kind, kind.angle, v0, v1, t)
        rows: list[Array | None] = []
        for i, (curve, sampled) in enumerate(found.items()):
            if isinstance(sampled, Sampled):
                points[node, i] = _whole(sampled.points.reshape(samples, -1))
                costs[node, i] = sampled.cost
                rows += [sampled.speed, sampled.acceleration]
            else:
                errors.setdefault(node, {})[curve] = message(sampled)
                rows += [None, None]
        for i, row in enumerate([*rows, distance(found)]):
            if row is not None and row.max() > 0:
                scales[node, i] = row.max()
                profiles[node, i] = _whole(row / row.max())
        progress()
    start, end = ends(kind, kind.angle)
    return {
        "axes": [axis.tolist() for axis in AXES[name]],
        "samples": samples,
        "start": described(start),
        "end": described(end),
        "points": _text(points),
        "profiles": _text(profiles),
        "scales": _text(scales),
        "costs": _text(costs),
        "errors": errors,
    }
