"""The project itself."""

from __future__ import annotations

import inspect
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import problems
from benchmarks.compare import (
    complex_tasks,
    cubic_problems,
    derivative_tasks,
    gradient_problems,
    rotation_tasks,
    spline_tasks,
)
from benchmarks.compare.methods import extended
from benchmarks.compare.protocol import Measures, Task, Tasks, serve
from benchmarks.memory import resident
from stiefel_rs import GeometricCubic, Grassmann, RiemannianCubic, Stiefel, orthogonal_log, skew_exp

# Type checkers do not see static methods of a class whose constructor never returns.
Cubics: Any = RiemannianCubic
LOOP = 1000
RANDOM_CUBICS = tuple(f"{n},{k}" for n, k in cubic_problems.RANDOM)


def exp_task(m: int) -> Task:
    """Exponential of one matrix."""
    A = problems.skew(m)
    return Task(lambda: skew_exp(A))


def log_task(m: int) -> Task:
    """Logarithm of one rotation."""
    Q = problems.rotation(m)
    return Task(lambda: orthogonal_log(Q))


def cubic(n: int, k: int) -> GeometricCubic:
    """Curve with the common boundary data."""
    b = problems.boundary(n, k)
    return GeometricCubic(b.S0, b.V0, b.S1, b.V1)


def curve_task(n: int, k: int) -> Task:
    """1000 points of an existing curve."""
    curve, t = cubic(n, k), problems.parameters(1000)
    return Task(lambda: curve(t), units=len(t))


def single_task() -> Task:
    """One point, one call from Python."""
    curve = cubic(3, 1)
    return Task(lambda: curve(0.3))


def tall_task() -> Task:
    """All points of the curve on St(10^6, 4)."""
    curve, t = cubic(*problems.TALL), problems.parameters(problems.TALL_POINTS)
    return Task(lambda: curve(t), units=len(t), result=lambda: np.zeros(0))


def tall_start_task() -> Task:
    """Construction of that curve."""
    b = problems.boundary(*problems.TALL)
    return Task(lambda: GeometricCubic(b.S0, b.V0, b.S1, b.V1), result=lambda: np.zeros(0))


def riemannian_log_task(n: int, k: int, distance: str) -> Task:
    """Riemannian logarithm."""
    S0, S1, _ = problems.log_problem(n, k, distance)
    log = _method(Stiefel(n, k), "log")
    return Task(lambda: log(S0, S1))


def riemannian_exp_task(n: int, k: int, metric: str) -> Task:
    """Riemannian exponential."""
    S0, _, V = problems.log_problem(n, k, "0.5")
    exp = _method(Stiefel(n, k, metric=metric), "exp")
    return Task(lambda: exp(S0, V))


def subspace_exp_task(n: int, k: int) -> Task:
    """Riemannian exponential of the Grassmann manifold; as projectors, since bases differ."""
    Y0, _, V = problems.subspace_problem(n, k)
    M = Grassmann(n, k)
    return Task(lambda: M.exp(Y0, V), result=lambda: M.projector(M.exp(Y0, V)))


def subspace_log_task(n: int, k: int) -> Task:
    """Riemannian logarithm of the Grassmann manifold."""
    Y0, Y1, _ = problems.subspace_problem(n, k)
    M = Grassmann(n, k)
    return Task(lambda: M.log(Y0, Y1))


def retraction_task(n: int, k: int, kind: str) -> Task:
    """Retraction of the given kind."""
    S0, _, V = problems.log_problem(n, k, "0.5")
    M = Stiefel(n, k)
    if "kind" in inspect.signature(M.retract).parameters:
        retract = partial(_method(M, "retract"), kind=kind)
        return Task(lambda: retract(S0, V))
    if kind != "polar":
        raise NotImplementedError(f"this build's Stiefel.retract has no kind={kind!r}")
    return Task(lambda: M.project(S0 + V))


def initial_task() -> Task:
    """The paper's initial value problem on the sphere."""
    data = cubic_problems.paper("sphere").initial
    return Task(lambda: Cubics.from_initial(*data), result=lambda: state(Cubics.from_initial(*data), 1.0))


