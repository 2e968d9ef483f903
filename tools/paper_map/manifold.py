"""Rows of sections 1 and 2 of the paper: the problem, the manifold, retractions and quasi-geodesics."""

from typing import Final

from . import report
from .row import Row

INTRODUCTION: Final = (
    Row(
        "Functional J",
        "A Riemannian cubic minimises the integral of the squared covariant acceleration for given end points and "
        "end velocities.",
        ("Curve.cost", "RiemannianCubic.from_boundary"),
        (
            "test_paper_manifold.py::test_functional_of_a_curve",
            "test_paper_manifold.py::test_functional_of_a_curve_at_rest_and_of_a_geodesic",
            "test_riemannian_cubic_boundary.py::test_guess_and_all_found",
        ),
        (report.FUNCTIONAL, report.CUBICS),
        "`cost()` is J as printed, without the factor 1/2. A cubic is a stationary curve, not always "
        "a minimiser: `all_found=True` returns several, ranked by cost.",
    ),
    Row(
        "Interval",
        "Curves can be restricted to [0, 1] without loss of generality.",
        ("RiemannianCubic.reparametrised",),
        ("test_riemannian_cubic.py::test_parts_reversals_other_parameters",),
        (report.ANOTHER_TIME,),
    ),
    Row(
        "Claim",
        "The Euler-Lagrange equations of J are hard to solve, hence geometric algorithms.",
        ("RiemannianCubic.from_boundary",),
        (
            "test_riemannian_cubic_boundary.py::test_the_papers_problems",
            "test_riemannian_cubic_boundary.py::test_close_and_slow_problems_all_converge",
        ),
        (
            report.verdict("euler_lagrange"),
            report.EXACT,
            report.ANY_SHAPE,
            report.BOUNDARY_PROBLEMS,
        ),
    ),
    Row(
        "Four points",
        "The first and the last of the four points are given; the two between them follow from the velocities.",
        ("GeometricCubic.control_points",),
        (
            "test_paper_de_casteljau.py::test_eq_9_first_control_point",
            "test_paper_de_casteljau.py::test_eq_10_second_control_point",
        ),
        (report.DE_CASTELJAU,),
        "`control_points[0]` to `control_points[3]`",
    ),
    Row(
        "Claim on St(3,1)",
        "It is the sphere, and its quasi-geodesics are geodesics (also abstract and section 4.1).",
        ("QuasiGeodesic", "Geodesic"),
        (
            "test_paper_quasi_geodesics.py::test_remark_1_spheres_and_rotations_have_geodesics_only",
            "test_curves.py::test_great_circle_is_a_geodesic_of_the_sphere",
        ),
        (
            report.verdict("quasi_geodesics"),
            report.QUASI_GEODESICS,
        ),
    ),
    Row(
        "Claim on St(3,2)",
        "Its quasi-geodesics are in general not geodesics (also abstract and section 4.1).",
        ("QuasiGeodesic", "Geodesic"),
        ("test_paper_quasi_geodesics.py::test_remark_1_both_parts_give_no_geodesic_for_two_columns",),
        (
            report.verdict("quasi_geodesics"),
            report.QUASI_GEODESICS,
        ),
    ),
)

MANIFOLD: Final = (
    Row(
        "(1)",
        "St(n,k) is the set of matrices with `S^T S = I`, for k from 1 to n.",
        ("Stiefel", "Stiefel.check_point"),
        ("test_paper_manifold.py::test_eq_1_points", "test_stiefel.py::test_check_point_measures_the_defect"),
        (report.MANIFOLD,),
    ),
    Row(
        "Gr(n,k)",
        "`P = S S^T` is a symmetric projection of rank k: a point of the Grassmann manifold.",
        ("Stiefel.decompose",),
        ("test_paper_manifold.py::test_projections_of_rank_k",),
        (report.MANIFOLD,),
        "`Grassmann.projector` returns this P; in the formulas P is `I - S S^T`.",
    ),
    Row(
        "`so_P(n)`",
        "The skew matrices with `X P + P X = X`.",
        ("Stiefel.decompose",),
        ("test_paper_manifold.py::test_generators_at_a_projection",),
        (report.MANIFOLD,),
    ),
    Row(
        "Tangent space of Gr(n,k)",
        "The commutators `[X, P]` with X in `so_P(n)`.",
        ("Stiefel.decompose",),
        ("test_paper_manifold.py::test_generators_at_a_projection",),
        (report.MANIFOLD,),
    ),
    Row(
        "(2)",
        "A tangent vector satisfies `V^T S + S^T V = 0`.",
        ("Stiefel.check_tangent", "Stiefel.dim"),
        (
            "test_paper_manifold.py::test_eq_2_tangent_space",
            "test_paper_manifold.py::test_eq_2_dimension",
            "test_stiefel.py::test_check_tangent_measures_the_defect",
        ),
        (report.MANIFOLD,),
    ),
    Row(
        "(3)",
        "The tangent vectors are the matrices `X S + S Omega`, X in `so_P(n)` and Omega skew.",
        ("Stiefel.compose",),
        (
            "test_paper_manifold.py::test_eq_3_every_pair_gives_a_tangent_vector",
            "tests/manifold/parametrisation.rs::compose_undoes_decompose",
        ),
        (report.MANIFOLD,),
        "The code uses `V = K + S Omega` with K normal to the columns of S: `X = K S^T - S K^T`.",
    ),
    Row(
        "(4)",
        "`X = V S^T - S V^T + 2 S V^T S S^T` and `Omega = S^T V`.",
        ("Stiefel.decompose",),
        (
            "test_paper_manifold.py::test_eq_4_pair_of_a_tangent_vector",
            "tests/manifold/parametrisation.rs::eq_new_param1_is_our_pair",
        ),
        (report.MANIFOLD,),
    ),
    Row(
        "(5)",
        "The metric `tr V_1^T (I - S S^T / 2) V_2`.",
        ("Stiefel.inner", "Stiefel.norm"),
        ("test_paper_manifold.py::test_eq_5_metric", "tests/manifold/metric.rs::inner_is_the_canonical_metric"),
        (report.MANIFOLD,),
    ),
    Row(
        "Claim",
        "(5) is the canonical metric, the member `alpha = 0` of the alpha family.",
        ("Stiefel.alpha",),
        ("test_paper_manifold.py::test_eq_5_is_the_canonical_metric", "test_formulas.py::test_metric"),
        (report.MANIFOLD,),
    ),
    Row(
        "Claim",
        "Quasi-geodesics replace geodesics, for which no formula with given end points is known.",
        ("QuasiGeodesic", "Geodesic", "GeometricCubic.pieces"),
        ("test_control_points.py::test_every_method_meets_the_boundary_data",),
        (report.CONTROL_POINTS, report.GEODESICS),
        '`GeometricCubic(..., pieces="geodesic")` uses geodesics, computed iteratively.',
    ),
)

