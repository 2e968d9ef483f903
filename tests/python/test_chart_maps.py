"""Discretization maps by name and order, covariant data, and curves across charts."""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest

import stiefel_rs
from stiefel_rs import Chart, InvalidInputError, OutsideDomainError, Stiefel
from stiefel_rs.reproduce import experiments, flows

EPS = np.finfo(float).eps
CHARTS = {"sphere": Chart.sphere(), "frame": Chart.frame()}
CUBICS = [c for c in json.loads((Path(__file__).parents[1] / "data" / "cubics.json").read_text()) if c["n"] == 3]
KEYS = ("point", "velocity", "acceleration", "jerk")
ROTATIONAL = ["exponential", "cayley", "quasi_geodesic"]
MAPS = ["initial_point", "midpoint", *ROTATIONAL, *(f"{name}_midpoint" for name in ROTATIONAL)]


@pytest.fixture(params=CHARTS)
def chart(request):
    return CHARTS[request.param]


@pytest.fixture
def experiment(chart):
    return next(e for e in experiments.EXPERIMENTS if e.chart == chart)


@pytest.fixture
def z0(experiment):
    return experiments.initial_state(experiment)


def orthogonal(rng):
    return np.linalg.qr(rng.standard_normal((3, 3)))[0]


@pytest.mark.parametrize("name", MAPS)
def test_discretize(chart, rng, name):
    d, shape = chart.d, (4, 5)
    x, v = rng.standard_normal((*shape, 2 * chart.d)), 0.3 * rng.standard_normal((*shape, 2 * chart.d))
    x[..., 0] = rng.uniform(0.8, 2.3, shape)
    pair = chart.discretize(x, v, name)
    assert pair.shape == (*shape, 2, 2 * d)
    back = 0.5 if "midpoint" in name else 0.0
    for end, part in ((0, -back), (1, 1 - back)):
        found = pair[..., end, :]
        if part == 0:
            assert np.array_equal(found, x)
        elif name in ("initial_point", "midpoint"):
            np.testing.assert_allclose(found, x + part * v, atol=8 * EPS)
        else:
            S, V = chart.embed(x[..., :d]), chart.embed_velocity(x[..., :d], part * v[..., :d])
            M, kind = Stiefel(3, chart.k), name.removesuffix("_midpoint")
            exact = M.exp(S, V) if kind == "exponential" else M.retract(S, V, kind=kind)
            np.testing.assert_allclose(chart.embed(found[..., :d]), exact, atol=1e-13)


@pytest.mark.parametrize("name", MAPS)
def test_orders(chart, z0, name):
    exact = chart.reference(z0, [1.0])[0]
    base = 2 if "midpoint" in name else 1
    ranges = {1: (100, 400), 2: (50, 200), 4: (24, 72), 6: (8, 20)}
    for order, steps in ranges.items():
        if order < base:
            continue
        asked = None if order == base else order
        errors = [np.linalg.norm(chart.integrate(z0, n, map=name, order=asked)[-1] - exact) for n in steps]
        slope = np.log(errors[0] / errors[1]) / np.log(steps[1] / steps[0])
        assert abs(slope - order) < 0.2 + 0.05 * order, f"{name}: order {slope:.3f}, expected {order}"
    best = chart.integrate(z0, 60, map=name, order=8)[-1]
    np.testing.assert_allclose(best, exact, atol=1e-11)


def test_shooting_with_every_map_and_order(chart, z0):
    d = chart.d
    end = chart.reference(z0, [1.0])[0]
    for name, order in [*zip(MAPS, itertools.repeat(None)), ("exponential_midpoint", 4), ("cayley", 4)]:
        result = chart.shoot(z0[:d], z0[d : 2 * d], end[:d], end[d : 2 * d], 20, name, order=order)
        assert result.report.converged and result.report.iterations <= 5, f"{name}: {result.report!r}"
        assert np.array_equal(chart.integrate(result.trajectory[0], 20, map=name, order=order), result.trajectory)
        if order == 4:
            np.testing.assert_allclose(np.concatenate(result.momenta), z0[2 * d :], atol=1e-3)


