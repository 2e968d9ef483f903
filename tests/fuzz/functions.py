"""Functions and classes other than curves: name -> function of a `Draw` that returns (callable, arguments)."""

import io
import os
import pickle
import tempfile
from pathlib import Path

import numpy as np

import stiefel_rs
from stiefel_rs import (
    ConvergenceError,
    CubicHermite,
    CubicSpline,
    DerivativeBounds,
    Geodesic,
    GeometricCubic,
    InvalidInputError,
    LogReport,
    OutsideDomainError,
    QuasiGeodesic,
    RiemannianCubic,
    SmoothingSpline,
    SolverReport,
    Stiefel,
    StiefelError,
)

from .arguments import ESTIMATES, ends, initial, knots, metric, some, tension, threads


def integrate_cubic(d):
    numbers = {"t_end": lambda: d.number([1.0, 0.1, -1.0]), "order": lambda: d.integer([1, 2, 3, 4, 6, 8])}
    extra = some(d, {**numbers, **tension(d)})
    return stiefel_rs.integrate_cubic, [*initial(d), d.integer([1, 3, 10])], extra


def integrate_embedded(d):
    numbers = {"t_end": lambda: d.number([1.0, 0.1, -1.0]), "map": lambda: d.word(["midpoint"])}
    return stiefel_rs.integrate_embedded, [*initial(d), d.integer([1, 3, 10])], some(d, numbers)


def solved(*ends, **extra):
    """The solved problems of a batch: results of the others are not finite."""
    batch = stiefel_rs.solve_boundary(*ends, **extra)
    return [field[batch.converged] for field in batch]


def estimate(d):
    t, S = knots(d)
    extra = some(d, {"method": lambda: d.word(ESTIMATES), "closed": lambda: d.chance(0.5), **threads(d)})
    return stiefel_rs.estimate_velocities, [t, S], extra


def damaged(content, d):
    """Bytes of a file, some of them replaced, removed or duplicated."""
    data = bytearray(content)
    for _ in range(d.of([0, 1, 1, 2, 5])):
        at = d.source.randrange(max(1, len(data)))
        match d.of(["set", "set", "cut", "drop", "double", "number"]):
            case "set":
                data[at : at + 1] = bytes([d.source.randrange(256)])
            case "cut":
                del data[at:]
            case "drop":
                del data[at : at + d.of([1, 8, 64])]
            case "number":
                data[at : at + 8] = np.array([d.of([np.nan, np.inf, 1e300, 0.0, -1.0])]).tobytes()
            case _:
                data[at:at] = data[at : at + d.of([1, 8, 64])]
    return bytes(data)


def load_bytes(content):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "curve.npz"
        path.write_bytes(content)
        return stiefel_rs.load(path)


def load_arrays(form):
    file = io.BytesIO()
    np.savez(file, **form)
    return load_bytes(file.getvalue())


def stored(d):
    S0, V0, S1, V1 = [np.eye(3, 1), np.eye(3, 1)[::-1] * 0.5, np.eye(3, 1)[[2, 0, 1]], np.eye(3, 1)[::-1] * 0.5]
    S = np.stack([S0, S1, np.eye(3, 1)[::-1]])
    made = [QuasiGeodesic(S0, S1), Geodesic(S0, S1), GeometricCubic(S0, V0, S1, V1 * 0), CubicSpline([0, 1, 2.0], S)]
    made += [CubicHermite([0, 1, 2.0], S, 0 * S), SmoothingSpline([0, 1, 2.0], S, lam=0.5)]
    made += [RiemannianCubic.from_initial(S0, V0, V0, V0)]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "curve.npz"
        d.of(made).save(path)
        return path.read_bytes()


def load(d):
    if d.chance(0.1):
        return stiefel_rs.load, [d.of([None, 3, "", "no such file", b"no", "a\0b", "\ud800", os.curdir, Refuses])], {}
    content = stored(d)
    if d.chance(0.5):
        return load_bytes, [damaged(content, d)], {}
    # An intact archive whose arrays do not form a curve, which reaches all checks of the reader.
    with np.load(io.BytesIO(content)) as archive:
        form = {key: archive[key] for key in archive.files}
    for _ in range(d.of([1, 1, 2])):
        key = d.of(sorted(form))
        match d.of(["twist", "twist", "drop", "junk", "other"]):
            case "twist":
                form[key] = (
                    d.entries(np.asarray(form[key]))
                    if np.asarray(form[key]).dtype == float
                    else d.of([0, 1, 99, -1, "", "text", 0.5])
                )
            case "drop":
                del form[key]
            case "junk":
                form[key] = d.of([np.zeros(0), np.zeros((2, 2)), np.array(["a"]), 2**62, 1j, "CubicSpline", -1.5])
            case _:
                form["more"] = np.zeros(3)
        if not form:
            break
    return load_arrays, [form], {}


class Refuses:
    def __fspath__(self):
        return 3


def log_report(d):
    arrays = [np.array([d.chance(0.5)]), np.array([3]), *[d.small(1) for _ in range(2)], np.array([True])]
    return LogReport, d.of([arrays, [True, 3, 0.5, 1.0, False]]), {}


def exception(d):
    report = SolverReport(False, 3, 0.5, 1e-12, "max_iterations")
    kind, arguments = d.of(
        [
            (StiefelError, ["text"]),
            (InvalidInputError, ["text"]),
            (OutsideDomainError, ["text", d.number([1.0])]),
            (ConvergenceError, ["text", d.of([None, report])]),
        ]
    )
    return lambda *x: pickle.loads(pickle.dumps(kind(*x))), arguments, {}


FUNCTIONS = {
    "skew_exp": lambda d: (stiefel_rs.skew_exp, [d.skew(d.of([1, 2, 3, 4, 7]))], some(d, threads(d))),
    "orthogonal_log": lambda d: (stiefel_rs.orthogonal_log, [d.rotation()], some(d, threads(d))),
    "solve_boundary": lambda d: (solved, ends(d), some(d, threads(d))),
    "BoundaryBatch": lambda d: (
        stiefel_rs.BoundaryBatch,
        [*d.rng.uniform(0, 1, (2, 5, 3, 1)), *d.rng.uniform(0, 1, (3, 5))],
        {},
    ),
    "estimate_velocities": estimate,
    "integrate_cubic": integrate_cubic,
    "integrate_embedded": integrate_embedded,
    "load": load,
    "SolverReport": lambda d: (
        SolverReport,
        [d.chance(0.5), d.integer([3]), d.number([0.5]), 1e-12, d.word(["max_iterations"])],
        {},
    ),
    "LogReport": log_report,
    "DerivativeBounds": lambda d: (DerivativeBounds, [*d.rng.uniform(0, 1, 3).tolist(), d.word(["sampling"])], {}),
    "errors": exception,
    "Stiefel": lambda d: (Stiefel, [d.integer([3, 4]), d.integer([1, 2])], some(d, {"metric": lambda: metric(d)})),
}
