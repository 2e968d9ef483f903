"""`skew_exp` and `orthogonal_log` of complex arrays, compared with SciPy, mpmath, the real embedding, each other."""

import mpmath
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from stiefel_rs import InvalidInputError, OutsideDomainError, orthogonal_log, skew_exp

EPS = np.finfo(float).eps


def gaussian(rng, *shape):
    return rng.standard_normal(shape) + 1j * rng.standard_normal(shape)


def adjoint(A):
    return np.conj(np.swapaxes(A, -1, -2))


def skew(rng, *shape, norm=1.0):
    A = gaussian(rng, *shape)
    A = A - adjoint(A)
    return A * (norm / np.linalg.norm(A, 2, axis=(-2, -1), keepdims=True))


def unitary(angles, rng):
    """A unitary matrix with the given angles in a random orthonormal basis, and its skew-Hermitian logarithm."""
    B = np.linalg.qr(gaussian(rng, len(angles), len(angles)))[0]
    L = (B * (1j * np.asarray(angles))) @ adjoint(B)
    return (B * np.exp(1j * np.asarray(angles))) @ adjoint(B), (L - adjoint(L)) / 2


def embedded(A):
    return np.block([[A.real, -A.imag], [A.imag, A.real]])


def exact(function, A):
    """A function of mpmath, with 50 digits."""
    with mpmath.workdps(50):
        value = function(mpmath.matrix(A.tolist()))
        return np.array(value.tolist(), dtype=complex).reshape(A.shape)


def assert_below(measured, bound, what):
    assert measured <= bound, f"{what}: {measured:.3e} exceeds {bound:.3e}"


def assert_skew(L):
    assert np.array_equal(L, -adjoint(L)), f"not skew-Hermitian: {np.abs(L + adjoint(L)).max():.3e}"


@pytest.mark.parametrize("norm", [1e-300, 1e-9, 0.1, 1.0, 3.0, 20.0, 60.0, 1000.0])
@pytest.mark.parametrize("m", [1, 2, 3, 4, 6])
def test_exp_agrees_with_mpmath(m, norm, rng):
    A = skew(rng, m, m, norm=norm)
    bound = 2 * m * EPS * max(1.0, norm)
    assert_below(np.linalg.norm(skew_exp(A) - exact(mpmath.expm, A), 2), bound, "distance to the 50-digit exponential")


@pytest.mark.parametrize("norm", [1e-8, 0.1, 1.0, 10.0, 100.0])
@pytest.mark.parametrize("m", [5, 8, 13, 30, 70])
def test_exp_agrees_with_scipy(m, norm, rng):
    A = skew(rng, m, m, norm=norm)
    U = skew_exp(A)
    # SciPy's scaling and squaring loses about eps |A| per entry; 8 covers both sides.
    assert_below(np.linalg.norm(U - scipy.linalg.expm(A), 2), 8 * m * EPS * max(1, norm), "distance to SciPy's expm")
    # The docstring promises m * 1e-15.
    assert_below(np.linalg.norm(adjoint(U) @ U - np.eye(m), 2), m * 1e-15, "unitarity defect")


@pytest.mark.parametrize("m", [1, 2, 3, 7, 20])
def test_both_are_those_of_the_embedding(m, rng):
    A = skew(rng, m, m, norm=2.0)
    U = skew_exp(A)
    assert_below(np.linalg.norm(embedded(U) - skew_exp(embedded(A)), 2), 16 * m * EPS, "exponentials")
    assert_below(
        np.linalg.norm(embedded(orthogonal_log(U)) - orthogonal_log(embedded(U)), 2), 32 * m * EPS, "logarithms"
    )


@pytest.mark.parametrize("norm", [0.01, 1.0, 2.5, 3.1])
@pytest.mark.parametrize("m", [1, 2, 3, 5])
def test_log_agrees_with_mpmath(m, norm, rng):
    A = skew(rng, m, m, norm=norm)
    U = skew_exp(A)
    # mpmath's logarithm is not exactly skew, because of the unitarity defect of U. Differences of angles are up to 2
    # norm, so the logarithm has the condition number x / sin x for x = norm.
    bound = 20 * m * EPS * max(1, norm / np.sin(norm))
    L = orthogonal_log(U)
    assert_skew(L)
    # For angles near pi, mpmath 1.3 returns a logarithm other than the principal one.
    expected = exact(mpmath.logm, U) if norm < 3 else A
    assert_below(np.linalg.norm(L - expected, 2), bound, "distance to the 50-digit logarithm")