def test_covariant_data_and_states(chart, experiment, rng):
    z = rng.standard_normal((3, 4, 4 * chart.d))
    z[..., 0] = rng.uniform(0.4, 2.7, (3, 4))
    parts = chart.covariant(z)
    assert [p.shape for p in parts] == [(3, 4, 3, chart.k)] * 4
    np.testing.assert_array_equal(parts[0], chart.embed(z[..., : chart.d]))
    for i in np.ndindex(3, 4):
        back = chart.state(*(p[i] for p in parts))
        angles = slice(1, chart.d)
        back[angles] += 2 * np.pi * np.round((z[i][angles] - back[angles]) / (2 * np.pi))
        # sin(theta)^-2 <= 7 in the inverse metric, entries up to 30.
        np.testing.assert_allclose(back, z[i], atol=1e-12)
        path = chart.reference_across(*(p[i] for p in parts), 0.0)
        np.testing.assert_allclose(path.momentum, flows.spatial_momentum(experiment, z[i]), atol=1e-11)
        np.testing.assert_allclose(path.energy, chart.hamiltonian(z[i]), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("entry", CUBICS, ids=lambda c: c.get("name", f"St3_{c['k']}"))
def test_reference_across_the_poles_against_forty_digits(entry, rng):
    chart = CHARTS["sphere" if entry["k"] == 1 else "frame"]
    at = {0.0: entry["initial"], **{float(t): values for t, values in entry["at"].items()}}
    turns = [orthogonal(rng) for _ in range(5)]
    for values in at.values():
        # A reflection that maps the point at this time to the pole.
        w = np.array(values["point"])[:, 0] - [0, 0, 1]
        turns.append(np.eye(3) - 2 * np.outer(w, w) / (w @ w))
    for R in turns:
        data = [R @ np.array(entry["initial"][key]) for key in KEYS]
        path = chart.reference_across(*data, list(at))
        for i, values in enumerate(at.values()):
            for key in KEYS:
                np.testing.assert_allclose(getattr(path, key)[i], R @ np.array(values[key]), atol=1e-12)
        np.testing.assert_allclose(path.energy, path.energy[0], atol=1e-12)
        np.testing.assert_allclose(path.momentum, np.broadcast_to(path.momentum[0], (3, 3)), atol=1e-12)


def test_trajectory_across_charts(chart):
    # Over both poles and back: a geodesic, and a cubic close to it.
    S = chart.embed([np.pi / 2, 0.0, 0.0][: chart.d])
    V = chart.embed_velocity([np.pi / 2, 0.0, 0.0][: chart.d], [-2 * np.pi, 0.1, 0.0][: chart.d])
    A = chart.embed_velocity([np.pi / 2, 0.0, 0.0][: chart.d], [0.5, -0.3, 0.2][: chart.d])
    data = (S, V, A, -A)
    exact = chart.reference_across(*data, np.linspace(0, 1, 61))
    path = chart.integrate_across(*data, 60, map="exponential_midpoint", order=8)
    assert len(path.transitions) >= 1
    assert path.point.shape == (61, 3, chart.k) and path.states.shape == (61, 4 * chart.d)
    for key in KEYS:
        # 17 stages per step; the highest derivative grows to 40.
        np.testing.assert_allclose(getattr(path, key), getattr(exact, key), atol=1e-9)
    np.testing.assert_allclose(path.momentum, np.broadcast_to(path.momentum[0], (61, 3)), atol=1e-10)
    embedded = chart.embed(path.states[:, : chart.d])
    np.testing.assert_allclose(path.rotations @ path.point, embedded, atol=8 * EPS)
    np.testing.assert_allclose(path.energy, chart.hamiltonian(path.states), rtol=0)
    changes = [i for i in range(1, 61) if not np.array_equal(path.rotations[i], path.rotations[i - 1])]
    assert path.transitions == changes
    assert np.sin(path.states[:, 0]).min() >= 0.5
    assert "changes of chart" in repr(path)
    with pytest.raises(OutsideDomainError):
        # The curve runs through the pole of one chart.
        chart.reference(
            chart.state(S, chart.embed_velocity([np.pi / 2, 0, 0][: chart.d], [-8, 0, 0][: chart.d]), 0 * A, 0 * A),
            [1.0],
        )


def test_linear_maps_run_through_the_poles_too(chart):
    S = np.eye(3)[:, [2, 0]][:, : chart.k]
    V = np.array([[0.0, 0.3], [1.0, 0.0], [0.0, 0.0]])[:, : chart.k]
    V = Stiefel(3, chart.k).project_tangent(S, V)
    A = Stiefel(3, chart.k).project_tangent(S, np.ones((3, chart.k)))
    exact = chart.reference_across(S, V, A, 0 * A, [1.0]).point[0]
    errors = [
        np.linalg.norm(chart.integrate_across(S, V, A, 0 * A, n, map="midpoint").point[-1] - exact) for n in (50, 400)
    ]
    assert abs(np.log(errors[0] / errors[1]) / np.log(8) - 2) < 0.2, errors


def test_bad_input(chart, z0):
    with pytest.raises(InvalidInputError, match=r"'initial_point'.*'exponential_midpoint'.*found 'euler'"):
        chart.integrate(z0, 3, map="euler")
    for name, order in [("midpoint", 1), ("midpoint", 3), ("cayley", -4), ("cayley", 10**15), ("initial_point", 0)]:
        with pytest.raises(InvalidInputError, match="order"):
            chart.integrate(z0, 3, map=name, order=order)
    S, V, A, J = chart.covariant(z0)
    with pytest.raises(InvalidInputError, match="not tangent"):
        chart.integrate_across(S, V, S, J, 3)
    with pytest.raises(InvalidInputError, match="not orthonormal"):
        chart.state(2 * S, V, A, J)
    with pytest.raises(InvalidInputError, match="steps"):
        chart.integrate_across(S, V, A, J, 0)
    with pytest.raises(InvalidInputError, match="not finite"):
        chart.reference_across(S, V, A, J, [0.0, np.nan])
    with pytest.raises(InvalidInputError, match="not finite"):
        chart.reference_across(S, np.nan * V, A, J, 1.0)
    with pytest.raises(InvalidInputError, match="S"):
        chart.state(np.eye(4)[:, : chart.k], V, A, J)
    pole = np.eye(3)[:, [2, 0]][:, : chart.k]
    with pytest.raises(OutsideDomainError):
        chart.state(pole, 0 * V, 0 * V, 0 * V)
    assert chart.integrate_across(pole, 0 * V, 0 * V, 0 * V, 2).point.shape == (3, 3, chart.k)
    with pytest.raises(InvalidInputError):
        chart.discretize(z0, z0)
    with pytest.raises((stiefel_rs.ConvergenceError, OutsideDomainError, InvalidInputError)):
        chart.integrate_across(S, V, A, 1e200 * J, 3)
    with pytest.raises(stiefel_rs.StiefelError):
        chart.reference_across(S, V, 1e200 * A, J, 0.0)
    for huge in (1e8, 1e300):
        with pytest.raises(stiefel_rs.StiefelError):
            chart.reference_across(S, huge * V, A, J, 1e9)
