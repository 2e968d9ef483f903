"""Curves between two ends, computed before on a grid of velocities, for a page without a server.

Entries of points are 16-bit integers, in units of 1/32767; lengths and angles too, in units of 1/32767 of the largest
of their profile. Costs and lengths of curves are numbers of 64 bits.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from typing import Any, Final

import numpy as np

from .answers import text
from .messages import plain
from .sampling import Array, Sampled, apart, sample
from .two_ends import CURVES, KINDS, Ends, ends, find

# 2401 and 2025 nodes: the page with both is smaller than 5 MB.
AXES: Final[dict[str, tuple[Array, ...]]] = {
    "sphere": (np.linspace(-3, 3, 7), np.linspace(-3, 3, 7)),
    "frame": (np.linspace(-1.5, 1.5, 3), np.linspace(-1.5, 1.5, 3), np.linspace(-1.5, 1.5, 5)),
}
SAMPLES: Final = {"sphere": 33, "frame": 25}
UNIT: Final = 32767
# Speed and acceleration of each curve, and the angle between them.
PROFILES: Final = 2 * len(CURVES) + 1


def nodes(kind: str) -> Iterator[tuple[tuple[float, ...], tuple[float, ...]]]:
    """Velocities at start and end, the last parameter of the end running first."""
    one = list(itertools.product(*(axis.tolist() for axis in AXES[kind])))
    return itertools.product(one, one)


def size(kind: str) -> int:
    """Return the number of nodes."""
    return int(np.prod([len(axis) for axis in AXES[kind]])) ** 2


def spacing(kind: str) -> str:
    """Say where the nodes of the grid of a kind are."""
    parts = [
        f"{parameter}: {axis[0]:g} to {axis[-1]:g} in steps of {axis[1] - axis[0]:g}"
        for parameter, axis in zip(KINDS[kind].parameters, AXES[kind], strict=True)
    ]
    return f"Velocities of the grid in rad/s: {'; '.join(parts)}."


def _whole(values: Array) -> np.ndarray[Any, np.dtype[np.int16]]:
    return np.round(UNIT * values).astype(np.int16)


class _Table:
    """Arrays of all nodes."""

    def __init__(self, kind: Ends, count: int, samples: int) -> None:
        self.points = np.zeros((count, len(CURVES), samples, 3 * kind.k), dtype=np.int16)
        self.profiles = np.zeros((count, PROFILES, samples), dtype=np.int16)
        self.scales = np.zeros((count, PROFILES))
        self.numbers = np.zeros((count, len(CURVES), 2))
        self.errors: dict[int, dict[str, str]] = {}

    def set(self, node: int, kind: Ends, v0: tuple[float, ...], v1: tuple[float, ...], t: Array) -> None:
        found = sample(find(kind, kind.angle, v0, v1), t, t)
        rows: list[Array | None] = []
        for i, (name, curve) in enumerate(found.items()):
            if isinstance(curve, Sampled):
                self.points[node, i] = _whole(curve.points.reshape(len(t), -1))
                self.numbers[node, i] = curve.cost, curve.length
                rows += [curve.speed, curve.acceleration]
            else:
                self.errors.setdefault(node, {})[name] = plain(name, curve)
                rows += [None, None]
        for i, row in enumerate([*rows, apart(found)]):
            if row is not None and row.max() > 0:
                self.scales[node, i] = row.max()
                self.profiles[node, i] = _whole(row / row.max())


def build(name: str, progress: Callable[[], object]) -> dict[str, Any]:
    """Compute the grid of one kind; `progress` is called after each node."""
    kind, samples = KINDS[name], SAMPLES[name]
    t, table = np.linspace(0, 1, samples), _Table(kind, size(name), samples)
    for node, (v0, v1) in enumerate(nodes(name)):
        table.set(node, kind, v0, v1, t)
        progress()
    start, end = ends(kind, kind.angle)
    return {
        "axes": [axis.tolist() for axis in AXES[name]],
        "spacing": spacing(name),
        "samples": samples,
        "start": start.described(),
        "end": end.described(),
        "points": text(table.points, "<i2"),
        "profiles": text(table.profiles, "<i2"),
        "scales": text(table.scales, "<f8"),
        "numbers": text(table.numbers, "<f8"),
        "errors": table.errors,
    }
