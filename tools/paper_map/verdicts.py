"""The verdicts of the report, in its order; a run writes its own to ``tables/claims.csv``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True)
class Verdict:
    """The report's verdict on one statement.

    Attributes
    ----------
    claim : str
        Name in ``claims.csv``.
    place, statement, verdict : str
        As the report has them.
    timed : bool
        Whether the verdict rests on times, so that it may change from run to run.
    """

    claim: str
    place: str
    statement: str
    verdict: str
    timed: bool = False


VERDICTS: Final = (
    Verdict("euler_lagrange", "1", "the Euler-Lagrange equations are hard to solve", "answered: solved to round-off"),
    Verdict("quasi_geodesics", "1", "quasi-geodesics are geodesics on the sphere, not on St(3,2)", "holds"),
    Verdict(
        "remark",
        "Remark 1",
        "a quasi-geodesic is a geodesic only if X = 0 or Omega = 0",
        "holds only if k <= 2; for any k the condition is X S Omega = 0",
    ),
    Verdict(
        "joining",
        "Prop. 1",
        "the quasi-geodesic of its X and Omega joins two points",
        "holds for close points, as Remark 1 says: nearer than pi/2 on the sphere",
    ),
    Verdict("end_data", "Thm 1", "GCP has the given ends and end velocities", "holds"),
    Verdict("symplectic", "Prop. 2", "both discretization maps give symplectic integrators", "holds"),
    Verdict(
        "general_hamiltonian",
        "4.1",
        "a general expression for the Hamiltonian might be hard to find",
        "answered: mu . x + p . p / 2 in a moving frame",
    ),
    Verdict("sphere_hamiltonian", "4.1", "the Hamiltonian on the sphere", "holds"),
    Verdict(
        "hamiltonian",
        "4.1",
        "the Hamiltonian on St(3,2)",
        "holds only if one bracket spans its first two fractions",
    ),
    Verdict(
        "below_euclidean", "4.3", "GCP is far less accurate here than in Euclidean space, even on the sphere", "holds"
    ),
    Verdict(
        "sphere_error",
        "4.3",
        "relative mean error of GCP around 0.080 % in the sphere",
        "does not hold under any reading tried",
    ),
    Verdict(
        "frame_error",
        "4.3",
        "relative mean error of GCP around 0.45 % in St(3,2)",
        "holds only if undivided: 0.45 % coincides with the mean error itself",
    ),
    Verdict("independent_of_the_step", "4.3", "the error of GCP does not depend on the step h", "holds"),
    Verdict("increasing_in_the_step", "4.3", "the integrators' error increases with h and tends to zero", "holds"),
    Verdict(
        "near_the_start",
        "4.3",
        "integrators, not GCP, are ideal near the initial point, at any desired order",
        "holds only if the order is 2 or more (at N = 160)",
    ),
    Verdict(
        "better_retractions",
        "4.3",
        "conjecture: better retractions have smaller errors than the mid-point method",
        "holds only on average, not in every case",
    ),
    Verdict(
        "midpoint_wins", "4.3", "the mid-point map has a significantly lower error than the initial-point map", "holds"
    ),
    Verdict(
        "more_effort",
        "4.3",
        "the integrators need much more computational effort than GCP",
        "holds only if boundary values are met, or N is at least 50",
        timed=True,
    ),
    Verdict("shooting", "4.3", "shooting slows them down even further", "holds", timed=True),
    Verdict("much_faster", "4.3", "GCP is much faster for boundary values", "holds", timed=True),
    Verdict(
        "single_chart",
        "4.3",
        "challenge: a single chart only",
        "holds for the chart method; answered by both others",
    ),
    Verdict(
        "implicit_equations",
        "4.3",
        "challenge: implicit equations make it very slow",
        "holds; answered by the splittings",
        timed=True,
    ),
    Verdict(
        "numerical_errors",
        "4.3",
        "challenge: implicit equations are subject to numerical errors",
        "does not hold on its curves: they stay at round-off",
    ),
    Verdict(
        "homogeneous",
        "4.3",
        "the structure of a homogeneous space might improve performance",
        "holds",
        timed=True,
    ),
    Verdict(
        "embedded",
        "4.3",
        "future work: a submanifold of Euclidean space",
        "holds: it can be done, but a splitting is much faster",
        timed=True,
    ),
    Verdict("other_control_points", "4.3", "an alternative choice of control points", "holds: it helps"),
)
