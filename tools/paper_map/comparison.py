"""Rows of sections 4.2 and 4.3 of the paper: the experiments, the figures, the discussion."""

from typing import Final

from . import report
from .row import Row

EXPERIMENTS: Final = (
    Row(
        "Claim",
        "Points of (11) need exponentials of skew matrices and logarithms of orthogonal ones only.",
        ("skew_exp", "orthogonal_log", "GeometricCubic.__call__"),
        (
            "test_paper_de_casteljau.py::test_eq_11_theorem_1_curve",
            "test_linalg.py::test_exp_agrees_with_scipy",
            "test_linalg.py::test_log_agrees_with_mpmath",
        ),
        (report.ROTATIONS, report.DE_CASTELJAU),
        "k x k logarithms instead of n x n ones",
    ),
    Row(
        "Benchmark",
        "A Runge-Kutta method of higher order in one chart takes the place of the exact solution.",
        ("Chart.reference",),
        (
            "test_paper_charts.py::test_hamiltonian_flow_is_that_of_riemannian_cubics",
            "test_chart.py::test_reference_against_forty_digits",
        ),
        (report.IN_CHARTS, report.EXACT),
        "A Taylor method with error below 1e-13, `reference` in tables.",
    ),
    Row(
        "Data on the sphere",
        "Initial angles, velocity, acceleration and jerk; the time is 1.",
        ("reproduce.experiments.SPHERE", "Chart.momenta"),
        ("test_paper_charts.py::test_initial_data", "test_chart.py::test_momenta_of_a_polynomial_curve"),
        (report.FOUND, report.GCP_ERROR),
        "Acceleration and jerk are derivatives of the angles; other readings are in the table of the summary.",
    ),
    Row(
        "Data on St(3,2)",
        "The same for `(theta, phi, psi)`.",
        ("reproduce.experiments.STIEFEL_3_2", "Chart.momenta"),
        ("test_paper_charts.py::test_initial_data", "test_chart.py::test_momenta_of_a_polynomial_curve"),
        (report.FOUND, report.GCP_ERROR),
    ),
    Row(
        "Discrete flow",
        "Positions, velocities, accelerations and jerks at N + 1 equidistant times.",
        ("Chart.derivatives", "reproduce.experiments.reference"),
        ("test_paper_charts.py::test_flow_on_ttq",),
        (report.IN_CHARTS,),
        "`h = 1 / N`, `steps` is N",
    ),
    Row(
        "Boundary data",
        "The ends and end velocities of that flow are the data of the de Casteljau algorithm.",
        ("reproduce.experiments.boundary_data", "GeometricCubic"),
        ("test_paper_charts.py::test_flow_on_ttq", "test_paper_de_casteljau.py::test_eq_8_problem_1"),
        (report.GCP_CONSTANT,),
    ),
    Row(
        "Shooting",
        "Both integrators meet the boundary data by a shooting method.",
        ("Chart.shoot",),
        ("test_chart.py::test_shooting_meets_its_ends",),
        (report.SHOOTING, report.ORDERS),
        "BVP in tables; IVP is the same integrator without shooting.",
    ),
)

