"""Derivatives, lengths and costs of the project's curves as tasks."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from benchmarks import problems
from benchmarks.compare import derivative_rows
from benchmarks.compare.protocol import Task, Tasks
from stiefel_rs import Curve, GeometricCubic, GeometricPolynomial, RiemannianCubic

# Type checkers do not see static methods of a class whose constructor never returns.
Cubics: Any = RiemannianCubic
POINTS = 1000
READ: dict[str, Callable[[Curve, Any], Any]] = {
    "positions": lambda curve, t: curve(t),
    "velocity": lambda curve, t: curve.velocity(t),
    "second derivative": lambda curve, t: curve(t, 2),
    "acceleration": lambda curve, t: curve.acceleration(t),
    "jerk": lambda curve, t: curve.jerk(t),
}
INTEGRALS: dict[str, Callable[[Curve], Any]] = {
    "arc_length": lambda curve: curve.arc_length(),
    "cost": lambda curve: curve.cost(),
    "resample": lambda curve: curve.resample(101),
    "derivative_bounds": lambda curve: curve.derivative_bounds(),
}


def _curve(name: str, n: int, k: int) -> Curve:
    b = problems.boundary(n, k)
    data = (b.S0, b.V0, b.S1, b.V1)
    found: Curve = GeometricCubic(*data) if name == "GeometricCubic" else Cubics.from_boundary(*data)
    return found


def _read_task(name: str, shape: tuple[int, int], quantity: str) -> Task:
    curve, t = _curve(name, *shape), problems.parameters(POINTS)
    return Task(lambda: READ[quantity](curve, t), units=POINTS)


def _integral_task(name: str) -> Task:
    curve = _curve("GeometricCubic", 3, 2)
    return Task(lambda: INTEGRALS[name](curve), result=lambda: np.zeros(0))


def _minimal_task(n: int, k: int) -> Task:
    b = problems.boundary(n, k)
    data = (b.S0, b.V0, b.S1, b.V1)
    found = partial(GeometricPolynomial.minimal_cost, *data, degree=derivative_rows.MINIMAL)
    return Task(found, result=lambda: np.zeros(0))


def _exact_task(n: int, k: int) -> Task:
    b = problems.boundary(n, k)
    return Task(lambda: Cubics.from_boundary(b.S0, b.V0, b.S1, b.V1), result=lambda: np.zeros(0))


def tasks() -> Tasks:
    """All of them."""
    found: Tasks = {}
    for name, shapes, quantities in (
        ("GeometricCubic", derivative_rows.GEOMETRIC, derivative_rows.QUANTITIES),
        ("RiemannianCubic", derivative_rows.RIEMANNIAN, derivative_rows.COVARIANT),
    ):
        for n, k in shapes:
            for quantity in quantities:
                row = f"derivatives/{name}/{n},{k}/{quantity}"
                found[f"{row}:ours"] = partial(_read_task, name, (n, k), quantity)
                found[f"{row}:positions"] = partial(_read_task, name, (n, k), "positions")
    for n, k in derivative_rows.FREE:
        found[f"derivatives/minimal_cost/{n},{k}:ours"] = partial(_minimal_task, n, k)
        found[f"derivatives/minimal_cost/{n},{k}:cubic"] = partial(_exact_task, n, k)
    for name in INTEGRALS:
        found[f"derivatives/{name}:ours"] = partial(_integral_task, name)
    return found
