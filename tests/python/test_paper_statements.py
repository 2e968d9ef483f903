"""Measures of the report other than mean errors: readings, the start of the curves, geometry, challenges."""

import numpy as np
import pytest

from stiefel_rs import Stiefel
from stiefel_rs.reproduce import any_shape, challenges, embedded, experiments, geometry, near_start, readings

each_experiment = pytest.mark.parametrize("experiment", experiments.EXPERIMENTS, ids=lambda e: e.name)


@pytest.fixture(scope="module")
def measured():
    return geometry.measure()


def test_readings_are_divided_by_nothing_and_by_both_diameters():
    found = readings.measure((10, 100))
    own = [r for r in found if r.experiment is experiments.STIEFEL_3_2]
    assert len(own) == 7 and len({r.name for r in own}) == 7
    used = next(r for r in own if r.name == readings.USED)
    # Printed to five digits by an independent program.
    table = [experiments.STIEFEL_3_2.independent[n][0] for n in (10, 100)]
    np.testing.assert_allclose(used.errors[:2], [table[1], np.mean(table)], rtol=1e-4)
    mean = [value for name, value in used.values() if "mean error" in name]
    np.testing.assert_allclose(mean, used.errors[0] / np.array([1, 2 * np.sqrt(2), np.pi]), rtol=1e-14)
    name, value = readings.nearest(found, experiments.STIEFEL_3_2)
    assert (name, value) in readings.coinciding(found, experiments.STIEFEL_3_2)
    assert not readings.coinciding(found, experiments.SPHERE)


@pytest.mark.parametrize(("value", "same"), [(0.000804, True), (0.000796, True), (0.00081, False), (0.00079, False)])
def test_values_coincide_where_they_round_to_what_is_printed(value, same):
    assert readings.coincides(experiments.SPHERE, value) is same


def test_orders_near_the_start():
    rows = near_start.measure()
    expected = {"gcp": 0, "initial_point_ivp": 1, "initial_point_bvp": 1, "midpoint_ivp": 2, "midpoint_bvp": 2}
    expected |= {"composed_4": 4, "composed_6": 6, "splitting_2": 2, "splitting_4": 4}
    for r in rows:
        if r.method in expected:
            assert r.order == pytest.approx(expected[r.method], abs=0.2), (r.experiment.name, r.method)
    # A single fixed curve: the same error at the same time.
    gcp = near_start.of(rows, experiments.SPHERE, "gcp").near
    np.testing.assert_allclose(gcp, gcp[0], rtol=1e-9)


def test_the_counterexample_of_the_remark_is_one(measured):
    X, omega, distance = measured.counterexample
    assert X > 1 and omega > 1 and distance < 1e-14


def test_proposition_1_joins_near_points_only(measured):
    assert measured.joined == (geometry.SAMPLES, 0)


def test_quasi_geodesics_and_geodesics_by_their_formulas(measured):
    assert measured.sphere_distance < 1e-14
    assert 0.1 < measured.frame_distance < 1


def test_the_step_of_another_method_is_not_symplectic(measured, monkeypatch):
    assert measured.symplectic < geometry.DIFFERENCE_BOUND

    class Damped:
        """A chart whose steps lose a thousandth of every momentum."""

        d = experiments.SPHERE.chart.d

        def integrate(self, z, *arguments):
            found = experiments.SPHERE.chart.integrate(z, *arguments)
            return found * np.repeat([1.0, 0.999], 2 * self.d)

    chart = experiments.SPHERE.chart
    damped = type("Damped", (), {"chart": Damped(), "name": "damped"})()
    monkeypatch.setattr(experiments, "initial_state", lambda _: np.concatenate([[1.2, 3.0], np.full(6, 0.3)]))
    assert chart.d == Damped.d
    assert geometry.symplectic_defect(damped, "midpoint") > 1e-4


def test_the_printed_hamiltonians_one_needs_its_bracket(measured):
    assert measured.sphere_hamiltonian < 1e-13
    one, two = measured.hamiltonian
    assert one < 1e-12 and two > 0.1


