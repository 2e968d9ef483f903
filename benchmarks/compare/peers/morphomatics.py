"""morphomatics (JAX, double precision, compiled): Bezier curves on the sphere and on SO(3); JAX's own expm."""

from __future__ import annotations

from functools import partial

import jax

jax.config.update("jax_enable_x64", True)

import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402
from morphomatics.geom import BezierSpline  # noqa: E402
from morphomatics.manifold import SO3, Sphere  # noqa: E402

from benchmarks import problems  # noqa: E402
from benchmarks.compare.methods.casteljau import control_points  # noqa: E402
from benchmarks.compare.protocol import Task, Tasks, serve  # noqa: E402


def exp_task(m: int) -> Task:
    """`jax.scipy.linalg.expm`, compiled."""
    A = jnp.asarray(problems.skew(m))
    function = jax.jit(jax.scipy.linalg.expm)
    return Task(lambda: function(A).block_until_ready())


def sphere_points() -> problems.Array:
    """Control points on the sphere as vectors."""
    b = problems.boundary(3, 1)
    return np.asarray(control_points(b.S0, b.V0, b.S1, b.V1)[:, :, 0])


def rotation_points() -> problems.Array:
    """The control points of the curve on St(3, 2) as rotations: the third column is the cross product."""
    b = problems.boundary(3, 2)
    P = control_points(b.S0, b.V0, b.S1, b.V1)
    return np.concatenate([P, np.cross(P[:, :, 0], P[:, :, 1])[:, :, None]], axis=2)


def curve_task(manifold: Sphere | SO3, points: problems.Array) -> Task:
    """1000 points of a cubic Bezier curve at once."""
    spline = BezierSpline(manifold, jnp.asarray(points)[None])
    t = jnp.asarray(problems.parameters(1000))
    function = jax.jit(jax.vmap(spline.eval))
    return Task(
        lambda: function(t).block_until_ready(),
        units=len(t),
        result=lambda: _frames(function(t)),
    )


def single_task() -> Task:
    """One point, one call from Python."""
    spline = BezierSpline(Sphere((3,)), jnp.asarray(sphere_points())[None])
    function = jax.jit(spline.eval)
    return Task(lambda: function(0.3).block_until_ready(), result=lambda: _frames(function(0.3)))


def _frames(points: jax.Array) -> problems.Array:
    """Points as they are on St(3, 1) and St(3, 2): vectors become columns, rotations lose their last one."""
    found = np.asarray(points)
    return found[..., :2] if found.shape[-2:] == (3, 3) else found[..., None]


def tasks() -> Tasks:
    """All tasks by name."""
    found: Tasks = {f"skew_exp/{m}:jax": partial(exp_task, m) for m in problems.LARGE}
    found["curve/3,1:morphomatics"] = lambda: curve_task(Sphere((3,)), sphere_points())
    found["curve/3,2:morphomatics"] = lambda: curve_task(SO3(), rotation_points())
    found["curve_single/3,1:morphomatics"] = single_task
    return found


if __name__ == "__main__":
    serve(tasks(), packages=("morphomatics", "jax", "jaxlib", "numpy"))
