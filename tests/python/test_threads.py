"""Threads: shared objects, the interpreter lock, Ctrl-C, bit-identical results."""

import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from stiefel_rs import Chart, GeometricCubic, Stiefel

# A process that was asked to stop within a second also has to leave Python.
STOP_LIMIT = 1.0
TEARDOWN = 1.0
# How long a call that does not stop is waited for.
PATIENCE = 4.0

SETUP = """
import time
import numpy as np
from stiefel_rs import Chart, CubicHermite, CubicSpline, GeometricCubic, Stiefel, orthogonal_log, skew_exp
chart = Chart.sphere()
# A geodesic along the equator: it never leaves the chart.
z0 = np.array([np.pi / 2, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0])
M = Stiefel(40, 10)
S0 = M.random_point(0)
V0 = 0.1 * M.random_tangent(S0, 1)
S1 = M.retract(S0, V0)
curve = GeometricCubic(S0, V0, S1, 0.1 * M.random_tangent(S1, 2))
big = Stiefel(240, 100)
B0 = big.random_point(0)
W0 = 0.05 * big.random_tangent(B0, 1)
B1 = big.retract(B0, W0)
far = Stiefel(60, 50)
F0 = far.random_point(0)
G0 = far.random_tangent(F0, 1)
rng = np.random.default_rng(0)
grid = np.arange(200_000.0)
R0 = np.linalg.qr(rng.standard_normal((200_000, 4, 2)))[0]
def skew(m, scale):
    A = rng.standard_normal((m, m))
    return scale * (A - A.T)
print("ready", flush=True)
try:
    {call}
except KeyboardInterrupt:
    print("interrupted", time.time(), flush=True)
else:
    print("finished", time.time(), flush=True)
"""

# Every one of them would run for much longer than the test waits.
LONG_CALLS = {
    "integrate": "chart.integrate(z0, 20_000_000)",
    "integrate_batch": "chart.integrate(np.tile(z0, (2000, 1)), 10_000)",
    "integrate_midpoint": "chart.integrate(z0, 20_000_000, 1.0, 'midpoint')",
    "shoot": "chart.shoot(z0[:2], z0[2:4], [1.6, 0.1], z0[2:4], 8_000_000)",
    "reference": "chart.reference(z0, np.linspace(0, 1, 10_000_000))",
    "reference_far": "chart.reference([1.5, 0, 0, 1e3, 0, 0, 0, 0], [30.0])",
    "curve": "curve(np.linspace(0, 1, 100_000))",
    "curve_jerk": "curve.jerk(np.linspace(0, 1, 20_000))",
    "curve_one_thread": "curve.jerk(np.linspace(0, 1, 20_000), num_threads=1)",
    "curve_cost": "GeometricCubic(B0, W0, B1, W0 * 0).cost()",
    "skew_exp_batch": "skew_exp(np.tile(skew(300, 10.0), (600, 1, 1)))",
    "skew_exp_one": "skew_exp(skew(1500, 100.0))",
    "transport_far": "far.transport(F0, 4e3 * G0, G0)",
    "spline": "CubicSpline(np.arange(3000.0), far.random_point(0, 3000))",
    "hermite": "CubicHermite(grid, R0, 0 * R0)",
    "hermite_one_thread": "CubicHermite(grid, R0, 0 * R0, num_threads=1)",
    "log_batch": "orthogonal_log(np.tile(skew_exp(skew(300, 0.1)), (600, 1, 1)))",
}


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT cannot be sent to one process")
@pytest.mark.parametrize("name", LONG_CALLS)
def test_ctrl_c_stops_a_long_call(name, spawn):
    process = spawn("-c", SETUP.format(call=LONG_CALLS[name]), stdout=subprocess.PIPE)
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.7)
    assert process.poll() is None, "the call was to take much longer"
    start, start_wall = time.perf_counter(), time.time()
    process.send_signal(signal.SIGINT)
    try:
        said, _ = process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        pytest.fail(f"still running {PATIENCE} s after the signal")
    left = time.perf_counter() - start
    said, stopped = said.split()
    assert said == "interrupted", f"the call {said}"
    stopped = float(stopped) - start_wall
    assert stopped < STOP_LIMIT, f"KeyboardInterrupt came {stopped:.2f} s after the signal"
    assert left < STOP_LIMIT + TEARDOWN, f"the process left {left:.2f} s after the signal"


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT cannot be sent to one process")
def test_an_interrupted_process_goes_on_working(spawn):
    call = "chart.integrate(z0, 20_000_000)"
    code = SETUP.format(call=call) + "print(chart.integrate(z0, 3000).shape, curve([0.5]).shape, flush=True)\n"
    process = spawn("-c", code, stdout=subprocess.PIPE)
    process.stdout.readline()
    time.sleep(0.7)
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate(timeout=30)
    assert said.startswith("interrupted "), said
    assert said.endswith("\n(3001, 8) (1, 40, 10)\n"), said


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
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
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
        "integrate": lambda: chart.integrate(z0, 200_000),
        "curve": lambda: curve.jerk(np.linspace(0, 1, 2_000), num_threads=1),
        "reference": lambda: chart.reference([1.5, 0, 0, 500.0, 0, 0, 0, 0], [1.0]),
        "shoot": lambda: chart.shoot(z0[:2], z0[2:4], [1.6, 0.1], z0[2:4], 50_000),
    }[what]
    running, ticks = threading.Event(), []

    def tick():
        while running.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    running.set()
    ticker = threading.Thread(target=tick)
    ticker.start()
    start = time.perf_counter()
    work()
    end = time.perf_counter()
    running.clear()
    ticker.join()
    during = sum(start + 0.1 * (end - start) < t < end - 0.1 * (end - start) for t in ticks)
    # With the lock held not one tick falls into the middle of the call.
    assert during >= 5, f"{during} ticks of another thread during a call of {end - start:.3f} s"


def test_a_mutated_argument_does_not_matter_after_the_call_began():
    # Input is copied before the lock is released: results are those of the values at the call.
    chart = Chart.sphere()
    z0 = np.array([np.pi / 2, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0])
    expected = chart.integrate(z0, 100_000)
    shared, stop = z0.copy(), threading.Event()

    def scribble():
        time.sleep(0.02)
        while not stop.is_set():
            shared[:] = np.nan
            time.sleep(0)

    thread = threading.Thread(target=scribble)
    thread.start()
    result = chart.integrate(shared, 100_000)
    stop.set()
    thread.join()
    assert np.array_equal(result, expected)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads the threads' clocks from /proc")
def test_one_thread_means_one_thread():
    code = """
import os, numpy as np
from pathlib import Path
from stiefel_rs import GeometricCubic
S, V = np.eye(4, 2), np.array([[0, -1], [1, 0], [2, 0], [0, -1.0]])
curve, t = GeometricCubic(S, 0.3 * V, S, 0.2 * V), np.linspace(0, 1, 10000)
for _ in range(300):
    curve(t, num_threads=1)
ticks = [sum(map(int, (task / "stat").read_text().rsplit(")")[1].split()[11:13]))
         for task in Path("/proc/self/task").iterdir() if task.name != str(os.getpid())]
print(sum(ticks), max(ticks))
"""
    # NumPy's own threads spin for a while when they are made.
    alone = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    run = [sys.executable, "-c", code]
    done = subprocess.run(run, capture_output=True, text=True, check=True, timeout=120, env=alone)
    total, busiest = map(int, done.stdout.split())
    assert busiest >= 0.9 * total - 2, f"the busiest of the workers has {busiest} of {total} ticks"
