"""Rows of sections 3, 4 and 4.1 of the paper: the de Casteljau algorithm, discretization maps, Hamiltonians."""

from typing import Final

from . import report
from .row import Row

DE_CASTELJAU: Final = (
    Row(
        "Assumption",
        "The manifold is geodesically complete.",
        ("Geodesic.from_velocity",),
        ("test_paper_claims.py::test_geodesics_are_complete",),
        (report.GEODESICS,),
    ),
    Row(
        "Problem 1, (8)",
        "A curve with end points `S_0`, `S_3` and end velocities `V_0`, `V_3`.",
        ("GeometricCubic", "RiemannianCubic.from_boundary"),
        (
            "test_paper_de_casteljau.py::test_eq_8_problem_1",
            "test_riemannian_cubic_boundary.py::test_boundary_data_are_met",
            "tests/curve/end_conditions.rs::meets_end_points_and_end_velocities",
        ),
        (report.DE_CASTELJAU,),
        "The ends are `S0, V0, S1, V1`.",
    ),
    Row(
        "(9) and `S_1`",
        "`X_0` and `Omega_0` belong to `V_0 / 3`; the first control point is `e^{X_0} S_0 e^{Omega_0}`.",
        ("GeometricCubic.control_points", "Stiefel.retract"),
        (
            "test_paper_de_casteljau.py::test_eq_9_first_control_point",
            "tests/curve/end_conditions.rs::control_points_are_retractions_of_a_third_of_the_velocities",
        ),
        (report.DE_CASTELJAU,),
        "`control_points[1]`",
    ),
    Row(
        "(10) and `S_2`",
        "`X_2` and `Omega_2` belong to `-V_3 / 3` at `S_3`; the second control point is `e^{X_2} S_3 e^{Omega_2}`.",
        ("GeometricCubic.control_points", "Stiefel.retract"),
        ("test_paper_de_casteljau.py::test_eq_10_second_control_point",),
        (report.DE_CASTELJAU,),
        "`control_points[2]`",
    ),
    Row(
        "`X_1, Omega_1`",
        "The pair (6) from `S_1` to `S_2`.",
        ("Stiefel.inverse_retract",),
        ("test_paper_de_casteljau.py::test_x_1_and_omega_1",),
        (report.DE_CASTELJAU,),
    ),
    Row(
        "`X_3` to `Omega_5`",
        "The pairs (6) between the points of the three legs at t, and between the points of the two resulting curves.",
        ("QuasiGeodesic", "Stiefel.inverse_retract"),
        (
            "test_paper_de_casteljau.py::test_x_3_to_omega_5",
            "tests/curve/algorithm.rs::equals_de_casteljau_with_n_by_n_exponentials",
        ),
        (report.DE_CASTELJAU,),
        "Points `b01`, `b12`, `b23`, `b012`, `b123` instead of products of exponentials.",
    ),
    Row(
        "Theorem 1, (11)",
        "The curve of three nested exponentials solves Problem 1.",
        ("GeometricCubic",),
        (
            "test_paper_de_casteljau.py::test_eq_11_theorem_1_curve",
            "test_paper_de_casteljau.py::test_theorem_1_the_printed_curve_solves_problem_1",
            "test_paper_de_casteljau.py::test_theorem_1_equal_points_at_rest",
        ),
        (
            report.verdict("end_data"),
            report.DE_CASTELJAU,
        ),
        "The geometric cubic polynomial is `GeometricCubic`, GCP in tables.",
    ),
)

