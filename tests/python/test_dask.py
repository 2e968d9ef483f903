"""Batches over dask arrays: the same bits as one process, through lost workers, killed runs and bad input."""

import doctest
import importlib
import json
import os
import pickle
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from beside import HANGS

import stiefel_rs
from stiefel_rs import (
    ConvergenceError,
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
from stiefel_rs.dask import _boundary, _records  # noqa: E402

# Some tests leave the cluster alone while it is there.
pytestmark = pytest.mark.filterwarnings("ignore:Running on a single-machine scheduler:UserWarning")

M = stiefel_rs.Stiefel(5, 2)
T = np.array([0.0, 0.3, 1.0])
COUNT = 40
# This one is far too fast for a cubic to be found.
BAD = 23


@pytest.fixture(scope="module")
def client():
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", memory_limit=0
        ) as cluster,
        distributed.Client(cluster) as connected,
    ):
        yield connected


def random_ends(count, seed=7, manifold=M):
    rng = np.random.default_rng(seed)
    S0 = manifold.random_point(rng, count)
    S1 = manifold.retract(S0, 0.4 * manifold.random_tangent(S0, rng))
    return S0, 0.3 * manifold.random_tangent(S0, rng), S1, 0.3 * manifold.random_tangent(S1, rng)


@pytest.fixture(scope="module")
def ends():
    return random_ends(COUNT)


@pytest.fixture(scope="module")
def unsolvable(ends):
    S0, V0, S1, V1 = ends
    V0 = V0.copy()
    V0[BAD] *= 1000
    return S0, V0, S1, V1


@pytest.fixture(scope="module")
def expected(ends):
    """Fields of both kinds, from one process and one curve at a time."""

    def fields(curve, initial):
        S, V, A, J = initial
        report = curve.report
        return {
            "S": S, "V": V, "A": A, "J": J, "cost": curve.cost(), "points": curve(T), "code": 0, "message": "",
            "converged": report is None or report.converged,
            "iterations": report.iterations if report else 0,
            "residual": report.residual if report else 0.0,
        }  # fmt: skip

    exact = [RiemannianCubic.from_boundary(*data) for data in zip(*ends, strict=True)]
    geometric = [GeometricCubic(*data) for data in zip(*ends, strict=True)]
    rows = {
        "riemannian": [fields(curve, curve.initial) for curve in exact],
        "geometric": [
            fields(curve, (curve(0.0), curve.velocity(0.0), curve.acceleration(0.0), curve.jerk(0.0)))
            for curve in geometric
        ],
    }
    return {kind: {name: np.array([row[name] for row in found]) for name in found[0]} for kind, found in rows.items()}


def assert_same(found, expected):
    for name, values in found.items():
        if name == "message":
            assert [str(text) for text in values] == [str(text) for text in expected[name]]
        else:
            np.testing.assert_array_equal(values, expected[name], err_msg=name)


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
    """What travels besides the inputs: a name and options, for each block some hundred bytes."""
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
    assert methods - there == {"check_point", "check_tangent", "random_point", "random_tangent"}


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


# A worker that is lost, a run that is killed.


def complete(path):
    """Blocks of a store that are complete, as far as it is there."""
    try:
        return int((zarr.open_group(path, mode="r")["complete"][...] != 0).sum())
    except (FileNotFoundError, KeyError):
        return 0


def wait_for(condition):
    end = time.monotonic() + HANGS
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


def hold(path, blocks, go):
    """Let solves of this process wait, once so many blocks are complete, until there is a file `go`."""
    solve = _boundary._curve

    def waiting(*arguments):
        while not os.path.exists(go) and complete(path) >= blocks:
            time.sleep(0.01)
        return solve(*arguments)

    _boundary._curve = waiting


def test_a_killed_worker_loses_nothing(client, tmp_path):
    ends = random_ends(400)
    sweep = batches.solve_boundary(*ends, chunk=5)
    path, go = tmp_path / "store", tmp_path / "go"
    client.run(hold, path, 5, go)
    future = client.compute(sweep.to_zarr(path, compute=False), retries=1)
    wait_for(lambda: complete(path) > 4)
    victim = pid_of_a_worker(client)
    os.kill(victim, signal.SIGKILL)
    assert complete(path) < 80, "killed in the middle"
    go.touch()
    assert future.result(timeout=HANGS) == 400
    found, again = batches.from_zarr(path), dask.compute(dict(sweep), scheduler="synchronous")[0]
    assert_same(dask.compute(found)[0], again)
    assert victim not in client.run(os.getpid).values()


