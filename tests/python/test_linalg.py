"""`skew_exp` and `orthogonal_log` compared with SciPy, mpmath, closed forms, and each other."""

import mpmath
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from stiefel_rs import OutsideDomainError, orthogonal_log, skew_exp

EPS = np.finfo(float).eps


def skew(rng, *shape):
    A = rng.standard_normal(shape)
    return (A - np.swapaxes(A, -1, -2)) / 2


def rotation(angles, m, rng=None):
    """A rotation by the given angles in a random (or the standard) orthonormal basis, and its skew logarithm."""
    L = np.zeros((m, m))
    Q = np.eye(m)
    for i, angle in enumerate(angles):
        j = 2 * i
        c, s = np.cos(angle), np.sin(angle)
        Q[j : j + 2, j : j + 2] = [[c, -s], [s, c]]
        L[j, j + 1], L[j + 1, j] = -angle, angle
    if rng is None:
        return Q, L
    B = np.linalg.qr(rng.standard_normal((m, m)))[0]
    return B @ Q @ B.T, B @ L @ B.T


def assert_below(measured, bound, what):
    assert measured <= bound, f"{what}: {measured:.3e} exceeds {bound:.3e}"


@pytest.mark.parametrize("m", [1, 2, 3, 4, 5, 8, 13, 30])
@pytest.mark.parametrize("scale", [1e-8, 0.1, 1.0, 10.0])
def test_exp_agrees_with_scipy(m, scale, rng):
    A = scale * skew(rng, m, m)
    R = skew_exp(A)
    # SciPy's scaling and squaring loses about eps |A| per entry; 8 covers both sides.
    bound = 8 * m * EPS * max(1.0, np.linalg.norm(A, 2))
    assert_below(np.linalg.norm(R - scipy.linalg.expm(A)), bound, "distance to scipy.linalg.expm")
    # The docstring promises m * 1e-15.
    assert_below(np.linalg.norm(R.T @ R - np.eye(m)), m * 1e-15, "orthogonality defect")


@pytest.mark.parametrize(("m", "scale"), [(2, 1.0), (3, 1e-9), (3, 3.0), (4, 1.0), (5, 20.0), (7, 60.0)])
def test_exp_agrees_with_mpmath(m, scale, rng):
    A = scale * skew(rng, m, m)
    with mpmath.workdps(40):
        exact = np.array(mpmath.expm(mpmath.matrix(A.tolist())).tolist(), dtype=float).reshape(m, m)
    # Backward stable: relative eps in A moves e^A by eps |A|.
    bound = 4 * m * EPS * max(1.0, np.linalg.norm(A, 2))
    assert_below(np.linalg.norm(skew_exp(A) - exact), bound, "distance to the 40-digit exponential")


@pytest.mark.parametrize("m", [2, 3, 4, 5, 8, 21, 50])
def test_log_inverts_exp_below_pi(m, rng):
    A = skew(rng, m, m)
    A *= 3.0 / np.linalg.norm(A, 2)
    # An angle of 3 is 0.14 from pi: the logarithm's condition number there is about 1/0.14.
    assert_below(np.linalg.norm(orthogonal_log(skew_exp(A)) - A), 100 * m * EPS, "|log(exp A) - A|")


@pytest.mark.parametrize(
    ("angles", "m"),
    [
        ([], 5),
        ([1.0, 1.0, 1.0], 7),
        ([1.0, 1.0 + 1e-9, 1.0 - 1e-8], 6),
        ([1e-12, 2e-12], 4),
        ([np.pi - 1e-10, 0.3], 5),
        ([np.pi - 1e-10, np.pi - 2e-10], 4),
        ([0.4, np.pi - 0.4], 4),
        ([2.5] * 10 + [0.1] * 5, 32),
    ],
)
def test_log_of_degenerate_angles(angles, m, rng):
    Q, _ = rotation(angles, m, rng)
    L = orthogonal_log(Q)
    assert np.array_equal(L, -L.T), f"not skew: {np.abs(L + L.T).max():.3e}"
    # The promised backward error for m <= 50; Q itself is orthogonal to a few eps only.
    assert_below(np.linalg.norm(scipy.linalg.expm(L) - Q), 1e-13, "|exp(log Q) - Q|")
    largest = max(angles, default=0.0)
    assert_below(abs(np.linalg.norm(L, 2) - largest), 1e-13 * m, "error of the largest angle")


@pytest.mark.parametrize("angle", [1e-300, 1e-160, 1e-9, 0.5, 1.5, 3.0, -2.0])
@pytest.mark.parametrize("m", [2, 3, 4])
def test_log_of_a_plane_rotation_in_closed_form(angle, m):
    Q, L = rotation([angle], m)
    # Entries of Q have errors of eps, and so does the angle; small ones are determined by the sine to full relative
    # accuracy.
    bound = 4 * m * EPS * min(1.0, abs(angle) * 4)
    assert_below(np.abs(orthogonal_log(Q) - L).max(), bound, "distance to the closed form")


