"""Functions and curves of the module with valid arguments, for tests that replace one argument by another."""

import numpy as np
import pytest

from stiefel_rs import (
    Chart,
    CubicHermite,
    CubicSpline,
    Geodesic,
    GeometricCubic,
    GeometricPolynomial,
    Grassmann,
    QuasiGeodesic,
    RiemannianCubic,
    SmoothingSpline,
    Stiefel,
    estimate_velocities,
    integrate_embedded,
    orthogonal_log,
    skew_exp,
    solve_boundary,
)

M = Stiefel(4, 2)
GR = Grassmann(4, 2)
SPHERE = Chart.sphere()
# Entries are multiples of 1/2: exact in every float type and, doubled, in integers.
S = np.eye(4, 2)
S1 = np.array([[0, 0], [0, 1], [1, 0], [0, 0.0]])
V = np.array([[0, -1], [1, 0], [2, 0], [0, -1.0]])
V1 = np.array([[1, 0], [0, 0], [0, 0], [0, 1.0]])
S2 = np.array([[1, 1], [-1, 1], [1, 1], [1, -1]]) / 2
# Horizontal at S.
H = np.array([[0, 0], [0, 0], [2, 0], [0, -1.0]])
H2 = np.array([[0, 0], [0, 0], [0, 1], [3, 0.0]])
# Horizontal at S2.
H0 = np.array([[1, 0], [0, -1], [-1, 0], [0, -1.0]])
V2 = np.array([[0, 1], [-1, 0], [0, 1], [3, 0.0]])
Z0 = np.array([1, 2, 1, 0, 0, 1, 0, 1.0])
T = np.array([0.0, 1.0, 2.0])
SKEW = np.array([[0, -2, 1], [2, 0, 0], [-1, 0, 0.0]])

CUBIC = RiemannianCubic.from_initial(S, V / 2, V2 / 2, V / 2)
SPLINE = CubicSpline(T, np.stack([S, S2, S]))
HALVES = np.array([0.5, 1.0])