def pid_of_a_worker(client):
    return sorted(client.run(os.getpid).values())[0]


def test_a_worker_killed_with_results_in_its_memory(client, ends, expected):
    client.wait_for_workers(2)
    kept = batches.solve_boundary(*ends, t=T, chunk=4).persist()
    distributed.wait(kept.records)
    os.kill(pid_of_a_worker(client), signal.SIGKILL)
    (found,) = dask.compute(dict(kept))
    assert_same(found, expected["riemannian"])


KILLED = """
import signal
import sys
import numpy as np
sys.path.insert(0, sys.argv[2])
from test_dask import hold, random_ends
from stiefel_rs.dask import solve_boundary
go = sys.argv[1] + ".go"
def interrupted(*arguments):
    open(go, "w").close()
    signal.default_int_handler(*arguments)
signal.signal(signal.SIGINT, interrupted)
# It stays in the middle until it is stopped.
hold(sys.argv[1], 3, go)
solve_boundary(*random_ends(400), t=[0.0, 1.0], chunk=10).to_zarr(sys.argv[1], scheduler=sys.argv[3])
"""


def test_a_killed_run_goes_on(client, spawn, tmp_path):
    path = tmp_path / "store"
    child = spawn("-c", KILLED, str(path), str(Path(__file__).parent), "synchronous")
    wait_for(lambda: complete(path) >= 3)
    child.kill()
    child.wait()
    done = complete(path)
    assert 3 <= done < 40
    written = {file: file.stat().st_mtime_ns for file in (path / "A" / "c").rglob("*") if file.is_file()}
    with pytest.raises(InvalidInputError, match=r"of 40 blocks are not complete"):
        batches.from_zarr(path)

    sweep = batches.solve_boundary(*random_ends(400), t=[0.0, 1.0], chunk=10)
    with pytest.raises(InvalidInputError, match="something already"):
        sweep.to_zarr(path)
    assert sweep.to_zarr(path, resume=True, compute=False).compute() == 400 - 10 * done
    kept = [file for file, at in written.items() if file.stat().st_mtime_ns == at]
    assert len(kept) >= done, "blocks that are complete are not written again"
    assert_same(dask.compute(batches.from_zarr(path))[0], dask.compute(dict(sweep), scheduler="synchronous")[0])
    assert sweep.to_zarr(path, resume=True, compute=False).compute() == 0


def test_an_error_leaves_what_is_complete(unsolvable, tmp_path):
    # Which blocks come before the bad one depends on their names, and those on the path: one time in ten none does.
    for path in (tmp_path / f"store_{i}" for i in range(10)):
        with pytest.raises(ConvergenceError, match=f"^problem {BAD}: "):
            batches.solve_boundary(*unsolvable, chunk=5).to_zarr(path, scheduler="synchronous")
        if complete(path):
            break
    assert complete(path) > 0
    with pytest.raises(ConvergenceError, match=f"^problem {BAD}: "):
        batches.solve_boundary(*unsolvable, chunk=5).to_zarr(path, resume=True, scheduler="synchronous")


@pytest.fixture
def store(ends, tmp_path):
    path = tmp_path / "store"
    batches.solve_boundary(*ends, kind="geometric", chunk=9).to_zarr(path, scheduler="synchronous")
    return path


def test_what_is_stored_can_be_read_by_others(ends, store):
    group = zarr.open_group(store, mode="r")
    manifest = group.attrs["stiefel_rs"]
    assert manifest["stiefel_rs"] == stiefel_rs.__version__
    assert len(manifest["inputs"]) == 64
    np.testing.assert_array_equal(group["V"][...], batches.from_zarr(store)["V"].compute())
    assert group["A"].chunks == (9, 5, 2)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"chunk": 10}, "blocks, inputs$"),
        ({"t": T}, "options, fields"),
        ({"on_error": "mark"}, "options$"),
        ({"pieces": "geodesic"}, "options$"),
        ({"kind": "riemannian"}, "options, fields"),
        ({"fields": ["A"]}, "fields$"),
    ],
)
def test_a_store_of_another_sweep(ends, store, change, told):
    options = {"kind": "geometric", "chunk": 9, **change}
    with pytest.raises(InvalidInputError, match=f"store: of another sweep, different in: {told}"):
        batches.solve_boundary(*ends, **options).to_zarr(store, resume=True)


