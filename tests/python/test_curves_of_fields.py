"""Ends, joints, and derivatives by the data, of curves of real subspaces, complex subspaces and complex frames."""

import itertools

import numpy as np
import pytest
from complex_frames import H, assert_close, normal, skew, walk
from scipy.linalg import expm
from test_subspaces import knots

from stiefel_rs import CubicSpline, Grassmann, RiemannianCubic, Stiefel

SUBSPACES = [
    Grassmann(3, 1),
    Grassmann(5, 2),
    Grassmann(3, 2),
    Grassmann(8, 3),
    Grassmann(2, 1, field="complex"),
    Grassmann(4, 2, field="complex"),
    Grassmann(5, 3, field="complex"),
]
FRAMES = [Stiefel(n, k, field="complex") for n, k in [(1, 1), (3, 1), (4, 2), (3, 3), (9, 2)]]
TIMES = np.array([0.0, 1.0, 1.8, 3.0, 4.1])


def points(M):
    """Five points; of subspaces by randomly rotated bases."""
    return knots(M) if isinstance(M, Grassmann) else walk(M.n, M.k, 5)[1]


@pytest.mark.parametrize("M", [*SUBSPACES, *FRAMES], ids=repr)
@pytest.mark.parametrize("ends", ["natural", "clamped", "velocities"])
def test_joints_are_twice_differentiable(M, ends):
    """Covariant velocities and accelerations of both pieces at each knot; third derivatives jump."""
    Y = points(M)
    V = 0.3 * M.random_tangent(Y[[0, -1]], rng=1)
    bc_type = ((1, V[0]), (1, V[1])) if ends == "velocities" else ends
    curve = CubicSpline(TIMES, Y, bc_type, manifold=M)
    # Pieces have the interval [0, 1].
    widths = np.diff(TIMES)
    assert all(piece.t_span == (0.0, 1.0) for piece in curve.pieces)
    for i, (before, after) in enumerate(itertools.pairwise(curve.pieces)):
        left, right = widths[i], widths[i + 1]
        assert_close(before(1.0), after(0.0), 1e-14, f"point of knot {i + 1}")
        assert_close(before.velocity(1.0) / left, after.velocity(0.0) / right, 1e-14, f"velocity of knot {i + 1}")
        # Accelerations are at most 5; measured at most 4e-14.
        jump = before.acceleration(1.0) / left**2 - after.acceleration(0.0) / right**2
        assert_close(jump, 0.0, 5e-13, f"acceleration of knot {i + 1}")
        assert abs(before.jerk(1.0) / left**3 - after.jerk(0.0) / right**3).max() > 0.1
    if ends == "natural":
        assert_close(curve.acceleration(TIMES[[0, -1]]), 0.0, 5e-13, "accelerations of the ends")


@pytest.mark.parametrize("M", [*SUBSPACES, *FRAMES], ids=repr)
def test_clamped_ends_are_at_rest(M):
    Y = points(M)
    clamped, natural = (CubicSpline(TIMES, Y, ends, manifold=M) for ends in ("clamped", "natural"))
    assert clamped.bc_type == "clamped"
    # Measured at most 7e-16.
    assert_close(clamped.velocity(TIMES[[0, -1]]), 0.0, 1e-14, "velocities of the ends")
    assert abs(natural.velocity(TIMES[[0, -1]])).max(axis=(-2, -1)).min() > 0.1
    # Natural ends have the least cost of all; these curves pass through the same points.
    assert natural.cost() < clamped.cost()
    for Y0, at in zip(Y, TIMES, strict=True):
        end = clamped(at)
        Q = H(Y0) @ end if isinstance(M, Grassmann) else np.eye(M.k)
        assert_close(end, Y0 @ Q, 1e-14, f"point at {at}")


# ---------------------------------------------------------------- derivatives by the data


def pairing(gradients, changes):
    """Re sum(conj(G) * X), of all matrices."""
    return sum(np.sum(np.conj(G) * X).real for G, X in zip(gradients, changes, strict=True))


def difference(values, h):
    """Fourth-order difference of values at -2 h, -h, h and 2 h."""
    return (8 * (values[2] - values[1]) - values[3] + values[0]) / (12 * h)


def generator(M, rng):
    """A unit skew or skew-Hermitian matrix of size n."""
    X = skew(normal(rng, M.n, M.n) if M.field == "complex" else rng.standard_normal((M.n, M.n)))
    return X / np.linalg.norm(X)


