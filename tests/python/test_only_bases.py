"""Frames that are far apart only because their columns are rotated: errors name the Grassmann manifold and `align`."""

import re

import numpy as np
import pytest

from stiefel_rs import (
    ConvergenceError,
    CubicSpline,
    GeometricCubic,
    Grassmann,
    OutsideDomainError,
    QuasiGeodesic,
    RiemannianCubic,
    SmoothingSpline,
    Stiefel,
)

HINT = r"the nearest bases of their spans are (\S+) times as far apart: .*Grassmann manifold.*align"


def turned_bases(n, k, count, field="real", seed=0):
    """Bases of subspaces 0.3 apart along a geodesic, each turned at random."""
    rng = np.random.default_rng(seed)
    M, U = Grassmann(n, k, field=field), Stiefel(k, k, field=field)
    Y = M.random_point(rng)
    V = M.random_tangent(Y, rng)
    V *= 0.3 / M.norm(Y, V)
    return np.array([M.exp(Y, i * V) @ U.random_point(rng) for i in range(count)])


def assert_advised(caught, S0, S1):
    found = re.search(HINT, str(caught.value))
    assert found, str(caught.value)
    field = "complex" if np.iscomplexobj(S0) else "real"
    frames, bases = [np.linalg.norm(S - S0) for S in (S1, Grassmann(*S0.shape, field=field).align(S0, S1))]
    assert abs(float(found.group(1)) - bases / frames) <= 6e-4


# Opposite columns: no shortest geodesic and no quasi-geodesic joins them as frames; the subspaces are the same.
S0 = np.eye(6, 2)
PAIRS = {
    "log": lambda: Stiefel(6, 2).log(S0, -S0),
    "dist": lambda: Stiefel(6, 2).dist(S0, -S0),
    "quasi-geodesic": lambda: QuasiGeodesic(S0, -S0),
    "polar": lambda: Stiefel(6, 2).inverse_retract(S0, -S0, kind="polar"),
    "cayley": lambda: Stiefel(6, 2).inverse_retract(S0, -S0, kind="cayley"),
    "qr": lambda: Stiefel(6, 2).inverse_retract(S0, -S0, kind="qr"),
    "geometric cubic": lambda: GeometricCubic(S0, 0 * S0, -S0, 0 * S0),
    "geometric spline": lambda: CubicSpline([0.0, 1.0, 2.0], [S0, -S0, S0], kind="geometric"),
    "smoothing two": lambda: SmoothingSpline([0.0, 1.0], [S0, -S0], lam=1.0),
}


@pytest.mark.parametrize("name", PAIRS)
def test_opposite_columns(name):
    with pytest.raises((OutsideDomainError, ConvergenceError), match=HINT) as caught:
        PAIRS[name]()
    assert_advised(caught, S0, -S0)


@pytest.mark.parametrize("seed", [0, 4, 5])
def test_uneven_times_do_not_hide_it(seed):
    rng = np.random.default_rng(seed)
    frames, S = [], np.linalg.qr(rng.standard_normal((6, 3)))[0]
    for _ in range(10):
        S = np.linalg.qr(S + 0.02 * rng.standard_normal((6, 3)))[0]
        frames.append(S @ np.linalg.qr(rng.standard_normal((3, 3)))[0])
    t = np.cumsum(rng.choice([1.0, 30.0], 10))
    with pytest.raises((OutsideDomainError, ConvergenceError), match=HINT) as caught:
        CubicSpline(t, frames)
    assert "interval" not in str(caught.value)


@pytest.mark.parametrize("field", ["real", "complex"])
@pytest.mark.parametrize("bc_type", ["natural", "periodic"])
def test_splines_through_turned_bases(field, bc_type):
    # Too many dimensions for descents, which find splines through turned bases too.
    Y = turned_bases(20, 3 if field == "complex" else 4, 6, field)
    if bc_type == "periodic":
        Y[-1] = Y[0]
    with pytest.raises(ConvergenceError, match=HINT) as caught:
        CubicSpline(np.arange(6.0), Y, bc_type=bc_type)
    knot = int(re.search(r"knots (\d) and", str(caught.value)).group(1))
    assert caught.value.knot == knot
    assert_advised(caught, Y[knot], Y[knot + 1])
    assert not caught.value.report.converged


def test_what_the_hint_says_helps():
    Y = turned_bases(20, 3, 6)
    M, t = Grassmann(20, 3), np.arange(6.0)
    spline = CubicSpline(t, Y, manifold=M)
    aligned = [Y[0]]
    for basis in Y[1:]:
        aligned.append(M.align(aligned[-1], basis))
    frames = CubicSpline(t, aligned)
    # The points lie on a geodesic, which has no cost.
    assert spline.cost() < 1e-20
    assert frames.cost() < 1e-20
    np.testing.assert_allclose(M.projector(spline(2.5)), M.projector(frames(2.5)), atol=1e-10)


def test_no_hint_for_frames_as_far_apart_as_their_subspaces():
    with pytest.raises(OutsideDomainError) as caught:
        Stiefel(6, 2).inverse_retract(S0, np.eye(6, 2, -2), kind="polar")
    assert "their spans" not in str(caught.value)
    # Rotations are no bases: their subspaces are all the same.
    with pytest.raises(OutsideDomainError) as caught:
        Stiefel(3, 3).log(np.eye(3), np.diag([1.0, -1.0, -1.0]))
    assert "their spans" not in str(caught.value)


def spinning(n, k, count, angle, noise=0.02):
    """Frames whose first two columns turn in their plane by about so much from one to the next, with noise."""
    rng = np.random.default_rng(3)
    M, angles = Stiefel(n, k), np.cumsum(angle * (1 + 0.1 * rng.standard_normal(count)))
    S = np.zeros((count, n, k))
    S[:, np.arange(k), np.arange(k)] = 1.0
    S[:, 0, 0], S[:, 0, 1] = np.cos(angles), -np.sin(angles)
    S[:, 1, 0], S[:, 1, 1] = np.sin(angles), np.cos(angles)
    return M.retract(S, noise * M.random_tangent(S, rng))


@pytest.mark.parametrize(("n", "k", "count"), [(3, 2, 100), (8, 2, 60), (60, 2, 12)])
def test_frames_that_spin_are_solved_although_they_look_like_bases(n, k, count):
    S = spinning(n, k, count, 1.2)
    t = np.arange(float(count))
    spline = CubicSpline(t, S)
    np.testing.assert_allclose(spline(t), S, atol=1e-12)
    smooth = SmoothingSpline(t, S, lam=0.1)
    assert smooth.report.converged
    assert 0 < smooth.cost() < spline.cost()


def test_one_turned_pair_is_not_blamed_for_another_leg():
    S = spinning(20, 2, 8, 0.1, noise=0.0)
    # One pair is turned far; the ends of another leg are opposite.
    turn = np.array([[np.cos(2.0), -np.sin(2.0)], [np.sin(2.0), np.cos(2.0)]])
    S[2:] = S[2:] @ turn
    S[6:] = 0
    S[6:, 5, 0], S[6:, 6, 1] = 1.0, 1.0
    with pytest.raises(ConvergenceError) as caught:
        CubicSpline(np.arange(8.0), S, max_iterations=1)
    assert "their spans" not in str(caught.value)


def test_boundary_problem():
    Y = turned_bases(30, 8, 2)
    V = np.zeros_like(Y[0])
    with pytest.raises(ConvergenceError, match=HINT) as caught:
        RiemannianCubic.from_boundary(Y[0], V, Y[1], V, max_iterations=1)
    assert_advised(caught, Y[0], Y[1])