def test_a_store_of_other_inputs_or_another_version(ends, store):
    S0, V0, S1, V1 = ends
    other = V1.copy()
    other[-1] *= 1 + 1e-15
    with pytest.raises(InvalidInputError, match=r"different in: inputs$"):
        batches.solve_boundary(S0, V0, S1, other, kind="geometric", chunk=9).to_zarr(store, resume=True)
    change_manifest(store, stiefel_rs="0.0.1")
    with pytest.raises(InvalidInputError, match=r"different in: version of stiefel_rs$"):
        batches.solve_boundary(*ends, kind="geometric", chunk=9).to_zarr(store, resume=True)
    change_manifest(store, version=2)
    with pytest.raises(InvalidInputError, match="version 2 of the format, expected 1"):
        batches.from_zarr(store)


def change_manifest(store, **changes):
    group = zarr.open_group(store, mode="r+")
    group.attrs["stiefel_rs"] = {**group.attrs["stiefel_rs"], **changes}


def flip_a_byte(file):
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 255
    file.write_bytes(content)


@pytest.mark.parametrize("name", ["A", "S", "converged", "complete"])
def test_a_damaged_store(ends, store, name):
    flip_a_byte(store / name / "c" / "/".join(["2", "0", "0"] if name in "AS" else ["2"]))
    with pytest.raises(InvalidInputError, match="store: damaged: "):
        batches.from_zarr(store)
    with pytest.raises(InvalidInputError, match="store: damaged: "):
        batches.solve_boundary(*ends, kind="geometric", chunk=9).to_zarr(store, resume=True)


def test_wrong_values_are_damage_too(store):
    zarr.open_group(store, mode="r+")["J"][20] = 0.0
    with pytest.raises(InvalidInputError, match=r"1 of 5 complete blocks .* problems \[18:27\]"):
        batches.from_zarr(store)
    assert (batches.from_zarr(store, check=False)["J"][20].compute() == 0).all()


def test_no_store_at_all(ends, store, tmp_path):
    for folder in ("nothing", "empty", "other"):
        path = tmp_path / folder
        if folder == "empty":
            path.mkdir()
        if folder == "other":
            zarr.open_group(path, mode="w").create_array("cost", shape=(COUNT,), dtype="float64")
        with pytest.raises(InvalidInputError, match=folder):
            batches.from_zarr(path)
        if folder != "nothing":
            with pytest.raises(InvalidInputError, match=folder):
                batches.solve_boundary(*ends).to_zarr(path, resume=True)
    shutil.rmtree(store / "A")
    with pytest.raises(InvalidInputError, match="store: damaged"):
        batches.from_zarr(store)


def test_marks_are_stored(unsolvable, tmp_path):
    sweep = batches.solve_boundary(*unsolvable, chunk=7, on_error="mark")
    stored = sweep.to_zarr(tmp_path / "store", scheduler="synchronous")
    assert_same(dask.compute(stored)[0], dask.compute(dict(sweep), scheduler="synchronous")[0])
    assert stored["message"][BAD].compute().item().startswith("shooting")


def fails_once(block, flag):
    if not flag.exists():
        flag.touch()
        raise OSError("a moment of bad luck")
    return block


def test_tasks_are_tried_again(client, ends, tmp_path):
    S0, V0, S1, V1 = ends

    def once(flag):
        return da.from_array(V1, chunks=(8, 5, 2)).map_blocks(fails_once, tmp_path / flag, meta=V1[:0])

    with pytest.raises(OSError, match="bad luck"):
        batches.solve_boundary(S0, V0, S1, once("first"))["A"].compute()
    # Tasks of another name: the scheduler may still know the first ones as failed.
    stored = batches.solve_boundary(S0, V0, S1, once("second")).to_zarr(tmp_path / "store", retries=2)
    assert (stored["code"].compute() == 0).all()


