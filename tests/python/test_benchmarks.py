"""The harness of `make benchmark`: it runs, and its measures are correct."""

import re
import subprocess
import sys

import mpmath
import numpy as np
import pytest
from beside import HANGS
from scipy.spatial.transform import Rotation, RotationSpline

from benchmarks import problems
from benchmarks.boundary import cost, solved
from benchmarks.boundary.random_problems import FAMILIES
from benchmarks.compare import cubic_problems, spline_problems, spline_tasks
from benchmarks.compare.measure import Figure, Outcome
from benchmarks.compare.methods import casteljau, cubics, extended, rotation_spline
from benchmarks.compare.methods.hermite import TangentHermite, stiefel_exp
from benchmarks.compare.methods.stiefel_log import cayley_log, rotation_log, stiefel_log, symmetric_exp
from benchmarks.compare.page import HEADERS, WHOLE, Page
from benchmarks.compare.peers import stiefel_rs as ours
from benchmarks.compare.row import Bound, Rival, Row
from benchmarks.compare.rows import all_rows
from benchmarks.compare.table import lines_of, shown, verdicts
from benchmarks.environment import ROOT
from stiefel_rs import (
    CubicSpline,
    GeometricCubic,
    Grassmann,
    RiemannianCubic,
    SolverReport,
    Stiefel,
    orthogonal_log,
    skew_exp,
)

EPS = np.finfo(float).eps

extended_precision = pytest.mark.skipif(
    np.finfo(np.longdouble).nmant < 63, reason="long double has no more digits than double here"
)


def test_a_run_without_other_libraries(tmp_path):
    page = tmp_path / "page.md"
    options = ["--quick", "--only", "curve_single", "--peers", "--out", str(page)]
    command = [sys.executable, "-m", "benchmarks.compare", *options]
    done = subprocess.run(command, check=True, cwd=ROOT, capture_output=True, text=True, timeout=HANGS)
    text = page.read_text()
    assert "`GeometricCubic`, one point, St(3,1)" in text
    assert "`scipy` skipped: not asked for" in text
    assert "stiefel-rs is faster in 0 of 0 comparisons." in text
    assert "of 1 targets are met" in done.stdout


def test_names_are_unique():
    names = [row.name for row in all_rows()]
    assert len(names) == len(set(names))
    # A run of some rows finds their lines in the page by these keys.
    titles = [row.title for row in all_rows()]
    assert len(titles) == len(set(titles))


def test_our_process_has_all_tasks_and_measures():
    rows = all_rows()
    assert {f"{row.name}:ours" for row in rows} <= set(ours.tasks())
    assert {f"{row.name}:exact" for row in rows if row.exact} <= set(ours.tasks())
    rivals = [(row, rival) for row in rows for rival in row.rivals if rival.peer.startswith("stiefel_rs")]
    assert {f"{row.name}:{rival.task}" for row, rival in rivals} <= set(ours.tasks())
    assert {bound.measure for row in rows for bound in row.bounds} <= set(ours.measures())


def line(work, figure, ratio=""):
    return (work, figure, "", "", ratio)


def test_a_page_is_read_as_it_was_written():
    facts = {
        WHOLE: {"processor": "a | b", "`scipy`": "1"},
        "rows with `x`": {"processor": "a | b", "`heyoka`": "2"},
        "rows with `y`": {"processor": "a | b", "`heyoka`": "2"},
    }
    lines = [
        line("first", "1 us", "2.5"),
        line("second, |x|", "2 us", "0.4"),
        line("second, |x|", "2 us"),
        line("second, |x|", "4e-16"),
        line("third", "4e-16"),
    ]
    page = Page(facts, lines, {"geomstats": "does not install: no"})
    assert Page.parse(page.text()) == page
    assert "\nstiefel-rs is faster in 1 of 2 comparisons." in page.text()
    # Cells that repeat those above are empty, also where another task has the same figure beneath it.
    *_, repeated, same_work, same_figure = page.text().splitlines()
    assert re.match(r"\|\s+\|\s+\|", repeated)
    assert re.match(r"\|\s+\| 4e-16", same_work)
    assert re.match(r"\| third\s+\| 4e-16", same_figure)
    assert len(lines[0]) == len(HEADERS)


def test_the_committed_page_is_read_as_it_was_written():
    text = (ROOT / "docs" / "benchmarks.md").read_text()
    assert Page.parse(text).text() == text


def test_a_run_of_some_rows_keeps_the_others():
    old = Page({WHOLE: {"date": "1"}}, [line("first", "1"), line("gone", "2"), line("third", "3")], {"scipy": "old"})
    new = Page({"some": {"date": "2", "`scipy`": "1"}}, [line("third", "4"), line("second", "5")], {"heyoka": "none"})
    page = old.updated(new, ["first", "second", "third"])
    assert page.lines == [line("first", "1"), line("second", "5"), line("third", "4")]
    assert page.facts == {**old.facts, **new.facts}
    # SciPy was available this time.
    assert page.failures == {"heyoka": "none"}


