"""Properties of SciPy's `RotationSpline`: its cost, and the jump of its angular acceleration."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RotationSpline

Array = NDArray[np.float64]
NODES = 24


def cost(spline: RotationSpline, t: Array) -> float:
    """Integral of the squared angular acceleration, by Gauss's rule on each leg."""
    x, w = np.polynomial.legendre.leggauss(NODES)
    h = np.diff(t)[:, None]
    times = t[:-1, None] + h * (x + 1) / 2
    squares = np.sum(spline(times.ravel(), 2) ** 2, axis=1).reshape(times.shape)
    return float(np.sum(squares * w * h / 2))


def jump(spline: RotationSpline, t: Array) -> float:
    """Largest jump of the angular acceleration at a knot."""
    inner = t[1:-1]
    jumps = spline(inner, 2) - spline(np.nextafter(inner, -np.inf), 2)
    return float(np.linalg.norm(jumps, axis=1).max())
