"""Ctrl-C during long calls: the calls poll for it, and leave objects unchanged.

How many seconds it takes is measured by `make interrupts`, not here.
"""

import _thread
import itertools
import os
import pickle
import signal
import subprocess
import sys
import threading
from functools import partial

import numpy as np
import pytest
from beside import HANGS, StoppedError, handled, stopped_while_it_runs

from benchmarks.interrupt_calls import CALLS, cubic, geometric, hermite, walk
from stiefel_rs import CubicHermite, CubicSpline, InvalidInputError, load, skew_exp
from stiefel_rs._core import _restored


def state():
    """Data for the calls."""
    return [hermite()([0.5, 99.25], 1), hermite().points, cubic()(0.5), geometric()(0.5)]


def test_a_call_that_does_not_look_is_found():
    # A sum in NumPy, which releases the interpreter lock and does not poll for signals.
    assert stopped_while_it_runs(partial(np.sin, np.zeros(1_000_000))) == "finished"


@pytest.mark.parametrize("name", CALLS)
def test_a_long_call_looks_for_ctrl_c(name):
    before = state()
    assert stopped_while_it_runs(CALLS[name]()) == "stopped"
    for found, expected in zip(state(), before, strict=True):
        assert np.array_equal(found, expected)


NUMBERS = np.zeros((2**19 // 512, 32, 16))
READ = {
    "contiguous": NUMBERS,
    "backwards": NUMBERS[::-1],
    "transposed": NUMBERS.swapaxes(-1, -2),
    "float32": NUMBERS.astype(np.float32),
    "integers": NUMBERS.astype(np.int16),
    "broadcast": np.broadcast_to(NUMBERS[0], NUMBERS.shape),
}
# array -> a call that is refused as soon as its arrays are read, before anything is computed.
REFUSED = {
    "matrices": lambda array: partial(skew_exp, array),
    "points": lambda array: partial(CubicSpline, np.zeros(3), array, "unknown"),
    "times": lambda array: partial(CubicSpline, array.reshape(-1), np.zeros((3, 3, 1))),
    "stored": lambda array: partial(
        _restored, {"format": "stiefel_rs curve", "kind": "unknown", "version": 1, "x": array}
    ),
}


@pytest.mark.parametrize("entry", REFUSED)
@pytest.mark.parametrize("layout", READ)
def test_reading_large_arguments_looks_for_ctrl_c(entry, layout):
    """4 MB of float64 are read in pieces: if a signal is pending from the start, reading stops early."""
    call = REFUSED[entry](READ[layout])
    with pytest.raises(InvalidInputError):
        call()
    with handled() as handler:
        assert handler.outcome(partial(_thread.interrupt_main), call) == "stopped"


# Between opening a file and entering `with`, Python itself may be interrupted; the file is then closed by the garbage
# collector.
@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.parametrize("what", ["save", "load", "pickle"])
def test_files_are_whole_after_ctrl_c(what, tmp_path, rng):
    """Mostly Python code: the signal may arrive anywhere."""
    t, S = walk(5_000)
    curve = CubicHermite(t, S, 0 * S, "geometric")
    path = tmp_path / "curve.npz"
    curve.save(path)
    content = path.read_bytes()
    work = {
        "save": lambda: curve.save(path),
        "load": lambda: load(path),
        "pickle": lambda: pickle.loads(pickle.dumps(curve)),
    }[what]

    def interrupt(delay):
        sum(range(delay))
        signal.raise_signal(signal.SIGINT)

    for delay in rng.integers(200_000, size=10):
        with handled(), pytest.raises(StoppedError):
            threading.Thread(target=interrupt, args=[delay]).start()
            for _ in itertools.count():
                work()
        assert os.listdir(tmp_path) == [path.name]
        assert path.read_bytes() == content
    assert np.array_equal(load(path).points, curve.points)


CHILD = """
import numpy as np
from beside import beside
from benchmarks.interrupt_calls import CALLS, CHART, EQUATOR
call = CALLS["integrate"]()
try:
    with beside(lambda: print("running", flush=True)):
        call()
except KeyboardInterrupt:
    print("interrupted", flush=True)
print(CHART.integrate(EQUATOR, 3000).shape, flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT cannot be sent to one process")
def test_an_interrupted_process_goes_on_working(spawn):
    path = os.pathsep.join([os.path.dirname(__file__), *sys.path])
    process = spawn("-c", CHILD, stdout=subprocess.PIPE, env=os.environ | {"PYTHONPATH": path})
    assert process.stdout.readline() == "running\n"
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate(timeout=HANGS)
    assert said == "interrupted\n(3001, 8)\n"


def test_ctrl_c_in_the_first_call_is_no_panic():
    """NumPy's C interface is loaded with the module; when the first call loaded it, an exception there was a panic."""
    code = """
import numpy, stiefel_rs
def interrupted(*_):
    raise KeyboardInterrupt
numpy.lib.NumpyVersion = interrupted
print(stiefel_rs.skew_exp([[0.0, 0.0], [0.0, 0.0]]).shape)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=HANGS, check=False)
    assert done.stdout == "(2, 2)\n", done.stderr
