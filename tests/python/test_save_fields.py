"""Files and pickles of curves of real subspaces, complex subspaces and complex frames restore every bit."""

import pickle

import numpy as np
import pytest
from complex_frames import walk
from test_save import assert_same
from test_subspaces import knots

import stiefel_rs
from stiefel_rs import (
    CubicHermite,
    CubicSpline,
    Geodesic,
    GeometricCubic,
    GeometricPolynomial,
    Grassmann,
    RiemannianCubic,
    SmoothingSpline,
    Stiefel,
    integrate_cubic,
)

MANIFOLDS = [
    Grassmann(3, 1),
    Grassmann(5, 2),
    Grassmann(2, 1, field="complex"),
    Grassmann(5, 2, field="complex"),
    Stiefel(1, 1, field="complex"),
    Stiefel(4, 2, field="complex"),
]
CURVES = {
    "natural": lambda t, Y, V, M: CubicSpline(t, Y, manifold=M),
    "periodic": lambda t, Y, V, M: CubicSpline(t, [*Y[:-1], Y[0]], "periodic", manifold=M),
    "end vectors": lambda t, Y, V, M: CubicSpline(t, Y, ((1, V[0]), (2, V[-1])), extrapolate=True, manifold=M),
    "in tension": lambda t, Y, V, M: CubicSpline(t, Y, tension=3.0, manifold=M),
    "geometric spline": lambda t, Y, V, M: CubicSpline(t[:3], Y[:3], kind="geometric", manifold=M),
    "Hermite": lambda t, Y, V, M: CubicHermite(t, Y, V, manifold=M),
    "smoothing": lambda t, Y, V, M: SmoothingSpline(t, Y, lam=0.1, manifold=M),
    "geodesic": lambda t, Y, V, M: Geodesic(Y[0], Y[1], manifold=M),
    "geodesic polynomial": lambda t, Y, V, M: GeometricPolynomial(Y[:4], pieces="geodesic", manifold=M),
    "geometric cubic": lambda t, Y, V, M: GeometricCubic(Y[0], V[0], Y[1], V[1], pieces="geodesic", manifold=M),
    "initial": lambda t, Y, V, M: RiemannianCubic.from_initial(Y[0], V[0], V[0], -V[0], 2.0, manifold=M).reversed(),
    "boundary": lambda t, Y, V, M: RiemannianCubic.from_boundary(Y[0], V[0], Y[1], V[1], manifold=M),
}


def data(M):
    """Times, points and vectors; random bases of subspaces."""
    t = np.array([0.0, 1.0, 1.8, 3.0, 4.1])
    if isinstance(M, Grassmann):
        Y = knots(M)
        return t, Y, 0.3 * M.random_tangent(Y, rng=1)
    _, S, V = walk(M.n, M.k, 5)
    return t, S, V


@pytest.mark.parametrize("M", MANIFOLDS, ids=repr)
@pytest.mark.parametrize("name", CURVES)
def test_the_same_curve_comes_back(name, M, tmp_path):
    original = CURVES[name](*data(M), M)
    assert original.manifold == M
    path, second = tmp_path / "curve.npz", tmp_path / "second.npz"
    original.save(path)
    loaded = stiefel_rs.load(path)
    for again in (loaded, pickle.loads(pickle.dumps(original))):
        # Including attributes and pieces.
        assert_same(again, original)
        assert again.manifold == M
        assert again.field == M.field
        for piece in again.pieces if isinstance(again, stiefel_rs.PiecewiseCurve) else ():
            assert piece.manifold == M
    # Nothing is lost by saving once more.
    loaded.save(second)
    with np.load(path) as first, np.load(second) as other:
        assert {name: (x.shape, x.tobytes()) for name, x in first.items()} == {
            name: (x.shape, x.tobytes()) for name, x in other.items()
        }


@pytest.mark.parametrize("M", MANIFOLDS, ids=repr)
def test_restored_curves_are_differentiated_alike(M, tmp_path):
    """Pull-backs depend on everything that a curve was made of."""
    t, Y, V = data(M)
    spline, cubic = CubicSpline(t, Y, manifold=M), RiemannianCubic.from_boundary(Y[0], V[0], Y[1], V[1], manifold=M)
    for original, at in ((spline, [0.4, 2.2]), (cubic, [0.4, 0.9])):
        original.save(tmp_path / "curve.npz")
        W = np.array([M.project_tangent(original(s), w) for s, w in zip(at, V[:2], strict=True)])
        for again in (stiefel_rs.load(tmp_path / "curve.npz"), pickle.loads(pickle.dumps(original))):
            for found, expected in zip(again.point_pullback(at, W), original.point_pullback(at, W), strict=True):
                assert np.array_equal(found, expected) or found == expected == (None, None)


@pytest.mark.parametrize("M", MANIFOLDS, ids=repr)
def test_trajectories(M):
    _, Y, V = data(M)
    original = integrate_cubic(Y[0], V[0], V[0], -V[0], 8, manifold=M)
    again = pickle.loads(pickle.dumps(original))
    for name in ("t", "point", "velocity", "acceleration", "jerk", "energy"):
        found, expected = getattr(again, name), getattr(original, name)
        assert found.dtype == expected.dtype
        assert np.array_equal(found, expected)
    assert (again.momentum_drift, again.constraint_drift) == (original.momentum_drift, original.constraint_drift)