def test_errors_and_compilation_are_told():
    row = Row("name", "work", (rival := Rival("a", "task", "other"),), exact=True)
    figures = Figure([1.0], [1.0], error=2e-16), {rival: Figure([2.0, 4.0, 5.0], [2.0], setup=3.0, error=1e-13)}
    cells = lines_of(Outcome(row, *figures, {}))[0].cells()
    assert cells[1] == "1 s, error 2e-16"
    assert cells[3] == "2 s (median 4 s), error 1e-13, after 3 s of compilation"


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


def test_notes_and_numbers_without_a_bound_are_told():
    row = Row("name", "work", bounds=(Bound("size", "peak memory in MiB"),))
    lines = lines_of(Outcome(row, Figure([1.0], [1.0], note="cost 2, jump 3e-14"), {}, {"size": 12.0}))
    assert [line.cells()[1:3] for line in lines] == [
        ("1 s, cost 2, jump 3e-14", ""),
        ("peak memory in MiB: 12", ""),
    ]
    assert all(line.reached is None for line in lines)


@pytest.mark.parametrize(
    ("limit", "target"), [(2.0, ("<= 2 s", True)), (0.5, ("<= 500 ms", False)), (None, ("", None))]
)
def test_the_target_of_our_time_stands_in_a_line_without_another(limit, target):
    near, far = Rival("a", "near", "near", at_most=1.0), Rival("b", "far", "far")
    row = Row("name", "work", (near, far), seconds=limit)
    outcome = Outcome(row, Figure([1.0], [1.0]), {near: Figure([3.0], [3.0]), far: Figure([9.0], [9.0])}, {})
    assert [(line.reach, line.reached) for line in lines_of(outcome)] == [("ratio >= 1", True), target]
    count, *missed = verdicts([outcome]).splitlines()
    assert count.startswith("1 of 2" if limit == 0.5 else "2 of 2" if limit else "1 of 1")
    assert missed == (["missed: work: 1 s, <= 500 ms"] if limit == 0.5 else [])


def test_a_missed_target_beside_another_library_has_its_ratio():
    rival = Rival("a", "task", "other", at_most=2.0)
    outcome = Outcome(Row("name", "work", (rival,)), Figure([1.0], [1.0]), {rival: Figure([0.25], [0.25])}, {})
    assert verdicts([outcome]).splitlines() == [
        "0 of 1 targets are met",
        "missed: work: 1 s beside 250 ms, ratio 0.25, <= 2 times the other",
    ]


def test_the_page_shows_other_libraries_alone():
    other, own = Rival("a", "task", "another library"), Rival("stiefel_rs", "task", "ours in another way")
    row = Row("name", "work", (own, other), bounds=(Bound("size", "size"),))
    figures = {other: Figure([3.0], [3.0]), own: Figure([2.0], [2.0])}
    found = shown(Outcome(row, Figure([1.0], [1.0]), figures, {"size": 1.0}))
    assert [line.cells()[2:] for line in found] == [("another library", "3 s", "3")]
    alone = Row("name", "work", (own,))
    found = shown(Outcome(alone, Figure([1.0], [1.0]), {own: Figure([2.0], [2.0])}, {}))
    assert [line.cells() for line in found] == [("work", "1 s", "", "", "")]


def test_the_target_of_our_time_has_a_line_where_all_others_have_targets():
    rival = Rival("a", "task", "other", at_most=1.0)
    row = Row("name", "work", (rival,), seconds=2.0)
    lines = lines_of(Outcome(row, Figure([1.0], [1.0]), {rival: Figure([3.0], [3.0])}, {}))
    assert [line.cells()[2] for line in lines] == ["", "other"]
    assert (lines[0].reach, lines[0].reached) == ("<= 2 s", True)


@extended_precision
@pytest.mark.parametrize("norm", [1e-3, 1.0, 30.0])
def test_extended_precision_exponential(norm):
    A = norm * problems.skew(20)
    found = extended.expm(A)
    with mpmath.workdps(40):
        exact = mpmath.expm(mpmath.matrix(A.tolist()))
        # 64 bits represent numbers near 1 to 5e-20; the squarings multiply this by up to the norm.
        error = max(abs(mpmath.mpf(str(found[i, j])) - exact[i, j]) for i in range(20) for j in range(20))
    assert error < 2e-19 * max(1.0, norm)


