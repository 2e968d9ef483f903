"""InterpolatePy: natural Riemannian cubics on SO(3) by multiple shooting, compiled if the wheel provides it."""

from __future__ import annotations

from functools import partial

import numpy as np
from interpolatepy import HAS_CPP
from interpolatepy.quaternion import Quaternion, ShootingQuaternionInterpolation

from benchmarks.compare import rotation_problems, spline_problems
from benchmarks.compare.protocol import Task, Tasks, serve
from benchmarks.compare.spline_problems import Knots, rotations
from benchmarks.problems import Array


def points(spline: ShootingQuaternionInterpolation) -> Array:
    """Its points at the times of the comparison, as frames of St(3, 2)."""
    _, values = spline.generate_trajectory(spline_problems.EVALUATIONS)
    return rotations(np.array([[q.w, q.x, q.y, q.z] for q in values]))[..., :2]


def jump(spline: ShootingQuaternionInterpolation, knots: Knots) -> float:
    """Largest jump of the angular acceleration at a knot."""
    inner = knots.t[1:-1]
    sides = [
        np.array([spline.evaluate_acceleration(float(t)) for t in times])
        for times in (inner, np.nextafter(inner, -np.inf))
    ]
    return float(np.linalg.norm(sides[0] - sides[1], axis=1).max())


def make(knots: Knots) -> ShootingQuaternionInterpolation:
    """The spline, from quaternions in the library's convention."""
    assert knots.quaternions is not None
    return ShootingQuaternionInterpolation(knots.t, [Quaternion(*map(float, q)) for q in knots.quaternions])


def setup_task(count: int) -> Task:
    """The natural spline through keyframes."""
    knots = spline_problems.keyframes(count)
    assert knots.quaternions is not None
    quaternions = [Quaternion(*map(float, q)) for q in knots.quaternions]

    def run() -> ShootingQuaternionInterpolation:
        return ShootingQuaternionInterpolation(knots.t, quaternions)

    def note() -> str:
        spline = run()
        compiled = "compiled" if HAS_CPP else "in Python"
        return f"{compiled}, cost {spline.acceleration_energy:.6g}, jump {jump(spline, knots):.1g}"

    return Task(run, result=lambda: points(run()), note=note)


def points_task() -> Task:
    """Points of the spline through the keyframes, by the library's call for many points."""
    spline = make(spline_problems.keyframes(spline_problems.EVALUATED))
    count = spline_problems.EVALUATIONS
    return Task(lambda: spline.generate_trajectory(count), units=count, result=lambda: points(spline))


def tasks() -> Tasks:
    """All tasks by name."""
    # The same work is in two rows: with curves on St(3, 2), and with splines of rotations.
    counts = {"spline_setup": spline_problems.KEYFRAMES, "rotation_setup": rotation_problems.COUNTS}
    found: Tasks = {
        f"{row}/{count}:interpolatepy": partial(setup_task, count) for row in counts for count in counts[row]
    }
    found["spline_points:interpolatepy"] = points_task
    return found


if __name__ == "__main__":
    serve(tasks(), packages=("interpolatepy", "numpy", "scipy"))
