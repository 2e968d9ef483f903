"""Formulas that do not hold as printed, with the amounts that the tests measure."""

from typing import Final

from .row import Misprint

SPHERE: Final = Misprint(
    "Remark 1",
    "St(n,1) is the unit sphere `S^n`.",
    "It is `S^{n-1}`, of dimension n - 1.",
    "The dimension of the tangent space differs from n by {error}, for n = 2 to 6.",
    1.0,
    ("test_paper_misprints.py::test_remark_1_dimension_of_the_sphere",),
)
GEODESIC: Final = Misprint(
    "Remark 1",
    "The quasi-geodesic is a geodesic only if `X = 0` or `Omega = 0`.",
    "It is a geodesic if and only if `K Omega = 0`, `K = X S`; equivalent for k = 1 and 2, but not for k >= 3.",
    "On St(4,3) there is a geodesic whose X and Omega have the Frobenius norm {error}, from entries of 0.8. (The "
    "report uses entries of 1: norms 1.414.)",
    1.131,
    (
        "test_paper_misprints.py::test_remark_1_for_three_columns",
        "test_paper_misprints.py::test_remark_1_condition_for_any_number_of_columns",
    ),
)
PROPOSITION: Final = Misprint(
    "Proposition 1",
    "(6) and (7) join two distinct points.",
    "They join close points, as Remark 1 adds; on the sphere, points closer than pi/2. Beyond, Omega is the logarithm "
    "of -1. With the change of signs in [formulas: quasi-geodesics](mathematics.md#quasi-geodesics) every point except "
    "the opposite point is reached.",
    "At the angle 2 the curve with Omega = 0 ends at a distance of {error} from `S_1`.",
    2.0,
    (
        "test_paper_misprints.py::test_proposition_1_past_a_right_angle",
        "tests/quasi_geodesic/between_points.rs::between_meets_end_points_beyond_the_paper",
    ),
)
BRACKET: Final = Misprint(
    "Hamiltonian of St(3,2)",
    "The bracket after `(1 - cos(2 theta))^3` opens in one fraction and closes in the next.",
    "The cube multiplies both fractions.",
    "With the cube on the first fraction only, H differs by {error} at the state of the test, where theta = 0.9 and "
    "H = 0.8067. (The report has the largest difference divided by 1 + |H| at 200 random states.)",
    0.7255,
    ("test_paper_misprints.py::test_bracket_of_the_hamiltonian_of_frames",),
)
FACTOR: Final = Misprint(
    "Functional J, Hamiltonians",
    "J has no factor 1/2, the Hamiltonians have `p^2 / 2`.",
    "The Hamiltonians belong to J/2; the Hamiltonians of J have `p^2 / 4`. The curves are the same, the momenta "
    "twice as large.",
    "On the sphere the two Hamiltonians differ by {error} at the state of the test.",
    0.2496,
    ("test_paper_misprints.py::test_functional_with_and_without_one_half",),
)
GEOMETRIC: Final = Misprint(
    "Section 4.3",
    "The de Casteljau algorithm approximates geometric cubic polynomials.",
    "It yields geometric cubics (Theorem 1), and approximates Riemannian cubics.",
    "On St(3,2), N = 10, its mean distance to (11) is at round-off, its mean distance to the Riemannian cubic is "
    "{error}.",
    0.004151,
    ("test_paper_misprints.py::test_geometric_cubics_are_no_riemannian_ones",),
)
MISPRINTS: Final = (SPHERE, GEODESIC, PROPOSITION, BRACKET, FACTOR, GEOMETRIC)
