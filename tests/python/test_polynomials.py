"""Geometric polynomials: refusals, and the numbers in their errors."""

import numpy as np
import pytest

from stiefel_rs import (
    GeometricCubic,
    GeometricPolynomial,
    InvalidInputError,
    OutsideDomainError,
    QuasiGeodesic,
    Stiefel,
)

M = Stiefel(4, 2)
S = np.eye(4, 2)
S1 = np.array([[0, 0], [0, 1], [1, 0], [0, 0.0]])
V = np.array([[0, -1], [1, 0], [2, 0], [0, -1.0]])


@pytest.mark.parametrize("points", [2, 3, 5])
def test_a_cubic_has_four_control_points(points):
    with pytest.raises(InvalidInputError, match=f"4 control points, found {points}"):
        GeometricCubic.from_control_points([S] * points)


@pytest.mark.parametrize("pieces", ["", "Geodesic", "line"])
def test_unknown_pieces(pieces):
    with pytest.raises(InvalidInputError, match="pieces: expected"):
        GeometricPolynomial([S, S1], pieces=pieces)


def test_control_points_beyond_the_injectivity_radius_say_how_far():
    far = M.exp(S, 3.0 / M.norm(S, V) * V)
    with pytest.raises(OutsideDomainError, match="injectivity radius") as caught:
        GeometricPolynomial([S, far], pieces="geodesic")
    assert caught.value.angle > 0.89 * np.pi


@pytest.mark.parametrize("seed", [416, 511])
def test_a_curve_that_would_jump_is_refused_with_the_parameter(seed):
    # Regression: jumps of 0.03 and 0.06 at t = 0.985 and t = 0.022, between the points of a coarser grid.
    rng, manifold = np.random.default_rng(seed), Stiefel(5, 2)
    degree = int(rng.integers(4, 13))
    points = [manifold.random_point(rng)]
    for _ in range(degree):
        step = manifold.project_tangent(points[-1], rng.standard_normal((5, 2)))
        length = rng.uniform(2.3, 3.1) / np.linalg.norm(step, 2)
        points.append(manifold.retract(points[-1], step * length))
    with pytest.raises(OutsideDomainError, match="no smooth curve: at t = ") as caught:
        GeometricPolynomial(points)
    assert caught.value.angle == np.pi


def boundary(manifold, rng, speed=1.0):
    """End points a step of length 1 apart, with random end velocities of the given length."""

    def tangent(point, length):
        v = manifold.random_tangent(point, rng)
        return v * (length / manifold.norm(point, v))

    start = manifold.random_point(rng)
    end = manifold.retract(start, tangent(start, 1.0))
    return start, tangent(start, speed), end, tangent(end, speed)


@pytest.mark.parametrize("shape", [(3, 1), (3, 2), (5, 2), (3, 3)])
def test_minimal_cost_meets_its_data_and_costs_less(shape):
    manifold = Stiefel(*shape)
    data = boundary(manifold, np.random.default_rng(1))
    cubic = GeometricCubic(*data)
    for degree in (4, 6):
        curve = GeometricPolynomial.minimal_cost(*data, degree=degree)
        assert type(curve) is GeometricPolynomial
        assert (curve.degree, curve.pieces) == (degree, "quasi_geodesic")
        for t, point, velocity in ((0.0, *data[:2]), (1.0, *data[2:])):
            np.testing.assert_allclose(curve(t), point, atol=1e-13)
            np.testing.assert_allclose(curve.velocity(t), velocity, atol=1e-12)
        assert curve.report.converged and curve.report.residual <= curve.report.tolerance
        assert 1 <= curve.report.iterations <= 10
        assert curve.cost() < cubic.cost()
    assert cubic.report is None and GeometricPolynomial([data[0], data[2]]).report is None


def test_minimal_cost_takes_array_likes_and_degree_five_by_default():
    curve = GeometricPolynomial.minimal_cost([[1], [0]], [[0], [1]], [[0], [1]], [[1], [0]])
    assert curve.degree == 5 and curve.n == 2


@pytest.mark.parametrize("degree", [-1, 0, 2, 11, 10**9])
def test_minimal_cost_of_no_degree(degree):
    with pytest.raises(InvalidInputError, match=f"degree: must be from 3 to 10, found {degree}"):
        GeometricPolynomial.minimal_cost(S, 0 * V, S1, 0 * S1, degree=degree)


@pytest.mark.parametrize(
    ("n", "k", "degree", "work"), [(400, 40, 4, 5580 * 6 * 160 * 40**2), (14, 12, 10, 630 * 45 * 14 * 12**2)]
)
def test_minimal_cost_that_would_take_minutes_is_refused_with_its_work(n, k, degree, work):
    data = boundary(Stiefel(n, k), np.random.default_rng(2))
    with pytest.raises(InvalidInputError, match=r"work of the search.*at most 1\.1e7 .*lower degree.*found") as error:
        GeometricPolynomial.minimal_cost(*data, degree=degree)
    assert float(str(error.value).rsplit(" ", 1)[1]) == pytest.approx(work, rel=1e-3)


