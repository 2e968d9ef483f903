"""Points that wander, and vectors at them, for the tests of splines."""

import numpy as np

from stiefel_rs import Stiefel

# Legs that miss their knot or jump by at most 1e-12, and evaluation.
MET = 1e-11


def walk(n, k, count, step=0.6, seed=0):
    """Points that wander, at unequal times."""
    manifold, rng = Stiefel(n, k), np.random.default_rng(seed + n + 100 * k)
    points = [manifold.random_point(rng)]
    for _ in range(count - 1):
        V = manifold.random_tangent(points[-1], rng)
        points.append(manifold.exp(points[-1], step * V / manifold.norm(points[-1], V)))
    return np.cumsum(rng.uniform(0.5, 1.5, count)), np.stack(points)


def velocities(points, seed=5):
    """Of length 1 at every point."""
    manifold = Stiefel(*points.shape[1:])
    V = manifold.random_tangent(points, np.random.default_rng(seed))
    return V / manifold.norm(points, V)[:, None, None]