FIGURES: Final = (
    Row(
        "Figure 1",
        "Trajectories on the sphere: Runge-Kutta, de Casteljau, retraction based.",
        ("reproduce.experiments.solve",),
        ("test_reproduce.py::test_figures_are_png_and_pdf",),
        (report.TRAJECTORY_SPHERE, report.TRAJECTORY_FRAME),
        "St(3,2) is drawn as well, with both columns.",
    ),
    Row(
        "Figure 2a",
        "Table of mean errors on the sphere.",
        ("reproduce.experiments.mean_errors",),
        ("test_reproduce.py::test_error_table", "tests/paper.rs::sphere_table_agrees_to_four_digits"),
        (report.GCP_ERROR, report.GCP_CONSTANT),
        "Its numbers are not in the paper's text: recomputed, not compared. Retraction is the initial-point map.",
    ),
    Row(
        "Figure 2b",
        "Table of mean errors on St(3,2).",
        ("reproduce.experiments.mean_errors",),
        ("test_reproduce.py::test_error_table", "tests/paper.rs::stiefel_3_2_table_agrees_to_four_digits"),
        (report.GCP_ERROR, report.GCP_CONSTANT),
        "As for figure 2a.",
    ),
    Row(
        "Figure 3a",
        "Mean error against the step on the sphere.",
        ("reproduce.experiments.slope",),
        ("test_reproduce.py::test_figures_are_png_and_pdf", "test_reproduce.py::test_error_table"),
        (report.ERROR_SPHERE,),
    ),
    Row(
        "Figure 3b",
        "Mean error against the step on St(3,2).",
        ("reproduce.experiments.slope",),
        ("test_reproduce.py::test_figures_are_png_and_pdf", "test_reproduce.py::test_error_table"),
        (report.ERROR_FRAME,),
    ),
)

