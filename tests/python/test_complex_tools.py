"""Complex frames in the tools around the core: Dask, pymanopt, the command line, figures."""

import argparse

import numpy as np
import pytest
from complex_frames import H, assert_close, normal, walk

import stiefel_rs
from stiefel_rs import (
    CubicHermite,
    CubicSpline,
    RiemannianCubic,
    Stiefel,
    interpolate,
)

T, S, V = walk(3, 2, 6)


# ---------------------------------------------------------------- Dask


@pytest.fixture
def batches():
    pytest.importorskip("dask")
    from stiefel_rs import dask  # noqa: PLC0415

    return dask


def test_boundary_problems_of_a_batch(batches):
    sweep = batches.solve_boundary(S[:-1], V[:-1], S[1:], V[1:], t=[0.0, 0.5], chunk=2)
    curve = RiemannianCubic.from_boundary(S[2], V[2], S[3], V[3])
    assert sweep["J"].dtype == sweep["points"].dtype == np.complex128
    assert sweep["cost"].dtype == np.float64
    assert_close(sweep["J"].compute()[2], curve.initial[3], 0.0, "jerk")
    assert_close(sweep["points"].compute()[2, 1], curve(0.5), 0.0, "point")
    assert_close(sweep["cost"].compute()[2], curve.cost(), 0.0, "cost")
    bad = S[1:].copy()
    bad[1] *= 1.1
    marked = batches.solve_boundary(S[:-1], V[:-1], bad, V[1:], on_error="mark")
    assert np.isnan(marked["A"].compute()[1]).all()
    assert marked["code"].compute().tolist() == [0, 1, 0, 0, 0]


def test_splines_and_points_of_a_batch(batches):
    sweep = batches.splines(T, np.stack([S, S.conj()]), at=[T[0], T[-1]])
    curve = CubicSpline(T, S)
    assert_close(sweep["velocities"].compute()[0], curve.velocity(T), 0.0, "velocities")
    assert_close(sweep["points"].compute()[1, 1], S[-1].conj(), 1e-11, "conjugate points")
    hermite = batches.splines(T, S, V, at=[T[0] + 0.3])["points"].compute()
    assert_close(hermite[0], CubicHermite(T, S, V)(T[0] + 0.3), 0.0, "given velocities")
    points = batches.evaluate([0.0, 1.0], S, V, 0.5 * V, -V).compute()
    assert points.dtype == np.complex128
    assert_close(points[3, 1], RiemannianCubic.from_initial(S[3], V[3], 0.5 * V[3], -V[3])(1.0), 0.0, "points")


def test_maps_of_a_batch(batches):
    M, lazy = Stiefel(3, 2, field="complex"), batches.Stiefel(3, 2, field="complex")
    assert repr(lazy) == "stiefel_rs.dask.Stiefel(3, 2, metric=0.0, field='complex')"
    assert_close(lazy.exp(S, V).compute(), M.exp(S, V), 0.0, "exponential")
    assert_close(lazy.retract(S, V, "qr").compute(), M.retract(S, V, "qr"), 0.0, "retraction")
    assert lazy.norm(S, V).compute().dtype == np.float64
    X, Omega = lazy.decompose(S, V)
    assert X.compute().shape == (6, 3, 3)
    assert_close(Omega.compute(), M.decompose(S, V)[1], 0.0, "Omega")
    found, report = lazy.log_report(S[:-1], S[1:])
    assert_close(found.compute(), M.log(S[:-1], S[1:]), 0.0, "logarithm")
    assert_close(report["length"].compute(), M.dist(S[:-1], S[1:]), 0.0, "length")
    with pytest.raises(TypeError, match="S: expected real numbers"):
        batches.Stiefel(3, 2).norm(S, V)


# ---------------------------------------------------------------- pymanopt


def test_eigenvalues_by_trust_regions():
    """The least eigenvalues of a Hermitian matrix, by exact gradients and Hessians."""
    pymanopt = pytest.importorskip("pymanopt")
    from pymanopt.optimizers import TrustRegions  # noqa: PLC0415

    from stiefel_rs.pymanopt import StiefelManifold  # noqa: PLC0415

    A = normal(np.random.default_rng(1), 6, 6)
    A = A + H(A)
    M = StiefelManifold(6, 2, field="complex", rng=1)
    assert M.dim == 20
    numpy = pymanopt.function.numpy(M)
    problem = pymanopt.Problem(
        M,
        numpy(lambda S: np.trace(H(S) @ A @ S).real),
        euclidean_gradient=numpy(lambda S: 2 * A @ S),
        euclidean_hessian=numpy(lambda S, V: 2 * A @ V),
    )
    found = TrustRegions(verbosity=0).run(problem)
    assert_close(found.cost, np.linalg.eigvalsh(A)[:2].sum(), 1e-9, "sum of the least eigenvalues")
    assert M.zero_vector(found.point).dtype == np.complex128
    with pytest.raises(ValueError, match="determinant"):
        StiefelManifold(2, 2, field="complex", determinant=1)


def test_geometry_is_that_of_the_unitary_group_of_pymanopt():
    """Euclidean metric: inner products, projections, and logarithms in the Lie algebra."""
    group = pytest.importorskip("pymanopt.manifolds").UnitaryGroup(3)
    U = Stiefel(3, 3, metric="euclidean", field="complex")
    rng = np.random.default_rng(2)
    X, Z = U.random_point(rng), normal(rng, 3, 3)
    # pymanopt represents tangent vectors by elements of the algebra, X^H V; its `projection` in 2.2.1 is for real
    # matrices.
    A, B = (group.to_tangent_space(X, H(X) @ Y) for Y in (Z, normal(rng, 3, 3)))
    assert_close(U.project_tangent(X, Z), X @ A, 1e-14, "projection")
    assert_close(U.inner(X, X @ A, X @ B), group.inner_product(X, A, B), 1e-13, "inner product")
    assert_close(U.exp(X, X @ A), group.exp(X, A), 1e-13, "exponential")
    small = A / 4
    assert_close(U.dist(X, U.exp(X, X @ small)), group.dist(X, group.exp(X, small)), 1e-12, "distance")


# ---------------------------------------------------------------- command line and figures


def run(*words):
    parser = argparse.ArgumentParser()
    interpolate.add_parser(parser.add_subparsers())
    arguments = parser.parse_args(["interpolate", *map(str, words)])
    arguments.check(arguments)
    return interpolate.run(arguments)


@pytest.mark.parametrize("kind", ["riemannian", "hermite", "geometric", "smoothing"])
def test_command_line(kind, tmp_path, capsys):
    points, out, samples = (tmp_path / name for name in ("points.npz", "curve.npz", "samples.npz"))
    np.savez(points, t=T, S=S, V=V)
    command = [points, "--kind", kind, "--out", out, *["--lam", "0.1"] * (kind == "smoothing")]
    assert run(*command, "--num", "5", "--samples", samples) == 0
    assert "St(3,2,C), 6 points" in capsys.readouterr().out
    curve = stiefel_rs.load(out)
    assert curve.field == "complex"
    with np.load(samples) as found:
        assert found["S"].dtype == found["A"].dtype == np.complex128
        assert (found["S"] == curve(found["t"])).all()
    assert run(*command, "--plot", tmp_path / "figure.svg") == 1
    assert "--plot draws real frames" in capsys.readouterr().err
