"""Symbols of the paper that the project writes differently."""

from typing import Final

SYMBOLS: Final = (
    ("`S_0, S_3, V_0, V_3` (end data)", "`S0, S1, V0, V1`"),
    ("`S_1, S_2` (control points)", "`control_points[1]`, `control_points[2]`"),
    ("`P = S S^T`", "`Grassmann.projector(S)`; in the formulas `P = I - S S^T`"),
    ("`X, Omega`", "`X, Omega`, or `K = X S` with `V = K + S Omega`"),
    ("`R_S(V)`", "`Stiefel.retract(S, V)`"),
    ("`beta`, `gamma`", "`QuasiGeodesic`, `GeometricCubic`"),
    ("`J` (script)", "`Curve.cost()`"),
    ("`D/dt`", "`D_t`; `Curve.acceleration`, `Curve.jerk`"),
    ("`Q`, `(q, v)` of definition 2", "the tangent bundle in a chart, `x = (q, qdot)` and `v`"),
    ("`(q, qdot, p_q, p_qdot)`", "`z`, shape `(4 d,)`"),
    ("charts `psi`, `Psi`", "`Chart.sphere()`, `Chart.frame()`"),
    ("`N`, `h`", "`steps`, `t_end / steps`"),
    ("GCP", "`GeometricCubic`"),
    ("Retraction, Mid-point Retraction", '`map="initial_point"`, `map="midpoint"`'),
)
