"""The project's functions of complex matrices and frames, and of real data of the same shape, as tasks."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from benchmarks import problems
from benchmarks.compare import complex_rows, cubic_problems, spline_problems
from benchmarks.compare.protocol import Task, Tasks
from benchmarks.problems import Boundary, Field
from stiefel_rs import CubicSpline, RiemannianCubic, Stiefel, orthogonal_log, skew_exp

# Type checkers do not see static methods of a class whose constructor never returns.
Cubics: Any = RiemannianCubic


def _pairs(run: Callable[[], Any]) -> Task:
    """A task whose complex results are compared as pairs of real numbers."""
    return Task(run, result=lambda: np.ascontiguousarray(run()).view(np.float64))


def exp_task(m: int, field: Field) -> Task:
    """Exponential of one matrix."""
    A = problems.skew(m) if field == "real" else problems.skew_hermitian(m)
    return _pairs(lambda: skew_exp(A))


def log_task(m: int, field: Field) -> Task:
    """Logarithm of one rotation or unitary matrix."""
    Q = problems.rotation(m) if field == "real" else problems.unitary(m)
    return _pairs(lambda: orthogonal_log(Q))


def frame_log_task(n: int, k: int, field: Field) -> Task:
    """Riemannian logarithm."""
    S0, S1, _ = problems.log_problem(n, k, "0.5", field)
    M = Stiefel(n, k, field=field)
    return _pairs(lambda: M.log(S0, S1))


def boundary_task(data: Callable[..., Boundary], n: int, k: int, field: Field) -> Task:
    """A boundary value problem."""
    b = data(n, k, field=field)
    ends = b.S0, b.V0, b.S1, b.V1
    return Task(lambda: Cubics.from_boundary(*ends), result=lambda: np.zeros(0))


def spline_task(n: int, k: int, field: Field) -> Task:
    """The natural spline through a random walk."""
    knots = spline_problems.walk(n, k, complex_rows.KNOTS, field)
    return Task(lambda: CubicSpline(knots.t, knots.S), result=lambda: np.zeros(0))


def tasks() -> Tasks:
    """All of them."""
    makers: dict[str, Callable[[Field], Task]] = {}
    for m in problems.COMPLEX:
        makers[f"skew_exp_complex/{m}"] = partial(exp_task, m)
        makers[f"unitary_log/{m}"] = partial(log_task, m)
    for name, shapes, make in (
        ("log", complex_rows.LOGS, frame_log_task),
        ("near", complex_rows.BOUNDARIES, partial(boundary_task, problems.boundary)),
        ("far", complex_rows.BOUNDARIES, partial(boundary_task, cubic_problems.random_boundary)),
        ("spline", complex_rows.SPLINES, spline_task),
    ):
        for n, k in shapes:
            makers[f"complex/{name}/{n},{k}"] = partial(make, n, k)
    complex_ones: Tasks = {f"{name}:ours": partial(make, "complex") for name, make in makers.items()}
    return complex_ones | {f"{name}:real": partial(make, "real") for name, make in makers.items()}
