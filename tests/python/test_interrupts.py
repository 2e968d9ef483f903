"""Ctrl-C during long calls of many knots, many problems and files: within a second, and the objects are as before."""

import signal
import subprocess
import sys
import time

import pytest

# From the signal to the exception, and from there to the end of the process.
STOP_LIMIT = 1.0
PATIENCE = 20.0

SETUP = """
import itertools, os, pickle, sys, tempfile, time
import numpy as np
from stiefel_rs import CubicHermite, CubicSpline, RiemannianCubic, SmoothingSpline, Stiefel, Geodesic
from stiefel_rs import GeometricPolynomial, estimate_velocities, integrate_cubic, load
N = 100_000
rng = np.random.default_rng(0)
t = np.arange(float(N))
a, b = np.cumsum(rng.uniform(-0.3, 0.3, (2, N)), axis=1)
P = np.stack([np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), np.sin(b)], axis=-1)[..., None]
P /= np.linalg.norm(P, axis=1, keepdims=True)
M = Stiefel(30, 10)
S0 = M.random_point(0)
V0 = 0.5 * M.random_tangent(S0, 1) / M.norm(S0, M.random_tangent(S0, 1))
S1 = M.exp(S0, V0)
many = M.random_point(2, 1000)
near = M.exp(many, 0.5 * M.random_tangent(many, 3) / 10)
cubic = RiemannianCubic.from_initial(S0, V0, 0 * V0, V0)
K = {knots}
curve = CubicHermite(t[:K], P[:K], "catmull-rom", "geometric")
path = os.path.join(tempfile.mkdtemp(), "curve.npz")
curve.save(path)
def state():
    there = sorted(os.listdir(os.path.dirname(path)))
    return curve([0.5, 99.25], 1).tobytes() + curve.points.tobytes() + cubic(0.5).tobytes() + repr(there).encode()
before = state()
print("ready", flush=True)
try:
    {call}
except KeyboardInterrupt:
    print("interrupted", time.time(), flush=True)
else:
    print("finished", time.time(), flush=True)
same = state() == before and load(path).points.tobytes() == curve.points.tobytes()
print("same" if same else "changed", flush=True)
os.remove(path)
os._exit(0)
"""

LONG_CALLS = {
    "spline": "CubicSpline(t, P)",
    "spline_geometric": "CubicSpline(t, P, kind='geometric')",
    "spline_periodic": "CubicSpline(np.append(t, N), np.concatenate([P, P[:1]]), 'periodic')",
    "smoothing": "SmoothingSpline(t, P, lam=1.0)",
    "smoothing_chosen": "SmoothingSpline(t, P)",
    "arc_length": "curve.arc_length()",
    "cost": "curve.cost()",
    "derivative_bounds": "[curve.derivative_bounds() for _ in itertools.count()]",
    "resample": "curve.resample(1_000_000)",
    "velocities": "[estimate_velocities(t, P, 'natural') for _ in itertools.count()]",
    "log_batch": "[M.log(many, near) for _ in itertools.count()]",
    "exp_batch": "[M.exp(many, 0.1 * M.random_tangent(many, 1)) for _ in itertools.count()]",
    "boundary": "[RiemannianCubic.from_boundary(S0, V0, S1, 0 * V0) for _ in itertools.count()]",
    "all_found": "RiemannianCubic.from_boundary(S0, 20 * V0, S1, 0 * V0, all_found=True)",
    "minimal_cost": "[GeometricPolynomial.minimal_cost(S0, V0, S1, 0 * V0) for _ in itertools.count()]",
    "integrate_cubic": "integrate_cubic(S0, V0, 0 * V0, V0, 1_000_000)",
    "variation": "cubic.point_variation(np.linspace(0, 1, 1_000_000), 0 * V0, V0, 0 * V0, 0 * V0)",
    "save": "[curve.save(path) for _ in itertools.count()]",
    "load": "[load(path) for _ in itertools.count()]",
    "pickle": "[pickle.loads(pickle.dumps(curve)) for _ in itertools.count()]",
}
# Where one call of the size of the others would end within the second.
KNOTS = {"save": 100_000, "load": 100_000, "pickle": 100_000}


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT cannot be sent to one process")
@pytest.mark.parametrize("name", LONG_CALLS)
def test_ctrl_c_leaves_everything_as_it_was(name, spawn):
    process = spawn("-c", SETUP.format(call=LONG_CALLS[name], knots=KNOTS.get(name, 10_000)), stdout=subprocess.PIPE)
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.7)
    assert process.poll() is None
    start = time.time()
    process.send_signal(signal.SIGINT)
    try:
        said, _ = process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        pytest.fail(f"still running {PATIENCE} s after the signal")
    what, when, state = said.split()
    assert what == "interrupted", f"the call {what}"
    assert float(when) - start < STOP_LIMIT, f"KeyboardInterrupt came {float(when) - start:.2f} s after the signal"
    assert state == "same"
