"""Every entry point with a way to draw its arguments: name -> function of a `Draw` that gives (callable, arguments).

Arguments that are named in the dictionary by a number are positional.
"""

import copy
import io
import os
import pickle
import tempfile
from pathlib import Path

import numpy as np

import stiefel_rs
from stiefel_rs import (
    Chart,
    ConvergenceError,
    CubicHermite,
    CubicSpline,
    DerivativeBounds,
    Geodesic,
    GeometricCubic,
    GeometricPolynomial,
    InvalidInputError,
    LogReport,
    OutsideDomainError,
    QuasiGeodesic,
    RiemannianCubic,
    SmoothingSpline,
    SolverReport,
    Stiefel,
    StiefelError,
)

MAPS = ["initial_point", "midpoint", "exponential", "exponential_midpoint", "cayley", "cayley_midpoint"]
MAPS += ["quasi_geodesic", "quasi_geodesic_midpoint"]
RETRACTIONS = ["quasi_geodesic", "qr", "polar", "cayley"]
ESTIMATES = ["catmull-rom", "akima", "natural"]
KINDS = ["riemannian", "geometric"]
THREADS = [1, 2, 3]


def some(d, options):
    """A random part of the keyword arguments."""
    return {name: value() for name, value in options.items() if d.chance(0.35)}


def threads(d):
    return {"num_threads": lambda: d.integer(THREADS)}


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


# Curves: (class or constructor, positional arguments, keyword arguments).


def hermite(d):
    t, S = knots(d)
    V = d.of(ESTIMATES) if d.chance(0.3) else d.tangent(S)
    extra = some(d, {"extrapolate": lambda: d.chance(0.5), **threads(d)})
    return CubicHermite, [t, S, V, d.word(KINDS)], extra


def spline(d):
    t, S = knots(d)
    if len(S) and d.chance(0.2):
        S[-1] = S[0]
    return CubicSpline, [t, S, bc_type(d, S), d.word(KINDS)], spline_options(d)


def smoothing(d):
    t, S = knots(d)
    weights = d.of([None, d.rng.uniform(0.1, 2, len(t)), np.zeros(len(t)), d.small(len(t))])
    return SmoothingSpline, [t, S, weights, d.of([None, d.number([0.1, 1.0, 0.0])])], spline_options(d)


def boundary_cubic(d):
    guess = d.of([None, None, (np.zeros((d.n, d.k)),) * 2, d.of([3, "ab", (), (1, 2), [np.zeros(3)] * 2])])
    numbers = {"tol": lambda: d.number([1e-12, 1e-8]), "max_iterations": lambda: d.integer([0, 1, 50])}
    return RiemannianCubic.from_boundary, ends(d), some(d, {**numbers, "guess": lambda: guess})


def initial_cubic(d):
    extra = some(d, {"t_end": lambda: d.number([1.0, 2.0, -1.0]), "tol": lambda: d.number([1e-17, 1e-6])})
    return RiemannianCubic.from_initial, initial(d), extra


def quintic(d):
    S0, V0, S1, V1 = ends(d)
    return GeometricPolynomial.quintic, [S0, V0, d.tangent(S0), S1, V1, d.tangent(S1)], {}


def pieces(d):
    return some(d, {"pieces": lambda: d.word(["quasi_geodesic", "geodesic"])})