@pytest.mark.parametrize("m", [8, 20, 50])
def test_log_agrees_with_scipy(m, rng):
    U = skew_exp(skew(rng, m, m, norm=2.5))
    assert_below(np.linalg.norm(orthogonal_log(U) - scipy.linalg.logm(U), 2), 100 * m * EPS, "distance to SciPy's logm")


ANGLES = [0.0, 1e-15, 1e-8, 0.7, 0.7 + 1e-9, -0.7, np.pi / 2, -np.pi / 2, 3.0, np.pi - 1e-6, np.pi, 1e-9 - np.pi]


@given(
    st.lists(st.sampled_from(ANGLES) | st.floats(-np.pi, np.pi), min_size=1, max_size=10),
    st.integers(0, 2**32 - 1),
)
@settings(deadline=None, max_examples=200)
def test_log_then_exp_gives_the_unitary_matrix_back(angles, seed):
    m = len(angles)
    U, _ = unitary(angles, np.random.default_rng(seed))
    L = orthogonal_log(U)
    assert_skew(L)
    assert_below(np.linalg.norm(skew_exp(L) - U, 2), 3 * m * 1e-15, f"|exp(log U) - U| for angles {angles}")
    assert_below(np.linalg.norm(L, 2), np.pi * (1 + 8 * EPS), "largest angle")
    diagonal = np.diag(np.exp(1j * np.array(angles)))
    assert_below(np.linalg.norm(skew_exp(orthogonal_log(diagonal)) - diagonal, 2), 3 * m * 1e-15, "diagonal")


@given(st.integers(1, 10), st.floats(0, 3.0), st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=100)
def test_exp_then_log_gives_the_skew_matrix_back(m, norm, seed):
    A = skew(np.random.default_rng(seed), m, m, norm=norm)
    # Condition number of the logarithm for differences of angles up to 6: 3 / sin 3 = 21.
    assert_below(np.linalg.norm(orthogonal_log(skew_exp(A)) - A, 2), 21 * 4 * m * EPS, "|log(exp A) - A|")


@pytest.mark.parametrize("m", [1, 2, 3, 4, 9, 30])
def test_log_of_an_eigenvalue_minus_one_has_the_angle_pi(m, rng):
    assert_below(np.linalg.norm(orthogonal_log(-np.eye(m) + 0j) - 1j * np.pi * np.eye(m), 2), 4 * EPS, "log of -I")
    angles = np.where(np.arange(m) % 2 == 0, np.pi, 0.3)
    U, L = unitary(angles, rng)
    assert_below(np.linalg.norm(orthogonal_log(U) - L, 2), 20 * m * EPS, "half of the space")


@pytest.mark.parametrize(
    "Q", [[[-1.0]], np.diag([1.0, 1.0, -1.0]), np.diag([1.0, -1.0, -1.0]), np.roll(np.eye(6), 1, axis=0)]
)
def test_what_has_no_real_logarithm_has_a_complex_one(Q):
    Q = np.asarray(Q)
    with pytest.raises(OutsideDomainError):
        orthogonal_log(Q)
    L = orthogonal_log(Q.astype(complex))
    assert_skew(L)
    assert_below(np.linalg.norm(skew_exp(L) - Q, 2), len(Q) * 1e-15, "|exp(log Q) - Q|")


@pytest.mark.parametrize("size", [1e-300, 1e-160, 1e-9])
@pytest.mark.parametrize("m", [1, 2, 3, 4, 20])
def test_log_of_small_angles_is_relatively_exact(m, size, rng):
    A = skew(rng, m, m)
    L = orthogonal_log(np.eye(m) + size * A)
    # e^{sA} = I + sA + O(s^2); the imaginary part and the off-diagonal entries are stored to eps s.
    error = np.linalg.norm(L / size - A, 2)
    assert_below(error, 4 * m * EPS + 2 * size, "relative error")


