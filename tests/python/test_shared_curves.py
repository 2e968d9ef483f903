"""Sixteen threads share one curve of each class and make every kind of call: results are those of one thread."""

import copy
import gc
import pickle
import sys
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest
from beside import HANGS
from test_save import CURVES, walk

import stiefel_rs
from stiefel_rs import QuasiGeodesic, RiemannianCubic, StiefelError

THREADS, ROUNDS = 16, 2


def bits(value):
    """All data of a result, as bytes and text."""
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    if isinstance(value, (tuple, list)):
        return [bits(x) for x in value]
    return repr(value)


def calls(curve, folder):
    """Calls of one curve by name; each gives the same bits every time."""
    start, end = curve.t_span
    few, many = np.linspace(start, end, 5), np.linspace(start, end, 300)

    def there_and_back(i):
        path = folder / f"curve{i}.npz"
        curve.save(path)
        return stiefel_rs.load(path)(few)

    made = {
        "few": lambda i: [curve(few, nu) for nu in range(4)],
        "many": lambda i: curve(many, 1, num_threads=2),
        "derivatives": lambda i: [curve.velocity(few), curve.acceleration(few), curve.jerk(few)],
        "numbers": lambda i: [curve.cost(), curve.arc_length(), curve.derivative_bounds()],
        "resample": lambda i: curve.resample(7),
        "copies": lambda i: [copy.deepcopy(curve)(few), pickle.loads(pickle.dumps(curve))(few), repr(curve)],
        "file": there_and_back,
        "attributes": lambda i: [
            repr(getattr(curve, x)) for x in dir(curve) if not x.startswith("_") and x != "pieces"
        ],
        "error": lambda i: refused(curve),
    }
    if isinstance(curve, RiemannianCubic):
        made["other cubics"] = lambda i: [curve.reversed()(start), curve.restricted(start, end)(few)]
    return made


def refused(curve):
    with pytest.raises(StiefelError) as caught:
        curve(np.nan)
    return str(caught.value)


def plain(name, result):
    # The text of bound methods contains an address.
    return [x for x in result if " object at 0x" not in x] if name == "attributes" else bits(result)


@pytest.mark.parametrize("name", CURVES)
def test_sixteen_threads_share_a_curve(name, tmp_path):
    curve = CURVES[name](*walk(4, 2, 4))
    made = calls(curve, tmp_path)
    # A new curve, so that the threads compute at the same time what is built on first use.
    other = CURVES[name](*walk(4, 2, 4))
    expected = {key: plain(key, call(99)) for key, call in calls(other, tmp_path).items()}
    gate = Barrier(THREADS)

    def work(i):
        names = list(made)
        np.random.default_rng(i).shuffle(names)
        gate.wait(timeout=HANGS)
        return [(key, plain(key, made[key](i))) for _ in range(ROUNDS) for key in names]

    with ThreadPoolExecutor(THREADS) as pool:
        for found in pool.map(work, range(THREADS)):
            for key, result in found:
                assert result == expected[key], f"{key} differs between threads"


def test_every_class_of_curve_is_shared():
    classes = {type(make(*walk(4, 2, 4))) for make in CURVES.values()}
    public = {x for x in vars(stiefel_rs).values() if isinstance(x, type) and issubclass(x, stiefel_rs.Curve)}
    assert classes == public - {stiefel_rs.Curve, stiefel_rs.PiecewiseCurve}


class Finalized:
    """Garbage that runs code when it is collected: the interpreter may switch threads there."""

    def __init__(self):
        self.ring = self

    def __del__(self):
        sum(range(50))


def test_files_are_read_by_threads_while_garbage_is_collected(tmp_path):
    curve = QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]])
    path = tmp_path / "curve.npz"
    curve.save(path)

    def work(i):
        for _ in range(100):
            Finalized()
            assert (stiefel_rs.load(path)(0.5) == curve(0.5)).all()

    threshold, interval = gc.get_threshold(), sys.getswitchinterval()
    gc.set_threshold(20)
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(THREADS) as pool:
            list(pool.map(work, range(THREADS), timeout=HANGS))
    finally:
        gc.set_threshold(*threshold)
        sys.setswitchinterval(interval)