def test_places_to_store(ends, tmp_path, monkeypatch):
    """A folder next to the client, wherever the workers are; an address with a protocol."""
    sweep = batches.solve_boundary(*ends, kind="geometric", chunk=9, fields="A")
    monkeypatch.chdir(tmp_path)
    writing = sweep.to_zarr("near", compute=False)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert writing.compute(scheduler="synchronous") == COUNT
    assert list(batches.from_zarr(tmp_path / "near")) == ["A"]
    for address in (f"file://{tmp_path}/far", f"memory://{tmp_path.name}/far"):
        with dask.config.set(scheduler="synchronous"):
            with pytest.raises(InvalidInputError, match="far"):
                batches.from_zarr(address)
            far = sweep.to_zarr(address, resume=True)
            np.testing.assert_array_equal(far["A"].compute(), sweep["A"].compute())
            assert sweep.to_zarr(address, resume=True, compute=False).compute() == 0
            with pytest.raises(InvalidInputError, match="something already"):
                sweep.to_zarr(address)
    assert (tmp_path / "far" / "zarr.json").exists()


def test_unequal_blocks_are_not_written(ends, tmp_path):
    uneven = [da.from_array(array, chunks=((10, 25, 5), 5, 2)) for array in ends]
    with pytest.raises(InvalidInputError, match="Zarr needs equal ones"):
        batches.solve_boundary(*uneven).to_zarr(tmp_path / "store")
    assert not (tmp_path / "store").exists()


# Errors.


@pytest.mark.parametrize("scheduler", ["cluster", "synchronous"])
def test_an_error_names_the_problem(client, unsolvable, scheduler):
    sweep = batches.solve_boundary(*unsolvable, chunk=7)
    with pytest.raises(ConvergenceError, match=f"^problem {BAD}: shooting") as caught:
        sweep["cost"].compute(**({} if scheduler == "cluster" else {"scheduler": "synchronous"}))
    assert caught.value.problem == (BAD,)
    assert not caught.value.report.converged and caught.value.report.residual > 1e-12


def test_failures_can_be_marked(client, unsolvable, expected):
    (found,) = dask.compute(dict(batches.solve_boundary(*unsolvable, t=T, chunk=7, on_error="mark")))
    good = np.arange(COUNT) != BAD
    assert_same({name: values[good] for name, values in found.items()}, {
        name: values[good] for name, values in expected["riemannian"].items()
    })  # fmt: skip
    assert found["code"][BAD] == batches.Outcome.NO_CONVERGENCE and not found["converged"][BAD]
    assert found["message"][BAD].startswith("shooting for a Riemannian cubic: no convergence")
    assert found["iterations"][BAD] > 0 and found["residual"][BAD] > 1e-12
    assert all(np.isnan(found[name][BAD]).all() for name in ("S", "V", "A", "J", "cost", "points"))


def test_every_kind_of_failure_has_a_code(ends):
    S0, V0, S1, V1 = (array.copy() for array in ends)
    V0[1] += 0.1
    V0[2] *= 1e4
    V1[3, 0, 0] = np.nan
    lazy = da.from_array(V1, chunks=(8, 5, 2))
    sweep = batches.solve_boundary(S0, V0, S1, lazy, kind="geometric", on_error="mark")
    found = dask.compute(dict(sweep))[0]
    Outcome = batches.Outcome
    assert found["code"][:4].tolist() == [Outcome.SOLVED, *[Outcome.INVALID_INPUT] * 3]
    assert not found["code"][4:].any()
    assert "not tangent" in found["message"][1] and "not finite" in found["message"][3]
    assert found["iterations"][1] == -1 and np.isnan(found["residual"][1])
    square = stiefel_rs.Stiefel(3, 3)
    Q = square.random_point(rng=1)
    apart = dask.compute(dict(batches.solve_boundary(Q, 0 * Q, -Q, 0 * Q, on_error="mark")))[0]
    assert apart["code"] == Outcome.OUTSIDE_DOMAIN


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


def test_errors_of_splines_name_problem_and_knot(client):
    S = M.random_point(rng=3, size=(6, 4))
    S[4, 2] *= 1.1
    with pytest.raises(InvalidInputError, match=r"^problem 4: ") as caught:
        batches.splines(np.arange(4.0), S, chunk=2)["velocities"].compute()
    assert (caught.value.problem, caught.value.knot) == ((4,), 2)


