"""Rows of complex matrices and frames, compared with other libraries and with real data of the same shape."""

from __future__ import annotations

from benchmarks import problems
from benchmarks.compare.row import Rival, Row

# Targets for the ratio to the time of the real problem.
SMALL, LARGE = 4.0, 3.5
# Targets of the matrix functions by size.
MATRICES = dict(zip(problems.COMPLEX, (SMALL, SMALL, LARGE, LARGE), strict=True))
LOGS = {(10, 3): SMALL, (50, 5): LARGE}
BOUNDARIES = {(4, 2): SMALL, (10, 3): SMALL}
SPLINES = {(4, 2): SMALL, (10, 3): SMALL, (50, 5): LARGE}
KNOTS = 20


def matrices() -> list[Row]:
    """Exponentials of skew-Hermitian matrices, logarithms of unitary ones."""
    expm = Rival("scipy", "expm", "SciPy expm")
    # For angles near pi the logarithm has a condition number of about m.
    logm = Rival("scipy", "logm", "SciPy logm", agree=1e-8)
    schur = Rival("scipy", "schur", "LAPACK complex Schur", agree=1e-8)
    exponentials = [
        Row(f"skew_exp_complex/{m}", f"`skew_exp`, complex, m = {m}, norm 1", (_real(most), expm), ahead=1)
        for m, most in MATRICES.items()
    ]
    logarithms = [
        Row(f"unitary_log/{m}", f"`orthogonal_log`, unitary, m = {m}", (_real(most), schur, logm), ahead=1)
        for m, most in MATRICES.items()
    ]
    return exponentials + logarithms


def frames() -> list[Row]:
    """Logarithms, cubics and splines of complex frames."""
    rows = [_row("log", n, k, "`log`, complex, distance 0.5", most) for (n, k), most in LOGS.items()]
    for name, distance in (("near", 0.7), ("far", 1.5)):
        work = f"`RiemannianCubic.from_boundary`, complex, distance {distance}"
        rows += [_row(name, n, k, work, most) for (n, k), most in BOUNDARIES.items()]
    work = f"natural `CubicSpline`, complex, {KNOTS} knots"
    return rows + [_row("spline", n, k, work, most) for (n, k), most in SPLINES.items()]


def _row(name: str, n: int, k: int, work: str, at_most: float) -> Row:
    return Row(f"complex/{name}/{n},{k}", f"{work}, St({n},{k})", (_real(at_most),))


def _real(at_most: float) -> Rival:
    return Rival("stiefel_rs", "real", "real data of the same shape", at_most=at_most, agree=None, best_of=False)
