"""The first page of the report: every verdict follows from the numbers, and changes with them."""

from dataclasses import replace

import numpy as np
import pytest

from stiefel_rs.reproduce import challenges, claims, experiments, measurements, near_start, readings
from stiefel_rs.reproduce.measurements import Settings


@pytest.fixture(scope="module")
def found():
    return measurements.measure(Settings((5, 20), 1, 2, 1, quick=True), lambda: None)


def verdict(claim, found):
    return claim(found).verdict


def with_geometry(found, **values):
    return replace(found, geometry=replace(found.geometry, **values))


def with_errors(found, change):
    rows = {
        name: [replace(r, errors={m: change(m, r.steps, x) for m, x in r.errors.items()}) for r in own]
        for name, own in found.rows.items()
    }
    return replace(found, rows=rows)


def with_times(found, change):
    timing = [replace(t, ratio=change(t.method, t.steps)) for t in found.timing]
    return replace(found, timing=timing)


def test_every_claim_has_a_number_and_a_verdict(found):
    rows = claims.read(found)
    assert len(rows) == len(claims.CLAIMS) == len({r.statement for r in rows})
    for row in rows:
        assert row.verdict.startswith((claims.HOLDS, claims.FAILS, claims.ANSWERED)) or row.verdict == claims.OPEN
        assert row.verdict == claims.OPEN or any(c.isdigit() for c in row.measured)
    page = claims.page(rows)
    # A bar in a cell would start another column.
    assert {line.count("|") for line in page.splitlines()} == {len(claims.HEADER) + 2}
    assert [row[0] for row in claims.csv_rows(found)] == [claim.__name__ for claim in claims.CLAIMS]


def test_geometry(found):
    assert verdict(claims.quasi_geodesics, found) == claims.HOLDS
    assert verdict(claims.quasi_geodesics, with_geometry(found, sphere_distance=0.1)) == claims.FAILS
    assert "X S Omega = 0" in verdict(claims.remark, found)
    assert verdict(claims.remark, with_geometry(found, counterexample=(1.0, 1.0, 0.1))) == claims.HOLDS
    assert "pi/2" in verdict(claims.joining, found)
    assert verdict(claims.joining, with_geometry(found, joined=(200, 200))) == claims.HOLDS
    assert verdict(claims.joining, with_geometry(found, joined=(199, 0))) == claims.FAILS
    assert verdict(claims.end_data, found) == claims.HOLDS
    assert verdict(claims.end_data, with_geometry(found, end_defect=1e-6)) == claims.FAILS
    assert verdict(claims.symplectic, found) == claims.HOLDS
    assert verdict(claims.symplectic, with_geometry(found, symplectic=1e-3)) == claims.FAILS
    assert verdict(claims.sphere_hamiltonian, found) == claims.HOLDS
    assert verdict(claims.sphere_hamiltonian, with_geometry(found, sphere_hamiltonian=0.1)) == claims.FAILS
    assert "one bracket" in verdict(claims.hamiltonian, found)
    assert verdict(claims.hamiltonian, with_geometry(found, hamiltonian=(0.1, 0.1))) == claims.FAILS
    assert verdict(claims.below_euclidean, found) == claims.HOLDS
    assert verdict(claims.below_euclidean, with_geometry(found, circle_error=1e-3)) == claims.FAILS


def test_percentages(found):
    assert verdict(claims.sphere_error, found) == "does not hold under any reading tried"
    assert verdict(claims.frame_error, found).startswith("holds only if undivided: 0.45 % coincides")

    def scaled(factor):
        own = [replace(r, errors=tuple(factor * x for x in r.errors)) for r in found.readings]
        return replace(found, readings=own)

    # In the paper's terms: the mean error divided by the largest Frobenius distance.
    error = next(r.errors[0] for r in found.readings if r.experiment is experiments.SPHERE and r.name == readings.USED)
    assert verdict(claims.sphere_error, scaled(2 * 0.0008 / error)) == claims.HOLDS
    assert verdict(claims.frame_error, scaled(2 * np.sqrt(2))) == claims.HOLDS


