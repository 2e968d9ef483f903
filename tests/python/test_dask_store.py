"""Stores of batches: lost workers, killed runs, damage."""

import os
import shutil
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from beside import HANGS, wait_for
from dask_problem import BAD, COUNT, T, assert_same, cluster, random_ends, solved, unsolvable_ends

import stiefel_rs
from stiefel_rs import ConvergenceError, InvalidInputError

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
def unsolvable():
    return unsolvable_ends()


@pytest.fixture(scope="module")
def expected(ends):
    return solved(ends)


def complete(path):
    """Number of complete blocks of a store, if it exists."""
    try:
        return int((zarr.open_group(path, mode="r")["complete"][...] != 0).sum())
    except (FileNotFoundError, KeyError):
        return 0


def hold(path, blocks, go):
    """Pause the solves of this process once that many blocks are complete, until the file `go` exists."""
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
from dask_problem import random_ends
from test_dask_store import hold
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
    with pytest.raises(InvalidInputError, match=r"of 40 blocks are incomplete"):
        batches.from_zarr(path)

    sweep = batches.solve_boundary(*random_ends(400), t=[0.0, 1.0], chunk=10)
    with pytest.raises(InvalidInputError, match="already exists"):
        sweep.to_zarr(path)
    assert sweep.to_zarr(path, resume=True, compute=False).compute() == 400 - 10 * done
    kept = [file for file, at in written.items() if file.stat().st_mtime_ns == at]
    assert len(kept) >= done, "blocks that are complete are not written again"
    assert_same(dask.compute(batches.from_zarr(path))[0], dask.compute(dict(sweep), scheduler="synchronous")[0])
    assert sweep.to_zarr(path, resume=True, compute=False).compute() == 0


def test_an_error_leaves_what_is_complete(unsolvable, tmp_path):
    # Which blocks come before the bad one depends on their names, which depend on the path: one time in ten none does.
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
    with pytest.raises(InvalidInputError, match=f"store: belongs to another sweep, with different {told}"):
        batches.solve_boundary(*ends, **options).to_zarr(store, resume=True)


def test_a_store_of_other_inputs_or_another_version(ends, store):
    S0, V0, S1, V1 = ends
    other = V1.copy()
    other[-1] *= 1 + 1e-15
    with pytest.raises(InvalidInputError, match=r"with different inputs$"):
        batches.solve_boundary(S0, V0, S1, other, kind="geometric", chunk=9).to_zarr(store, resume=True)
    change_manifest(store, stiefel_rs="0.0.1")
    with pytest.raises(InvalidInputError, match=r"with different version of stiefel_rs$"):
        batches.solve_boundary(*ends, kind="geometric", chunk=9).to_zarr(store, resume=True)
    change_manifest(store, version=2)
    with pytest.raises(InvalidInputError, match="expected version 1 of the format, found 2"):
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
    assert stored["message"][BAD].compute().item().startswith("boundary value problem")


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
    # Tasks with other names: the scheduler may still remember the first ones as failed.
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
            with pytest.raises(InvalidInputError, match="already exists"):
                sweep.to_zarr(address)
    assert (tmp_path / "far" / "zarr.json").exists()


def test_unequal_blocks_are_not_written(ends, tmp_path):
    uneven = [da.from_array(array, chunks=((10, 25, 5), 5, 2)) for array in ends]
    with pytest.raises(InvalidInputError, match="Zarr needs equal sizes"):
        batches.solve_boundary(*uneven).to_zarr(tmp_path / "store")
    assert not (tmp_path / "store").exists()


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
