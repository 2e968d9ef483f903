"""Random initial data of cubics: a point, velocity, covariant acceleration and covariant jerk."""

import numpy as np

from stiefel_rs import Stiefel

EPS = np.finfo(float).eps
NAMES = ("point", "velocity", "acceleration", "jerk")


def data(n, k, seed=0, speed=1.0):
    """A point and three tangent vectors of a given length, shape (n, k) each."""
    rng = np.random.default_rng(seed)
    M = Stiefel(n, k)
    S = M.random_point(rng)
    tangents = [M.random_tangent(S, rng) for _ in range(3)]
    return S, *(V * speed / max(M.norm(S, V), EPS) for V in tangents)
