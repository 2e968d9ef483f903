"""The comparison of control points: cost and accelerations of the exact cubic, and the statements of rows and text."""

import itertools

import numpy as np
import pytest

from stiefel_rs import Stiefel
from stiefel_rs.reproduce import control_points, experiments


@pytest.fixture(scope="module")
def rows():
    return control_points.measure()


@pytest.mark.parametrize("experiment", experiments.EXPERIMENTS, ids=lambda e: e.name)
def test_accelerations_and_cost_are_those_of_the_reference(experiment):
    problem = control_points.boundary_problem(experiment)
    chart, d, h = experiment.chart, experiment.chart.d, 1e-3
    z = chart.reference(experiments.initial_state(experiment), h * np.arange(1001))
    points = chart.embed(z[:, :d])
    velocity = chart.embed_velocity(z[:, :d], z[:, d : 2 * d])
    # Ambient accelerations by central differences of the exact velocity, of order 4.
    second = (8 * (velocity[3:-1] - velocity[1:-3]) - (velocity[4:] - velocity[:-4])) / (12 * h)
    s, v = points[2:-2], velocity[2:-2]
    st, vt = np.swapaxes(s, 1, 2), np.swapaxes(v, 1, 2)
    acceleration = second + v @ (vt @ s) + s @ (vt @ v - vt @ s @ (st @ v))
    squares = Stiefel(3, chart.k).norm(s, acceleration) ** 2
    # Simpson's rule on the inner part, and a linear law on the omitted parts at both ends, 2 h each.
    inner = (squares[0] + squares[-1] + 4 * squares[1:-1:2].sum() + 2 * squares[2:-2:2].sum()) * h / 3
    ends = 2 * h * (2 * squares[[0, -1]] - squares[[1, -2]]).sum()
    # h^2 for the linear law and h^4 for the rest.
    assert problem.cost == pytest.approx(inner + ends, rel=2e-5)
    first, last = problem.accelerations
    # Two steps away, accelerations differ by 2 h times the jerk.
    np.testing.assert_allclose(acceleration[0], first, atol=5e-3)
    np.testing.assert_allclose(acceleration[-1], last, atol=5e-3)
    for point, tangent in ((problem.ends[0], first), (problem.ends[2], last)):
        Stiefel(3, chart.k).check_tangent(point, tangent)


def test_every_method_meets_the_boundary_data():
    for experiment in experiments.EXPERIMENTS:
        problem = control_points.boundary_problem(experiment)
        for method in control_points.LABELS:
            curve = control_points.build(problem, method)
            data = [f(t) for t in (0.0, 1.0) for f in (curve, curve.velocity)]
            for found, expected in zip(data, problem.ends, strict=True):
                np.testing.assert_allclose(found, expected, atol=1e-12, err_msg=method)
            if method in control_points.POLYNOMIALS:
                assert curve.degree == control_points.degree(method)


def test_rows_hold_the_papers_errors_and_falling_costs(rows):
    for experiment, error in zip(experiments.EXPERIMENTS, (1.0757e-4, 4.5209e-3), strict=True):
        own = {r.method: r for r in rows if r.experiment is experiment}
        assert list(own) == list(control_points.LABELS)
        assert own["gcp"].error == pytest.approx(error, rel=1e-4)
        least = [own["gcp"], *(own[f"minimal_cost_{m}"] for m in control_points.DEGREES)]
        for before, after in itertools.pairwise(least):
            assert after.error < before.error / 5
            # No curve costs less than the cubic; costs are accurate to 1e-12.
            assert -1e-11 < after.excess < before.excess
        assert own["quintic"].error < own["gcp"].error / 20
        assert [r.free for r in least] == [experiment.chart.d * i for i in range(5)]
        assert own["exact"].error == 0 and own["exact"].excess == 0
        assert all(r.build_seconds > 0 and r.point_seconds > 0 for r in rows)


def test_rows_and_section(rows):
    cells = control_points.csv_rows(rows)
    assert [c[4] for c in cells] == [r.error for r in rows]
    assert all(len(c) == len(control_points.HEADER) for c in cells)
    text = control_points.section(rows)
    assert text.startswith("### Other control points")
    assert text.count("| minimal cost") == 2 * len(control_points.DEGREES)
    assert text.count("| none: the exact cubic") == 2
    for r in rows:
        assert r.method == "exact" or f"{r.error:.4e}" in text


def test_slower_than_the_exact_cubic_is_said_by_degree():
    def row(experiment, method, build, point):
        return control_points.Row(experiment, method, 0, 0.0, 1.0, 0.0, build, point)

    rows = [row(e, "exact", 3.0, 1.0) for e in experiments.EXPERIMENTS]
    rows += [row(e, f"minimal_cost_{m}", m - 2.0, 1.0) for e in experiments.EXPERIMENTS for m in control_points.DEGREES]
    for line in control_points._slower(rows).splitlines():
        assert line.endswith("longer than the exact cubic to build in degree 6, 7, for a point in no degree.")


def test_figure_shows_every_row_and_names_round_off(rows):
    figure = pytest.importorskip("matplotlib.figure")
    drawn = pytest.importorskip("stiefel_rs.reproduce.control_points_figure")
    smallest = drawn.SMALLEST_EXCESS
    for experiment in experiments.EXPERIMENTS:
        ax = figure.Figure().add_subplot()
        drawn._draw(experiment, rows, "excess", ax=ax)
        own = [r for r in rows if r.experiment is experiment and r.method != "exact"]
        values = [y for line in ax.lines for y in line.get_ydata()]
        assert sorted(values) == sorted(max(r.excess, smallest) for r in own)
        assert len(ax.texts) == sum(r.excess < smallest for r in own)


def test_figure(rows, tmp_path):
    drawn = pytest.importorskip("stiefel_rs.reproduce.control_points_figure")
    done = []
    paths = drawn.write(tmp_path, rows, lambda: done.append(1))
    assert [p.name for p in paths] == ["control_points.png", "control_points.svg", "control_points.pdf"]
    assert all(p.stat().st_size > 5000 for p in paths) and done == [1]