@pytest.mark.parametrize("name", ["V0", "S1"])
def test_minimal_cost_refuses_bad_input(name):
    data = dict(zip(("S0", "V0", "S1", "V1"), boundary(M, np.random.default_rng(3)), strict=True))
    with pytest.raises(InvalidInputError, match=f"{name}: entry 0 is not finite"):
        GeometricPolynomial.minimal_cost(**(data | {name: np.full((4, 2), np.nan)}))
    with pytest.raises(InvalidInputError, match=f"{name}: expected shape"):
        GeometricPolynomial.minimal_cost(**(data | {name: np.zeros((5, 2))}))
    with pytest.raises(TypeError):
        GeometricPolynomial.minimal_cost(**(data | {name: np.zeros((4, 2), dtype=str)}))


@pytest.mark.parametrize("shape", [(3, 1), (3, 2), (5, 2), (9, 2), (3, 3)])
def test_quintic_meets_its_data(shape):
    manifold, rng = Stiefel(*shape), np.random.default_rng(4)
    s0, v0, s1, v1 = boundary(manifold, rng)
    a0, a1 = 2 * manifold.random_tangent(s0, rng), 2 * manifold.random_tangent(s1, rng)
    curve = GeometricPolynomial.quintic(s0, v0, a0, s1, v1, a1)
    assert curve.degree == 5
    for t, point, velocity, acceleration in ((0.0, s0, v0, a0), (1.0, s1, v1, a1)):
        np.testing.assert_allclose(curve(t), point, atol=1e-13)
        np.testing.assert_allclose(curve.velocity(t), velocity, atol=1e-12)
        np.testing.assert_allclose(curve.acceleration(t), acceleration, atol=1e-11)


def test_quintic_of_a_quasi_geodesic_is_it():
    line = QuasiGeodesic.from_velocity(S, V / 2)
    data = [f(t) for t in (0.0, 1.0) for f in (line, line.velocity, line.acceleration)]
    t = np.linspace(0, 1, 20)
    np.testing.assert_allclose(GeometricPolynomial.quintic(*data)(t), line(t), atol=1e-14)


def test_quintics_join_with_continuous_acceleration():
    manifold, rng = Stiefel(5, 2), np.random.default_rng(5)
    s0, v0, s1, v1 = boundary(manifold, rng)
    s2 = manifold.retract(s1, v1)
    v2, a = 0 * s2, [manifold.random_tangent(s, rng) for s in (s0, s1, s2)]
    before = GeometricPolynomial.quintic(s0, v0, a[0], s1, v1, a[1])
    after = GeometricPolynomial.quintic(s1, v1, a[1], s2, v2, a[2])
    np.testing.assert_allclose(before(1.0, nu=2), after(0.0, nu=2), atol=1e-11)


def test_quintic_refuses_accelerations_that_are_not_tangent_or_too_long():
    rest = (S, 0 * V, S1, 0 * S1)
    with pytest.raises(InvalidInputError, match="A0: not tangent"):
        GeometricPolynomial.quintic(S, 0 * V, S, *rest[2:], 0 * V)
    with pytest.raises(InvalidInputError, match="A0: must be small enough"):
        GeometricPolynomial.quintic(S, 0 * V, 1e9 * V, *rest[2:], 0 * V)


@pytest.mark.parametrize("shape", [(3, 1), (3, 2), (5, 2), (4, 3), (3, 3)])
def test_cubic_of_geodesics_meets_its_data(shape):
    manifold = Stiefel(*shape)
    data = boundary(manifold, np.random.default_rng(6))
    curve = GeometricCubic(*data, pieces="geodesic")
    assert (curve.pieces, curve.degree) == ("geodesic", 3)
    for t, point, velocity in ((0.0, *data[:2]), (1.0, *data[2:])):
        np.testing.assert_allclose(curve(t), point, atol=1e-13)
        np.testing.assert_allclose(curve.velocity(t), velocity, atol=1e-12)
    s0, v0, s1, v1 = data
    control_points = [s0, manifold.exp(s0, v0 / 3), manifold.exp(s1, -v1 / 3), s1]
    np.testing.assert_allclose(curve.control_points, control_points, atol=1e-14)
    t = np.linspace(0, 1, 150)
    same = GeometricPolynomial(control_points, pieces="geodesic")
    np.testing.assert_allclose(curve(t), same(t), atol=1e-13)


def test_cubic_of_unknown_pieces():
    with pytest.raises(InvalidInputError, match="pieces: expected"):
        GeometricCubic(S, 0 * V, S1, 0 * S1, pieces="line")


def test_cubic_of_geodesics_refuses_velocities_beyond_the_injectivity_radius():
    fast = V * (9.0 / M.norm(S, V))
    with pytest.raises(InvalidInputError, match=r"V0: must be shorter than three times .* found 9"):
        GeometricCubic(S, fast, S1, 0 * S1, pieces="geodesic")