def test_bad_shapes_types_and_values_are_found_early(ends):
    S0, V0, S1, V1 = ends
    solve = batches.solve_boundary
    holes = V0.copy()
    holes[7, 1, 0] = np.nan
    unknown = da.from_array(V0, chunks=(10, 5, 2))[da.from_array(np.arange(COUNT) > 3, chunks=10)]
    for call, error, text in [
        (lambda: solve(S0, V0[:, :4], S1, V1), InvalidInputError, r"V0: expected shape \(\.\.\., 5, 2\), found"),
        (lambda: solve(S0, V0[:7], S1, V1), InvalidInputError, r"do not broadcast: .*V0 \(7,\)"),
        (lambda: solve(S0[0, 0], V0, S1, V1), InvalidInputError, "S0: expected at least 2 axes"),
        (lambda: solve(S0[:, :1], V0[:, :1], S1[:, :1], V1[:, :1]), InvalidInputError, "k"),
        (lambda: solve(S0, V0, S1, V1.astype(complex)), TypeError, "V1: expected real numbers"),
        (lambda: solve(S0, V0, S1, da.from_array(V1.astype(complex))), TypeError, "V1: expected real numbers"),
        (lambda: solve(S0, V0, S1, V1.astype("M8[s]")), TypeError, "V1: expected real numbers"),
        (lambda: solve(S0, V0, S1, [[1.0], [2.0, 3.0]]), InvalidInputError, "V1"),
        (lambda: solve(S0, holes, S1, V1), InvalidInputError, r"V0: the entry at \(7, 1, 0\) is not finite"),
        (lambda: solve(S0, unknown, S1, V1), InvalidInputError, "V0: sizes of its blocks are unknown"),
        (lambda: solve(*ends, chunk=0), InvalidInputError, "chunk: expected at least 1"),
        (lambda: solve(*ends, chunk=2.5), TypeError, "chunk"),
        (lambda: solve(*ends, kind="exact"), InvalidInputError, "kind"),
        (lambda: solve(*ends, on_error="ignore"), InvalidInputError, "on_error"),
        (lambda: solve(*ends, fields=["A", "B"]), InvalidInputError, r"fields: \['B'\]"),
        (lambda: solve(*ends, fields=["points"]), InvalidInputError, r"fields: \['points'\]"),
        (lambda: solve(*ends, fields=[]), InvalidInputError, "fields"),
        (lambda: solve(*ends, pieces="geodesic"), InvalidInputError, "pieces: no option of riemannian cubics"),
        (lambda: solve(*ends, kind="geometric", tol=1e-9), InvalidInputError, "tol: no option of geometric"),
        (lambda: solve(*ends, t=[np.nan]), InvalidInputError, "t: not finite"),
        (lambda: solve(*ends, t=["a"]), TypeError, "t: expected real numbers"),
        (lambda: batches.Stiefel(2, 3), InvalidInputError, "k"),
        (lambda: batches.Stiefel(4, 2).exp(S0, V0), InvalidInputError, "S: expected shape"),
        (lambda: batches.skew_exp(S0), InvalidInputError, "A: expected shape"),
        (lambda: batches.splines([0.0, 1.0], S0), InvalidInputError, "t: expected shape"),
        (lambda: batches.splines([0.0, 1.0], S0[0]), InvalidInputError, "S: expected at least 3"),
        (lambda: batches.splines(np.arange(40.0), S0, V0, bc_type="clamped"), InvalidInputError, "V: with velocities"),
        (lambda: batches.splines(np.arange(40.0), S0, "cubic"), InvalidInputError, "V: must be one of"),
        (lambda: batches.splines(np.arange(40.0), S0, bc_type=2), InvalidInputError, "bc_type"),
        (lambda: batches.evaluate(T, *ends, what="snap"), InvalidInputError, "what"),
        (lambda: batches.evaluate(T, *ends, kind="geometric", t_end=2.0), InvalidInputError, "t_end"),
    ]:
        with pytest.raises(error, match=text):
            call()


