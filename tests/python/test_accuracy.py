"""Errors of matrix functions compared with at least 50 digits, as stated in `docs/accuracy.md`."""

import re

import mpmath
import numpy as np
import pytest

from benchmarks.accuracy import complex_cases
from benchmarks.accuracy.cases import BITS, below_pi, exp_cases, log_cases, random_skew, rotation
from benchmarks.accuracy.errors import (
    UNIT,
    ExpErrors,
    exp_errors,
    exp_reference,
    log_errors,
    log_reference,
    unitary_log_errors,
    unitary_log_reference,
)
from benchmarks.accuracy.fixed_point import FixedPoint, embedded, restricted
from benchmarks.accuracy.tables import is_shown
from stiefel_rs import OutsideDomainError, orthogonal_log, skew_exp

EPS = np.finfo(float).eps

# The reference takes 8 seconds for one logarithm at m = 50, so one such case is tested here; the page has all.
LOG_CASES = [case for case in log_cases() if case.m < 50 or case.name == "random"]
# Embedded matrices have twice the size: the reference takes 13 seconds at m = 30.
UNITARY_CASES = complex_cases.log_cases(complex_cases.SIZES[:-1])


def identifier(case):
    return f"{case.name}, m = {case.m}"


def distance(F, X, exact):
    """Largest difference between integers times 2^-bits and a matrix of mpmath."""
    m = len(X)
    scale = mpmath.mpf(2) ** F.bits
    return max(abs(mpmath.mpf(int(X[i, j])) / scale - exact[i, j]) for i in range(m) for j in range(m))


@pytest.mark.parametrize("m", [2, 3, 6])
def test_reference_exponential_agrees_with_mpmath(m):
    A = random_skew(m, 5.0)
    F = FixedPoint(BITS)
    with mpmath.workdps(90):
        assert distance(F, F.expm(F.exact(A)), mpmath.expm(mpmath.matrix(A.tolist()))) < 1e-70


