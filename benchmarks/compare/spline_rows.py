"""Rows of the splines."""

from __future__ import annotations

from benchmarks.compare import spline_problems
from benchmarks.compare.row import Bound, Rival, Row

JUMP = 1e-10
# InterpolatePy stops when orientations and derivatives at the knots agree to 1e-8.
MEETS = 1e-7
GEOMETRIC = 'stiefel-rs with `kind="geometric"`'


def splines() -> list[Row]:
    """Set-up and evaluation through keyframes, Hermite interpolation, and large problems."""
    keyframes = [_keyframes(count) for count in spline_problems.KEYFRAMES]
    return [*keyframes, _points(), *_hermite(), *_large(), _subspaces()]


def _keyframes(count: int) -> Row:
    name = f"spline_setup/{count}"
    return Row(
        name,
        f"natural `CubicSpline`, {count} keyframes on SO(3), as St(3,2)",
        (
            Rival("interpolatepy", "interpolatepy", "InterpolatePy, the same problem", agree=MEETS),
            Rival("stiefel_rs", "loose", "stiefel-rs with tol=1e-8, as InterpolatePy", agree=MEETS, best_of=False),
            Rival("stiefel_rs", "rotations", "stiefel-rs as St(3,3)", agree=1e-9, best_of=False),
            Rival("stiefel_rs", "geometric", f"{GEOMETRIC}, another curve", agree=None, best_of=False),
            Rival("scipy", "rotation_spline", "SciPy RotationSpline, another curve", agree=None, best_of=False),
        ),
        ahead=10,
        bounds=(Bound(f"{name}:jump", "jump of the covariant acceleration", JUMP),),
    )


def _points() -> Row:
    return Row(
        "spline_points",
        f"{spline_problems.EVALUATIONS} points of the spline through {spline_problems.EVALUATED} keyframes",
        (
            Rival("interpolatepy", "interpolatepy", "InterpolatePy", agree=MEETS),
            Rival("stiefel_rs", "rotations", "stiefel-rs as St(3,3)", agree=1e-9, best_of=False),
            Rival("scipy", "rotation_spline", "SciPy RotationSpline, another curve", agree=None, best_of=False),
        ),
        unit="point",
        ahead=20,
    )


def _hermite() -> list[Row]:
    n, k, count = spline_problems.SAMPLED
    data = f"St({n},{k}), {count} knots of a known curve"
    # Each method computes a different curve: the error shows which is closer to the sampled one.
    rivals = (
        Rival("scipy", "tangent", "Zimmermann's method, SciPy", agree=None),
        Rival("stiefel_rs", "geometric", GEOMETRIC, agree=None, best_of=False),
    )
    ratio = Bound("spline_hermite/setup:error", "error relative to Zimmermann's method", 1.0)
    return [
        Row("spline_hermite/setup", f"`CubicHermite`, {data}", rivals, ahead=100, bounds=(ratio,), exact=True),
        Row("spline_hermite/point", f"`CubicHermite`, one point, {data}", rivals, ahead=100, exact=True),
    ]


def _large() -> list[Row]:
    n, k, count = spline_problems.TALL
    rows = []
    for name, work, limit in (
        ("spline_large/long", f"natural `CubicSpline`, {spline_problems.LONG} knots, St(3,2)", 1.0),
        ("spline_large/tall", f"natural `CubicSpline`, {count} knots, St({n},{k})", 2.0),
    ):
        threads = Rival(
            "stiefel_rs_threads", "ours", "2 threads, bit-identical", agree=None, identical=True, best_of=False
        )
        # Linear growth: twice the knots take at most twice the memory, plus a tenth for measurement noise.
        bounds = (
            Bound(f"{name}:peak", "peak memory in MiB"),
            Bound(f"{name}:growth", "ratio of peak memories with twice the knots", 2.2),
        )
        rows.append(Row(name, work, (threads,), seconds=limit, bounds=bounds))
    return rows


def _subspaces() -> Row:
    n, k, count = spline_problems.SUBSPACES
    frames = Rival("stiefel_rs", "frames", "aligned bases as frames", at_most=1.2, agree=None, best_of=False)
    return Row("spline_large/subspaces", f"natural `CubicSpline`, {count} subspaces, Gr({n},{k})", (frames,))