def test_steps(found):
    assert verdict(claims.independent_of_the_step, found) == claims.HOLDS
    halved = with_errors(found, lambda m, n, x: x * 5 / n if m == "gcp" else x)
    assert verdict(claims.independent_of_the_step, halved) == claims.FAILS
    assert verdict(claims.increasing_in_the_step, found) == claims.HOLDS
    constant = with_errors(found, lambda m, n, x: 1.0 if m == "midpoint_ivp" else x)
    assert verdict(claims.increasing_in_the_step, constant) == claims.FAILS
    one = replace(found, settings=replace(found.settings, steps=(5,)), rows={n: r[:1] for n, r in found.rows.items()})
    assert verdict(claims.independent_of_the_step, one) == verdict(claims.increasing_in_the_step, one) == claims.OPEN
    assert verdict(claims.midpoint_wins, found) == claims.HOLDS
    worse = with_errors(found, lambda m, n, x: 1.0 if m == "midpoint_ivp" else x)
    assert verdict(claims.midpoint_wins, worse) == claims.FAILS


def test_near_the_start(found):
    assert "order is 2 or more" in verdict(claims.near_the_start, found)

    def scaled(methods, factor):
        rows = [
            replace(r, near=tuple(factor * x for x in r.near)) if r.method in methods else r for r in found.near_start
        ]
        return replace(found, near_start=rows)

    assert verdict(claims.near_the_start, scaled(("initial_point_ivp", "initial_point_bvp"), 1e-6)) == claims.HOLDS
    assert verdict(claims.near_the_start, scaled(near_start.METHODS[1:], 1e6)) == claims.FAILS
    # Without the orders reached by compositions, none can be chosen.
    flat = [replace(r, near=r.near[:1] * 5) if r.method == "composed_4" else r for r in found.near_start]
    assert verdict(claims.near_the_start, replace(found, near_start=flat)) == claims.FAILS
    assert "by mid-point IVP" in verdict(claims.near_the_start, scaled(("midpoint_bvp",), 1e6))


def test_difficulties_that_are_overcome(found):
    def with_shapes(**values):
        return replace(found, shapes=[replace(r, **values) for r in found.shapes])

    assert verdict(claims.euler_lagrange, found) == "answered: solved to round-off"
    assert verdict(claims.euler_lagrange, with_shapes(residual=1e-3)) == claims.HOLDS
    assert verdict(claims.general_hamiltonian, found).startswith("answered: mu . x")
    assert verdict(claims.general_hamiltonian, with_shapes(distance=1e-3)) == claims.HOLDS
    assert "round-off" in verdict(claims.numerical_errors, found)
    worse = [replace(r, largest=(1e-9,) * 5) if r.method == "composed_6" else r for r in found.near_start]
    assert verdict(claims.numerical_errors, replace(found, near_start=worse)) == claims.HOLDS


def test_conjecture(found):
    def always(factor):
        errors = [
            replace(e, error=factor if e.retraction != "linear in coordinates" else 1.0) for e in found.study.errors
        ]
        return replace(found, study=replace(found.study, errors=errors))

    assert verdict(claims.better_retractions, always(0.5)) == claims.HOLDS
    assert verdict(claims.better_retractions, always(2.0)) == claims.FAILS
    one = [
        replace(e, error=1.1) if e.retraction == "Cayley" and e.curve == "random 1" else e
        for e in always(0.5).study.errors
    ]
    mixed = replace(found, study=replace(found.study, errors=one))
    assert "only on average" in verdict(claims.better_retractions, mixed)


