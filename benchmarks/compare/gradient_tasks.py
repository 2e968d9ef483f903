"""The project's gradients through JAX as tasks."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp

from benchmarks.compare import gradient_problems
from benchmarks.compare.protocol import Task
from stiefel_rs import jax as differentiable

jax.config.update("jax_enable_x64", True)

# Counts the calls of all tasks: a solution for the same data, of this task or of another one, would be reused.
_CALLS = itertools.count(1)


def task(function: Callable[[Any], Any], data: Any, *, gradient: bool) -> Task:
    """A compiled value, or value and gradient; every call gets new data."""
    compiled = jax.jit(jax.value_and_grad(function) if gradient else function)

    def run() -> Any:
        return jax.block_until_ready(compiled(data * (1.0 + 1e-12 * next(_CALLS))))

    return Task(run, result=lambda: run()[1] if gradient else run())


def spline_task(*, gradient: bool) -> Task:
    """A spline of rotations as a function of its keyframes."""
    problem = gradient_problems.spline()
    times, weights = problem.times.ravel(), problem.weights.reshape(-1, 3, 3)

    def function(R: Any) -> Any:
        return jnp.sum(weights * differentiable.cubic_spline(problem.t, R, times))

    return task(function, problem.R, gradient=gradient)


def boundary_task(n: int, k: int, *, gradient: bool) -> Task:
    """A boundary value problem as a function of its first velocity."""
    b, (t, weights) = gradient_problems.boundary(n, k), gradient_problems.boundary_weights(n, k)

    def function(V0: Any) -> Any:
        return jnp.sum(weights * differentiable.riemannian_cubic(b.S0, V0, b.S1, b.V1, t))

    return task(function, b.V0, gradient=gradient)


def make(work: str, *, gradient: bool) -> Task:
    """The task of a row, selected by the part of its name after the slash."""
    if work == "spline":
        return spline_task(gradient=gradient)
    n, k = map(int, work.split(","))
    return boundary_task(n, k, gradient=gradient)
