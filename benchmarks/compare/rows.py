"""The comparisons and their targets."""

from __future__ import annotations

from benchmarks import problems
from benchmarks.compare import complex_rows, cubic_rows, derivative_rows, gradient_rows, rotation_rows, spline_rows
from benchmarks.compare.row import THREADS, Bound, Rival, Row

US = 1e-6
# Speed-up by two threads that counts as linear.
SCALING = 0.9 * THREADS


def _exponentials() -> list[Row]:
    reach = dict(zip(problems.SMALL_EXP, (1, 2, 8, 30), strict=True))
    gemms = dict(zip(problems.LARGE, (9, 7, 6), strict=True))
    small = [
        Row(f"skew_exp/{m}", f"`skew_exp`, m = {m}", (Rival("scipy", "expm", "SciPy expm"),), seconds=us * US)
        for m, us in reach.items()
    ]
    large = [
        Row(
            f"skew_exp/{m}",
            f"`skew_exp`, m = {m}, norm 1",
            (
                Rival("scipy", "gemm", "NumPy GEMM", at_most=count, agree=None, best_of=False),
                Rival("scipy", "expm", "SciPy expm"),
                Rival("morphomatics", "jax", "JAX expm, compiled"),
            ),
            bounds=(Bound(f"skew_exp/{m}:defect", "orthogonality defect", m * 1e-15),),
        )
        for m, count in gemms.items()
    ]
    return small + large


def _logarithms() -> list[Row]:
    def rivals(at_most: float | None) -> tuple[Rival, ...]:
        # For angles near pi the logarithm of a random rotation has a condition number of about m.
        schur = Rival("scipy", "schur", "LAPACK real Schur and atan2", at_most=at_most, agree=1e-8)
        cayley = Rival("scipy", "cayley", "Cayley transform and eigh, NumPy", agree=1e-8)
        return schur, cayley, Rival("scipy", "logm", "SciPy logm", agree=1e-8)

    reach = dict(zip(problems.SMALL_LOG, (1, 15, 60), strict=True))
    small = [
        Row(f"orthogonal_log/{m}", f"`orthogonal_log`, m = {m}", rivals(None), seconds=us * US)
        for m, us in reach.items()
    ]
    large = [
        Row(
            f"orthogonal_log/{m}",
            f"`orthogonal_log`, m = {m}",
            rivals(1 / 2),
            bounds=(Bound(f"orthogonal_log/{m}:backward", "backward error", m * 1e-15),),
        )
        for m in problems.LARGE
    ]
    return small + large


def _curves() -> list[Row]:
    reach = dict(zip(problems.CURVES, ((0.15, 4), (0.5, 3), (20, None), (100, None)), strict=True))
    jax = {
        (3, 1): Rival("morphomatics", "morphomatics", "morphomatics, jit + vmap"),
        # Geodesics of SO(3) differ from the quasi-geodesics of St(3, 2): the same ends, but another curve.
        (3, 2): Rival("morphomatics", "morphomatics", "morphomatics on SO(3), jit + vmap", agree=None),
    }
    rows = [
        Row(
            f"curve/{n},{k}",
            f"`GeometricCubic`, 1000 points at once, St({n},{k})",
            (
                Rival("scipy", "thin", "NumPy, thin, vectorised"),
                Rival("scipy", "formulas", "the paper's n x n formulas, SciPy", pick=problems.FORMULA_POINT),
                *((jax[n, k],) if (n, k) in jax else ()),
            ),
            unit="point",
            seconds=us * US,
            ahead=ahead,
        )
        for (n, k), (us, ahead) in reach.items()
    ]
    return [*rows, _single_point(), *_tall_curve()]


def _single_point() -> Row:
    return Row(
        "curve_single/3,1",
        "`GeometricCubic`, one point, St(3,1)",
        (
            Rival("morphomatics", "morphomatics", "morphomatics, jit"),
            Rival("scipy", "thin", "NumPy, thin"),
        ),
        seconds=2 * US,
    )


