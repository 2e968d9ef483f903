"""Errors compared with at least 50 digits, as stated in `docs/accuracy.md`."""

import re

import mpmath
import numpy as np
import pytest

from benchmarks.accuracy.__main__ import is_shown
from benchmarks.accuracy.cases import BITS, below_pi, exp_cases, log_cases, random_skew, rotation
from benchmarks.accuracy.errors import UNIT, ExpErrors, exp_errors, exp_reference, log_errors, log_reference
from benchmarks.accuracy.fixed_point import FixedPoint
from stiefel_rs import OutsideDomainError, orthogonal_log, skew_exp

EPS = np.finfo(float).eps

# The reference takes 8 seconds for one logarithm at m = 50, so one such case is tested here; the page has all.
LOG_CASES = [case for case in log_cases() if case.m < 50 or case.name == "random"]


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


@pytest.mark.parametrize("case", exp_cases(), ids=identifier)
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

    for cases in (exp_cases(), log_cases()):
        shown = [case for case in cases if is_shown(case.name, case.m)]
        assert len(shown) < len(cases)
        assert families(shown) == families(cases)
    # The angle next to pi, and the one that is refused.
    assert {case.m for case in shown if case.name == "one angle pi - 1e-14"} == {2, 3, 4, 12}