@extended_precision
def test_extended_precision_defects():
    R, Q = skew_exp(problems.skew(30)), problems.rotation(30)
    assert 0 < extended.orthogonality_defect(R) < 30 * 1e-15
    # A known error is reproduced.
    assert extended.orthogonality_defect(R * (1 + 1e-12)) == pytest.approx(2e-12 * np.sqrt(30), rel=1e-2)
    assert extended.backward_error(orthogonal_log(Q), Q) < 30 * 1e-15


@pytest.mark.parametrize("m", [3, 6, 30])
def test_rotations_of_the_comparison(m):
    A, Q = problems.skew(m), problems.rotation(m)
    assert np.linalg.det(Q) == pytest.approx(1)
    assert np.linalg.norm(symmetric_exp(A) - skew_exp(A)) < 10 * m * EPS
    for function in (rotation_log, cayley_log):
        # The largest angle is 0.02 from pi: condition number 150.
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
    # At 0.9 pi the iteration contracts slowly: it stops at 1e-12, ten times that from the limit.
    assert np.linalg.norm(stiefel_log(S0, S1) - V) < 1e-10


def test_equation_on_the_sphere():
    cubic = cubic_problems.paper("sphere")
    y = np.concatenate([each[:, 0] for each in cubic.initial])
    assert np.abs(cubics.sphere_field(0, y) - cubics.sphere_field_scalar(0, y)).max() < 10 * EPS
    end = cubics.solve(cubics.sphere_field_scalar, y, tol=cubics.FINEST).reshape(4, 3, 1)
    # The method's own tolerance; acceleration and jerk are no larger than 2.
    assert np.abs(end - np.stack(cubic.end)).max() < 1e-11


@pytest.mark.parametrize("name", cubic_problems.PAPER)
def test_shooting_of_the_comparison(name):
    cubic = cubic_problems.paper(name)
    solvers = [cubics.GroupShooting(cubic.boundary)]
    if name == "sphere":
        solvers.append(cubics.SphereShooting(cubic.boundary))
    for solver in solvers:
        found = solver.at(solver.solve(), 0.5)
        assert np.abs(found - np.stack(cubic.middle[:2])).max() < 1e-11


def test_collocation_of_the_comparison():
    cubic = cubic_problems.paper("sphere")
    found = cubics.sphere_collocation(cubic.boundary, 1e-8)(0.5)
    assert np.abs(found - np.stack(cubic.middle[:2])).max() < 1e-10


def test_reduced_data_give_the_same_curve():
    b = cubic_problems.random_boundary(30, 3)
    small = cubic_problems.reduced(b)
    assert small.S0.shape == (12, 3)
    curve, inner = (RiemannianCubic.from_boundary(each.S0, each.V0, each.S1, each.V1) for each in (b, small))
    # Both satisfy their ends to 1e-12.
    assert np.abs(curve(0.5) - cubic_problems.basis(b) @ inner(0.5)).max() < 1e-11


def test_keyframes_of_the_comparison():
    knots = spline_problems.keyframes(20)
    assert np.abs(Rotation.from_quat(knots.quaternions, scalar_first=True).as_matrix() - knots.S).max() < 10 * EPS
    turns = Rotation.from_matrix(knots.S[1:] @ np.swapaxes(knots.S[:-1], 1, 2)).magnitude()
    assert turns.min() > 0.3 - 1e-9
    assert turns.max() < 1.2 + 1e-9
    assert np.diff(knots.t).min() >= 0.5


@pytest.mark.parametrize("field", ["real", "complex"])
def test_walk_of_the_comparison(field):
    knots, M = spline_problems.walk(6, 2, 5, field), Stiefel(6, 2, field=field)
    M.check_point(knots.S)
    assert np.iscomplexobj(knots.S) == (field == "complex")
    assert [M.dist(*pair) for pair in zip(knots.S[:-1], knots.S[1:], strict=True)] == pytest.approx(
        [0.5] * 4, abs=1e-12
    )


def test_subspaces_of_the_comparison(monkeypatch):
    monkeypatch.setattr(spline_problems, "SUBSPACES", (9, 2, 4))
    (knots, bases), M = spline_problems.subspaces(), Grassmann(9, 2)
    assert np.abs(M.projector(knots.S) - M.projector(bases)).max() < 1e-14
    assert np.abs(knots.S - bases).max() > 0.1
    for near, far in zip(knots.S[:-1], knots.S[1:], strict=True):
        assert M.dist(near, far) == pytest.approx(0.5, abs=1e-12)
        assert np.abs(M.align(near, far) - far).max() < 1e-14


