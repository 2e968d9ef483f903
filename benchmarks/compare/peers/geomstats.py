"""geomstats: exponential and logarithm of its Stiefel manifold, canonical metric, and of its Grassmann manifold."""

from __future__ import annotations

from functools import partial

import geomstats.backend as gs
from geomstats.geometry.grassmannian import Grassmannian
from geomstats.geometry.stiefel import Stiefel

from benchmarks import problems
from benchmarks.compare.protocol import Task, Tasks, serve


def exp_task(n: int, k: int) -> Task:
    """Riemannian exponential."""
    S0, _, V = problems.log_problem(n, k, "0.5")
    metric = Stiefel(n, k).metric
    return Task(lambda: metric.exp(V, S0))


def log_task(n: int, k: int, distance: str) -> Task:
    """Riemannian logarithm, with the library's own tolerance."""
    S0, S1, _ = problems.log_problem(n, k, distance)
    metric = Stiefel(n, k).metric
    return Task(lambda: metric.log(S1, S0))


def subspace_exp_task(n: int, k: int) -> Task:
    """Riemannian exponential of the Grassmann manifold, whose points are projectors here."""
    Y0, _, V = problems.subspace_problem(n, k)
    P, X = Y0 @ Y0.T, V @ Y0.T + Y0 @ V.T
    metric = Grassmannian(n, k).metric
    return Task(lambda: metric.exp(X, P))


def subspace_log_task(n: int, k: int) -> Task:
    """Riemannian logarithm of the Grassmann manifold between projectors, as a horizontal vector."""
    Y0, Y1, _ = problems.subspace_problem(n, k)
    P0, P1 = Y0 @ Y0.T, Y1 @ Y1.T
    metric = Grassmannian(n, k).metric
    return Task(lambda: metric.log(P1, P0), result=lambda: metric.log(P1, P0) @ Y0)


def tasks() -> Tasks:
    """All tasks by name."""
    assert gs.__name__.endswith("numpy"), "the NumPy backend is to be timed"
    found: Tasks = {}
    for n, k in problems.LOGS:
        found[f"exp/{n},{k}:geomstats"] = partial(exp_task, n, k)
        for distance in problems.DISTANCES:
            found[f"log/{n},{k}/{distance}:geomstats"] = partial(log_task, n, k, distance)
    for n, k in problems.SUBSPACES:
        found[f"subspace_exp/{n},{k}:geomstats"] = partial(subspace_exp_task, n, k)
        found[f"subspace_log/{n},{k}:geomstats"] = partial(subspace_log_task, n, k)
    return found


if __name__ == "__main__":
    serve(tasks(), packages=("geomstats", "numpy", "scipy"))
