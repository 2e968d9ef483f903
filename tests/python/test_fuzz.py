"""Random calls of every entry point, a short run of `python -m tests.fuzz`, and checks that it detects failures."""

import inspect
import random
import sys

import numpy as np
import pytest

import stiefel_rs
from tests.fuzz import __main__ as command
from tests.fuzz import case, curves, entries

FIRST, CASES = 20_240_419, 400
# Results, which users do not construct; they are checked wherever they are returned.
RESULTS = {"ChartTrajectory", "CubicTrajectory", "ShootingResult", "Curve", "CurveDerivative", "PiecewiseCurve"}


def test_random_calls():
    # However long they take: a busy machine draws the same number.
    found, count, _ = command.search(FIRST, CASES, float("inf"), command.LIMIT, report=lambda text: None)
    assert count == CASES, f"{count} cases of {CASES}"
    again = [f"python -m tests.fuzz --case {seed}: {text}" for seed, text in found]
    assert not found, "\n".join(again)


def covered():
    """Names of the entry points that the cases draw from."""
    names = set(entries.CALLS) | set(curves.CURVES)
    names |= {f"Curve.{name}" for name in curves.METHODS}
    names |= {f"CurveDerivative.{name}" for name in curves.DERIVATIVE_METHODS}
    names |= {f"CubicSpline.{name}" for name in curves.SPLINE_METHODS}
    return names | {f"RiemannianCubic.{name}" for name in curves.CUBIC_METHODS}


@pytest.mark.parametrize("name", [x for x in stiefel_rs.__all__ if x != "__version__"])
def test_every_public_name_is_drawn(name):
    thing, names = getattr(stiefel_rs, name), covered()
    if not inspect.isclass(thing):
        assert name in names
        return
    if not issubclass(thing, Exception) and name not in RESULTS | {"Chart", "RiemannianCubic"}:
        assert name in names, f"the constructor of {name} is not drawn"
    methods = [x for x in vars(thing) if not x.startswith("_") and callable(getattr(thing, x))]
    # Figures take matplotlib's arguments, and have tests of their own.
    missing = [x for x in methods if f"{name}.{x}" not in names and x != "plot"]
    assert not missing, f"methods of {name} that are not drawn: {missing}"


def test_a_case_is_made_of_its_seed():
    for seed in range(12):
        first, second = case.run(seed), case.run(seed)
        # Addresses of objects do not belong to the case.
        assert [x.split(" at 0x")[0] for x in first.trace] == [x.split(" at 0x")[0] for x in second.trace]
        assert first.outcome == second.outcome


def test_no_case_leaves_a_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    curve = stiefel_rs.QuasiGeodesic(np.eye(2, 1), np.eye(2, 1)[::-1])
    made = case.Case(random.Random(0))
    made.run = lambda: made.call("save", curve.save, ["text"], {})
    case.elsewhere(made)
    assert made.outcome == "result"
    assert not list(tmp_path.iterdir())


class Panic(BaseException):
    pass


def raises(error):
    raise error


@pytest.mark.parametrize(
    ("function", "says"),
    [
        (lambda x: np.array([1.0, np.nan]), "finite input"),
        (lambda x: (0.5, float("inf")), "result[1] = inf"),
        (lambda x: stiefel_rs.SolverReport(True, 1, float("nan"), 1.0, "max_iterations"), "result.residual = nan"),
        (lambda x: raises(Panic("overflow")), "Panic: overflow"),
        (lambda x: raises(KeyError("a")), "KeyError"),
        (lambda x: raises(OSError("a")), "OSError"),
        (lambda x: raises(ValueError("")), "without a text"),
        (lambda x: x.fill(3.0), "changed its argument"),
    ],
)
def test_what_must_not_be_is_found(function, says):
    made = case.Case(random.Random(0))
    made.call("name", function, [np.zeros(2)], {})
    assert len(made.found) == 1
    assert says in str(made.found[0])


def test_what_may_be_is_not_found():
    made = case.Case(random.Random(0))
    made.call("name", lambda x: x * 2, [np.array([np.nan])], {})
    made.call("name", lambda x: raises(stiefel_rs.InvalidInputError("text")), [np.zeros(2)], {})
    made.call("name", lambda x: raises(MemoryError("text")), [np.zeros(2)], {})
    assert not made.found


WORKERS = {
    "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)": "process ended with code -11",
    "while True: pass": "hang",
    "import time; time.sleep(60)": "hang",
}


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize("body", WORKERS)
def test_crashes_and_hangs_are_seen(body, monkeypatch):
    # A worker whose third case kills it: that case is named, and the search continues with the next one.
    code = f"""
import sys
from tests.fuzz import case, worker
def run(seed):
    if seed == 2:
        {body}
    return case.Case(case.random.Random(seed))
worker.case.run = run
worker.PATIENCE = 3.0
worker.work(int(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4]))
"""
    true = command.subprocess.Popen

    def popen(words, **pipes):
        return true([sys.executable, "-c", code, *words[3:]], **pipes)

    monkeypatch.setattr(command.subprocess, "Popen", popen)
    # It ends with the fifth case; the seconds do not limit it.
    found, count, _ = command.search(0, 5, 600.0, 1.0, report=lambda text: None)
    assert [seed for seed, _ in found] == [2]
    assert found[0][1].startswith(WORKERS[body]), found
    assert count == 5