CURVES = {
    "QuasiGeodesic": lambda d: (QuasiGeodesic, ends(d)[::2], {}),
    "QuasiGeodesic.from_velocity": lambda d: (QuasiGeodesic.from_velocity, initial(d)[:2], {}),
    "Geodesic": lambda d: (Geodesic, ends(d)[::2], some(d, {"metric": lambda: metric(d)})),
    "Geodesic.from_velocity": lambda d: (
        Geodesic.from_velocity,
        initial(d)[:2],
        some(d, {"metric": lambda: metric(d)}),
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


# Functions.


def integrate_cubic(d):
    extra = some(d, {"t_end": lambda: d.number([1.0, 0.1, -1.0]), "order": lambda: d.integer([1, 2, 3, 4, 6, 8])})
    return stiefel_rs.integrate_cubic, [*initial(d), d.integer([1, 3, 10])], extra


def estimate(d):
    t, S = knots(d)
    extra = some(d, {"method": lambda: d.word(ESTIMATES), "closed": lambda: d.chance(0.5), **threads(d)})
    return stiefel_rs.estimate_velocities, [t, S], extra


def damaged(content, d):
    """Bytes of a file with some of them replaced, removed or doubled."""
    data = bytearray(content)
    for _ in range(d.of([0, 1, 1, 2, 5])):
        at = d.source.randrange(max(1, len(data)))
        match d.of(["set", "set", "cut", "drop", "double", "number"]):
            case "set":
                data[at : at + 1] = bytes([d.source.randrange(256)])
            case "cut":
                del data[at:]
            case "drop":
                del data[at : at + d.of([1, 8, 64])]
            case "number":
                data[at : at + 8] = np.array([d.of([np.nan, np.inf, 1e300, 0.0, -1.0])]).tobytes()
            case _:
                data[at:at] = data[at : at + d.of([1, 8, 64])]
    return bytes(data)


def load_bytes(content):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "curve.npz"
        path.write_bytes(content)
        return stiefel_rs.load(path)


def load_arrays(form):
    file = io.BytesIO()
    np.savez(file, **form)
    return load_bytes(file.getvalue())


def stored(d):
    S0, V0, S1, V1 = [np.eye(3, 1), np.eye(3, 1)[::-1] * 0.5, np.eye(3, 1)[[2, 0, 1]], np.eye(3, 1)[::-1] * 0.5]
    S = np.stack([S0, S1, np.eye(3, 1)[::-1]])
    made = [QuasiGeodesic(S0, S1), Geodesic(S0, S1), GeometricCubic(S0, V0, S1, V1 * 0), CubicSpline([0, 1, 2.0], S)]
    made += [CubicHermite([0, 1, 2.0], S, 0 * S), SmoothingSpline([0, 1, 2.0], S, lam=0.5)]
    made += [RiemannianCubic.from_initial(S0, V0, V0, V0)]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "curve.npz"
        d.of(made).save(path)
        return path.read_bytes()


def load(d):
    if d.chance(0.1):
        return stiefel_rs.load, [d.of([None, 3, "", "no such file", b"no", "a\0b", "\ud800", os.curdir, Refuses])], {}
    content = stored(d)
    if d.chance(0.5):
        return load_bytes, [damaged(content, d)], {}
    # A whole archive whose arrays are not those of a curve: all checks of the reader are reached.
    with np.load(io.BytesIO(content)) as archive:
        form = {key: archive[key] for key in archive.files}
    for _ in range(d.of([1, 1, 2])):
        key = d.of(sorted(form))
        match d.of(["twist", "twist", "drop", "junk", "other"]):
            case "twist":
                form[key] = (
                    d.entries(np.asarray(form[key]))
                    if np.asarray(form[key]).dtype == float
                    else d.of([0, 1, 99, -1, "", "text", 0.5])
                )
            case "drop":
                del form[key]
            case "junk":
                form[key] = d.of([np.zeros(0), np.zeros((2, 2)), np.array(["a"]), 2**62, 1j, "CubicSpline", -1.5])
            case _:
                form["more"] = np.zeros(3)
        if not form:
            break
    return load_arrays, [form], {}


class Refuses:
    def __fspath__(self):
        return 3


def log_report(d):
    arrays = [np.array([d.chance(0.5)]), np.array([3]), *[d.small(1) for _ in range(2)], np.array([True])]
    return LogReport, d.of([arrays, [True, 3, 0.5, 1.0, False]]), {}


def exception(d):
    report = SolverReport(False, 3, 0.5, 1e-12, "max_iterations")
    kind, arguments = d.of(
        [
            (StiefelError, ["text"]),
            (InvalidInputError, ["text"]),
            (OutsideDomainError, ["text", d.number([1.0])]),
            (ConvergenceError, ["text", d.of([None, report])]),
        ]
    )
    return lambda *x: pickle.loads(pickle.dumps(kind(*x))), arguments, {}


FUNCTIONS = {
    "skew_exp": lambda d: (stiefel_rs.skew_exp, [d.skew(d.of([1, 2, 3, 4, 7]))], some(d, threads(d))),
    "orthogonal_log": lambda d: (stiefel_rs.orthogonal_log, [d.rotation()], some(d, threads(d))),
    "estimate_velocities": estimate,
    "integrate_cubic": integrate_cubic,
    "load": load,
    "SolverReport": lambda d: (
        SolverReport,
        [d.chance(0.5), d.integer([3]), d.number([0.5]), 1e-12, d.word(["max_iterations"])],
        {},
    ),
    "LogReport": log_report,
    "DerivativeBounds": lambda d: (DerivativeBounds, [*d.rng.uniform(0, 1, 3).tolist(), d.word(["sampling"])], {}),
    "errors": exception,
    "Stiefel": lambda d: (Stiefel, [d.integer([3, 4]), d.integer([1, 2])], some(d, {"metric": lambda: metric(d)})),
}


# Methods of the manifold.


def manifold(d):
    return Stiefel(d.n, d.k, metric=d.of(["canonical", "euclidean", 0.0, -0.3, None]) if d.chance(0.4) else None)


def with_tangents(name, count, *options):
    def draw(d):
        S = d.batch()
        return (
            getattr(manifold(d), name),
            [S, *(d.tangent_of_some(S) for _ in range(count)), *(o(d) for o in options)],
            {},
        )

    return draw


def two_points(name, *options):
    def draw(d):
        return getattr(manifold(d), name), [d.batch(), d.point(), *(o(d) for o in options)], {}

    return draw


def compose(d):
    X = d.rng.uniform(-1, 1, (d.n, d.n))
    Omega = d.rng.uniform(-1, 1, (d.k, d.k))
    return manifold(d).compose, [d.point(), X - X.T, Omega - Omega.T], {}


def composed(d):
    """What belongs together by construction."""
    M, S = manifold(d), d.point()
    return M.compose, [S, *M.decompose(S, d.tangent(S))], {}


def ambient(d, S):
    return d.rng.standard_normal(S.shape) * (d.of([1e-300, 1e-8, 1e8, 1e300]) if d.chance(d.wild) else 1.0)


def with_ambient(name, count):
    def draw(d):
        S = d.batch()
        return getattr(manifold(d), name), [S, *(ambient(d, S) for _ in range(count))], {}

    return draw


def hessian_of(d):
    S = d.batch()
    return manifold(d).euclidean_to_riemannian_hessian, [S, ambient(d, S), ambient(d, S), d.tangent(S)], {}


def retraction(d):
    return d.word(RETRACTIONS)


def tolerance(d):
    return d.number([1e-8, 1e-10])


def size(d):
    return d.of([None, 2, (2, 2), (), 0, (0, 3), -1, 2**40, (2**40, 2**40), "ab", 2.5, [2], None])


MANIFOLD = {
    "Stiefel.check_point": lambda d: (manifold(d).check_point, [d.batch(), tolerance(d)], {}),
    "Stiefel.check_tangent": with_tangents("check_tangent", 1, tolerance),
    "Stiefel.random_point": lambda d: (manifold(d).random_point, [seed(d)], some(d, {"size": lambda: size(d)})),
    "Stiefel.random_tangent": with_tangents("random_tangent", 0, seed),
    "Stiefel.project": with_ambient("project", 0),
    "Stiefel.project_any": lambda d: (manifold(d).project, [ambient(d, d.batch())], {}),
    "Stiefel.project_tangent": with_ambient("project_tangent", 1),
    "Stiefel.inner": with_tangents("inner", 2),
    "Stiefel.norm": with_tangents("norm", 1),
    "Stiefel.decompose": with_tangents("decompose", 1),
    "Stiefel.compose": lambda d: d.of([compose, composed])(d),
    "Stiefel.exp": with_tangents("exp", 1),
    "Stiefel.log": lambda d: (
        *two_points("log")(d)[:2],
        some(d, {"full_output": lambda: d.of([True, False, 3, None])}),
    ),
    "Stiefel.dist": two_points("dist"),
    "Stiefel.retract": with_tangents("retract", 1, retraction),
    "Stiefel.inverse_retract": two_points("inverse_retract", retraction),
    "Stiefel.transport": with_tangents("transport", 2),
    "Stiefel.curvature": with_tangents("curvature", 3),
    "Stiefel.sectional_curvature": with_tangents("sectional_curvature", 2),
    "Stiefel.euclidean_to_riemannian_gradient": with_ambient("euclidean_to_riemannian_gradient", 1),
    "Stiefel.euclidean_to_riemannian_hessian": hessian_of,
}


# Methods of the charts.


def chart(d):
    return d.of([Chart.sphere, Chart.frame])()


def with_parts(name):
    """Coordinates and derivatives, (q,), (q, qdot) or (q, qdot, qddot, qdddot)."""

    def draw(d):
        c = chart(d)
        lead = d.of([(), (), (2,), (0,), (2, 2)])
        count = {"embed": 1, "embed_velocity": 2, "discretize": 2, "momenta": 4}[name]
        parts = [d.near((*lead, c.d)), *(d.small((*lead, c.d)) for _ in range(count - 1))]
        return getattr(c, name), parts, some(d, {"map": lambda: d.word(MAPS)}) if name == "discretize" else {}

    return draw


def state(d, c, lead=()):
    return np.concatenate([d.near((*lead, c.d)), d.small((*lead, 3 * c.d))], axis=-1)


def with_state(name):
    def draw(d):
        c = chart(d)
        return getattr(c, name), [state(d, c, d.of([(), (), (2,), (0,)]))], {}

    return draw


def on_chart(d, c):
    """Initial data of a cubic on St(3, 1) or St(3, 2)."""
    d.n, d.k, d.seen = 3, c.k, []
    S = d.point()
    return [S, d.tangent(S), d.tangent(S), d.tangent(S)]


def across(name):
    def draw(d):
        c = chart(d)
        data = on_chart(d, c)
        if name == "state":
            return c.state, data, {}
        if name == "reference_across":
            return c.reference_across, [*data, np.linspace(0, 0.5, d.of([0, 1, 3]))], {}
        return c.integrate_across, [*data, d.integer([1, 3, 10])], stepping(d)

    return draw


def stepping(d):
    order = {"order": lambda: d.of([None, 1, 2, 4, 6, 8, 3, -1, 2**40, "2"])}
    return some(d, {"t_end": lambda: d.number([1.0, 0.1, -0.5]), "map": lambda: d.word(MAPS), **order})


def integrate(d):
    c = chart(d)
    return c.integrate, [state(d, c, d.of([(), (), (2,), (0,)])), d.integer([1, 3, 10])], stepping(d)


def reference(d):
    c = chart(d)
    return (
        c.reference,
        [state(d, c), d.of([np.zeros(0), np.array([0.0, 0.25]), np.array([0.5]), np.array([-1, 1.0])])],
        {},
    )


def shoot(d):
    c = chart(d)
    data = [d.near(c.d, 0.1), d.small(c.d), d.near(c.d, 0.1), d.small(c.d)]
    guess = {"guess": lambda: d.of([None, (np.zeros(c.d), np.zeros(c.d)), 3, (), (np.zeros(c.d),), "ab"])}
    numbers = {"tol": lambda: d.number([1e-12, 1e-8]), "max_iterations": lambda: d.integer([0, 1, 50])}
    # Steps are work that was asked for: shooting takes any number, since it stores one trajectory at the end.
    return c.shoot, [*data, d.of([0, -1, 1, 4, 10])], {**stepping(d), **some(d, {**numbers, **guess})}


CHART = {
    "Chart.sphere": lambda d: (Chart.sphere, [], {}),
    "Chart.frame": lambda d: (Chart.frame, [], {}),
    **{f"Chart.{name}": with_parts(name) for name in ["embed", "embed_velocity", "momenta", "discretize"]},
    **{
        f"Chart.{name}": with_state(name) for name in ["derivatives", "hamiltonian", "gradient", "hessian", "covariant"]
    },
    **{f"Chart.{name}": across(name) for name in ["state", "integrate_across", "reference_across"]},
    "Chart.integrate": integrate,
    "Chart.reference": reference,
    "Chart.shoot": shoot,
}

CALLS = {**FUNCTIONS, **MANIFOLD, **CHART}


# Methods of one curve: name -> function of (draw, curve).


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


def duplicate(d, curve):
    return d.of([copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x)), repr, hash]), [curve], {}


METHODS = {
    "__call__": lambda d, c: (c, [d.parameters(), d.integer([0, 1, 2, 3])], some(d, threads(d))),
    "velocity": lambda d, c: (c.velocity, [d.parameters()], some(d, threads(d))),
    "acceleration": lambda d, c: (c.acceleration, [d.parameters()], some(d, threads(d))),
    "jerk": lambda d, c: (c.jerk, [d.parameters()], some(d, threads(d))),
    "cost": lambda d, c: (c.cost, [], {}),
    "arc_length": lengths,
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
}


def methods(curve):
    return {**METHODS, **CUBIC_METHODS} if isinstance(curve, RiemannianCubic) else METHODS