def change(X, *data):
    """The changes of a basis and vectors at it along a one-parameter group, with the basis changed horizontally."""
    turn = H(data[0]) @ X @ data[0]
    return [X @ part - part @ turn for part in data]


# Differences of fourth order have errors of 1e-10, relative to the derivatives.
H_STEP = 1e-3
STEPS = H_STEP * np.array([-2, -1, 1, 2])
SMALL = [Grassmann(3, 1), Grassmann(5, 2), *(Grassmann(n, k, field="complex") for n, k in [(2, 1), (3, 2), (4, 2)])]
AT = np.array([0.3, 0.8])


@pytest.mark.parametrize("M", SMALL, ids=repr)
def test_derivatives_by_boundary_data(M):
    rng, (Y0, Y1) = np.random.default_rng(3), knots(M, 2, seed=1)
    V0, V1 = (0.7 * M.random_tangent(Y, rng=2) for Y in (Y0, Y1))
    curve = RiemannianCubic.from_boundary(Y0, V0, Y1, V1, manifold=M)
    # In the basis of the curve at its end.
    Y1, V1 = curve(1.0), curve.velocity(1.0)
    X, Z = generator(M, rng), generator(M, rng)
    W0, W1 = M.random_tangent(Y0, rng), M.random_tangent(Y1, rng)
    dY0, dV0 = change(X, Y0, V0)
    dY1, dV1 = change(Z, Y1, V1)
    changes = (dY0, dV0 + W0, dY1, dV1 + W1)
    moved = []
    for s in STEPS:
        E0, E1 = expm(s * X), expm(s * Z)
        ends = E0 @ Y0, E0 @ (V0 + s * W0), E1 @ Y1, E1 @ (V1 + s * W1)
        moved.append(RiemannianCubic.from_boundary(*ends, tol=1e-14, manifold=M))
    found = curve.point_variation(AT, *changes)
    expected = difference([M.align(curve(AT), other(AT)) for other in moved], H_STEP)
    assert_close(M.project_tangent(curve(AT), found), found, 1e-14, "horizontal")
    scale = max(1.0, abs(found).max())
    assert_close(found, M.project_tangent(curve(AT), expected), 1e-9 * scale, "points")

    def initial(other):
        """The initial data in the basis nearest to Y0."""
        U, _, Wh = np.linalg.svd(H(other(0.0)) @ Y0)
        return np.stack(other.initial) @ (U @ Wh)

    slopes = difference([initial(other) for other in moved], H_STEP)
    for part, slope in zip(curve.initial_variation(*changes), slopes, strict=True):
        assert_close(part, slope, 1e-8 * max(1.0, abs(slope).max()), "initial data")
    cost = difference([other.cost() for other in moved], H_STEP)
    assert_close(pairing(curve.cost_gradient(), changes), cost, 2e-10 * max(1.0, abs(cost)), "cost")
    W = M.random_tangent(curve(AT), rng)
    assert_close(pairing(curve.point_pullback(AT, W), changes), pairing([W], [found]), 2e-14 * scale, "pull-back")


@pytest.mark.parametrize("M", SMALL, ids=repr)
def test_derivatives_by_initial_data(M):
    rng, Y = np.random.default_rng(4), M.random_point(rng=5)
    data = [Y, *(M.random_tangent(Y, rng=seed) for seed in (6, 7, 8))]
    added = [0 * Y, *(M.random_tangent(Y, rng=seed) for seed in (9, 10, 11))]
    curve, X = RiemannianCubic.from_initial(*data, manifold=M), generator(M, rng)
    changes = [a + b for a, b in zip(change(X, *data), added, strict=True)]
    moved = []
    for s in STEPS:
        parts = [expm(s * X) @ (part + s * more) for part, more in zip(data, added, strict=True)]
        moved.append(RiemannianCubic.from_initial(*parts, manifold=M))
    found = curve.initial_point_variation(AT, *changes)
    expected = difference([M.align(curve(AT), other(AT)) for other in moved], H_STEP)
    scale = max(1.0, abs(found).max())
    assert_close(found, M.project_tangent(curve(AT), expected), 1e-9 * scale, "points")
    W = M.random_tangent(curve(AT), rng)
    gradient = curve.initial_point_pullback(AT, W)
    assert_close(pairing(gradient, changes), pairing([W], [found]), 2e-14 * scale, "pull-back")
