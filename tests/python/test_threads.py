"""Threads: shared objects, the interpreter lock, bit-identical results."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest
from beside import HANGS, beside, stopped_while_it_runs

from stiefel_rs import Chart, GeometricCubic, Stiefel


def make_curve(n=8, k=3):
    M = Stiefel(n, k)
    S0 = M.random_point(0)
    S1 = M.retract(S0, 0.5 * M.random_tangent(S0, 1))
    return GeometricCubic(S0, 0.5 * M.random_tangent(S0, 2), S1, 0.5 * M.random_tangent(S1, 3))


def test_sixteen_threads_share_a_curve_and_a_chart():
    curve, chart = make_curve(), Chart.frame()
    z0 = np.array([1.5, 0.0, 0.0, 0.1, 0.1, 0.1, 0.0, 0.0, 0.0, 0.1, 0.1, 0.1])
    # 20 parameters run in place, 2000 go through the thread pool.
    grids = [np.linspace(0, 1, 20), np.linspace(0, 1, 2000)]

    def work(_):
        values = [curve(grids[0], 2), curve(grids[1]), curve.jerk(grids[0])]
        return [*values, chart.integrate(z0, 200, map="midpoint"), chart.reference(z0, [0.5, 1.0])]

    expected = work(0)
    with ThreadPoolExecutor(16) as pool:
        for result in pool.map(work, range(32)):
            for i, (found, exact) in enumerate(zip(result, expected, strict=True)):
                assert np.array_equal(found, exact), f"result {i} differs between threads"


def test_many_threads_make_the_first_call_at_once():
    # Caches filled on first use must not deadlock with the interpreter lock.
    code = """
import numpy as np, threading
from stiefel_rs import Chart, Stiefel, skew_exp, InvalidInputError
gate = threading.Barrier(16)
failed = []
def work():
    gate.wait()
    try:
        skew_exp([[0, 1], [-1, 0]])
        Stiefel(3, 1).inner(np.eye(3)[:, :1], np.zeros((2, 3, 1)), np.zeros((3, 1)))
        Chart.sphere().integrate(np.array([1.5, 0, 0, 0.1, 0, 0, 0, 0]), 3000)
        try:
            skew_exp(np.ones((2, 2)))
        except InvalidInputError:
            pass
    except BaseException as error:
        failed.append(error)
threads = [threading.Thread(target=work) for _ in range(16)]
[t.start() for t in threads]
[t.join() for t in threads]
print(failed)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=HANGS, check=False)
    assert done.stdout == "[]\n", done.stdout + done.stderr


@pytest.mark.parametrize("num_threads", [1, 2, 3, 7])
@pytest.mark.parametrize("method", ["__call__", "acceleration", "jerk"])
def test_curves_are_bit_identical_for_any_number_of_threads(num_threads, method):
    evaluate = getattr(make_curve(), method)
    t = np.linspace(0, 1, 1501)
    one = evaluate(t, num_threads=num_threads)
    assert np.array_equal(one, evaluate(t)), f"{method} with num_threads={num_threads} differs from the default"


def test_thread_variable_does_not_change_a_bit():
    code = """
import hashlib, numpy as np
from stiefel_rs import Chart, Stiefel
M = Stiefel(9, 4)
S = M.random_point(0, 4000)
V = M.random_tangent(S, 1)
z = np.tile([1.5, 0, 0, .1, 0, 0, .1, .1], (40, 1)) + 1e-3 * np.arange(40)[:, None]
out = [S, V, M.retract(S, V), M.norm(S, V), Chart.sphere().integrate(z, 1000, map='midpoint')]
print(hashlib.sha256(b''.join(np.ascontiguousarray(x).tobytes() for x in out)).hexdigest())
"""
    digests = set()
    for threads in ["1", "2", "5"]:
        environment = {**os.environ, "RAYON_NUM_THREADS": threads}
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True)
        digests.add(done.stdout)
    assert len(digests) == 1, f"results differ with the number of threads: {digests}"


@pytest.mark.parametrize("what", ["integrate", "curve", "reference", "shoot"])
def test_long_calls_release_the_interpreter_lock(what):
    chart, curve = Chart.sphere(), make_curve()
    z0 = np.array([np.pi / 2, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0])
    work = {
        "integrate": partial(chart.integrate, z0, 1_000_000),
        "curve": partial(curve.jerk, np.linspace(0, 1, 50_000), num_threads=1),
        # A quarter of a second, of which 0.05 s may pass between two looks for signals.
        "reference": partial(chart.reference, z0, np.linspace(0, 1, 2_000_000)),
        "shoot": partial(chart.shoot, z0[:2], z0[2:4], [1.6, 0.1], z0[2:4], 500_000),
    }[what]
    # The signal comes from another thread, which only runs when the lock is released.
    assert stopped_while_it_runs(work) == "stopped"


def test_a_mutated_argument_does_not_matter_after_the_call_began():
    # Input is copied before the lock is released: results belong to the values at the call.
    chart = Chart.sphere()
    z0 = np.array([np.pi / 2, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0])
    expected = chart.integrate(z0, 100_000)
    shared = z0.copy()
    with beside(lambda: shared.fill(np.nan)):
        result = chart.integrate(shared, 100_000)
    assert np.isnan(shared).all()
    assert np.array_equal(result, expected)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="counts the threads of a process in /proc")
def test_one_thread_means_one_thread():
    """Pools create their threads on first use; one thread is the calling one, not the sixteen of the global pool."""
    code = """
import os, numpy as np
from stiefel_rs import GeometricCubic, skew_exp
S, V = np.eye(4, 2), np.array([[0, -1], [1, 0], [2, 0], [0, -1.0]])
curve, t = GeometricCubic(S, 0.3 * V, S, 0.2 * V), np.linspace(0, 1, 100_000)
def threads():
    return len(os.listdir("/proc/self/task"))
before = threads()
for num_threads in (1, 16, None):
    curve(t, num_threads=num_threads)
    curve.jerk(t[::10], num_threads=num_threads)
    skew_exp(np.zeros((10_000, 5, 5)), num_threads=num_threads)
    print(threads() - before)
"""
    environment = os.environ | {"RAYON_NUM_THREADS": "16"}
    run = [sys.executable, "-c", code]
    done = subprocess.run(run, capture_output=True, text=True, check=True, timeout=HANGS, env=environment)
    one, sixteen, default = map(int, done.stdout.split())
    # In addition to the pools, threads for which the calls waited may not have ended yet.
    waited = 3
    assert 0 <= one <= waited
    assert 16 <= sixteen <= 16 + 2 * waited
    assert 32 <= default <= 32 + 3 * waited
