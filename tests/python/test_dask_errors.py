"""Errors of batches: they name the problem, or are marked; invalid input is found early; interrupts."""

import doctest
import importlib
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from beside import HANGS
from dask_problem import BAD, COUNT, M, T, assert_same, cluster, random_ends, solved, unsolvable_ends

import stiefel_rs
from stiefel_rs import ConvergenceError, InvalidInputError

dask = pytest.importorskip("dask")
distributed = pytest.importorskip("distributed")
zarr = pytest.importorskip("zarr")

import dask.array as da  # noqa: E402

from stiefel_rs import dask as batches  # noqa: E402
from stiefel_rs.dask import _records  # noqa: E402

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


@pytest.mark.parametrize("scheduler", ["cluster", "synchronous"])
def test_an_error_names_the_problem(client, unsolvable, scheduler):
    sweep = batches.solve_boundary(*unsolvable, chunk=7)
    with pytest.raises(ConvergenceError, match=f"^problem {BAD}: boundary value problem") as caught:
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
    assert found["message"][BAD].startswith("boundary value problem of a Riemannian cubic: no convergence")
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
        (lambda: solve(S0, V0, S1, V1.astype(str)), TypeError, "V1: expected real or complex numbers"),
        (lambda: solve(S0, V0, S1, da.from_array(V1.astype(str))), TypeError, "V1: expected real or complex numbers"),
        (lambda: solve(S0, V0, S1, V1.astype("M8[s]")), TypeError, "V1: expected real or complex numbers"),
        (lambda: solve(S0, V0, S1, [[1.0], [2.0, 3.0]]), InvalidInputError, "V1"),
        (lambda: solve(S0, holes, S1, V1), InvalidInputError, r"V0: the entry at \(7, 1, 0\) is not finite"),
        (lambda: solve(S0, unknown, S1, V1), InvalidInputError, "V0: the sizes of its blocks are unknown"),
        (lambda: solve(*ends, chunk=0), InvalidInputError, "chunk: expected at least 1"),
        (lambda: solve(*ends, chunk=2.5), TypeError, "chunk"),
        (lambda: solve(*ends, kind="exact"), InvalidInputError, "kind"),
        (lambda: solve(*ends, on_error="ignore"), InvalidInputError, "on_error"),
        (lambda: solve(*ends, fields=["A", "B"]), InvalidInputError, r"fields: \['B'\]"),
        (lambda: solve(*ends, fields=["points"]), InvalidInputError, r"fields: \['points'\]"),
        (lambda: solve(*ends, fields=[]), InvalidInputError, "fields"),
        (lambda: solve(*ends, pieces="geodesic"), InvalidInputError, "pieces: not an option of riemannian cubics"),
        (lambda: solve(*ends, kind="geometric", tol=1e-9), InvalidInputError, "tol: not an option of geometric"),
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
        (lambda: splines(at=[5.0, 39.25]), InvalidInputError, r"at: 39.25 is outside the knots, .* 0.5 to 39.0"),
        (lambda: splines(at=[0.25]), InvalidInputError, "at: 0.25 is outside"),
        (lambda: batches.splines([0.0], S0[:, None]), InvalidInputError, r"t: .*N >= 2"),
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
