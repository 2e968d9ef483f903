"""The places to which the map refers; a renamed place is changed here."""

from typing import Final

from .row import Section
from .verdicts import VERDICTS

# Headings of out/tables/summary.md.
RELATIVE_ERROR: Final = Section("summary", "0.080 % and 0.45 %: the relative mean error of GCP", "0.080 % and 0.45 %")
FLAT: Final = Section("summary", "Exact where the manifold is flat", "exact where flat")
STEP: Final = Section("summary", "The error and the step", "the error and the step")
NEAR_START: Final = Section("summary", "Near the initial point", "near the initial point")
TWO_MAPS: Final = Section("summary", "The mid-point map against the initial-point map", "mid-point or initial-point")
CONJECTURE: Final = Section("summary", "The conjecture as stated", "the conjecture")
TIMES: Final = Section("summary", "Times", "times")
CHART_CHALLENGE: Final = Section("summary", "The chart challenge", "the chart challenge")
IMPLICIT_CHALLENGE: Final = Section("summary", "The challenge of implicit equations", "implicit equations")
EMBEDDED: Final = Section("summary", "A submanifold of Euclidean space", "a submanifold of Euclidean space")
RETRACTION_PAIRS: Final = Section(
    "summary", "Every pair of retractions, initial and boundary values, orders 1 and 2", "every pair of retractions"
)
EXACT: Final = Section("summary", "The exact cubic, without charts", "the exact cubic")
ANY_SHAPE: Final = Section("summary", "Exact cubics on any St(n,k)", "any St(n,k)")
CONTROL_POINTS: Final = Section("summary", "Other control points", "other control points")
INVARIANTS: Final = Section("summary", "Energy and momentum along the discrete flows", "energy and momentum")
INDEPENDENT: Final = Section("summary", "Independent recomputation (NumPy/mpmath)", "independent recomputation")
SUMMARY: Final = (
    RELATIVE_ERROR,
    FLAT,
    STEP,
    NEAR_START,
    TWO_MAPS,
    CONJECTURE,
    TIMES,
    CHART_CHALLENGE,
    IMPLICIT_CHALLENGE,
    EMBEDDED,
    RETRACTION_PAIRS,
    EXACT,
    ANY_SHAPE,
    CONTROL_POINTS,
    INVARIANTS,
    INDEPENDENT,
)

# Tables of out/tables and figures of out/figures.
TABLE_2A: Final = Section("table", "figure_2a", "mean errors on the sphere")
TABLE_2B: Final = Section("table", "figure_2b", "mean errors on St(3,2)")
FIGURE_1: Final = Section("figure", "figure_1", "trajectories on the sphere")
FIGURE_3A: Final = Section("figure", "figure_3a", "mean errors on the sphere, drawn")
FIGURE_3B: Final = Section("figure", "figure_3b", "mean errors on St(3,2), drawn")
TRAJECTORY_FRAME: Final = Section("figure", "trajectory_stiefel_3_2", "trajectories on St(3,2)")
CONJECTURE_FIGURE: Final = Section("figure", "conjecture", "the conjecture, drawn")
CONTROL_POINTS_FIGURE: Final = Section("figure", "control_points", "other control points, drawn")
FILES: Final = (
    TABLE_2A,
    TABLE_2B,
    FIGURE_1,
    FIGURE_3A,
    FIGURE_3B,
    TRAJECTORY_FRAME,
    CONJECTURE_FIGURE,
    CONTROL_POINTS_FIGURE,
)

# Rows of the table of verdicts.
_VERDICTS: Final = {v.claim: Section("verdict", v.claim, f"verdict {n}") for n, v in enumerate(VERDICTS, 1)}


def verdict(claim: str) -> Section:
    """Return the row of the table of verdicts with this name in ``claims.csv``."""
    return _VERDICTS[claim]


# Pages of docs/.
MANIFOLD: Final = Section("page", "mathematics.md", "formulas: the manifold", "The manifold")
GEODESICS: Final = Section("page", "mathematics.md", "formulas: geodesics", "Geodesics")
RETRACTIONS: Final = Section("page", "mathematics.md", "formulas: retractions", "Retractions")
QUASI_GEODESICS: Final = Section("page", "mathematics.md", "formulas: quasi-geodesics", "Quasi-geodesics")
DE_CASTELJAU: Final = Section("page", "mathematics.md", "formulas: de Casteljau curves", "De Casteljau curves")
CUBICS: Final = Section("page", "mathematics.md", "formulas: Riemannian cubics", "Riemannian cubics")
SPLITTINGS: Final = Section("page", "mathematics.md", "formulas: splittings", "Splittings")
IN_THE_EMBEDDING: Final = Section("page", "mathematics.md", "formulas: in the embedding", "In the embedding")
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
EMBEDDED_STEPS: Final = Section("page", "integrators.md", "embedded method", "In the embedding, at equal steps")
PAGES: Final = (
    MANIFOLD,
    GEODESICS,
    RETRACTIONS,
    QUASI_GEODESICS,
    DE_CASTELJAU,
    CUBICS,
    SPLITTINGS,
    IN_THE_EMBEDDING,
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
    EMBEDDED_STEPS,
)
ALL: Final = (*SUMMARY, *FILES, *_VERDICTS.values(), *PAGES)
