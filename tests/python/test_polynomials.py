"""Geometric polynomials: what is refused, and with which numbers."""

import numpy as np
import pytest

from stiefel_rs import GeometricCubic, GeometricPolynomial, InvalidInputError, OutsideDomainError, Stiefel

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
    # Found: jumps of 0.03 and 0.06 at t = 0.985 and t = 0.022, between the points of a coarser grid.
    rng, manifold = np.random.default_rng(seed), Stiefel(5, 2)
    degree = int(rng.integers(4, 13))
    points = [manifold.random_point(rng)]
    for _ in range(degree):
        step = manifold.random_tangent(points[-1], rng)
        length = rng.uniform(2.3, 3.1) / np.linalg.norm(step, 2)
        points.append(manifold.retract(points[-1], step * length))
    with pytest.raises(OutsideDomainError, match="no smooth curve: at t = ") as caught:
        GeometricPolynomial(points)
    assert caught.value.angle == np.pi