@pytest.mark.parametrize("field", ["real", "complex"])
def test_ends_of_the_comparison(field):
    M = Stiefel(5, 2, field=field)
    near, far = problems.boundary(5, 2, field=field), cubic_problems.random_boundary(5, 2, field=field)
    for b, distance, speed in ((near, 0.7, 0.5), (far, 1.5, 1.5)):
        assert M.dist(b.S0, b.S1) == pytest.approx(distance, abs=1e-12)
        assert [M.norm(b.S0, b.V0), M.norm(b.S1, b.V1)] == pytest.approx([speed, speed], abs=1e-12)
    S0, S1, V = problems.log_problem(5, 2, "0.5", field)
    assert np.abs(M.log(S0, S1) - V).max() < 1e-13


def test_known_curve_of_the_comparison():
    t, h = np.linspace(-1, 1, 5), 1e-3
    S, V = spline_problems.factors(5, 2, t)
    Stiefel(5, 2).check_tangent(S, V)
    at = {i: spline_problems.factors(5, 2, t + i * h)[0] for i in (-2, -1, 1, 2)}
    # Fourth order: fifth derivatives are some hundreds here.
    assert np.abs((8 * (at[1] - at[-1]) - (at[2] - at[-2])) / (12 * h) - V).max() < 1e-9


def test_hermite_interpolation_of_the_comparison():
    knots, h = spline_problems.sampled(), 1e-5
    curve = TangentHermite(knots.t, knots.S, knots.V)
    assert np.abs(np.stack([curve(float(t)) for t in knots.t]) - knots.S).max() < 1e-10
    # One-sided differences of second order, where two legs meet: the curve is once differentiable.
    for side in (h, -h):
        t = float(knots.t[3])
        slope = (4 * curve(t + side) - curve(t + 2 * side) - 3 * curve(t)) / (2 * side)
        assert np.abs(slope - knots.V[3]).max() < 1e-6
    S, V = knots.S[0], knots.V[0]
    assert np.abs(stiefel_exp(S, V) - Stiefel(5, 2).exp(S, V)).max() < 100 * EPS


def test_character_of_splines_of_the_comparison():
    knots = spline_problems.keyframes(6)
    spline = RotationSpline(knots.t, Rotation.from_matrix(knots.S))
    fine = np.linspace(knots.t[0], knots.t[-1], 20001)
    coarse_cost = np.trapezoid(np.sum(spline(fine, 2) ** 2, axis=1), fine)
    assert rotation_spline.cost(spline, knots.t) == pytest.approx(coarse_cost, rel=1e-5)
    assert rotation_spline.jump(spline, knots.t) < 1e-8
    curve = CubicSpline(knots.t, knots.S)
    assert spline_tasks.jump(curve) < 1e-10
    # The natural spline is stationary, and the cheapest nearby.
    assert curve.cost() < rotation_spline.cost(spline, knots.t)
    # For a curve that is not the spline, the jumps are detected.
    bent = CubicSpline(knots.t[:2], knots.S[:2]).acceleration(knots.t[1]) - curve.acceleration(knots.t[1])
    assert np.linalg.norm(bent) > 1e-3


def test_random_boundary_problems_are_counted():
    easy = FAMILIES[0]
    tally = solved.solve_all(4, 2, easy, 5)
    assert len(tally.reports) == len(tally.seconds) == len(tally.defects) == 5
    assert tally.reaches(easy)
    assert max(tally.defects) < 2e-12
    missed = SolverReport(True, 13, 1e-13, 1e-12, "converged")
    for report in (missed, SolverReport(True, 3, 2e-12, 1e-12, "converged")):
        tally.reports[0] = report
        assert not tally.reaches(easy)
    tally.reports[0] = missed
    assert tally.reaches(FAMILIES[1])
    del tally.reports[0]
    assert not tally.reaches(FAMILIES[1])


@pytest.mark.parametrize("kind", cost.KINDS, ids=lambda kind: kind.title)
def test_costs_of_solutions_are_compared(kind):
    outcomes = [cost.outcome(kind, index) for index in (1, 2)]
    assert all("reversed" in outcome.others and outcome.ratio <= cost.SLACK for outcome in outcomes)
    assert ("geodesic" in outcomes[0].others) == (kind.speed == 0)
    title, problems, failed, none, above, *_ = cost.line(kind, outcomes)
    assert (title, problems, failed, none, above) == (kind.title, 2, 0, 0, 0)
    dear = cost.Outcome((3, 1), 2.0, {"reversed": 1.0}, 0.1)
    assert cost.line(kind, [*outcomes, dear])[4] == "1 (reversed)"


def test_the_page_of_random_boundary_problems(tmp_path):
    page = tmp_path / "page.md"
    solved.main(["--count", "1", "--out", str(page)])
    text = page.read_text()
    assert all(f"| St({n},{k})" in text for n, k in solved.SHAPES)
    assert "Newton steps, mean" in text and "arget" not in text