def _tall_curve() -> list[Row]:
    work = f"`GeometricCubic`, {problems.TALL_POINTS} points at once, St(10^6,{problems.TALL[1]})"
    gemm = Rival("scipy", "gemm", "NumPy GEMM with that output", at_most=1.5, agree=None)
    memory = Bound("curve_tall:memory", "peak memory / (input + output)", 1.2)
    return [
        Row("curve_tall", work, (gemm,), unit="point", bounds=(memory,)),
        Row("curve_tall_start", f"`GeometricCubic`, construction, St(10^6,{problems.TALL[1]})"),
    ]


def _batches() -> list[Row]:
    rows = []
    for name in ("skew_exp/3", "skew_exp/6", "orthogonal_log/3", "orthogonal_log/6"):
        function, m = name.split("/")
        loop = Rival("scipy", "loop", "Python loop over SciPy", agree=None)
        rows.append(_batch(name, f"`{function}`, m = {m}", (loop,)))
    for function in ("retract", "inverse_retract", "log"):
        loop = Rival("stiefel_rs", "ours_loop", "Python loop over single calls", agree=None)
        rows.append(_batch(f"{function}/4,2", f"`{function}`, St(4,2)", (loop,)))
    return rows


def _batch(name: str, what: str, rivals: tuple[Rival, ...]) -> Row:
    one = Rival("stiefel_rs", "ours", "1 thread, bit-identical", at_most=1 / SCALING, agree=None, identical=True)
    return Row(
        f"batch/{name}",
        f"batch of {problems.BATCH}: {what}, {THREADS} threads",
        (one, *rivals),
        unit="problem",
        ours="stiefel_rs_threads",
    )


def _riemannian() -> list[Row]:
    reach = dict(zip(problems.LOGS, (10, 10, 3, 2), strict=True))
    rows = []
    for (n, k), ahead in reach.items():
        for distance in problems.DISTANCES:
            # geomstats stops at 1e-8.
            rivals = (
                Rival("scipy", "algebraic", "algebraic method with Sylvester steps, NumPy", agree=1e-8),
                Rival("geomstats", "geomstats", "geomstats", agree=1e-5),
            )
            label = distance.replace("pi", " pi")
            rows.append(Row(f"log/{n},{k}/{distance}", f"`log`, distance {label}, St({n},{k})", rivals, ahead=ahead))
    for n, k in problems.LOGS:
        euclidean = (Rival("pymanopt", "pymanopt", "pymanopt"),)
        rows.append(Row(f"exp/{n},{k}", f"`exp`, St({n},{k})", (Rival("geomstats", "geomstats", "geomstats"),)))
        rows.append(Row(f"exp_euclidean/{n},{k}", f"`exp`, Euclidean metric, St({n},{k})", euclidean))
        for kind in ("polar", "qr"):
            rows.append(Row(f"retract_{kind}/{n},{k}", f"retraction, {kind}, St({n},{k})", euclidean))
    return rows


def _subspaces() -> list[Row]:
    reach = dict(zip(problems.SUBSPACES, (5, 2), strict=True))
    rows = []
    for (n, k), ahead in reach.items():
        for function in ("exp", "log"):
            # geomstats represents subspaces by projectors, and computes logarithms of n x n matrices.
            rivals = (
                Rival("pymanopt", "pymanopt", "pymanopt"),
                Rival("geomstats", "geomstats", "geomstats, projectors", agree=1e-6),
            )
            rows.append(
                Row(f"subspace_{function}/{n},{k}", f"`Grassmann.{function}`, Gr({n},{k})", rivals, ahead=ahead)
            )
    return rows


def _import() -> list[Row]:
    # 20 ms are about 0.15 times the time of NumPy alone.
    numpy = Rival("stiefel_rs", "numpy", "`import numpy`", at_most=1.15, agree=None, best_of=False)
    return [Row("import", "`import stiefel_rs` in a new process", (numpy,))]


def all_rows() -> list[Row]:
    """Every row of the table."""
    matrices = _exponentials() + _logarithms() + complex_rows.matrices()
    curves = _curves() + derivative_rows.derivatives() + _batches() + _riemannian() + _subspaces()
    cubics, splines, rotations = cubic_rows.cubics(), spline_rows.splines(), rotation_rows.rotations()
    frames, gradients = complex_rows.frames(), gradient_rows.gradients()
    return matrices + curves + cubics + splines + frames + rotations + gradients + _import()
