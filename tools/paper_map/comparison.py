"""Rows of sections 4.2 and 4.3 of the paper: the experiments, the figures, the discussion."""

from typing import Final

from . import report
from .row import Row

EXPERIMENTS: Final = (
    Row(
        "Claim",
        "Points of (11) need only exponentials of skew matrices and logarithms of orthogonal matrices.",
        ("skew_exp", "orthogonal_log", "GeometricCubic.__call__"),
        (
            "test_paper_de_casteljau.py::test_eq_11_theorem_1_curve",
            "test_linalg.py::test_exp_agrees_with_scipy",
            "test_linalg.py::test_log_agrees_with_mpmath",
        ),
        (report.ROTATIONS, report.DE_CASTELJAU),
        "k x k logarithms instead of n x n logarithms",
    ),
    Row(
        "Benchmark",
        "A Runge-Kutta method of higher order in one chart replaces the exact solution.",
        ("Chart.reference",),
        (
            "test_paper_charts.py::test_hamiltonian_flow_is_that_of_riemannian_cubics",
            "test_chart.py::test_reference_against_forty_digits",
        ),
        (
            report.IN_CHARTS,
            report.EXACT,
            report.INDEPENDENT,
        ),
        "A Taylor method with error below 1e-13, `reference` in tables.",
    ),
    Row(
        "Data on the sphere",
        "Initial angles, velocity, acceleration and jerk; the time is 1.",
        ("reproduce.experiments.SPHERE", "Chart.momenta"),
        ("test_paper_charts.py::test_initial_data", "test_chart.py::test_momenta_of_a_polynomial_curve"),
        (
            report.RELATIVE_ERROR,
            report.FOUND,
        ),
        "Acceleration and jerk are derivatives of the angles; the summary has other interpretations.",
    ),
    Row(
        "Data on St(3,2)",
        "The same for `(theta, phi, psi)`.",
        ("reproduce.experiments.STIEFEL_3_2", "Chart.momenta"),
        ("test_paper_charts.py::test_initial_data", "test_chart.py::test_momenta_of_a_polynomial_curve"),
        (
            report.RELATIVE_ERROR,
            report.FOUND,
        ),
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
        (report.STEP,),
    ),
    Row(
        "Shooting",
        "Both integrators meet the boundary data by a shooting method.",
        ("Chart.shoot",),
        ("test_chart.py::test_shooting_meets_its_ends",),
        (
            report.SHOOTING,
            report.TIMES,
        ),
        "BVP in tables; IVP is the same integrator without shooting.",
    ),
)

FIGURES: Final = (
    Row(
        "Figure 1",
        "Trajectories on the sphere: Runge-Kutta, de Casteljau, retraction based.",
        ("reproduce.paper_figures.trajectory_figure",),
        (
            "test_reproduce.py::test_figures_are_png_svg_and_pdf",
            "test_paper_figures.py::test_zooms_show_the_curves_apart",
        ),
        (
            report.FIGURE_1,
            report.TRAJECTORY_FRAME,
        ),
        "The second figure, on St(3,2), is not in the paper.",
    ),
    Row(
        "Figure 2a",
        "Table of mean errors on the sphere.",
        ("reproduce.experiments.mean_errors",),
        (
            "test_reproduce.py::test_tables_of_the_paper_have_its_columns",
            "tests/paper.rs::sphere_table_agrees_to_four_digits",
        ),
        (
            report.TABLE_2A,
            report.STEP,
            report.INDEPENDENT,
        ),
        "Recomputed but not compared, since the paper prints no numbers as text. `Retraction` is the initial-point "
        "map.",
    ),
    Row(
        "Figure 2b",
        "Table of mean errors on St(3,2).",
        ("reproduce.experiments.mean_errors",),
        (
            "test_reproduce.py::test_tables_of_the_paper_have_its_columns",
            "tests/paper.rs::stiefel_3_2_table_agrees_to_four_digits",
        ),
        (
            report.TABLE_2B,
            report.STEP,
            report.INDEPENDENT,
        ),
        "As for figure 2a.",
    ),
    Row(
        "Figure 3a",
        "Mean error against the step on the sphere.",
        ("reproduce.paper_figures.error_figure", "reproduce.experiments.slope"),
        (
            "test_paper_figures.py::test_errors_are_those_of_the_papers_three_methods",
            "test_reproduce.py::test_error_table",
        ),
        (report.FIGURE_3A,),
    ),
    Row(
        "Figure 3b",
        "Mean error against the step on St(3,2).",
        ("reproduce.paper_figures.error_figure", "reproduce.experiments.slope"),
        (
            "test_paper_figures.py::test_errors_are_those_of_the_papers_three_methods",
            "test_reproduce.py::test_error_table",
        ),
        (report.FIGURE_3B,),
    ),
)