DISCUSSION: Final = (
    Row(
        "Claim",
        "De Casteljau's algorithm is far less accurate on these manifolds than in Euclidean space, even on the sphere.",
        ("GeometricCubic",),
        ("test_paper_claims.py::test_de_casteljau_is_exact_only_where_the_manifold_is_flat",),
        (report.GCP_ERROR, report.FOUND),
    ),
    Row(
        "Claim",
        "Relative mean errors: around 0.080 % on the sphere, 0.45 % on St(3,2).",
        ("reproduce.experiments.gcp_error_by_convention",),
        ("test_paper_claims.py::test_relative_mean_errors",),
        (report.GCP_ERROR, report.FOUND),
        "0.45 % coincides with the mean error before any division; 0.080 % does not follow from the data.",
    ),
    Row(
        "Relative error",
        "Mean error over the largest distance of two points.",
        ("reproduce.experiments.Experiment",),
        ("test_reproduce.py::test_diameter_is_the_distance_of_opposite_points",),
        (report.GCP_ERROR,),
        "Frobenius distance, `2 sqrt(k)` at most",
    ),
    Row(
        "Claim",
        "The error of the integrators increases with the step.",
        ("Chart.integrate", "Chart.shoot"),
        ("test_paper_claims.py::test_errors_of_the_integrators_grow_with_the_step",),
        (report.ORDERS, report.ERROR_SPHERE, report.ERROR_FRAME),
    ),
    Row(
        "Claim",
        "It tends to zero, at the expense of more work.",
        ("reproduce.experiments.overtakes",),
        ("test_reproduce.py::test_error_table", "tests/integrator.rs::measured_orders_are_one_and_two"),
        (report.SMALL_STEPS, report.COST),
    ),
    Row(
        "Claim",
        "The integrators are ideal near the initial point.",
        ("Chart.integrate",),
        ("test_paper_claims.py::test_errors_near_the_initial_point",),
        (report.TRAJECTORY_SPHERE, report.TRAJECTORY_FRAME),
        "Initial values, N = 100: up to t = 0.1 the mid-point error is below a tenth of GCP's; up to t = 0.05 the "
        "initial-point error is larger than GCP's.",
    ),
    Row(
        "Claim",
        "Any order of the error can be had.",
        ("Chart.integrate", "integrate_cubic"),
        ("test_chart_maps.py::test_orders", "tests/composition.rs::measured_orders_are_two_four_six"),
        (report.EXACT, report.SPLITTINGS),
        "`order=2`, 4, 6, 8: compositions of mid-point steps, and splittings.",
    ),
    Row(
        "Claim",
        "The error of GCP does not depend on h.",
        ("GeometricCubic",),
        ("test_paper_claims.py::test_gcp_does_not_depend_on_the_step",),
        (report.GCP_CONSTANT,),
    ),
    Row(
        "Conjecture",
        "Better approximations of the Riemannian exponential give a smaller mean error than the mid-point method.",
        ("reproduce.conjecture.measure", "Chart.shoot"),
        (
            "test_conjecture.py::test_closeness_is_the_distance_to_the_exponential",
            "test_conjecture.py::test_errors_of_another_retraction_are_those_of_its_method",
            "test_conjecture.py::test_the_verdict_follows_the_numbers",
        ),
        (report.CONJECTURE,),
        '`map="exponential_midpoint"` and others',
    ),
    Row(
        "Claim",
        "The mid-point map has a significantly smaller error than the initial-point map.",
        ("Chart.shoot", "Chart.integrate"),
        ("test_paper_claims.py::test_midpoint_beats_initial_point",),
        (report.ORDERS, report.ERROR_SPHERE, report.ERROR_FRAME),
    ),
    Row(
        "Claim",
        "Retraction-based integrators need much more work than the de Casteljau algorithm.",
        ("reproduce.experiments.measure_times",),
        ("test_reproduce.py::test_timing_table",),
        (report.COST,),
    ),
    Row(
        "Claim",
        "The de Casteljau algorithm solves boundary value problems directly; the integrators need shooting, which "
        "slows them down further.",
        ("GeometricCubic", "Chart.shoot"),
        (
            "test_paper_claims.py::test_shooting_integrates_more_than_once",
            "test_reproduce.py::test_timing_table",
        ),
        (report.COST, report.SHOOTING),
    ),
    Row(
        "Challenge 1",
        "The integrators stay in one chart.",
        ("Chart.integrate_across", "Chart.reference_across"),
        (
            "test_chart_maps.py::test_trajectory_across_charts",
            "test_chart_maps.py::test_reference_across_the_poles_against_forty_digits",
            "tests/atlas.rs::discrete_flows_run_through_the_poles",
        ),
        (report.IN_CHARTS, report.CHARTS),
        "Answered by symplectic changes of chart, and without charts by `integrate_cubic`.",
    ),
    Row(
        "Challenge 2",
        "They solve implicit algebraic equations, slowly and with numerical errors.",
        ("integrate_cubic",),
        (
            "test_splitting.py::test_reference_values_are_met",
            "tests/splitting.rs::orders_are_those_announced",
            "tests/splitting.rs::steps_are_symplectic",
        ),
        (report.SPLITTINGS, report.EXACT, report.INTEGRATORS),
        "Answered by explicit symplectic splittings of orders 2, 4, 6 and 8.",
    ),
    Row(
        "Future work",
        "Use the structure of a Lie group or of a homogeneous space.",
        ("integrate_cubic", "RiemannianCubic.from_initial"),
        ("tests/splitting.rs::flows_agree_in_any_number_of_dimensions", "test_formulas.py::test_strang_step"),
        (report.SPLITTINGS, report.INTEGRATORS),
        "St(n,k) is SO(n)/SO(n-k); a step has two exact flows.",
    ),
    Row(
        "Future work",
        "Consider the manifold as a submanifold of Euclidean space.",
        ("RiemannianCubic", "Curve.acceleration"),
        ("test_formulas.py::test_equation_of_cubics", "tests/manifold/metric.rs::christoffel_term_is_metric"),
        (report.MANIFOLD, report.CUBICS),
        "The equation of cubics in ambient coordinates is checked; there is no constrained integrator yet.",
    ),
    Row(
        "Claim",
        "In a cost-benefit analysis the de Casteljau algorithm is much faster for the boundary value problem.",
        ("GeometricCubic", "reproduce.experiments.measure_times"),
        ("test_reproduce.py::test_timing_table",),
        (report.COST,),
    ),
    Row(
        "Future work",
        "Choose other control points.",
        ("GeometricPolynomial.minimal_cost", "GeometricPolynomial.quintic"),
        (
            "test_control_points.py::test_rows_hold_the_papers_errors_and_falling_costs",
            "test_random_control_points.py::test_higher_degrees_come_nearer",
        ),
        (report.CONTROL_POINTS, report.RANDOM_CONTROL_POINTS),
    ),
)