DISCRETIZATION: Final = (
    Row(
        "Definition 2",
        "A discretization map maps a tangent vector to two points: both are q for v = 0, and their derivatives "
        "differ by the identity.",
        ("Chart.discretize", "stiefel_rs::chart::DiscretizationMap"),
        ("test_paper_discretization.py::test_definition_2_discretization_map",),
        (report.CHARTS,),
        "Q is the tangent bundle in a chart: its point is `x = (q, qdot)`, the tangent vector `v`.",
    ),
    Row(
        "After definition 2",
        "It is a local diffeomorphism near the zero section.",
        ("Chart.discretize",),
        ("test_paper_discretization.py::test_definition_2_local_diffeomorphism",),
        (report.CHARTS,),
    ),
    Row(
        "After definition 2",
        "If the first point is q, the second one is a retraction.",
        ("Chart.discretize",),
        ("test_paper_discretization.py::test_definition_2_with_the_first_point_fixed_is_definition_1",),
        (report.CHARTS,),
    ),
    Row(
        "Example 1",
        "The initial-point map `(q, q + v)`.",
        ("Chart.discretize", "stiefel_rs::chart::LinearMap::INITIAL_POINT"),
        ("test_paper_discretization.py::test_example_1_initial_point",),
        (report.CHARTS,),
        '`map="initial_point"`',
    ),
    Row(
        "Example 2",
        "The mid-point map `(q - v/2, q + v/2)`.",
        ("Chart.discretize", "stiefel_rs::chart::LinearMap::MIDPOINT"),
        ("test_paper_discretization.py::test_example_2_midpoint",),
        (report.CHARTS,),
        '`map="midpoint"`',
    ),
    Row(
        "Cotangent lift",
        "The lift of a discretization map to the cotangent bundle is a discretization map and a symplectomorphism.",
        ("stiefel_rs::chart::discretization::cotangent_lift",),
        (
            "test_paper_discretization.py::test_example_3_lift_is_that_of_the_map",
            "tests/discretization.rs::cotangent_lift_is_symplectic",
        ),
        (report.CHARTS,),
    ),
    Row(
        "Proposition 2",
        "`(R_d^{T*})^{-1}(q_0, p_0, q_1, p_1) = h X_H` at its base point is a symplectic integrator.",
        ("Chart.integrate", "stiefel_rs::chart::integrate"),
        (
            "test_paper_discretization.py::test_proposition_2_equation_of_the_step",
            "test_chart.py::test_one_step_is_symplectic",
            "tests/integrator.rs::steps_are_symplectic_with_exact_tangents",
            "tests/integrator.rs::a_step_is_the_cotangent_lift_of_the_hamiltonian_vector",
        ),
        (
            report.verdict("symplectic"),
            report.CHARTS,
            report.INVARIANTS,
        ),
        "The state is `z = (q, qdot, p_q, p_qdot)`.",
    ),
    Row(
        "Example 3",
        "The lifts of both maps in coordinates.",
        ("Chart.integrate", "stiefel_rs::chart::discretization::cotangent_lift"),
        (
            "test_paper_discretization.py::test_example_3_lift_is_symplectic",
            "test_paper_discretization.py::test_example_3_lift_is_that_of_the_map",
            "tests/discretization.rs::cotangent_lift_of_the_papers_maps",
        ),
        (report.CHARTS,),
    ),
    Row(
        "Claim",
        "Different discretization maps give different symplectic integrators.",
        ("Chart.integrate", "stiefel_rs::chart::DiscretizationMap"),
        (
            "test_paper_discretization.py::test_proposition_2_equation_of_the_step",
            "tests/integrator.rs::steps_are_symplectic_with_exact_tangents",
        ),
        (report.verdict("symplectic"), report.RETRACTION_PAIRS),
        "Linear, exponential, Cayley and quasi-geodesic maps, each from the initial point and around the mid-point.",
    ),
    Row(
        "Claim",
        "Riemannian cubics are projections of a Hamiltonian flow on the cotangent bundle of the tangent bundle.",
        ("Chart.reference", "RiemannianCubic.from_initial"),
        (
            "test_paper_charts.py::test_hamiltonian_flow_is_that_of_riemannian_cubics",
            "tests/splitting.rs::solution_is_that_of_the_chart",
        ),
        (report.CHARTS, report.CUBICS),
    ),
)

HAMILTONIANS: Final = (
    Row(
        "Claim",
        "A general expression for the Hamiltonian might be hard to find; hence n = 3 with k = 1 and 2.",
        ("integrate_cubic", "stiefel_rs::cubic::integrate_cubic"),
        ("test_formulas.py::test_frame_form_of_cubics", "tests/splitting.rs::steps_are_symplectic"),
        (report.verdict("general_hamiltonian"), report.ANY_SHAPE, report.SPLITTINGS, report.CUBICS),
        "In a frame of any St(n,k) it is `<mu, x> + |p|^2 / 2`.",
    ),
    Row(
        "Chart of the sphere",
        "Spherical coordinates `(theta, phi)`.",
        ("Chart.sphere", "Chart.embed"),
        ("test_paper_charts.py::test_charts", "test_paper_charts.py::test_charts_cover_neighbourhoods"),
        (report.CHARTS, report.IN_CHARTS),
    ),
    Row(
        "Hamiltonian of the sphere",
        "H in spherical coordinates.",
        ("Chart.hamiltonian",),
        (
            "test_paper_charts.py::test_sphere_hamiltonian",
            "test_paper_charts.py::test_hamiltonian_is_that_of_the_metric",
        ),
        (report.verdict("sphere_hamiltonian"), report.CHARTS),
        "It belongs to J/2: see [misprints](#misprints).",
    ),
    Row(
        "Claim",
        "St(3,2) is the set of unit tangent vectors of the sphere.",
        ("Chart.frame", "Chart.embed"),
        ("test_paper_charts.py::test_frames_are_unit_tangent_vectors_of_the_sphere",),
        (report.CHARTS,),
    ),
    Row(
        "Chart of St(3,2)",
        "The matrix `A(theta, phi, psi)`.",
        ("Chart.frame", "Chart.embed"),
        ("test_paper_charts.py::test_charts", "test_paper_charts.py::test_charts_cover_neighbourhoods"),
        (report.CHARTS, report.IN_CHARTS),
    ),
    Row(
        "Hamiltonian of St(3,2)",
        "H in the chart, a sum of twelve products with coefficients in theta.",
        ("Chart.hamiltonian",),
        (
            "test_paper_charts.py::test_frame_hamiltonian",
            "test_paper_charts.py::test_frame_hamiltonian_term_by_term",
            "test_paper_charts.py::test_frame_hamiltonian_has_no_other_terms",
            "test_paper_charts.py::test_hamiltonian_is_that_of_the_metric",
            "test_chart.py::test_equator_is_no_singularity",
        ),
        (
            report.verdict("hamiltonian"),
            report.CHARTS,
        ),
        "The same function without division by `cos(theta)`; its bracket is among the [misprints](#misprints).",
    ),
)