DISCUSSION: Final = (
    Row(
        "Claim",
        "De Casteljau's algorithm is far less accurate on these manifolds than in Euclidean space, even on the sphere.",
        ("GeometricCubic",),
        ("test_paper_claims.py::test_de_casteljau_is_exact_only_where_the_manifold_is_flat",),
        (
            report.verdict("below_euclidean"),
            report.FLAT,
        ),
    ),
    Row(
        "Claim",
        "Relative mean errors: around 0.080 % on the sphere, 0.45 % on St(3,2).",
        ("reproduce.readings.measure",),
        ("test_paper_claims.py::test_relative_mean_errors",),
        (
            report.verdict("sphere_error"),
            report.verdict("frame_error"),
            report.RELATIVE_ERROR,
        ),
        "0.45 % matches the mean error before any division; no interpretation tried gives 0.080 %.",
    ),
    Row(
        "Relative error",
        "Mean error divided by the largest distance of two points.",
        ("reproduce.experiments.Experiment",),
        ("test_reproduce.py::test_diameter_is_the_distance_of_opposite_points",),
        (report.RELATIVE_ERROR,),
        "Frobenius distance, at most `2 sqrt(k)`; also tried: the geodesic distance, at most pi.",
    ),
    Row(
        "Claim",
        "The error of the integrators increases with the step.",
        ("Chart.integrate", "Chart.shoot"),
        ("test_paper_claims.py::test_errors_of_the_integrators_grow_with_the_step",),
        (
            report.verdict("increasing_in_the_step"),
            report.STEP,
            report.FIGURE_3A,
            report.FIGURE_3B,
        ),
    ),
    Row(
        "Claim",
        "It tends to zero, at the expense of more work.",
        ("reproduce.experiments.overtakes",),
        ("test_reproduce.py::test_error_table", "tests/integrator.rs::measured_orders_are_one_and_two"),
        (
            report.verdict("increasing_in_the_step"),
            report.STEP,
            report.TIMES,
        ),
    ),
    Row(
        "Claim",
        "The integrators are ideal near the initial point.",
        ("Chart.integrate",),
        ("test_paper_claims.py::test_errors_near_the_initial_point", "test_claims.py::test_near_the_start"),
        (
            report.verdict("near_the_start"),
            report.NEAR_START,
        ),
        "Mid-point method, N = 100: less than a tenth of GCP's error up to t = 0.1. Initial-point method, N = 100: "
        "larger than GCP's error up to t = 0.05, smaller on St(3,2) at t = 0.1. The report uses N = 160.",
    ),
    Row(
        "Claim",
        "Integrators of any order can be constructed.",
        ("Chart.integrate", "integrate_cubic"),
        ("test_chart_maps.py::test_orders", "tests/composition.rs::measured_orders_are_two_four_six"),
        (
            report.verdict("near_the_start"),
            report.NEAR_START,
            report.EXACT,
            report.SPLITTINGS,
        ),
        "`order=2`, 4, 6, 8: compositions of mid-point steps, and splittings.",
    ),
    Row(
        "Claim",
        "The error of GCP does not depend on h.",
        ("GeometricCubic",),
        ("test_paper_claims.py::test_gcp_does_not_depend_on_the_step",),
        (
            report.verdict("independent_of_the_step"),
            report.STEP,
        ),
    ),
    Row(
        "Conjecture",
        "Better approximations of the Riemannian exponential give a smaller mean error than the mid-point method.",
        ("reproduce.conjecture.outcomes", "Chart.shoot"),
        (
            "test_conjecture.py::test_closeness_is_the_distance_to_the_exponential",
            "test_conjecture.py::test_errors_of_another_retraction_are_those_of_its_method",
            "test_conjecture.py::test_the_conjecture_is_read_against_the_midpoint_method",
        ),
        (
            report.verdict("better_retractions"),
            report.CONJECTURE,
            report.CONJECTURE_FIGURE,
            report.RETRACTION_PAIRS,
        ),
        '`map="exponential_midpoint"` and others',
    ),
    Row(
        "Claim",
        "The mid-point map has a significantly smaller error than the initial-point map.",
        ("Chart.shoot", "Chart.integrate"),
        ("test_paper_claims.py::test_midpoint_beats_initial_point",),
        (
            report.verdict("midpoint_wins"),
            report.TWO_MAPS,
        ),
        "The paper sees a trend towards its conjecture; both maps come from one retraction, linear in coordinates.",
    ),
    Row(
        "Claim",
        "Retraction-based integrators need much more work than the de Casteljau algorithm.",
        ("reproduce.timing.measure_times",),
        ("test_reproduce.py::test_timing_table",),
        (
            report.verdict("more_effort"),
            report.TIMES,
        ),
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
        (
            report.verdict("shooting"),
            report.TIMES,
            report.SHOOTING,
        ),
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
        (
            report.verdict("single_chart"),
            report.CHART_CHALLENGE,
            report.IN_CHARTS,
        ),
        "Answered by symplectic changes of chart, and by `integrate_cubic` without charts.",
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
        (
            report.verdict("implicit_equations"),
            report.verdict("numerical_errors"),
            report.IMPLICIT_CHALLENGE,
            report.NEAR_START,
            report.SPLITTINGS,
        ),
        "Answered by explicit symplectic splittings of orders 2, 4, 6 and 8.",
    ),
    Row(
        "Future work",
        "Use the structure of a Lie group or of a homogeneous space.",
        ("integrate_cubic", "RiemannianCubic.from_initial"),
        ("tests/splitting.rs::flows_agree_in_any_number_of_dimensions", "test_formulas.py::test_strang_step"),
        (
            report.verdict("homogeneous"),
            report.IMPLICIT_CHALLENGE,
            report.ANY_SHAPE,
            report.INTEGRATORS,
        ),
        "St(n,k) is SO(n)/SO(n-k); a step has two exact flows.",
    ),
    Row(
        "Future work",
        "Consider the manifold as a submanifold of Euclidean space.",
        ("integrate_embedded", "reproduce.embedded.measure", "Curve.acceleration"),
        (
            "tests/embedded.rs::order_is_two",
            "tests/embedded.rs::constraints_and_momentum_hold_to_round_off_for_any_number_of_steps",
            "tests/embedded.rs::steps_are_symplectic_on_the_constrained_manifold",
            "test_embedded.py::test_the_cubic_is_met_with_order_two",
            "test_embedded.py::test_shapes_and_invariants",
            "test_formulas.py::test_step_in_the_embedding",
            "test_paper_statements.py::test_embedded_method_beside_the_others",
            "test_formulas.py::test_equation_of_cubics",
            "tests/manifold/metric.rs::christoffel_term_is_metric",
        ),
        (
            report.verdict("embedded"),
            report.EMBEDDED,
            report.IN_THE_EMBEDDING,
            report.EMBEDDED_STEPS,
            report.MANIFOLD,
            report.CUBICS,
        ),
        "A symplectic method of order 2 on `T*(TSt(n, k))` in the space of four `n x k` matrices, for any `n` and `k`.",
    ),
    Row(
        "Claim",
        "In a cost-benefit analysis the de Casteljau algorithm is much faster for the boundary value problem.",
        ("GeometricCubic", "reproduce.timing.measure_times"),
        ("test_reproduce.py::test_timing_table",),
        (
            report.verdict("much_faster"),
            report.TIMES,
        ),
    ),
    Row(
        "Future work",
        "Choose other control points.",
        ("GeometricPolynomial.minimal_cost", "GeometricPolynomial.quintic"),
        (
            "test_control_points.py::test_rows_hold_the_papers_errors_and_falling_costs",
            "test_random_control_points.py::test_higher_degrees_come_nearer",
        ),
        (
            report.verdict("other_control_points"),
            report.CONTROL_POINTS,
            report.CONTROL_POINTS_FIGURE,
            report.RANDOM_CONTROL_POINTS,
        ),
    ),
)