@pytest.mark.parametrize("function", [skew_exp, orthogonal_log])
@pytest.mark.parametrize("m", [1, 2, 3, 5, 30])
def test_batches_equal_their_members(function, m, rng):
    A = skew(rng, 2, 3, m, m)
    batch = A if function is skew_exp else skew_exp(A)
    result = function(batch)
    assert result.shape == (2, 3, m, m)
    assert result.dtype == np.complex128
    assert result.flags.writeable
    for i in np.ndindex(2, 3):
        assert np.array_equal(result[i], function(batch[i])), f"member {i} differs from the single call"


@pytest.mark.parametrize("function", [skew_exp, orthogonal_log])
def test_the_numbers_of_the_array_decide(function, rng):
    A = skew(rng, 3, 3)
    A = A if function is skew_exp else skew_exp(A)
    expected = function(A)
    forms = {
        "lists": A.tolist(),
        "Fortran": np.asfortranarray(A),
        "reversed": A[::-1, ::-1].copy()[::-1, ::-1],
        "byte order": A.astype(A.dtype.newbyteorder()),
        "long": A.astype(np.clongdouble),
        "unmasked": np.ma.array(A),
        "read-only": np.frombuffer(A.tobytes(), dtype=complex).reshape(3, 3),
    }
    wide = np.zeros((3, 3), dtype=[("flag", "u1"), ("number", "c16")])
    wide["number"] = A
    forms["misaligned"] = wide["number"]
    for name, form in forms.items():
        found = function(form)
        assert found.dtype == np.complex128, name
        assert np.array_equal(found, expected), name
    assert function(np.eye(3) * (function is orthogonal_log)).dtype == np.float64
    single = function((np.eye(3) * (function is orthogonal_log)).astype(np.complex64))
    assert single.dtype == np.complex128
    assert np.array_equal(single, np.eye(3) * (function is skew_exp))


@pytest.mark.parametrize("function", [skew_exp, orthogonal_log])
@pytest.mark.parametrize("lead", [(0,), (2, 0), (0, 3)])
def test_empty_batches(function, lead):
    found = function(np.zeros((*lead, 3, 3), dtype=complex))
    assert found.shape == (*lead, 3, 3)
    assert found.dtype == np.complex128


@pytest.mark.parametrize("function", [skew_exp, orthogonal_log])
@pytest.mark.parametrize("shape", [(), (3,), (2, 3), (0, 2, 3), (0, 0), (4, 0, 0)])
def test_shapes_that_are_refused(function, shape):
    with pytest.raises(InvalidInputError, match="shape"):
        function(np.zeros(shape, dtype=complex))


@pytest.mark.parametrize("function", [skew_exp, orthogonal_log])
def test_threads_do_not_change_a_bit(function, rng):
    A = skew(rng, 3000, 4, 4)
    batch = A if function is skew_exp else skew_exp(A)
    one = function(batch, num_threads=1)
    for threads in [2, None]:
        assert np.array_equal(one, function(batch, num_threads=threads)), f"num_threads={threads} differs from 1"
    with pytest.raises(InvalidInputError, match="num_threads"):
        function(batch[0], num_threads=0)


@pytest.mark.parametrize("m", [1, 2, 3, 12])
def test_errors_carry_the_defect(m, rng):
    A = skew(rng, m, m)
    with pytest.raises(InvalidInputError, match=r"A: not skew-Hermitian, \|A \+ A\^H\| / 2 = 1\.000e-6 exceeds"):
        skew_exp(A + 1.0001e-6 * np.diag([1.0] + [0.0] * (m - 1)))
    with pytest.raises(InvalidInputError, match=r"Q: not unitary, \|Q\^H Q - I\| = [0-9.]+e-6 exceeds 1\.000e-9"):
        orthogonal_log(skew_exp(A) * (1 + 1e-6))
    for function, name in [(skew_exp, "A"), (orthogonal_log, "Q")]:
        for bad in [np.nan, np.inf, 1j * np.nan, -1j * np.inf]:
            broken = A.copy() if function is skew_exp else skew_exp(A)
            broken[-1, 0] = bad
            with pytest.raises(InvalidInputError, match=f"{name}: entry .* is not finite"):
                function(broken)
            with pytest.raises(InvalidInputError, match="batch member 1"):
                function(np.stack([np.eye(m) * (function is orthogonal_log), broken]))
        masked = np.ma.array(np.zeros((m, m), dtype=complex))
        masked[0, 0] = np.ma.masked
        with pytest.raises(InvalidInputError, match=f"{name}: 1 of {m * m} entries is masked"):
            function(masked)
