"""pymanopt: exponential and retractions of its Stiefel manifold (Euclidean metric, no logarithm), and subspaces."""

from __future__ import annotations

from functools import partial

import numpy as np
from pymanopt.manifolds import Grassmann, Stiefel

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


def subspace_exp_task(n: int, k: int) -> Task:
    """Riemannian exponential of the Grassmann manifold; as projectors, since bases differ."""
    Y0, _, V = problems.subspace_problem(n, k)
    manifold = Grassmann(n, k)

    def projector() -> problems.Array:
        Y = manifold.exp(Y0, V)
        return np.asarray(Y @ Y.T)

    return Task(lambda: manifold.exp(Y0, V), result=projector)


def subspace_log_task(n: int, k: int) -> Task:
    """Riemannian logarithm of the Grassmann manifold."""
    Y0, Y1, _ = problems.subspace_problem(n, k)
    manifold = Grassmann(n, k)
    return Task(lambda: manifold.log(Y0, Y1))


def tasks() -> Tasks:
    """All tasks by name."""
    found: Tasks = {}
    for n, k in problems.LOGS:
        found[f"exp_euclidean/{n},{k}:pymanopt"] = partial(exp_task, n, k)
        for kind in ("polar", "qr"):
            found[f"retract_{kind}/{n},{k}:pymanopt"] = partial(retraction_task, n, k, kind)
    for n, k in problems.SUBSPACES:
        found[f"subspace_exp/{n},{k}:pymanopt"] = partial(subspace_exp_task, n, k)
        found[f"subspace_log/{n},{k}:pymanopt"] = partial(subspace_log_task, n, k)
    return found


if __name__ == "__main__":
    serve(tasks(), packages=("pymanopt", "numpy", "scipy"))