RETRACTIONS: Final = (
    Row(
        "Definition 1",
        "A retraction: `R_S(0) = S`, and its derivative at 0 is the identity.",
        ("Stiefel.retract", "Stiefel.exp"),
        (
            "test_paper_quasi_geodesics.py::test_definition_1_retraction",
            "test_paper_quasi_geodesics.py::test_definition_1_exponential",
            "tests/manifold/parametrisation.rs::retraction_is_right_to_first_order",
        ),
        (report.RETRACTIONS,),
    ),
    Row(
        "Quasi-geodesic",
        "The curve `R_S(tV)`, from S with velocity V.",
        ("QuasiGeodesic.from_velocity",),
        (
            "test_paper_quasi_geodesics.py::test_derivatives_of_the_quasi_geodesic",
            "tests/retraction/equations.rs::quasi_geodesic_is_the_curve_at_one",
        ),
        (report.QUASI_GEODESICS,),
        "Here only the curve of the retraction `e^X S e^Omega`.",
    ),
    Row(
        "`R_S(V)`",
        "`e^X S e^Omega` is a retraction.",
        ("Stiefel.retract",),
        ("test_paper_quasi_geodesics.py::test_retraction_of_the_paper",),
        (report.RETRACTIONS, report.QUASI_GEODESICS),
    ),
    Row(
        "Derivatives of beta",
        "`e^{tX} (X S + S Omega) e^{t Omega}` and `e^{tX} (X^2 S + 2 X S Omega + S Omega^2) e^{t Omega}`.",
        ("QuasiGeodesic.__call__", "QuasiGeodesic.velocity"),
        (
            "test_paper_quasi_geodesics.py::test_derivatives_of_the_quasi_geodesic",
            "tests/quasi_geodesic/from_velocity.rs::agrees_with_the_n_by_n_formula_and_its_derivatives",
        ),
        (report.QUASI_GEODESICS,),
        "`curve(t, nu=1)`, `curve(t, nu=2)`",
    ),
    Row(
        "Proposition 1, (6)",
        "X is half the logarithm of a product of two reflections; Omega is the logarithm of `S_0^T e^{-X} S_1`.",
        ("Stiefel.inverse_retract", "orthogonal_log"),
        ("test_paper_quasi_geodesics.py::test_eq_6_proposition_1_velocity",),
        (report.QUASI_GEODESICS, report.ROTATIONS),
        "The velocity `X S_0 + S_0 Omega` is returned; no n x n matrix is formed.",
    ),
    Row(
        "Proposition 1, (7)",
        "`e^{tX} S_0 e^{t Omega}` joins the two points.",
        ("QuasiGeodesic",),
        ("test_paper_quasi_geodesics.py::test_eq_7_proposition_1_curve",),
        (
            report.verdict("joining"),
            report.QUASI_GEODESICS,
        ),
        "Also beyond the domain of (6): see [misprints](#misprints).",
    ),
    Row(
        "Remark 1",
        "(6) needs both logarithms, which exist for close points.",
        ("Stiefel.inverse_retract", "OutsideDomainError"),
        (
            "test_paper_quasi_geodesics.py::test_remark_1_close_points_are_joined",
            "test_stiefel.py::test_unreachable_points_carry_the_angle",
        ),
        (
            report.verdict("joining"),
            report.QUASI_GEODESICS,
        ),
    ),
    Row(
        "Remark 1",
        "The quasi-geodesic is a geodesic only if `X = 0` or `Omega = 0`.",
        ("QuasiGeodesic.acceleration", "Geodesic"),
        (
            "test_paper_quasi_geodesics.py::test_remark_1_one_part_gives_a_geodesic",
            "test_paper_quasi_geodesics.py::test_remark_1_both_parts_give_no_geodesic_for_two_columns",
            "test_paper_misprints.py::test_remark_1_for_three_columns",
        ),
        (
            report.verdict("remark"),
            report.QUASI_GEODESICS,
        ),
        "Holds for k up to 2; the condition for any k is `K Omega = 0`, `K = X S`.",
    ),
    Row(
        "Remark 1",
        "One of them vanishes for k = 1, the unit sphere, and for k = n, the orthogonal group.",
        ("QuasiGeodesic", "Geodesic"),
        (
            "test_paper_quasi_geodesics.py::test_remark_1_spheres_and_rotations_have_geodesics_only",
            "tests/retraction/orders.rs::quasi_geodesics_are_geodesics_on_spheres_and_rotations",
        ),
        (report.QUASI_GEODESICS,),
    ),
)
