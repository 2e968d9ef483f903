"""Rows of the splines of rotations, compared with SciPy's class of the same name."""

from __future__ import annotations

from benchmarks.compare import rotation_problems, spline_problems
from benchmarks.compare.row import Rival, Row
from benchmarks.compare.spline_rows import MEETS

SCIPY = Rival("scipy", "rotation_spline", "SciPy RotationSpline, another curve", agree=None)


def rotations() -> list[Row]:
    """Set-up, set-up with values, values, and many splines at once."""
    return [*(_setup(count) for count in rotation_problems.COUNTS), _curve(), *_values(), _crowd()]


def _setup(count: int) -> Row:
    label = "InterpolatePy, the same problem"
    same = Rival("interpolatepy", "interpolatepy", label, at_most=0.1, agree=MEETS, best_of=False)
    work = f"natural `RotationSpline`, {count} keyframes from a `Rotation`"
    return Row(f"rotation_setup/{count}", work, (SCIPY, same), ahead=1.2)


def _curve() -> Row:
    count, times = rotation_problems.EVALUATED, spline_problems.EVALUATIONS
    work = f"natural `RotationSpline`, {count} keyframes, and rotations at {times} times"
    return Row("rotation_curve", work, (SCIPY,), ahead=1.2)


def _values() -> list[Row]:
    where = f"{spline_problems.EVALUATIONS} times of a spline through {rotation_problems.EVALUATED}"
    work = {"rotations": f"`RotationSpline`: rotations at {where}", "rates": f"`RotationSpline`: rates at {where}"}
    return [Row(f"rotation_values/{name}", work[name], (SCIPY,), unit="value", ahead=3) for name in work]


def _crowd() -> Row:
    joints, count = rotation_problems.JOINTS, rotation_problems.KEYFRAMES
    work = f"`RotationSpline`: {joints} splines of {count} keyframes in one call"
    loop = Rival("scipy", "rotation_spline", "a loop over SciPy's RotationSpline, other curves", agree=None)
    threads = Rival("stiefel_rs_threads", "ours", "2 threads, bit-identical", agree=None, identical=True, best_of=False)
    return Row("rotation_crowd", work, (loop, threads), unit="spline", ahead=10)
