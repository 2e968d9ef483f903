"""Claims of the text of arXiv 2404.19407 that no other test measures."""

import itertools

import numpy as np
import pytest
from paper import EPS, assert_close

from stiefel_rs import Geodesic, GeometricCubic, Stiefel
from stiefel_rs.reproduce import experiments, readings

STEPS = (10, 20, 50, 100)


@pytest.fixture(scope="module", params=experiments.EXPERIMENTS, ids=lambda e: e.name)
def experiment(request):
    return request.param


@pytest.fixture(scope="module")
def rows(experiment):
    return [experiments.mean_errors(experiment, n) for n in STEPS]


def distances(experiment, method, steps):
    """Distances of one method to the reference on the grid."""
    states = experiments.reference(experiment, steps)
    found = experiments.solve(experiment, method, steps, states[0], states[-1])
    return experiments.distances(found, experiments.points(experiment, states))


def test_geodesics_are_complete(rng):
    for shape in ((3, 1), (3, 2), (5, 2), (4, 4)):
        M = Stiefel(*shape)
        S = M.random_point(rng)
        curve = Geodesic.from_velocity(S, M.random_tangent(S, rng))
        for t in (-100.0, 100.0):
            bound = 32 * M.n * EPS
            M.check_point(curve(t), atol=bound)
            speeds = [M.norm(curve(s), curve.velocity(s)) for s in (0.0, t)]
            assert_close(speeds[1], speeds[0], bound * speeds[0], f"speed at {t}")


def circle(angle):
    return np.array([[np.cos(angle)], [np.sin(angle)]])


def test_de_casteljau_is_exact_only_where_the_manifold_is_flat(rng):
    t = np.linspace(0, 1, 11)
    for a, v, w in rng.uniform(-1.2, 1.2, (20, 3)):
        turn = np.array([[0.0, -1.0], [1.0, 0.0]])
        curve = GeometricCubic(circle(0.0), v * turn @ circle(0.0), circle(a), w * turn @ circle(a))
        exact = v * t + (3 * a - 2 * v - w) * t**2 + (v + w - 2 * a) * t**3
        assert_close(curve(t), [circle(x) for x in exact], 32 * EPS, "St(2,1): the cubic polynomial of the angle")
    for e, least in ((experiments.SPHERE, 9e-5), (experiments.STIEFEL_3_2, 4e-3)):
        error = distances(e, "gcp", 100).mean()
        assert error > least, f"{e.title}: mean error {error:.3e}"


def test_relative_mean_errors():
    sphere, frames = (distances(e, "gcp", 100).mean() for e in experiments.EXPERIMENTS)
    percent = [100 * frames, 100 * frames / np.sqrt(8), 100 * sphere, 100 * sphere / 2]
    # 0.45 % is the mean error itself.
    assert [f"{x:.2g}" for x in percent] == ["0.45", "0.16", "0.011", "0.0054"]
    own = [r for r in readings.measure(STEPS) if r.experiment is experiments.SPHERE]
    for name, x in (value for reading in own for value in reading.values()):
        assert not 0.00075 < x < 0.00085, f"0.080 % follows from a reading: {100 * x:.3f} % ({name})"


def test_errors_of_the_integrators_grow_with_the_step(rows):
    for method in experiments.METHODS[1:]:
        errors = [row.errors[method] for row in rows]
        assert all(a > b for a, b in itertools.pairwise(errors)), f"{method}: {errors}"


def test_errors_near_the_initial_point(experiment):
    gcp, first, second = (distances(experiment, m, 100) for m in ("gcp", "initial_point_ivp", "midpoint_ivp"))
    for error in (first, second):
        assert error[10] < 0.1 * error[100], f"at t = 0.1 {error[10]:.2e}, at t = 1 {error[100]:.2e}"
    ratio = (second[1:11] / gcp[1:11]).max()
    assert ratio < 0.1, f"mid-point over GCP up to t = 0.1: {ratio:.3f}"
    ratio = (first[1:6] / gcp[1:6]).min()
    assert ratio > 1, f"initial-point over GCP up to t = 0.05: {ratio:.3f}"


def test_gcp_does_not_depend_on_the_step(experiment):
    start, end = experiments.reference(experiment, 1)
    coarse, fine = (experiments.solve(experiment, "gcp", n, start, end) for n in (10, 100))
    assert_close(fine[::10], coarse, 8 * EPS, "points at the times of both grids")


def test_midpoint_beats_initial_point(rows):
    for row in rows:
        for problem in ("ivp", "bvp"):
            ratio = row.errors[f"midpoint_{problem}"] / row.errors[f"initial_point_{problem}"]
            assert ratio < 0.1, f"N = {row.steps}, {problem}: {ratio:.3f}"


def test_shooting_integrates_more_than_once(experiment):
    chart, d = experiment.chart, experiment.chart.d
    start, end = experiments.reference(experiment, 1)
    assert experiments.geometric_cubic(experiment, start, end).report is None
    for step_map in experiments.MAPS:
        report = chart.shoot(start[:d], start[d : 2 * d], end[:d], end[d : 2 * d], 20, step_map).report
        assert 1 <= report.iterations <= 5, f"{report!r}"
