"""pymanopt: exponential and retractions of its Stiefel manifold, Euclidean metric. It has no logarithm there."""

from __future__ import annotations

from functools import partial

from pymanopt.manifolds import Stiefel

from benchmarks import problems
from benchmarks.compare.protocol import Task, Tasks, serve


def exp_task(n: int, k: int) -> Task:
    """Riemannian exponential, Euclidean metric."""
    S0, _, V = problems.log_problem(n, k, "0.5")
    manifold = Stiefel(n, k)
    return Task(lambda: manifold.exp(S0, V))


def retraction_task(n: int, k: int, kind: str) -> Task:
    """Retraction of the given kind."""
    S0, _, V = problems.log_problem(n, k, "0.5")
    manifold = Stiefel(n, k, retraction=kind)
    return Task(lambda: manifold.retraction(S0, V))


def tasks() -> Tasks:
    """All of them by name."""
    found: Tasks = {}
    for n, k in problems.LOGS:
        found[f"exp_euclidean/{n},{k}:pymanopt"] = partial(exp_task, n, k)
        for kind in ("polar", "qr"):
            found[f"retract_{kind}/{n},{k}:pymanopt"] = partial(retraction_task, n, k, kind)
    return found


if __name__ == "__main__":
    serve(tasks(), packages=("pymanopt", "numpy", "scipy"))
