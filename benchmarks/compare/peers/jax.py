"""JAX: its derivatives through solvers with a fixed number of steps."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp

from benchmarks.compare import gradient_problems
from benchmarks.compare.methods import unrolled
from benchmarks.compare.protocol import Task, Tasks, serve
from benchmarks.problems import Array


def task(function: Callable[[Any], Any], data: Array, shown: Callable[[Array], Array]) -> Task:
    """Value and gradient, compiled; with the memory that the compiled function takes in addition to its data."""
    start = time.perf_counter()
    compiled = jax.jit(jax.value_and_grad(function)).lower(data).compile()
    setup = time.perf_counter() - start
    size = compiled.memory_analysis().temp_size_in_bytes / 1e6

    def run() -> Any:
        return jax.block_until_ready(compiled(data))

    return Task(run, result=lambda: shown(run()[1]), setup=setup, note=lambda: f"{size:.0f} MB")


def spline_task() -> Task:
    """A spline of rotations as a function of its keyframes."""
    problem = gradient_problems.spline()

    def function(R: Any) -> Any:
        return jnp.sum(problem.weights * unrolled.spline_rotations(problem.t, R, gradient_problems.LEG_PARTS))

    return task(function, problem.R, lambda G: gradient_problems.along(problem.R, G))


def boundary_task(n: int, k: int) -> Task:
    """A boundary value problem as a function of its first velocity."""
    b, (_, weights) = gradient_problems.boundary(n, k), gradient_problems.boundary_weights(n, k)

    def function(V0: Any) -> Any:
        return jnp.sum(weights * unrolled.boundary_points(b.S0, V0, b.S1, b.V1))

    return task(function, b.V0, lambda G: gradient_problems.along(b.S0, G))


def tasks() -> Tasks:
    """All tasks by name."""
    found: Tasks = {"gradient/spline:unrolled": spline_task}
    for n, k in gradient_problems.UNROLLED:
        found[f"gradient/{n},{k}:unrolled"] = partial(boundary_task, n, k)
    return found


if __name__ == "__main__":
    serve(tasks(), packages=("jax", "numpy"))
