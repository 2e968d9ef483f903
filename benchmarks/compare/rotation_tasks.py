"""The project's splines of rotations as tasks."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from benchmarks.compare import rotation_problems, spline_problems
from benchmarks.compare.protocol import Task, Tasks
from stiefel_rs import RotationSpline


def setup_task(count: int) -> Task:
    """The natural spline through keyframes; its points are compared."""
    t, keyframes = rotation_problems.keyframes(count)

    def run() -> RotationSpline:
        return RotationSpline(t, keyframes)

    times = spline_problems.evaluations(t)
    note = f"cost {run().cost():.6g}"
    return Task(run, result=lambda: run()(times).as_matrix()[..., :2], note=lambda: note)


def curve_task() -> Task:
    """A spline and its first evaluation."""
    t, keyframes = rotation_problems.keyframes(rotation_problems.EVALUATED)
    times = spline_problems.evaluations(t)

    def run() -> Any:
        return RotationSpline(t, keyframes)(times)

    return Task(run, result=lambda: run().as_matrix())


def values_task(order: int) -> Task:
    """Rotations or rates of a spline at many times."""
    t, keyframes = rotation_problems.keyframes(rotation_problems.EVALUATED)
    spline, times = RotationSpline(t, keyframes), spline_problems.evaluations(t)

    def run() -> Any:
        return spline(times, order)

    return Task(run, units=len(times), result=lambda: run().as_matrix() if order == 0 else run())


def crowd_task() -> Task:
    """Many splines in one call."""
    t, quaternions = rotation_problems.crowd()

    def run() -> RotationSpline:
        return RotationSpline(t, quaternions)

    middle = float(np.max(t[:, 0]) + np.min(t[:, -1])) / 2
    return Task(run, units=len(t), result=lambda: run()(middle))


def tasks() -> Tasks:
    """All tasks by name."""
    found: dict[str, Callable[[], Task]] = {"rotation_crowd:ours": crowd_task, "rotation_curve:ours": curve_task}
    for count in rotation_problems.COUNTS:
        found[f"rotation_setup/{count}:ours"] = partial(setup_task, count)
    for name, order in rotation_problems.VALUES.items():
        found[f"rotation_values/{name}:ours"] = partial(values_task, order)
    return found
