"""Curves and their methods, each with a way to draw its arguments: name -> function of a `Draw` (and of the curve)."""

import copy
import os
import pickle
import tempfile

import numpy as np

import stiefel_rs
from stiefel_rs import (
    CubicHermite,
    CubicSpline,
    Geodesic,
    GeometricCubic,
    GeometricPolynomial,
    QuasiGeodesic,
    RiemannianCubic,
    SmoothingSpline,
)

from .arguments import (
    ESTIMATES,
    KINDS,
    bc_type,
    ends,
    initial,
    knots,
    metric,
    some,
    spline_options,
    tension,
    threads,
)


def project(d):
    return {"project": lambda: d.chance(0.7)}


def parameters(d):
    return {"extrapolate": lambda: d.of([None, True, False]), **threads(d)}


def hermite(d):
    t, S = knots(d)
    V = d.of(ESTIMATES) if d.chance(0.3) else d.tangent(S)
    extra = some(d, {"extrapolate": lambda: d.chance(0.5), **threads(d), **project(d)})
    return CubicHermite, [t, S, V, d.word(KINDS)], extra


def spline(d):
    t, S = knots(d)
    if len(S) and d.chance(0.2):
        S[-1] = S[0]
    options = {**spline_options(d), **some(d, tension(d)), **some(d, project(d))}
    return CubicSpline, [t, S, bc_type(d, S), d.word(KINDS)], options


def smoothing(d):
    t, S = knots(d)
    weights = d.of([None, d.rng.uniform(0.1, 2, len(t)), np.zeros(len(t)), d.small(len(t))])
    return SmoothingSpline, [t, S, weights, d.of([None, d.number([0.1, 1.0, 0.0])])], spline_options(d)


def boundary_cubic(d):
    guess = d.of([None, None, (np.zeros((d.n, d.k)),) * 2, d.of([3, "ab", (), (1, 2), [np.zeros(3)] * 2])])
    numbers = {"tol": lambda: d.number([1e-12, 1e-8]), "max_iterations": lambda: d.integer([0, 1, 50])}
    return (
        RiemannianCubic.from_boundary,
        ends(d),
        some(d, {**numbers, **tension(d), **project(d), "guess": lambda: guess}),
    )


def initial_cubic(d):
    numbers = {"t_end": lambda: d.number([1.0, 2.0, -1.0]), "tol": lambda: d.number([1e-17, 1e-6])}
    extra = some(d, {**numbers, **tension(d), **project(d)})
    return RiemannianCubic.from_initial, initial(d), extra


def quintic(d):
    S0, V0, S1, V1 = ends(d)
    return GeometricPolynomial.quintic, [S0, V0, d.tangent(S0), S1, V1, d.tangent(S1)], {}


def pieces(d):
    return some(d, {"pieces": lambda: d.word(["quasi_geodesic", "geodesic"])})


CURVES = {
    "QuasiGeodesic": lambda d: (QuasiGeodesic, ends(d)[::2], {}),
    "QuasiGeodesic.from_velocity": lambda d: (QuasiGeodesic.from_velocity, initial(d)[:2], {}),
    "Geodesic": lambda d: (Geodesic, ends(d)[::2], some(d, {"metric": lambda: metric(d), **project(d)})),
    "Geodesic.from_velocity": lambda d: (
        Geodesic.from_velocity,
        initial(d)[:2],
        some(d, {"metric": lambda: metric(d), **project(d)}),
    ),
    "GeometricCubic": lambda d: (GeometricCubic, ends(d), pieces(d)),
    "GeometricCubic.from_control_points": lambda d: (GeometricCubic.from_control_points, [d.points(4)], {}),
    "GeometricPolynomial": lambda d: (GeometricPolynomial, [d.points(d.of([0, 1, 2, 3, 5]))], pieces(d)),
    "GeometricPolynomial.minimal_cost": lambda d: (
        GeometricPolynomial.minimal_cost,
        ends(d),
        some(d, {"degree": lambda: d.integer([3, 4, 5])}),
    ),
    "GeometricPolynomial.quintic": quintic,
    "RiemannianCubic.from_initial": initial_cubic,
    "RiemannianCubic.from_boundary": boundary_cubic,
    "CubicHermite": hermite,
    "CubicSpline": spline,
    "SmoothingSpline": smoothing,
}