def test_times(found):
    slow = with_times(found, lambda m, n: 1.0 if m == "gcp" else 10.0)
    assert verdict(claims.more_effort, slow) == claims.HOLDS
    large = with_times(found, lambda m, n: 10.0 if m.endswith("bvp") or n == 20 else 1.0)
    assert verdict(claims.more_effort, large) == "holds only if boundary values are met, or N is at least 20"
    with_shooting = with_times(found, lambda m, n: 10.0 if m.endswith("bvp") else 1.0)
    assert verdict(claims.more_effort, with_shooting) == "holds only if boundary values are met"
    assert verdict(claims.more_effort, with_times(found, lambda m, n: 1.0)) == claims.FAILS

    equal = [replace(x, steps=10, seconds=3.0, gcp_seconds=1.0) for x in found.equal_error]
    assert verdict(claims.much_faster, replace(slow, equal_error=equal)) == claims.HOLDS
    near = [replace(x, seconds=1.5) for x in equal]
    assert verdict(claims.much_faster, replace(slow, equal_error=near)) == "holds only if compared at equal N"
    assert verdict(claims.much_faster, with_times(found, lambda m, n: 1.0)) == claims.FAILS

    def seconds(shooting):
        return replace(
            found, timing=[replace(t, seconds=shooting if t.method.endswith("bvp") else 1.0) for t in found.timing]
        )

    assert verdict(claims.shooting, seconds(2.0)) == claims.HOLDS
    assert verdict(claims.shooting, seconds(0.5)) == claims.FAILS


def test_challenges(found):
    assert verdict(claims.single_chart, found) == "holds for the chart method; answered by both others"

    def at_pole(error, methods):
        poles = [replace(r, error=error) if r.method in methods else r for r in found.challenges.poles]
        return replace(found, challenges=replace(found.challenges, poles=poles))

    assert verdict(claims.single_chart, at_pole(None, challenges.METHODS)) == claims.HOLDS
    assert verdict(claims.single_chart, at_pole(1e-6, ("one_chart",))) == claims.FAILS

    def taking(ratio):
        equal = [replace(r, seconds=1.0 if r.method == "splitting" else ratio) for r in found.challenges.equal]
        return replace(found, challenges=replace(found.challenges, equal=equal))

    assert verdict(claims.implicit_equations, taking(10.0)) == "holds; answered by the splittings"
    assert verdict(claims.implicit_equations, taking(1.0)) == claims.FAILS
    assert verdict(claims.homogeneous, taking(10.0)) == claims.HOLDS
    assert verdict(claims.homogeneous, taking(0.5)) == claims.FAILS


def test_submanifold_of_euclidean_space(found):
    def verdict_with(cost, rows=found.embedded):
        equal = [replace(r, seconds=cost if r.method == "embedded" else 1.0) for r in found.challenges.equal]
        changed = replace(found, challenges=replace(found.challenges, equal=equal), embedded=rows)
        return verdict(claims.embedded, changed)

    assert verdict_with(10.0) == "holds: it can be done, but a splitting is much faster"
    assert verdict_with(1.0) == "holds: it can be done"
    # One curve of order 1, or one run that leaves the constraints, is enough.
    slow = [
        replace(r, error=r.error * r.steps) if (r.manifold, r.method) == ("St(5,2)", "embedded") else r
        for r in found.embedded
    ]
    assert verdict_with(10.0, slow) == verdict_with(1.0, slow) == claims.FAILS
    # The errors of the others do not affect the verdict.
    others = [replace(r, error=1.0) if r.method != "embedded" else r for r in found.embedded]
    assert verdict_with(1.0, others) == "holds: it can be done"
    last = found.embedded[-1]
    assert last.method == "embedded"
    assert verdict_with(1.0, [*found.embedded[:-1], replace(last, defect=1e-9)]) == claims.FAILS
    one = [r for r in found.embedded if r.steps == 5]
    assert verdict_with(10.0, one) == claims.OPEN


def test_control_points(found):
    assert verdict(claims.other_control_points, found) == "holds: it helps"
    worse = [replace(r, error=1.0) if r.method == "minimal_cost_4" else r for r in found.control_points]
    assert verdict(claims.other_control_points, replace(found, control_points=worse)) == claims.FAILS
