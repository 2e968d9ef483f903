"""Boundary problems for the tests of batches, their solutions from a single process, and a cluster."""

from contextlib import contextmanager

import numpy as np
import pytest

import stiefel_rs
from stiefel_rs import GeometricCubic, RiemannianCubic

dask = pytest.importorskip("dask")
distributed = pytest.importorskip("distributed")
zarr = pytest.importorskip("zarr")


M = stiefel_rs.Stiefel(5, 2)
T = np.array([0.0, 0.3, 1.0])
COUNT = 40
# This problem is far too fast for a cubic to be found.
BAD = 23


@contextmanager
def cluster():
    """Two worker processes, and a client connected to them."""
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", memory_limit=0
        ) as started,
        distributed.Client(started) as connected,
    ):
        yield connected


def random_ends(count, seed=7, manifold=M):
    rng = np.random.default_rng(seed)
    S0 = manifold.random_point(rng, count)
    S1 = manifold.retract(S0, 0.4 * manifold.random_tangent(S0, rng))
    return S0, 0.3 * manifold.random_tangent(S0, rng), S1, 0.3 * manifold.random_tangent(S1, rng)


def unsolvable_ends():
    """One of the problems has no solution."""
    S0, V0, S1, V1 = random_ends(COUNT)
    V0 = V0.copy()
    V0[BAD] *= 1000
    return S0, V0, S1, V1


def solved(ends):
    """Results for both kinds, from a single process and one curve at a time."""

    def fields(curve, initial):
        S, V, A, J = initial
        report = curve.report
        return {
            "S": S, "V": V, "A": A, "J": J, "cost": curve.cost(), "points": curve(T), "code": 0, "message": "",
            "converged": report is None or report.converged,
            "iterations": report.iterations if report else 0,
            "residual": report.residual if report else 0.0,
        }  # fmt: skip

    exact = [RiemannianCubic.from_boundary(*data) for data in zip(*ends, strict=True)]
    geometric = [GeometricCubic(*data) for data in zip(*ends, strict=True)]
    rows = {
        "riemannian": [fields(curve, curve.initial) for curve in exact],
        "geometric": [
            fields(curve, (curve(0.0), curve.velocity(0.0), curve.acceleration(0.0), curve.jerk(0.0)))
            for curve in geometric
        ],
    }
    return {kind: {name: np.array([row[name] for row in found]) for name in found[0]} for kind, found in rows.items()}


def assert_same(found, expected):
    for name, values in found.items():
        if name == "message":
            assert [str(text) for text in values] == [str(text) for text in expected[name]]
        else:
            np.testing.assert_array_equal(values, expected[name], err_msg=name)