def test_flat_and_curved(measured):
    # Angles up to 2 and speeds up to 2, in points of length 1.
    assert measured.circle_error < 1e-13
    assert measured.end_defect < 1e-13


@each_experiment
@pytest.mark.parametrize("angle", [0.0, 0.05])
def test_turned_curves_are_at_the_angle_from_the_pole(experiment, angle):
    R = challenges.rotation(experiment, angle)
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-14)
    middle = R @ experiments.points(experiment, experiments.reference(experiment, 2))[1]
    assert np.arccos(np.clip(middle[2, 0], -1, 1)) == pytest.approx(angle, abs=1e-7)


def test_challenges():
    found = challenges.measure(1)
    for r in found.poles:
        fails = r.angle == 0 and r.method == "one_chart"
        assert (r.error is None) is fails
        # Order 2 at N = 100: methods that need no chart, or avoid the poles, are not affected by them.
        assert r.method == "one_chart" or r.error < 1e-5
    for e in experiments.EXPERIMENTS:
        plain, near = (challenges.of(found.poles, e, "one_chart", angle=angle).error for angle in (None, 0.02))
        assert near > 30 * plain
    for r in found.equal:
        target = challenges.TARGETS[r.order]
        assert r.error <= target
        assert r.steps == challenges.LEAST_STEPS or r.error > target / 2**r.order / 2
    header, rows = challenges.csv_table(found)
    assert all(len(row) == len(header) for row in rows)


def test_embedded_method_beside_the_others():
    rows = embedded.measure((10, 20), 1)
    assert embedded.manifolds(rows) == ["sphere", "St(3,2)", "St(5,2)"]
    for manifold in embedded.manifolds(rows):
        names = embedded.WITHOUT_CHART if manifold == "St(5,2)" else tuple(challenges.LABELS)
        assert {r.method for r in rows if r.manifold == manifold} == set(names)
        for name in names:
            assert embedded.slope(rows, manifold, name) == pytest.approx(2, abs=0.2)
    # Frobenius norms over a few steps.
    assert embedded.largest_defect(rows) < 1e-14
    for r in rows:
        assert (r.defect is None) is (r.method != "embedded")
        assert r.error < 1e-2 and r.seconds > 0
    for method in ("one_chart", "across"):
        assert len(embedded.against(rows, method, "error")) == 4
    assert len(embedded.against(rows, "splitting", "seconds")) == 6
    # Twice the errors of the chart method on the paper's curves.
    assert embedded.against(rows, "one_chart", "error") == pytest.approx([2] * 4, abs=0.6)
    assert all(len(row) == len(embedded.HEADER) for row in embedded.csv_rows(rows))
    one = embedded.measure((10,), 1)
    assert embedded.slope(one, "sphere") is None and "None" not in embedded.section(one)


def test_smallest_number_of_steps():
    assert challenges.steps_for(lambda n: 1 / n**2, 2, 1e-4) == 100
    assert challenges.steps_for(lambda n: 1 / n**2 + 1 / n**3, 2, 1e-4) == 101
    assert challenges.steps_for(lambda n: 1e-9, 2, 1e-4) == challenges.LEAST_STEPS


def test_cubics_of_any_shape_agree_with_the_splitting():
    for n, k in ((4, 2), (6, 6)):
        row = any_shape.measure_shape(n, k, 1)
        S0, V0, S1, V1 = any_shape.problem(n, k)
        manifold = Stiefel(n, k)
        assert float(manifold.dist(S0, S1)) == pytest.approx(any_shape.DISTANCE)
        assert float(manifold.norm(S0, V0)) == pytest.approx(any_shape.SPEED)
        assert float(manifold.norm(S1, V1)) == pytest.approx(any_shape.SPEED)
        assert max(row.distance, row.defect) < 1e-13 and row.residual <= experiments.BOUNDARY_TOLERANCE