def save(d, curve):
    def there_and_back(path):
        if not isinstance(path, bytes):
            return curve.save(path)
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "curve")
            curve.save(file)
            return stiefel_rs.load(file)

    return there_and_back, [b"" if d.chance(0.8) else d.of(["/", 3, None, "a\0b", ""])], {}


def inside(d, curve):
    a, b = curve.t_span
    return float(d.rng.uniform(min(a, b), max(a, b)))


def lengths(d, curve):
    return curve.arc_length, [], some(d, {name: lambda: d.number([inside(d, curve)]) for name in ["t0", "t1"]})


def variations(d, curve):
    S0, S1 = curve(curve.t_span[0]), curve(curve.t_span[1])
    return [d.tangent(S0), d.tangent(S0), d.tangent(S1), d.tangent(S1)]


def starts(d, curve):
    S = curve(curve.t_span[0])
    return [d.tangent(S) for _ in range(4)]


def cotangents(d, curve):
    t, one = d.parameters(), (curve.n, curve.k)
    try:
        shape = np.shape(t) + one
        return [t, d.of([np.ones(shape), np.full(shape, 1e300), np.full(shape, np.nan), np.ones(one)])]
    except ValueError:
        return [t, np.ones(one)]


def spline_variations(d, curve):
    dS = d.tangent(curve.points)
    if isinstance(curve.bc_type, str) and curve.bc_type == "periodic" and d.chance(0.8):
        dS[-1] = dS[0]
    return curve.point_variation, [d.parameters(), dS], some(d, {"dt": lambda: d.of([0 * curve.t, curve.t, None, 1.0])})


def duplicate(d, curve):
    return d.of([copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x)), repr, hash]), [curve], {}


# Attributes of the result of `derivative`.
DERIVATIVE_METHODS = {
    "__call__": lambda d, c: (c.derivative(), [d.parameters(), d.integer([0, 1, 2])], some(d, parameters(d))),
    "derivative": lambda d, c: (c.derivative().derivative, [d.integer([0, 1, 2])], {}),
}
METHODS = {
    **{f"derivative, {name}": method for name, method in DERIVATIVE_METHODS.items()},
    "__call__": lambda d, c: (c, [d.parameters(), d.integer([0, 1, 2, 3])], some(d, parameters(d))),
    "velocity": lambda d, c: (c.velocity, [d.parameters()], some(d, parameters(d))),
    "acceleration": lambda d, c: (c.acceleration, [d.parameters()], some(d, parameters(d))),
    "jerk": lambda d, c: (c.jerk, [d.parameters()], some(d, parameters(d))),
    "cost": lambda d, c: (c.cost, [], {}),
    "arc_length": lengths,
    "derivative": lambda d, c: (c.derivative, [d.integer([0, 1, 3])], {}),
    "resample": lambda d, c: (c.resample, [d.integer([2, 5])], some(d, threads(d))),
    "derivative_bounds": lambda d, c: (c.derivative_bounds, [], {}),
    "save": save,
    "duplicate": duplicate,
    "attributes": lambda d, c: (lambda: (c,), [], {}),
}
CUBIC_METHODS = {
    "restricted": lambda d, c: (c.restricted, [d.number([inside(d, c)]), d.number([inside(d, c)])], {}),
    "reparametrised": lambda d, c: (c.reparametrised, [d.number([0.0]), d.number([2.0])], {}),
    "reversed": lambda d, c: (c.reversed, [], {}),
    "initial_variation": lambda d, c: (c.initial_variation, variations(d, c), {}),
    "point_variation": lambda d, c: (c.point_variation, [d.parameters(), *variations(d, c)], {}),
    "cost_gradient": lambda d, c: (c.cost_gradient, [], {}),
    "point_pullback": lambda d, c: (c.point_pullback, cotangents(d, c), {}),
    "initial_point_variation": lambda d, c: (c.initial_point_variation, [d.parameters(), *starts(d, c)], {}),
    "initial_point_pullback": lambda d, c: (c.initial_point_pullback, cotangents(d, c), {}),
}
SPLINE_METHODS = {
    "point_variation": spline_variations,
    "point_pullback": lambda d, c: (c.point_pullback, cotangents(d, c), {}),
    "cost_gradient": lambda d, c: (c.cost_gradient, [], {}),
}


def methods(curve):
    own = {RiemannianCubic: CUBIC_METHODS, CubicSpline: SPLINE_METHODS}
    return {**METHODS, **own.get(type(curve), {})}
