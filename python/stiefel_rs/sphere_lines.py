"""Circles, parallels and meridians of the unit sphere as points."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def circle(centre: Array, u: Array, v: Array) -> Array:
    """Return a closed polygon for ``centre + cos(angle) u + sin(angle) v``, shape ``(181, 3)``."""
    angle = np.linspace(0.0, 2.0 * np.pi, 181)[:, None]
    return np.asarray(centre + np.cos(angle) * u + np.sin(angle) * v)


def grid_lines() -> Iterator[Array]:
    """Yield parallels and meridians every 30 degrees, each of shape ``(181, 3)``."""
    x, y, z = np.eye(3)
    for latitude in np.radians(np.arange(-60, 61, 30)):
        yield circle(np.sin(latitude) * z, np.cos(latitude) * x, np.cos(latitude) * y)
    for longitude in np.radians(np.arange(0, 180, 30)):
        yield circle(np.zeros(3), np.cos(longitude) * x + np.sin(longitude) * y, z)
