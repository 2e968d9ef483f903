"""Random walks of points, and vectors at them, for the tests of splines."""

import numpy as np

from stiefel_rs import Stiefel

# Defects and jumps of legs of at most 1e-12, and round-off of the evaluation.
MET = 1e-11


def walk(n, k, count, step=0.6, seed=0):
    """A random walk of points at unequal times."""
    manifold, rng = Stiefel(n, k), np.random.default_rng(seed + n + 100 * k)
    points = [manifold.random_point(rng)]
    for _ in range(count - 1):
        V = manifold.random_tangent(points[-1], rng)
        points.append(manifold.exp(points[-1], step * V / manifold.norm(points[-1], V)))
    return np.cumsum(rng.uniform(0.5, 1.5, count)), np.stack(points)


def velocities(points, seed=5):
    """Tangent vectors of length 1 at every point."""
    manifold = Stiefel(*points.shape[1:])
    V = manifold.random_tangent(points, np.random.default_rng(seed))
    return V / manifold.norm(points, V)[:, None, None]