def test_bad_options_are_found_early_whatever_happens_to_errors(ends):
    S0, V0 = ends[:2]
    knots = np.stack([np.arange(40.0), np.arange(40.0) + 0.5])
    pair = np.stack([S0, S0])

    def solve(**options):
        batches.solve_boundary(*ends, on_error="mark", **options)

    def splines(t=knots, **options):
        batches.splines(t, pair, on_error="mark", **options)

    for call, error, text in [
        (lambda: solve(tol=-1.0), InvalidInputError, "tol: .*found -1"),
        (lambda: solve(tol=np.nan), InvalidInputError, "tol"),
        (lambda: solve(tol="a"), TypeError, "tol"),
        (lambda: solve(max_iterations=0), InvalidInputError, "max_iterations: .*found 0"),
        (lambda: solve(max_iterations=1.5), TypeError, "max_iterations"),
        (lambda: solve(kind="geometric", pieces="x"), InvalidInputError, "pieces"),
        (lambda: solve(kind="geometric", pieces=3), TypeError, "pieces"),
        (lambda: solve(fields=3), TypeError, "fields: expected names, found 3"),
        (lambda: splines(tol=2.0), InvalidInputError, "tol: .*found 2"),
        (lambda: splines(max_iterations="a"), TypeError, "max_iterations"),
        (lambda: splines(at=[5.0, 39.25]), InvalidInputError, r"at: 39.25 is outside of the knots, .* 0.5 to 39.0"),
        (lambda: splines(at=[0.25]), InvalidInputError, "at: 0.25 is outside"),
        (lambda: batches.splines([0.0], S0[:, None]), InvalidInputError, "t: .*two times"),
        (lambda: batches.evaluate(T, *ends, t_end=0.0), InvalidInputError, "t_end"),
        (lambda: batches.evaluate(T, *ends, t_end=np.nan), InvalidInputError, "t_end"),
        (lambda: batches.Stiefel(5, 2).retract(S0, V0, kind="x"), InvalidInputError, "kind"),
        (lambda: batches.Stiefel(5, 2).inverse_retract(S0, S0, kind="x"), InvalidInputError, "kind"),
    ]:
        with pytest.raises(error, match=text):
            call()
    splines(at=[0.5, 39.0])


def test_values_that_are_not_in_memory_are_found_by_their_task(client, ends):
    S0, V0, S1, V1 = ends
    holes = V0.copy()
    holes[17, 1, 0] = np.nan
    with pytest.raises(InvalidInputError, match=r"^problem 17: V0: .* not finite"):
        batches.solve_boundary(S0, da.from_array(holes, chunks=(8, 5, 2)), S1, V1)["A"].compute()


def test_another_version_on_a_worker_is_refused():
    _records.require_version(stiefel_rs.__version__)
    with pytest.raises(RuntimeError, match=f"stiefel_rs {stiefel_rs.__version__}, the client 9.9"):
        _records.require_version("9.9")


@pytest.mark.skipif(os.name == "nt", reason="needs POSIX signals")
@pytest.mark.parametrize("scheduler", ["synchronous", "threads"])
def test_ctrl_c_stops_a_local_run(spawn, tmp_path, scheduler):
    path = tmp_path / "store"
    child = spawn("-c", KILLED, str(path), str(Path(__file__).parent), scheduler, stderr=subprocess.PIPE)
    wait_for(lambda: complete(path) > 0)
    child.send_signal(signal.SIGINT)
    _, said = child.communicate(timeout=HANGS)
    assert "KeyboardInterrupt" in said
    assert 0 < complete(path) < 40


def test_the_package_does_not_need_dask():
    code = "import sys, stiefel_rs; assert not {'dask', 'distributed', 'zarr'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=HANGS)


@pytest.mark.parametrize("module", ["_boundary", "_evaluate", "_maps", "_splines"])
def test_examples_run(module):
    failed, attempted = doctest.testmod(importlib.import_module(f"stiefel_rs.dask.{module}"))
    assert attempted > 0 and failed == 0


def test_first_example_of_the_guide_runs():
    guide = (Path(__file__).parents[2] / "docs" / "dask.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", guide, flags=re.DOTALL)
    exec(compile(blocks[0], "dask.md", "exec"), names := {})
    assert (names["code"] == 0).mean() > 0.9
    for block in blocks[1:]:
        compile(block, "dask.md", "exec")


def test_public_names_are_documented():
    for name in batches.__all__:
        assert getattr(batches, name).__doc__
    assert json.dumps([int(code) for code in batches.Outcome]) == "[0, 1, 2, 3, 4]"