# name -> (function of its array arguments, [(argument, valid value)]).
CALLS = {
    "skew_exp": (skew_exp, [("A", SKEW)]),
    "orthogonal_log": (orthogonal_log, [("Q", np.roll(np.eye(3), 1, axis=0))]),
    "check_point": (M.check_point, [("S", S)]),
    "check_tangent": (M.check_tangent, [("S", S), ("V", V)]),
    "random_tangent": (lambda S: M.random_tangent(S, 1), [("S", S)]),
    "project": (M.project, [("Y", S + V)]),
    "project_tangent": (M.project_tangent, [("S", S), ("Z", S + V)]),
    "inner": (M.inner, [("S", S), ("V", V), ("W", V1 * 0)]),
    "norm": (M.norm, [("S", S), ("V", V)]),
    "decompose": (M.decompose, [("S", S), ("V", V)]),
    "compose": (M.compose, [("S", S), ("X", np.zeros((4, 4))), ("Omega", np.zeros((2, 2)))]),
    "retract": (M.retract, [("S", S), ("V", V)]),
    "inverse_retract": (M.inverse_retract, [("S0", S), ("S1", S1)]),
    "retract_qr": (lambda S, V: M.retract(S, V, "qr"), [("S", S), ("V", V)]),
    "retract_polar": (lambda S, V: M.retract(S, V, "polar"), [("S", S), ("V", V)]),
    "retract_cayley": (lambda S, V: M.retract(S, V, "cayley"), [("S", S), ("V", V)]),
    "inverse_qr": (lambda a, b: M.inverse_retract(a, b, "qr"), [("S0", S), ("S1", S2)]),
    "inverse_polar": (lambda a, b: M.inverse_retract(a, b, "polar"), [("S0", S), ("S1", S2)]),
    "inverse_cayley": (lambda a, b: M.inverse_retract(a, b, "cayley"), [("S0", S), ("S1", S2)]),
    "transport": (M.transport, [("S", S), ("V", V), ("W", V2)]),
    "curvature": (M.curvature, [("S", S), ("U", V), ("V", V2), ("W", V)]),
    "sectional_curvature": (M.sectional_curvature, [("S", S), ("U", V), ("V", V2)]),
    "gradient_of": (M.euclidean_to_riemannian_gradient, [("S", S), ("G", V + S)]),
    "hessian_of": (M.euclidean_to_riemannian_hessian, [("S", S), ("G", V + S), ("H", S), ("V", V)]),
    "Grassmann.check_point": (GR.check_point, [("Y", S)]),
    "Grassmann.check_tangent": (GR.check_tangent, [("Y", S), ("V", H)]),
    "Grassmann.random_tangent": (lambda Y: GR.random_tangent(Y, 1), [("Y", S)]),
    "Grassmann.project": (GR.project, [("Y", S + V)]),
    "Grassmann.project_tangent": (GR.project_tangent, [("Y", S), ("Z", S + V)]),
    "Grassmann.inner": (GR.inner, [("Y", S), ("V", H), ("W", H2)]),
    "Grassmann.norm": (GR.norm, [("Y", S), ("V", H)]),
    "Grassmann.principal_angles": (GR.principal_angles, [("Y0", S), ("Y1", S1)]),
    "Grassmann.align": (GR.align, [("Y0", S), ("Y1", S2)]),
    "Grassmann.projector": (GR.projector, [("Y", S)]),
    "Grassmann.exp": (GR.exp, [("Y", S), ("V", H)]),
    "Grassmann.log": (GR.log, [("Y0", S), ("Y1", S2)]),
    "Grassmann.dist": (GR.dist, [("Y0", S), ("Y1", S1)]),
    "Grassmann.transport": (GR.transport, [("Y", S), ("V", H), ("W", H2)]),
    "Grassmann.curvature": (GR.curvature, [("Y", S), ("U", H), ("V", H2), ("W", H)]),
    "Grassmann.sectional_curvature": (GR.sectional_curvature, [("Y", S), ("U", H), ("V", H2)]),
    "Grassmann.gradient": (GR.euclidean_to_riemannian_gradient, [("Y", S), ("G", V + S)]),
    "Grassmann.hessian": (
        GR.euclidean_to_riemannian_hessian,
        [("Y", S), ("G", V + S), ("H", S), ("V", H)],
    ),
    "QuasiGeodesic": (lambda a, b: QuasiGeodesic(a, b)(0.5), [("S0", S), ("S1", S1)]),
    "from_velocity": (lambda a, b: QuasiGeodesic.from_velocity(a, b)(0.5), [("S", S), ("V", V)]),
    "GeometricCubic": (lambda *x: GeometricCubic(*x)(0.5), [("S0", S), ("V0", V), ("S1", S1), ("V1", V1)]),
    "GeometricCubic.subspaces": (
        lambda *x: GeometricCubic(*x, manifold=GR)(0.5),
        [("S0", S), ("V0", H), ("S1", S2), ("V1", H0)],
    ),
    "from_control_points": (lambda P: GeometricCubic.from_control_points(P)(0.5), [("P", np.stack([S, S1, S, S]))]),
    "from_initial": (
        lambda *x: RiemannianCubic.from_initial(*x)(0.5),
        [("S", S), ("V", V), ("A", V2), ("J", V)],
    ),
    "integrate_embedded": (
        lambda *x: integrate_embedded(*x, 20).point,
        [("S", S), ("V", V), ("A", V2), ("J", V)],
    ),
    "from_boundary": (
        lambda *x: RiemannianCubic.from_boundary(*x)(0.5),
        [("S0", S), ("V0", V), ("S1", S2), ("V1", S2 @ [[0, -1], [1, 0]])],
    ),
    "point_pullback": (lambda *x: CUBIC.point_pullback(*x)[2], [("t", HALVES), ("W", np.stack([S, V]))]),
    "initial_point_variation": (
        lambda *x: CUBIC.initial_point_variation(HALVES, *x),
        [("dS", V * 0), ("dV", V), ("dA", V2), ("dJ", V)],
    ),
    "initial_point_pullback": (
        lambda *x: CUBIC.initial_point_pullback(*x)[3],
        [("t", HALVES), ("W", np.stack([S, V]))],
    ),
    "CubicSpline.point_variation": (
        SPLINE.point_variation,
        [("t", HALVES), ("dS", np.stack([V, V * 0, V2]))],
    ),
    "CubicSpline.point_pullback": (
        lambda *x: SPLINE.point_pullback(*x)[0],
        [("t", HALVES), ("W", np.stack([S, V]))],
    ),
    "CubicHermite": (
        lambda *x: CubicHermite(*x)(0.5),
        [("t", T), ("S", np.stack([S, S2, S])), ("V", np.stack([V1 * 0, V1 * 0, V]) / 2)],
    ),
    "CubicHermite.geometric": (
        lambda *x: CubicHermite(*x, "geometric")(0.5),
        [("t", T), ("S", np.stack([S, S2, S])), ("V", np.stack([V1 * 0, V1 * 0, V]) / 2)],
    ),
    "CubicSpline": (lambda *x: CubicSpline(*x)(0.5), [("t", T), ("S", np.stack([S, S2, S]))]),
    "SmoothingSpline": (
        lambda *x: SmoothingSpline(*x, np.array([1.0, 2.0, 0.5]), 0.5)(0.5),
        [("t", T), ("S", np.stack([S, S2, S]))],
    ),
    "CubicSpline.geometric": (
        lambda *x: CubicSpline(*x, kind="geometric")(0.5),
        [("t", T), ("S", np.stack([S, S2, S]))],
    ),
    "solve_boundary": (
        lambda *x: (batch := solve_boundary(*x)).acceleration[batch.converged],
        [("S0", S), ("V0", V), ("S1", S2), ("V1", S2 @ [[0, -1], [1, 0]])],
    ),
    "solve_boundary.subspaces": (
        lambda *x: (batch := solve_boundary(*x, manifold=GR)).acceleration[batch.converged],
        [("S0", S), ("V0", H), ("S1", S2), ("V1", GR.project_tangent(S2, H))],
    ),
    "estimate_velocities.subspaces": (
        lambda *x: estimate_velocities(*x, manifold=GR),
        [("t", T), ("S", np.stack([S, S2, S]))],
    ),
    "guess.subspaces": (
        lambda a, j: RiemannianCubic.from_boundary(S, H, S2, 0 * H, guess=(a, j), manifold=GR)(0.5),
        [("A", H2), ("J", H)],
    ),
    "estimate_velocities": (estimate_velocities, [("t", T), ("S", np.stack([S, S2, S]))]),
    "bc_type": (
        lambda A: CubicSpline(T, np.stack([S, S2, S]), ((2, A), "natural"))(0.5),
        [("bc_type", V / 2)],
    ),
    "exp": (M.exp, [("S", S), ("V", V)]),
    "log": (M.log, [("S0", S), ("S1", S2)]),
    "dist": (M.dist, [("S0", S), ("S1", S2)]),
    "Geodesic": (lambda a, b: Geodesic(a, b)(0.5), [("S0", S), ("S1", S2)]),
    "Geodesic.from_velocity": (lambda a, b: Geodesic.from_velocity(a, b)(0.5), [("S", S), ("V", V)]),
    "GeometricPolynomial": (lambda P: GeometricPolynomial(P)(0.5), [("P", np.stack([S, S2, S]))]),
    "GeometricPolynomial.subspaces": (
        lambda P: GeometricPolynomial(P, manifold=GR)(0.5),
        [("P", np.stack([S, S2, S]))],
    ),
    "GeometricPolynomial.geodesic": (
        lambda P: GeometricPolynomial(P, pieces="geodesic")(0.5),
        [("P", np.stack([S, S2, S]))],
    ),
    "curve": (QuasiGeodesic.from_velocity(S, V), [("t", np.array([0.0, 1.0]))]),
    "jerk": (lambda t: GeometricCubic(S, V, S, V).jerk(t), [("t", np.array([0.0, 1.0]))]),
    "embed": (SPHERE.embed, [("q", Z0[:2])]),
    "embed_velocity": (SPHERE.embed_velocity, [("q", Z0[:2]), ("qdot", Z0[2:4])]),
    "momenta": (SPHERE.momenta, [("q", Z0[:2]), ("qdot", Z0[2:4]), ("qddot", Z0[4:6]), ("qdddot", Z0[6:])]),
    "derivatives": (SPHERE.derivatives, [("z", Z0)]),
    "hamiltonian": (SPHERE.hamiltonian, [("z", Z0)]),
    "gradient": (SPHERE.gradient, [("z", Z0)]),
    "hessian": (SPHERE.hessian, [("z", Z0)]),
    "integrate": (lambda z: SPHERE.integrate(z, 3, 0.1), [("z0", Z0)]),
    "reference": (SPHERE.reference, [("z0", Z0), ("t", np.array([0.0, 0.25]))]),
    "shoot": (
        lambda *x: SPHERE.shoot(*x, 4).trajectory,
        [("q0", Z0[:2]), ("qdot0", Z0[2:4]), ("q1", Z0[:2]), ("qdot1", Z0[2:4])],
    ),
    "guess": (
        lambda p, m: SPHERE.shoot(Z0[:2], Z0[2:4], Z0[:2], Z0[2:4], 4, guess=(p, m)).trajectory,
        [("guess", np.zeros(2)), ("guess", np.zeros(2))],
    ),
}
ARGUMENTS = [
    pytest.param(call, i, id=f"{call}-{arg}{i}") for call, (_, args) in CALLS.items() for i, (arg, _) in enumerate(args)
]


def replaced(call, i, value):
    function, args = CALLS[call]
    return function(*[value if j == i else good for j, (_, good) in enumerate(args)])


def good(call, i):
    return CALLS[call][1][i][1]


def flat(result):
    return [np.asarray(x) for x in (result if isinstance(result, tuple) else (result,)) if x is not None]