@pytest.mark.parametrize("m", [3, 5, 9, 25])
def test_log_of_the_cyclic_permutation(m):
    # Eigenvalues are the roots of unity: the angles 2 pi j / m, j = 1 .. (m - 1) / 2, are known.
    Q = np.roll(np.eye(m), 1, axis=0)
    L = orthogonal_log(Q)
    angles = np.sort(np.abs(np.linalg.eigvals(L).imag))[::-2][: (m - 1) // 2][::-1]
    exact = 2 * np.pi * np.arange(1, (m - 1) // 2 + 1) / m
    assert_below(np.abs(angles - exact).max(), 16 * m * EPS, "error of the angles")
    assert_below(np.linalg.norm(scipy.linalg.expm(L) - Q), 1e-13, "|exp(log Q) - Q|")


def test_log_agrees_with_mpmath(rng):
    A = skew(rng, 5, 5)
    A *= 2.0 / np.linalg.norm(A, 2)
    Q = skew_exp(A)
    with mpmath.workdps(40):
        exact = np.array(mpmath.logm(mpmath.matrix(Q.tolist())).tolist(), dtype=complex).reshape(5, 5).real
    # mpmath's logarithm is not exactly skew, by Q's own orthogonality defect of a few eps.
    assert_below(np.linalg.norm(orthogonal_log(Q) - exact), 20 * 5 * EPS, "distance to the 40-digit logarithm")


@pytest.mark.parametrize(
    "Q",
    [
        [[-1.0]],
        -np.eye(2),
        np.diag([1.0, 1.0, -1.0]),
        np.diag([1.0, -1.0, -1.0]),
        np.diag([1.0, -1.0, -1.0, 1.0, 1.0]),
        np.roll(np.eye(6), 1, axis=0),
    ],
    ids=["minus_one", "half_turn_2", "reflection_3", "half_turn_3", "half_turn_5", "odd_permutation"],
)
def test_log_outside_of_its_domain_carries_the_angle(Q):
    with pytest.raises(OutsideDomainError) as caught:
        orthogonal_log(Q)
    assert_below(abs(caught.value.angle - np.pi), 4 * EPS, "distance of the carried angle from pi")


@given(
    st.lists(
        st.sampled_from([0.0, 1e-15, 1e-8, 0.7, 0.7 + 1e-9, np.pi / 2, 3.0, np.pi - 1e-6]) | st.floats(0, 3.1),
        min_size=1,
        max_size=6,
    ),
    st.booleans(),
    st.integers(0, 2**32 - 1),
)
@settings(deadline=None, max_examples=150)
def test_log_then_exp_gives_the_rotation_back(angles, odd, seed):
    m = 2 * len(angles) + odd
    Q, _ = rotation(angles, m, np.random.default_rng(seed))
    L = orthogonal_log(Q)
    assert_below(np.linalg.norm(skew_exp(L) - Q), 1e-13, f"|exp(log Q) - Q| for angles {angles}")
    assert_below(np.linalg.norm(L, 2), np.pi * (1 + 4 * EPS), "largest angle")


@given(st.integers(1, 12), st.floats(0, 3.1), st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=100)
def test_exp_then_log_gives_the_skew_matrix_back(m, largest, seed):
    A = skew(np.random.default_rng(seed), m, m)
    if m > 1:
        A *= largest / np.linalg.norm(A, 2)
    # Condition number of the logarithm near pi: x / |sin x| <= 75 for x <= 3.1.
    assert_below(np.linalg.norm(orthogonal_log(skew_exp(A)) - A), 75 * 4 * m * EPS, "|log(exp A) - A|")


@pytest.mark.parametrize("function", [skew_exp, orthogonal_log])
@pytest.mark.parametrize("m", [1, 2, 3, 5, 7])
def test_batches_equal_their_members(function, m, rng):
    A = skew(rng, 2, 3, m, m)
    batch = A if function is skew_exp else skew_exp(A)
    result = function(batch)
    assert result.shape == (2, 3, m, m)
    assert result.dtype == np.float64
    for i in np.ndindex(2, 3):
        assert np.array_equal(result[i], function(batch[i])), f"member {i} differs from the single call"


@pytest.mark.parametrize("function", [skew_exp, orthogonal_log])
@pytest.mark.parametrize("lead", [(0,), (2, 0), (0, 3)])
def test_empty_batches(function, lead):
    assert function(np.zeros((*lead, 3, 3))).shape == (*lead, 3, 3)


@pytest.mark.parametrize("function", [skew_exp, orthogonal_log])
def test_threads_do_not_change_a_bit(function, rng):
    # 5000 matrices of size 6 x 6 are enough to be distributed to threads.
    A = skew(rng, 5000, 6, 6)
    batch = A if function is skew_exp else skew_exp(A / 3)
    one = function(batch, num_threads=1)
    for threads in [2, 3, None]:
        assert np.array_equal(one, function(batch, num_threads=threads)), f"num_threads={threads} differs from 1"
    assert np.array_equal(one[:10], function(batch[:10])), "a short batch differs from a long one"


def test_result_is_new_and_writable():
    A = np.zeros((3, 3))
    R = skew_exp(A)
    assert R.flags.writeable
    assert not np.shares_memory(A, R)


def test_error_in_a_batch_names_the_member(rng):
    Q = np.tile(np.eye(3), (4, 1, 1))
    Q[2] = np.diag([1.0, -1.0, -1.0])
    with pytest.raises(OutsideDomainError, match="batch member 2"):
        orthogonal_log(Q)
