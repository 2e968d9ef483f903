"""Random arguments used by several entry points."""

import numpy as np

MAPS = ["initial_point", "midpoint", "exponential", "exponential_midpoint", "cayley", "cayley_midpoint"]
MAPS += ["quasi_geodesic", "quasi_geodesic_midpoint"]
RETRACTIONS = ["quasi_geodesic", "qr", "polar", "cayley"]
ESTIMATES = ["catmull-rom", "akima", "natural"]
KINDS = ["riemannian", "geometric"]
THREADS = [1, 2, 3]


def some(d, options):
    """A random subset of the keyword arguments."""
    return {name: value() for name, value in options.items() if d.chance(0.35)}


def threads(d):
    return {"num_threads": lambda: d.integer(THREADS)}


def tension(d):
    return {"tension": lambda: d.number([0.0, 1.0, 20.0, 1e-9])}


def seed(d):
    return d.of([0, 1, 2**63, -1, None, np.random.default_rng(3), 1.5]) if d.chance(d.wild) else 7


def metric(d):
    return d.of(["canonical", "euclidean", 0.5, 1.0, -0.5, 0.0, -1.0, 1e-300, 1e300, float("nan"), "text", None, -2, 3])


def ends(d):
    """A boundary problem: S0, V0, S1, V1."""
    S0 = d.point()
    S1 = d.point()
    return [S0, d.tangent(S0), S1, d.tangent(S1)]


def initial(d):
    S = d.point()
    return [S, d.tangent(S), d.tangent(S), d.tangent(S)]


def knots(d):
    count = d.of([2, 3, 3, 4, 6]) if d.chance(0.95) else d.of([0, 1])
    return d.times(count), d.points(count)


def end_condition(d, S):
    return d.of(["natural", "clamped", (1, d.tangent(S)), (2, d.tangent(S)), (3, d.tangent(S))])


def bc_type(d, S):
    if len(S) == 0 or d.chance(0.4):
        return d.word(["natural", "clamped", "periodic"])
    return (end_condition(d, S[0]), end_condition(d, S[-1]))


def spline_options(d):
    numbers = {"tol": lambda: d.number([1e-12, 1e-8]), "max_iterations": lambda: d.integer([0, 1, 50])}
    return some(d, {"extrapolate": lambda: d.chance(0.5), **numbers, **threads(d)})
