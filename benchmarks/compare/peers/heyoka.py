"""heyoka: cubics of the sphere in the ambient space, by its compiled Taylor integrator."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import heyoka as hy
import numpy as np

from benchmarks import problems
from benchmarks.compare import cubic_problems
from benchmarks.compare.protocol import Task, Tasks, serve

# Tolerance of Newton's method, and its maximal number of steps.
RESIDUAL, STEPS = 1e-12, 20


def equations() -> list[tuple[Any, Any]]:
    """`x' = v, v' = a - |v|^2 x, a' = j - <a, v> x, j' = <a, v> v - |v|^2 a - <j, v> x`."""
    x, v, a, j = (hy.make_vars(*(f"{name}{i}" for i in range(3))) for name in "xvaj")

    def inner(p: list[Any], q: list[Any]) -> Any:
        return hy.sum([r * s for r, s in zip(p, q, strict=True)])

    vv, av, jv = inner(v, v), inner(a, v), inner(j, v)
    return [
        *zip(x, v, strict=True),
        *((v[i], a[i] - vv * x[i]) for i in range(3)),
        *((a[i], j[i] - av * x[i]) for i in range(3)),
        *((j[i], av * v[i] - vv * a[i] - jv * x[i]) for i in range(3)),
    ]


def compiled(make: Callable[[], Any]) -> tuple[Any, float]:
    """An integrator and the seconds of its compilation, without cached results of an earlier one."""
    hy.llvm_state.set_diskcache_enabled(False)
    hy.llvm_state.clear_memcache()
    start = time.perf_counter()
    made = make()
    return made, time.perf_counter() - start


def initial_task() -> Task:
    """State at t = 1."""
    state = np.concatenate([each[:, 0] for each in cubic_problems.paper("sphere").initial])
    ta, setup = compiled(lambda: hy.taylor_adaptive(equations(), state.copy()))
    values = ta.state

    def run() -> None:
        ta.time = 0.0
        values[:] = state
        ta.propagate_until(1.0)

    def result() -> problems.Array:
        run()
        return np.array(values[:6]).reshape(2, 3, 1)

    return Task(run, result=result, setup=setup)


def points_task() -> Task:
    """Points of the continuous output."""
    state = np.concatenate([each[:, 0] for each in cubic_problems.paper("sphere").initial])
    ta, setup = compiled(lambda: hy.taylor_adaptive(equations(), state))
    output = ta.propagate_until(1.0, c_output=True)[4]
    t = problems.parameters(1000)
    return Task(lambda: output(t), units=len(t), result=lambda: np.array(output(t)[:, :3, None]), setup=setup)


class Newton:
    """Shooting with the derivatives of the variational equations, in tangent coordinates of both ends."""

    def __init__(self, b: problems.Boundary, *, compact: bool) -> None:
        self.known, self.wanted = (np.vstack(each)[:, 0] for each in ((b.S0, b.V0), (b.S1, b.V1)))
        B0, B1 = cubic_problems.tangent_basis(b.S0), cubic_problems.tangent_basis(b.S1)
        zero = np.zeros((3, 2))
        self.directions = np.vstack([np.zeros((6, 4)), np.block([[B0, zero], [zero, B0]])])
        self.coordinates = np.block([[B1, zero], [zero, B1]]).T
        self.guess = np.concatenate([B0.T @ w[:, 0] for w in cubic_problems.straight_guess(b)])
        system = equations()
        # Derivatives in four directions of the initial state; the directions are passed with the state.
        variations = hy.var_ode_sys(system, [variable for variable, _ in system[:4]], order=1)
        start = np.concatenate([self.known, np.zeros(6)])
        self.integrator, self.setup = compiled(lambda: hy.taylor_adaptive(variations, start, compact_mode=compact))
        self.values = self.integrator.state

    def integrate(self, c: problems.Array, end: float) -> None:
        """State and derivatives at a time."""
        self.integrator.time = 0.0
        self.values[:6] = self.known
        self.values[6:12] = self.directions[6:] @ c
        self.values[12:] = self.directions.ravel()
        self.integrator.propagate_until(end)

    def solve(self) -> problems.Array:
        """Coordinates of the initial acceleration and jerk."""
        c = self.guess
        for _ in range(STEPS):
            self.integrate(c, 1.0)
            defect = self.values[:6] - self.wanted
            if np.linalg.norm(defect) <= RESIDUAL:
                return c
            derivative = self.coordinates @ self.values[12:].reshape(12, 4)[:6]
            c = c - np.linalg.solve(derivative, self.coordinates @ defect)
        raise ArithmeticError(f"defect {np.linalg.norm(defect):.1e} after {STEPS} steps")

    def middle(self) -> problems.Array:
        """Position and velocity at t = 1/2."""
        self.integrate(self.solve(), 0.5)
        return np.array(self.values[:6]).reshape(2, 3, 1)


def boundary_task(*, compact: bool) -> Task:
    """The paper's boundary problem on the sphere."""
    newton = Newton(cubic_problems.paper("sphere").boundary, compact=compact)
    return Task(newton.solve, result=newton.middle, setup=newton.setup)


def tasks() -> Tasks:
    """All tasks by name."""
    return {
        "cubic_initial/sphere:heyoka": initial_task,
        "cubic_points/sphere:heyoka": points_task,
        "cubic_boundary/sphere:heyoka": partial(boundary_task, compact=False),
        "cubic_boundary/sphere:compact": partial(boundary_task, compact=True),
    }


if __name__ == "__main__":
    serve(tasks(), packages=("heyoka", "numpy"))
