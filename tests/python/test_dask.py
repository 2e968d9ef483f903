"""Batches over dask arrays: bit-identical to a single process."""

import pickle

import numpy as np
import pytest
from dask_problem import COUNT, M, T, assert_same, cluster, random_ends, solved

import stiefel_rs
from stiefel_rs import (
    CubicHermite,
    CubicSpline,
    GeometricCubic,
    InvalidInputError,
    OutsideDomainError,
    RiemannianCubic,
)

dask = pytest.importorskip("dask")
distributed = pytest.importorskip("distributed")
zarr = pytest.importorskip("zarr")

import dask.array as da  # noqa: E402

from stiefel_rs import dask as batches  # noqa: E402
from stiefel_rs.dask import _boundary  # noqa: E402

# Some tests do not use the cluster while it is running.
pytestmark = pytest.mark.filterwarnings("ignore:Running on a single-machine scheduler:UserWarning")


@pytest.fixture(scope="module")
def client():
    with cluster() as connected:
        yield connected


@pytest.fixture(scope="module")
def ends():
    return random_ends(COUNT)


@pytest.fixture(scope="module")
def expected(ends):
    return solved(ends)


@pytest.mark.parametrize("chunk", [1, 7, COUNT, 1000])
@pytest.mark.parametrize("kind", ["riemannian", "geometric"])
def test_boundary_problems_give_the_bits_of_one_process(client, ends, expected, kind, chunk):
    sweep = batches.solve_boundary(*ends, kind=kind, t=T, fields=list(expected[kind]), chunk=chunk)
    assert sweep.records.npartitions == -(-COUNT // min(chunk, COUNT))
    (found,) = dask.compute(dict(sweep))
    assert set(found) == set(expected[kind])
    assert_same(found, expected[kind])
    for name, array in sweep.items():
        assert (array.shape, array.dtype.kind) == (found[name].shape, found[name].dtype.kind), name


def test_default_fields(ends):
    exact = batches.solve_boundary(*ends)
    assert set(exact) == {"S", "V", "A", "J", "cost", "converged", "iterations", "residual", "code", "message"}
    assert set(batches.solve_boundary(*ends, kind="geometric", t=0.5)) == set(exact) - {"cost"} | {"points"}
    assert list(batches.solve_boundary(*ends, fields=["residual", "cost"])) == ["cost", "residual"]


def test_options_reach_the_solver(ends):
    S0, V0, S1, V1 = ends
    loose = batches.solve_boundary(*ends, tol=1e-4, fields=["iterations"])["iterations"].compute()
    expected = [RiemannianCubic.from_boundary(*data, tol=1e-4).report.iterations for data in zip(*ends, strict=True)]
    np.testing.assert_array_equal(loose, expected)
    points = batches.solve_boundary(*ends, kind="geometric", pieces="geodesic", t=0.5, fields="points")["points"]
    curve = GeometricCubic(S0[3], V0[3], S1[3], V1[3], pieces="geodesic")
    np.testing.assert_array_equal(points[3].compute(), curve(0.5))


def test_leading_axes_broadcast(client, ends):
    S0, V0, S1, V1 = ends
    speeds = np.array([0.5, 1.0, 1.5])[:, None, None, None]
    sweep = batches.solve_boundary(S0[:4], V0[:4], S1[:4], speeds * da.from_array(V1[:4], chunks=(2, 5, 2)), chunk=3)
    assert sweep.shape == (3, 4)
    assert sweep["A"].chunks == ((1, 1, 1), (3, 1), (5,), (2,))
    cost = sweep["cost"].compute()
    for i, j in np.ndindex(3, 4):
        assert cost[i, j] == RiemannianCubic.from_boundary(S0[j], V0[j], S1[j], speeds[i, 0] * V1[j]).cost()
    fixed = batches.solve_boundary(S0[0], V0[0], S1[0], speeds[:, 0] * V1[0], kind="geometric", t=T)["points"]
    np.testing.assert_array_equal(fixed[1].compute(), GeometricCubic(S0[0], V0[0], S1[0], V1[0])(T))


@pytest.mark.parametrize("count", [None, 0])
def test_one_problem_and_none(ends, tmp_path, count):
    data = [array[0] if count is None else array[:0] for array in ends]
    stored = batches.solve_boundary(*data).to_zarr(tmp_path / "store", scheduler="synchronous")
    if count is None:
        assert stored["cost"].compute() == RiemannianCubic.from_boundary(*data).cost()
    else:
        assert stored["A"].compute().shape == (0, 5, 2)


def test_fields_computed_together_share_their_tasks(ends, monkeypatch):
    calls = []
    curve = _boundary._curve
    sweep = batches.solve_boundary(*ends, kind="geometric", chunk=9)
    monkeypatch.setattr(_boundary, "_curve", lambda *data: calls.append(1) or curve(*data))
    dask.compute(dict(sweep), scheduler="synchronous")
    assert len(calls) == COUNT
    kept = sweep.persist(scheduler="synchronous")
    dask.compute(kept["S"], kept["A"], scheduler="synchronous")
    assert len(calls) == 2 * COUNT


def unexpected(block):
    raise AssertionError("computed while the graph was made")


def test_nothing_runs_before_it_is_computed(ends):
    S0, V0, S1, V1 = [da.from_array(array, chunks=(10, 5, 2)).map_blocks(unexpected, meta=array[:0]) for array in ends]
    sweep = batches.solve_boundary(S0, V0, S1, V1, t=T)
    assert sweep["A"].chunks[0] == (10,) * 4, "blocks of the inputs are kept"
    for name in sweep:
        assert sweep[name].shape[0] == COUNT
    batches.Stiefel(5, 2).log(S0, S1)
    batches.splines(np.arange(4.0), S0.reshape(10, 4, 5, 2), at=T)
    batches.evaluate(T, S0, V0, S1, V1)


def test_tasks_are_small(ends):
    """Besides the inputs, a name and options are sent: some hundred bytes per block."""
    lazy = [da.zeros(array.shape, chunks=(1, 5, 2)) for array in ends]
    graph = dask.optimize(batches.solve_boundary(*lazy).records)[0].__dask_graph__()
    assert len(pickle.dumps(dict(graph))) < 4000 * COUNT


MAPS = {
    "project": "Y", "project_tangent": "SY", "inner": "SVW", "norm": "SV", "exp": "SV", "log": "SR", "dist": "SR",
    "retract": "SV", "inverse_retract": "SR", "transport": "SVW", "curvature": "SVWU", "sectional_curvature": "SVW",
    "euclidean_to_riemannian_gradient": "SY", "euclidean_to_riemannian_hessian": "SYZV", "decompose": "SV",
    "compose": "SXO",
}  # fmt: skip


@pytest.fixture(scope="module")
def vectors(ends):
    rng = np.random.default_rng(11)
    S, V, R, _ = ends
    U, W = M.random_tangent(S, rng), M.random_tangent(S, rng)
    X, O = M.decompose(S, V)  # noqa: E741
    Y, Z = rng.standard_normal((2, COUNT, 5, 2))
    return {"S": S, "V": V, "R": R, "U": U, "W": W, "X": X, "O": O, "Y": Y, "Z": Z}


def test_maps_of_the_manifold(client, vectors):
    ours, lazy = batches.Stiefel(5, 2), {}
    for name, arguments in MAPS.items():
        blocks = [da.from_array(vectors[a], chunks=(9, 3, 1)) for a in arguments]
        lazy[name] = getattr(ours, name)(*blocks)
    (found,) = dask.compute(lazy)
    for name, arguments in MAPS.items():
        expected = getattr(M, name)(*(vectors[a] for a in arguments))
        np.testing.assert_array_equal(found[name][0], expected[0], err_msg=name)
        np.testing.assert_array_equal(found[name][-1], expected[-1], err_msg=name)
        if name != "decompose":
            assert lazy[name].shape == expected.shape
            np.testing.assert_array_equal(found[name], expected, err_msg=name)
    methods = {name for name in dir(stiefel_rs.Stiefel) if not name.startswith("_")}
    there = {name for name in dir(ours) if not name.startswith("_")}
    assert methods - there == {
        "check_point",
        "check_tangent",
        "is_point",
        "is_tangent",
        "random_point",
        "random_tangent",
    }


def test_maps_with_options(vectors):
    S, V, R = vectors["S"], vectors["V"], vectors["R"]
    euclidean = batches.Stiefel(5, 2, metric="euclidean")
    expected = stiefel_rs.Stiefel(5, 2, metric="euclidean")
    np.testing.assert_array_equal(euclidean.norm(S, V).compute(), expected.norm(S, V))
    np.testing.assert_array_equal(euclidean.retract(S, V, "cayley").compute(), expected.retract(S, V, "cayley"))
    near = expected.retract(S, 0.1 * V)
    back = euclidean.inverse_retract(S, near, kind="polar").compute()
    np.testing.assert_array_equal(back, expected.inverse_retract(S, near, kind="polar"))
    logarithms, report = batches.Stiefel(5, 2).log_report(S, R)
    same, whole = M.log(S, R, full_output=True)
    np.testing.assert_array_equal(logarithms.compute(), same)
    for name, values in report.items():
        np.testing.assert_array_equal(values.compute(), getattr(whole, name), err_msg=name)
    np.testing.assert_array_equal(
        batches.Stiefel(5, 2).dist(S[0], da.from_array(R, chunks=(9, 5, 2))).compute(), M.dist(S[0], R)
    )


def test_maps_of_rotations(vectors):
    A = da.from_array(vectors["X"], chunks=(9, 5, 5))
    Q = batches.skew_exp(A)
    np.testing.assert_array_equal(Q.compute(), stiefel_rs.skew_exp(vectors["X"]))
    logarithms = stiefel_rs.orthogonal_log(stiefel_rs.skew_exp(vectors["X"]))
    np.testing.assert_array_equal(batches.orthogonal_log(Q).compute(), logarithms)


def test_maps_of_unitary_matrices(vectors):
    # i S is skew-Hermitian for symmetric S.
    A = vectors["X"] + 1j * (vectors["X"] @ vectors["X"])
    Q = batches.skew_exp(da.from_array(A, chunks=(9, 5, 5)))
    assert Q.dtype == np.complex128
    np.testing.assert_array_equal(Q.compute(), stiefel_rs.skew_exp(A))
    logarithms = stiefel_rs.orthogonal_log(stiefel_rs.skew_exp(A))
    np.testing.assert_array_equal(batches.orthogonal_log(Q).compute(), logarithms)


@pytest.mark.parametrize("kind", ["riemannian", "geometric"])
@pytest.mark.parametrize("chunk", [1, 3, 10])
def test_splines(client, kind, chunk):
    rng = np.random.default_rng(5)
    t, at = np.array([0.0, 0.4, 1.0, 1.5]), np.array([[0.1, 0.4], [0.9, 1.5]])
    S = [M.random_point(rng, 8)]
    for _ in t[1:]:
        S.append(M.retract(S[-1], 0.3 * M.random_tangent(S[-1], rng)))
    S = np.stack(S, axis=1)
    fields = ["velocities", "cost", "converged", "iterations", "residual", "points"]
    (found,) = dask.compute(dict(batches.splines(t, S, kind=kind, at=at, chunk=chunk, fields=fields)))
    for i in range(len(S)):
        curve = CubicSpline(t, S[i], kind=kind)
        np.testing.assert_array_equal(found["velocities"][i], curve.velocity(t))
        np.testing.assert_array_equal(found["points"][i], curve(at))
        assert found["cost"][i] == curve.cost()
        assert found["residual"][i] == curve.report.residual and found["converged"][i]
        assert found["iterations"][i] == curve.report.iterations
    times = np.stack([t * (1 + i) for i in range(8)])
    named = batches.splines(times, S, "akima", kind=kind, at=at)["points"].compute()
    np.testing.assert_array_equal(named[2], CubicHermite(times[2], S[2], "akima", kind)(at))
    again = batches.splines(t, S, found["velocities"], kind=kind, at=at)["points"].compute()
    assert np.abs(again - found["points"]).max() < 1e-11
    ends = batches.splines(t, S, bc_type="clamped", kind=kind, fields="velocities")["velocities"].compute()
    np.testing.assert_array_equal(ends[4], CubicSpline(t, S[4], "clamped", kind).velocity(t))


@pytest.mark.parametrize("what", ["point", "velocity", "acceleration", "jerk"])
def test_evaluation(client, ends, what):
    initial = [da.from_array(array, chunks=(11, 5, 2)) for array in (ends[0], ends[1], ends[1] / 2, 2 * ends[1])]
    found = batches.evaluate(T, *initial, what=what, t_end=2.0).compute()
    assert found.shape == (COUNT, 3, 5, 2)
    for i in (0, 12, COUNT - 1):
        curve = RiemannianCubic.from_initial(ends[0][i], ends[1][i], ends[1][i] / 2, 2 * ends[1][i], 2.0)
        np.testing.assert_array_equal(found[i], curve(T) if what == "point" else getattr(curve, what)(T))
    geometric = batches.evaluate(0.3, *ends, what=what, kind="geometric", chunk=6)[5].compute()
    curve = GeometricCubic(*(array[5] for array in ends))
    np.testing.assert_array_equal(geometric, curve(0.3) if what == "point" else getattr(curve, what)(0.3))


def test_errors_of_maps_name_the_member(client, vectors):
    S, V = vectors["S"], vectors["V"].copy()
    V[31] += 0.1
    lazy = da.from_array(S.reshape(4, 10, 5, 2), chunks=(2, 3, 5, 2))
    with pytest.raises(InvalidInputError, match=r"^problem \(3, 1\): V: not tangent") as caught:
        batches.Stiefel(5, 2).exp(lazy, V.reshape(4, 10, 5, 2)).compute()
    assert caught.value.problem == (3, 1)
    assert "batch member" not in str(caught.value)
    with pytest.raises(OutsideDomainError, match=r"^problem 2: ") as caught:
        batches.Stiefel(3, 1).log(np.eye(3)[:, :1], np.stack([np.eye(3)[:, i : i + 1] for i in (1, 2)] + [
            -np.eye(3)[:, :1]
        ])).compute()  # fmt: skip
    assert caught.value.angle == pytest.approx(np.pi)
