"""The places that the map refers to; a place that gets another name is changed here."""

from typing import Final

from .row import Section

# Headings of out/tables/summary.md.
GCP_ERROR: Final = Section("summary", "1, 2. Mean error of GCP", "mean error of GCP")
GCP_CONSTANT: Final = Section("summary", "3. The error of GCP stays constant as h decreases", "constant error of GCP")
ORDERS: Final = Section("summary", "4. Order 1 of the initial-point method, order 2 of the mid-point method", "orders")
COST: Final = Section("summary", "5. Relative cost: the claim that GCP is faster", "relative cost")
SMALL_STEPS: Final = Section(
    "summary", "6. The retraction method reaches smaller errors for small h", "errors for small h"
)
INVARIANTS: Final = Section("summary", "7. Energy and momentum along the discrete flows", "energy and momentum")
CONJECTURE: Final = Section(
    "summary", "The conjecture: a retraction closer to the exponential has a smaller mean error", "the conjecture"
)
EXACT: Final = Section("summary", "The exact cubic, without charts", "the exact cubic")
CONTROL_POINTS: Final = Section("summary", "Other control points", "other control points")
SUMMARY: Final = (
    GCP_ERROR,
    GCP_CONSTANT,
    ORDERS,
    COST,
    SMALL_STEPS,
    INVARIANTS,
    CONJECTURE,
    EXACT,
    CONTROL_POINTS,
)

# Figures of out/figures.
TRAJECTORY_SPHERE: Final = Section("figure", "trajectory_sphere", "trajectories on the sphere")
TRAJECTORY_FRAME: Final = Section("figure", "trajectory_stiefel_3_2", "trajectories on St(3,2)")
ERROR_SPHERE: Final = Section("figure", "error_sphere", "mean errors on the sphere")
ERROR_FRAME: Final = Section("figure", "error_stiefel_3_2", "mean errors on St(3,2)")
FIGURES: Final = (TRAJECTORY_SPHERE, TRAJECTORY_FRAME, ERROR_SPHERE, ERROR_FRAME)

# Pages of docs/.
MANIFOLD: Final = Section("page", "mathematics.md", "formulas: the manifold", "The manifold")
GEODESICS: Final = Section("page", "mathematics.md", "formulas: geodesics", "Geodesics")
RETRACTIONS: Final = Section("page", "mathematics.md", "formulas: retractions", "Retractions")
QUASI_GEODESICS: Final = Section("page", "mathematics.md", "formulas: quasi-geodesics", "Quasi-geodesics")
DE_CASTELJAU: Final = Section("page", "mathematics.md", "formulas: de Casteljau curves", "De Casteljau curves")
CUBICS: Final = Section("page", "mathematics.md", "formulas: Riemannian cubics", "Riemannian cubics")
SPLITTINGS: Final = Section("page", "mathematics.md", "formulas: splittings", "Splittings")
FUNCTIONAL: Final = Section("page", "mathematics.md", "formulas: cost", "Cost and arc length")
CHARTS: Final = Section("page", "mathematics.md", "formulas: charts", "The paper's charts")
ROTATIONS: Final = Section(
    "page", "mathematics.md", "formulas: matrix functions", "Exponential and logarithm of rotations"
)
ANOTHER_TIME: Final = Section("page", "guides/join_two_frames.md", "guide: another time", "In another time")
IN_CHARTS: Final = Section("page", "guides/integrate.md", "guide: charts", "In the paper's charts")
SHOOTING: Final = Section("page", "guides/integrate.md", "guide: shooting", "Shooting")
FOUND: Final = Section("page", "guides/compare_with_the_paper.md", "guide: the comparison", "What was found")
BOUNDARY_PROBLEMS: Final = Section("page", "boundary_problems.md", "boundary problems")
RANDOM_CONTROL_POINTS: Final = Section("page", "control_points.md", "control points")
INTEGRATORS: Final = Section("page", "integrators.md", "integrators", "Cost of a step")
PAGES: Final = (
    MANIFOLD,
    GEODESICS,
    RETRACTIONS,
    QUASI_GEODESICS,
    DE_CASTELJAU,
    CUBICS,
    SPLITTINGS,
    FUNCTIONAL,
    CHARTS,
    ROTATIONS,
    ANOTHER_TIME,
    IN_CHARTS,
    SHOOTING,
    FOUND,
    BOUNDARY_PROBLEMS,
    RANDOM_CONTROL_POINTS,
    INTEGRATORS,
)
ALL: Final = (*SUMMARY, *FIGURES, *PAGES)
