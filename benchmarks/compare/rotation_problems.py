"""Splines of rotations in SciPy's form: keyframes as `Rotation` objects, one spline or those of many joints."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.compare import spline_problems
from benchmarks.problems import Array

COUNTS = (10, 50, 200, 2000)
# Number of keyframes of the spline whose values are timed, at the times of `spline_problems.evaluations`.
EVALUATED = 200
VALUES = {"rotations": 0, "rates": 1}
JOINTS = 1000
KEYFRAMES = 20


def keyframes(count: int) -> tuple[Array, Rotation]:
    """Times and rotations, 0.3 to 1.2 rad apart."""
    knots = spline_problems.keyframes(count)
    assert knots.quaternions is not None
    return knots.t, Rotation.from_quat(np.roll(knots.quaternions, -1, axis=-1))


def crowd() -> tuple[Array, Array]:
    """Times, shape (J, N), and quaternions, scalar last, shape (J, N, 4), of joints with such steps."""
    rng = np.random.default_rng([20240419, 18])
    axes = rng.standard_normal((JOINTS, KEYFRAMES - 1, 3))
    axes *= (rng.uniform(0.3, 1.2, axes.shape[:-1]) / np.linalg.norm(axes, axis=-1))[..., None]
    turns = [Rotation.identity(JOINTS)]
    for step in np.moveaxis(axes, 1, 0):
        turns.append(turns[-1] * Rotation.from_rotvec(step))
    t = np.cumsum(rng.uniform(0.5, 1.5, (JOINTS, KEYFRAMES)), axis=-1)
    return t, np.stack([turn.as_quat() for turn in turns], axis=1)
