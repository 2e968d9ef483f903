"""The harness of `make benchmark` itself: it runs, and what it measures by is right."""

import subprocess
import sys

import mpmath
import numpy as np
import pytest

from benchmarks import problems
from benchmarks.environment import ROOT
from benchmarks.measure import Figure, Outcome
from benchmarks.methods import casteljau, extended
from benchmarks.methods.stiefel_log import cayley_log, rotation_log, stiefel_log, symmetric_exp
from benchmarks.rows import Rival, Row, all_rows
from benchmarks.table import lines_of
from stiefel_rs import GeometricCubic, orthogonal_log, skew_exp

EPS = np.finfo(float).eps

extended_precision = pytest.mark.skipif(
    np.finfo(np.longdouble).nmant < 63, reason="long double has no more digits than double here"
)


def test_a_run_without_other_libraries(tmp_path):
    page = tmp_path / "page.md"
    command = [sys.executable, "-m", "benchmarks", "--quick", "--only", "curve_single", "--peers", "--out", str(page)]
    subprocess.run(command, check=True, cwd=ROOT, capture_output=True, timeout=120)
    text = page.read_text()
    assert "`GeometricCubic`, one point, St(3,1)" in text
    assert "`scipy` skipped: not asked for" in text
    assert "of the 1 targets" in text


def test_names_are_unique():
    names = [row.name for row in all_rows()]
    assert len(names) == len(set(names))


@pytest.mark.parametrize(
    ("ours", "ahead", "reached"),
    [(1.0, 4.0, [None, True]), (3.0, 4.0, [None, False]), (1.0, None, [None, None])],
)
def test_the_target_ahead_of_the_best_is_judged_on_the_best(ours, ahead, reached):
    slow, best = Rival("a", "slow", "slow"), Rival("b", "best", "best")
    row = Row("name", "work", (slow, best), ahead=ahead)
    figures = {slow: Figure([80.0], [80.0]), best: Figure([8.0], [8.0])}
    lines = lines_of(Outcome(row, Figure([ours], [ours]), figures, {}))
    assert [line.reached for line in lines] == reached


@extended_precision
@pytest.mark.parametrize("norm", [1e-3, 1.0, 30.0])
def test_extended_precision_exponential(norm):
    A = norm * problems.skew(20)
    found = extended.expm(A)
    with mpmath.workdps(40):
        exact = mpmath.expm(mpmath.matrix(A.tolist()))
        # 64 bits hold 5e-20 of numbers near 1; the squarings take up to the norm of that.
        error = max(abs(mpmath.mpf(str(found[i, j])) - exact[i, j]) for i in range(20) for j in range(20))
    assert error < 2e-19 * max(1.0, norm)


@extended_precision
def test_extended_precision_defects():
    R, Q = skew_exp(problems.skew(30)), problems.rotation(30)
    assert 0 < extended.orthogonality_defect(R) < 30 * 1e-15
    # A known error is found again.
    assert extended.orthogonality_defect(R * (1 + 1e-12)) == pytest.approx(2e-12 * np.sqrt(30), rel=1e-2)
    assert extended.backward_error(orthogonal_log(Q), Q) < 30 * 1e-15


@pytest.mark.parametrize("m", [3, 6, 30])
def test_rotations_of_the_comparison(m):
    A, Q = problems.skew(m), problems.rotation(m)
    assert np.linalg.det(Q) == pytest.approx(1)
    assert np.linalg.norm(symmetric_exp(A) - skew_exp(A)) < 10 * m * EPS
    for function in (rotation_log, cayley_log):
        # The largest angle of these is 0.02 from pi: condition 150.
        assert np.linalg.norm(function(Q) - orthogonal_log(Q)) < 1000 * m * EPS


@pytest.mark.parametrize(("n", "k"), [(3, 1), (3, 2), (50, 5)])
def test_curves_of_the_comparison(n, k):
    b, t = problems.boundary(n, k), problems.parameters(9)
    points = casteljau.control_points(b.S0, b.V0, b.S1, b.V1)
    curve = GeometricCubic(b.S0, b.V0, b.S1, b.V1)
    assert np.abs(points - curve.control_points).max() < 1e-14
    assert np.abs(casteljau.casteljau(points, t) - curve(t)).max() < 1e-13
    assert np.abs(casteljau.formulas(points, t[3]) - curve(t[3])).max() < 1e-12


@pytest.mark.parametrize(("n", "k"), problems.LOGS[:3])
@pytest.mark.parametrize("distance", problems.DISTANCES)
def test_logarithm_of_the_comparison(n, k, distance):
    S0, S1, V = problems.log_problem(n, k, distance)
    # At 0.9 pi the iteration contracts slowly: it stops at 1e-12 with ten times that to go.
    assert np.linalg.norm(stiefel_log(S0, S1) - V) < 1e-10