def initial_points_task() -> Task:
    """1000 points of that curve."""
    curve = Cubics.from_initial(*cubic_problems.paper("sphere").initial)
    t = problems.parameters(1000)
    return Task(lambda: curve(t), units=len(t))


def state(curve: RiemannianCubic, t: float) -> problems.Array:
    """Position and velocity at a time."""
    return np.stack([curve(t), curve.velocity(t)])


def boundary_task(name: str) -> Task:
    """A boundary value problem, accurate to 1e-12."""
    b = boundary(name)
    ends = b.S0, b.V0, b.S1, b.V1
    return Task(lambda: Cubics.from_boundary(*ends), result=lambda: state(Cubics.from_boundary(*ends), 0.5))


def boundary(name: str) -> problems.Boundary:
    """The data of a boundary value problem."""
    if name in cubic_problems.PAPER:
        return cubic_problems.paper(name).boundary
    if name == "reduced":
        return cubic_problems.reduced(cubic_problems.random_boundary(*cubic_problems.RANDOM[-1]))
    return cubic_problems.random_boundary(*map(int, name.split(",")))


def exact_task(name: str, where: str) -> Task:
    """Position and velocity to 40 digits."""
    exact = np.stack(getattr(cubic_problems.paper(name), where)[:2])
    return Task(lambda: exact)


def _method(M: Stiefel, name: str) -> Callable[..., object]:
    method: Callable[..., object] | None = getattr(M, name, None)
    if method is None:
        raise NotImplementedError(f"this build has no Stiefel.{name}")
    return method


def batch_task(work: str, *, loop: bool) -> Task:
    """A batch of small problems in one call, or the first of them in a Python loop."""
    function, arguments = batch(work)
    if not loop:
        return Task(lambda: function(*arguments), units=problems.BATCH)
    few = [argument[:LOOP] for argument in arguments]
    return Task(lambda: [function(*each) for each in zip(*few, strict=True)], units=LOOP)


def batch(work: str) -> tuple[Callable[..., object], tuple[problems.Array, ...]]:
    """Function and arguments of a batch."""
    match work.split("/"):
        case ["skew_exp", m]:
            return skew_exp, (problems.skew(int(m), (problems.BATCH,)),)
        case ["orthogonal_log", m]:
            return orthogonal_log, (problems.rotation(int(m), (problems.BATCH,)),)
        case [name, shape]:
            n, k = map(int, shape.split(","))
            M = Stiefel(n, k)
            S, V = problems.tangent_batch(n, k)
            return _method(M, name), (S, V) if name == "retract" else (S, M.retract(S, V))
    raise KeyError(work)


def tall_memory() -> float:
    """Peak resident memory of the curve on St(10^6, 4) and its points, divided by the size of input and output."""
    before = resident("VmRSS")
    b = problems.boundary(*problems.TALL)
    Path("/proc/self/clear_refs").write_text("5")
    points = GeometricCubic(b.S0, b.V0, b.S1, b.V1)(problems.parameters(problems.TALL_POINTS))
    inputs = sum(each.nbytes for each in (b.S0, b.V0, b.S1, b.V1))
    return (resident("VmHWM") - before) / (inputs + points.nbytes)


def gradient_task(work: str, *, gradient: bool) -> Task:
    """A function of a solution through JAX, with or without its gradient."""
    # JAX is only imported for these rows.
    from benchmarks.compare import gradient_tasks  # noqa: PLC0415

    return gradient_tasks.make(work, gradient=gradient)


BATCHES = (
    "skew_exp/3", "skew_exp/6", "orthogonal_log/3", "orthogonal_log/6",
    "retract/4,2", "inverse_retract/4,2", "log/4,2",
)  # fmt: skip


def import_task(module: str) -> Task:
    """A new process that imports a module."""
    command = [sys.executable, "-c", f"import {module}"]
    return Task(lambda: subprocess.run(command, check=True), result=lambda: np.zeros(0))