@pytest.mark.parametrize("m", [2, 3, 5])
def test_reference_logarithm_agrees_with_mpmath(m):
    # mpmath computes the logarithm of the matrix itself, so pass the nearest rotation.
    Q = rotation([2.9, 0.7][: m // 2], m)
    F = FixedPoint(BITS)
    with mpmath.workdps(90):
        U = mpmath.matrix(m, m)
        for i, row in enumerate(F.polar(F.exact(Q))):
            for j, entry in enumerate(row):
                U[i, j] = mpmath.mpf(int(entry)) / mpmath.mpf(2) ** BITS
        assert distance(F, F.logm_rotation(F.exact(Q)), mpmath.logm(U)) < 1e-60


@pytest.mark.parametrize("exponent", [1, 7, 14])
def test_reference_logarithm_inverts_the_reference_exponential_near_pi(exponent):
    F = FixedPoint(BITS)
    L = F.logm_rotation(F.exact(rotation([below_pi(10.0**-exponent), 1.0], 5)))
    assert F.norm(F.logm_rotation(F.expm(L)) - L) < 1e-45
    assert not (L + L.T).any()


def matrix_of(F, X):
    """Integers times 2^-bits as a matrix of mpmath."""
    m = len(X)
    return mpmath.matrix([[mpmath.mpf(int(x)) / mpmath.mpf(2) ** F.bits for x in row] for row in X]), m // 2


def complex_part(F, X):
    """The complex matrix that is embedded."""
    R, m = matrix_of(F, X)
    return R[:m, :m] + 1j * R[m:, :m]


@pytest.mark.parametrize("m", [1, 2, 4])
def test_complex_references_agree_with_mpmath(m):
    A = complex_cases.random_skew_hermitian(m, 2.5)
    F = FixedPoint(BITS)
    X = F.exact(embedded(A))
    with mpmath.workdps(90):
        exact = mpmath.expm(mpmath.matrix(A.tolist()))
        found = F.expm(X)
        assert mpmath.mnorm(complex_part(F, found) - exact, "f") < 1e-70
        # The logarithm of the exponential.
        assert mpmath.mnorm(complex_part(F, F.logm_rotation(found)) - mpmath.matrix(A.tolist()), "f") < 1e-60


@pytest.mark.parametrize("case", [case for case in UNITARY_CASES if case.log_over_pi is not None], ids=identifier)
def test_exact_logarithms_of_fourth_roots_of_the_identity(case):
    F, L = unitary_log_reference(case)
    assert F.norm(F.expm(L) - F.exact(embedded(case.matrix))) < 1e-60
    angles = np.linalg.eigvalsh(-1j * restricted(F.rounded(L)))
    assert -np.pi + 1 < angles.min()
    assert angles.max() <= np.pi + 4 * case.m * EPS


@pytest.mark.parametrize("case", exp_cases() + complex_cases.exp_cases(), ids=identifier)
def test_exponential(case):
    found = exp_errors(skew_exp(case.matrix), case.matrix, exp_reference(case.matrix))
    bounds = ExpErrors.bounds(case.matrix)
    assert not found.above(bounds), f"{found} against {bounds}"


@pytest.mark.parametrize("case", LOG_CASES, ids=identifier)
def test_logarithm(case):
    reference = log_reference(case.matrix)
    F, exact = reference
    try:
        L = orthogonal_log(case.matrix)
    except OutsideDomainError:
        gap = float(mpmath.pi - mpmath.mpf(np.linalg.norm(F.rounded(exact), 2)))
        # Angles that cannot be distinguished from pi are refused: 4 m eps, plus the 4 eps by which this angle itself
        # may be off.
        assert gap <= (4 * case.m + 4) * EPS, f"refused at {gap:.3e} from pi"
        return
    found = log_errors(L, case.matrix, reference)
    above = set(found.above(found.bounds(case.m)))
    # Relative accuracy near the identity: see below.
    assert above <= {"forward"}, f"{found} against {found.bounds(case.m)}"
    if found.size >= 1 or case.m <= 3:
        assert not above, f"{found} against {found.bounds(case.m)}"


@pytest.mark.parametrize("case", UNITARY_CASES, ids=identifier)
def test_logarithm_of_a_unitary_matrix(case):
    found = unitary_log_errors(orthogonal_log(case.matrix), case, unitary_log_reference(case))
    assert not found.above(found.bounds(case.m)), f"{found} against {found.bounds(case.m)}"


def test_errors_of_a_wrong_logarithm_are_seen():
    case = next(case for case in UNITARY_CASES if case.name == "random" and case.m == 3)
    L = orthogonal_log(case.matrix)
    wrong = unitary_log_errors(L * (1 + 1e-12), case, unitary_log_reference(case))
    assert wrong.forward == pytest.approx(1e-12, rel=1e-2)
    assert set(wrong.above(wrong.bounds(3))) == {"forward", "absolute", "backward"}


# Regression: the planes of a small rotation are known only to eps, so from m = 4 on its logarithm was accurate in
# absolute terms, but had no correct digit at 1e-16.
@pytest.mark.parametrize("angle", [0.03, 1e-3, 1e-8, 1e-12])
@pytest.mark.parametrize("m", [4, 6, 12])
def test_logarithm_of_a_small_rotation_is_right_relative_to_its_size(angle, m):
    Q = rotation([angle] * (m // 2), m)
    found = log_errors(orthogonal_log(Q), Q, log_reference(Q))
    assert found.forward <= m * UNIT, f"relative error {found.forward:.1e}"


def test_logarithm_of_the_identity_plus_a_tiny_skew_matrix():
    A = random_skew(6, 1e-300)
    assert np.allclose(orthogonal_log(np.eye(6) + A) / 1e-300, A / 1e-300, rtol=0, atol=1e-14)


def test_page_has_a_line_of_every_family():
    def families(cases):
        return {re.sub(r"(norm|pi - 1e-).*", r"\1", case.name) for case in cases}

    for cases in (UNITARY_CASES, exp_cases(), log_cases()):
        shown = [case for case in cases if is_shown(case.name, case.m)]
        assert len(shown) < len(cases)
        assert families(shown) == families(cases)
    # The angle next to pi, and the one that is refused.
    assert {case.m for case in shown if case.name == "one angle pi - 1e-14"} == {2, 3, 4, 12}