def tasks() -> Tasks:
    """All tasks by name."""
    found: dict[str, Callable[[], Task]] = {
        "curve_single/3,1:ours": single_task,
        "curve_tall:ours": tall_task,
        "curve_tall_start:ours": tall_start_task,
    }
    found["import:ours"] = partial(import_task, "stiefel_rs")
    found["import:numpy"] = partial(import_task, "numpy")
    found["cubic_initial/sphere:ours"] = initial_task
    found["cubic_initial/sphere:exact"] = partial(exact_task, "sphere", "end")
    found["cubic_points/sphere:ours"] = initial_points_task
    for name in (*cubic_problems.PAPER, "reduced", *RANDOM_CUBICS):
        found[f"cubic_boundary/{name}:ours"] = partial(boundary_task, name)
    for name in cubic_problems.PAPER:
        found[f"cubic_boundary/{name}:exact"] = partial(exact_task, name, "middle")
    for m in problems.SMALL_EXP + problems.LARGE:
        found[f"skew_exp/{m}:ours"] = partial(exp_task, m)
    for m in problems.SMALL_LOG + problems.LARGE:
        found[f"orthogonal_log/{m}:ours"] = partial(log_task, m)
    for n, k in problems.CURVES:
        found[f"curve/{n},{k}:ours"] = partial(curve_task, n, k)
    for work in BATCHES:
        found[f"batch/{work}:ours"] = partial(batch_task, work, loop=False)
        found[f"batch/{work}:ours_loop"] = partial(batch_task, work, loop=True)
    for n, k in problems.LOGS:
        found[f"exp/{n},{k}:ours"] = partial(riemannian_exp_task, n, k, "canonical")
        found[f"exp_euclidean/{n},{k}:ours"] = partial(riemannian_exp_task, n, k, "euclidean")
        for kind in ("polar", "qr"):
            found[f"retract_{kind}/{n},{k}:ours"] = partial(retraction_task, n, k, kind)
        for distance in problems.DISTANCES:
            found[f"log/{n},{k}/{distance}:ours"] = partial(riemannian_log_task, n, k, distance)
    for n, k in problems.SUBSPACES:
        found[f"subspace_exp/{n},{k}:ours"] = partial(subspace_exp_task, n, k)
        found[f"subspace_log/{n},{k}:ours"] = partial(subspace_log_task, n, k)
    for work in ("spline", *(f"{n},{k}" for n, k in gradient_problems.SHAPES)):
        found[f"gradient/{work}:ours"] = partial(gradient_task, work, gradient=True)
        found[f"gradient/{work}:value"] = partial(gradient_task, work, gradient=False)
    others = spline_tasks.tasks() | rotation_tasks.tasks() | derivative_tasks.tasks()
    return found | complex_tasks.tasks() | others


def exp_defect(m: int) -> float:
    """`|R^T R - I|_F` of an exponential, in extended precision."""
    return extended.orthogonality_defect(skew_exp(problems.skew(m)))


def log_backward_error(m: int) -> float:
    """`|e^L - Q|_F` of a logarithm, in extended precision."""
    Q = problems.rotation(m)
    return extended.backward_error(orthogonal_log(Q), Q)


def initial_error() -> float:
    """Error at t = 1 of the position, which has norm 1."""
    cubic = cubic_problems.paper("sphere")
    return float(np.linalg.norm(Cubics.from_initial(*cubic.initial)(1.0) - cubic.end[0]))


def boundary_residual(name: str) -> float:
    """Distance of position and velocity at t = 1 from the given ones."""
    b = boundary(name)
    curve = Cubics.from_boundary(b.S0, b.V0, b.S1, b.V1)
    return float(np.linalg.norm(state(curve, 1.0) - np.stack([b.S1, b.V1])))


def measures() -> Measures:
    """Measures other than times."""
    found: Measures = {"curve_tall:memory": tall_memory}
    found["cubic_initial/sphere:error"] = initial_error
    for name in RANDOM_CUBICS:
        found[f"cubic_boundary/{name}:residual"] = partial(boundary_residual, name)
    for m in problems.LARGE:
        found[f"skew_exp/{m}:defect"] = partial(exp_defect, m)
        found[f"orthogonal_log/{m}:backward"] = partial(log_backward_error, m)
    return found | spline_tasks.measures()


if __name__ == "__main__":
    serve(tasks(), measures(), packages=("stiefel-rs", "numpy"))
