//! `skew_exp` and `orthogonal_log` for arrays.

use std::cell::Cell;
use std::thread::LocalKey;

use faer::c64;
use faer::traits::ComplexField;
use faer::traits::math_utils::{is_finite, zero};
use numpy::Element;

use super::array_namespace::Namespace;
use super::batch::map_batch;
use super::complex_array::{array_of, of_pairs, pairs};
use super::prelude::*;
use crate::linalg::{OrthogonalLog, SkewExp, UnitaryLog};

/// Up to this size a thread keeps its buffers, and a single matrix is computed in place.
const SMALL: usize = 128;

/// Up to this size a call takes about ten microseconds at most, and keeps the GIL.
const TINY: usize = 24;

/// A function of a square matrix with entries `T` and buffers `K`.
struct Kernel<K: 'static, T: 'static> {
    /// Name of the argument.
    name: &'static str,
    /// Buffers for the last size.
    kept: &'static LocalKey<Cell<Option<(usize, K)>>>,
    make: fn(usize) -> K,
    into: fn(&mut K, MatMut<'_, T>, MatRef<'_, T>) -> Result<()>,
}

thread_local! {
    static KEPT_EXP: Cell<Option<(usize, SkewExp)>> = const { Cell::new(None) };
    static KEPT_LOG: Cell<Option<(usize, OrthogonalLog)>> = const { Cell::new(None) };
    static KEPT_COMPLEX_EXP: Cell<Option<(usize, SkewExp<c64>)>> = const { Cell::new(None) };
    static KEPT_UNITARY_LOG: Cell<Option<(usize, UnitaryLog)>> = const { Cell::new(None) };
}

static EXP: Kernel<SkewExp, f64> = Kernel {
    name: "A",
    kept: &KEPT_EXP,
    make: SkewExp::new,
    into: SkewExp::checked_into,
};

static COMPLEX_EXP: Kernel<SkewExp<c64>, c64> = Kernel {
    name: "A",
    kept: &KEPT_COMPLEX_EXP,
    make: SkewExp::new,
    into: SkewExp::checked_into,
};

static LOG: Kernel<OrthogonalLog, f64> = Kernel {
    name: "Q",
    kept: &KEPT_LOG,
    make: OrthogonalLog::new,
    into: OrthogonalLog::checked_into,
};

static UNITARY_LOG: Kernel<UnitaryLog, c64> = Kernel {
    name: "Q",
    kept: &KEPT_UNITARY_LOG,
    make: UnitaryLog::new,
    into: UnitaryLog::checked_into,
};

impl<K, T: ComplexField<Real = f64> + Element + Copy> Kernel<K, T> {
    /// Evaluates one matrix, stored row by row.
    fn apply(&self, a: MatRef<'_, T>, out: &mut [T]) -> Result<()> {
        let m = a.nrows();
        let kept = self.kept.take().filter(|(size, _)| *size == m);
        let (_, mut buffers) = kept.unwrap_or_else(|| (m, (self.make)(m)));
        let result = (self.into)(&mut buffers, MatMut::from_row_major_slice_mut(out, m, m), a);
        if m <= SMALL {
            self.kept.set(Some((m, buffers)));
        }
        result
    }

    /// Evaluates one small matrix that is stored row by row; `None` for any other object.
    fn one<'py>(&self, object: &Any<'py>, threads: Option<i64>) -> PyResult<Option<Any<'py>>> {
        // Subclasses may interpret their numbers differently.
        if let Ok(array) = object.cast_exact::<PyArray2<T>>()
            && let &[m, cols] = array.shape()
            && m == cols
            && (1..=SMALL).contains(&m)
            && array.data().is_aligned()
            && array.is_c_contiguous()
            && let Ok(entries) = array.to_vec()
        {
            Call::new(object.py(), threads, 0.0)?;
            return self.small(object.py(), &entries, m).map(Some);
        }
        Ok(None)
    }

    /// Evaluates one small matrix.
    fn small<'py>(&self, py: Python<'py>, entries: &[T], m: usize) -> PyResult<Any<'py>> {
        let mut out = vec![zero::<T>(); m * m];
        let mut work = || self.apply(MatRef::from_row_major_slice(entries, m, m), &mut out);
        if m <= TINY { work() } else { py.detach(work) }?;
        if !out.iter().all(is_finite) {
            return Err(Error::Overflow { quantity: "result" }.into());
        }
        Ok(to_array(py, out, &[m, m])?.into_any())
    }
}

impl<K> Kernel<K, f64> {
    fn batch<'py>(&'static self, array: &Any<'py>, threads: Option<i64>) -> PyResult<Any<'py>> {
        let py = array.py();
        let [batch] = matrix_batches([(array, self.name)])?;
        let (m, cols) = (batch.rows, batch.cols);
        let call = Call::new(py, threads, batch.numbers())?;
        // Checked for an empty batch too.
        check_square(self.name, m, cols)?;
        let found = map_batch(&call, [batch], &[m, m], |[batch], i, out, _| {
            self.apply(batch.get(i), out)
        });
        found?.into_bound_py_any(py)
    }
}

impl<K> Kernel<K, c64> {
    /// Reads a batch as pairs of real numbers: a matrix has the shape `(m, 2 m)`.
    fn batch<'py>(&'static self, array: &Any<'py>, threads: Option<i64>) -> PyResult<Any<'py>> {
        let py = array.py();
        let shape: Vec<usize> = array.getattr("shape")?.extract()?;
        let [.., m, cols] = shape[..] else {
            return Err(unexpected(self.name, "(..., n, k)", &shape));
        };
        check_square(self.name, m, cols)?;
        let [batch] = matrix_batches([(&pairs(array)?, self.name)])?;
        let call = Call::new(py, threads, batch.numbers())?;
        let found = map_batch(&call, [batch], &[m, 2 * m], move |[batch], i, out, _| {
            let (numbers, _) = batch.row(i).as_chunks::<2>();
            let entries: Vec<c64> = numbers.iter().map(|[re, im]| c64::new(*re, *im)).collect();
            let mut value = vec![c64::new(0.0, 0.0); m * m];
            self.apply(MatRef::from_row_major_slice(&entries, m, m), &mut value)?;
            for (pair, x) in out.as_chunks_mut::<2>().0.iter_mut().zip(value) {
                *pair = [x.re, x.im];
            }
            Ok(())
        });
        of_pairs(&found?.into_bound_py_any(py)?)
    }
}

pub(super) fn check_square(name: &str, m: usize, cols: usize) -> PyResult<()> {
    let expected = format!("{name}: expected shape (..., m, m) with m >= 1");
    ensure!(m == cols && m > 0, "{expected}, found (..., {m}, {cols})");
    Ok(())
}

/// Chooses between the real and the complex function by the dtype of the array.
fn map<'py, K, C>(
    real: &'static Kernel<K, f64>,
    complex: &'static Kernel<C, c64>,
    object: &Any<'py>,
    threads: Option<i64>,
) -> PyResult<Any<'py>> {
    if let Some(value) = real.one(object, threads)? {
        return Ok(value);
    }
    if let Some(value) = complex.one(object, threads)? {
        return Ok(value);
    }
    let value = match array_of(object, real.name)? {
        (array, true) => complex.batch(&array, threads),
        (array, false) => real.batch(&array, threads),
    }?;
    Namespace::of([(object, real.name)])?.array(value)
}

/// Return the exponential of a skew-symmetric or skew-Hermitian matrix.
///
/// The result is a rotation or a unitary matrix, to round-off.
///
/// Parameters
/// ----------
/// A : array_like, shape (..., m, m)
///     Real and skew-symmetric, or complex and skew-Hermitian: ``|A + A^H| / 2 <= 1e-12 |A|``.
/// num_threads : int, optional
///     Number of threads for a batch; by default the size of the global pool.
///
/// Returns
/// -------
/// ndarray, shape (..., m, m)
///     ``e^A``, with ``|Q^H Q - I|_2`` at most ``m * 1e-15``; complex128 if ``A`` is complex, else float64.
///
/// Raises
/// ------
/// InvalidInputError
///     Not square, not finite, or not skew-symmetric or skew-Hermitian (with the measured defect).
///
/// Notes
/// -----
/// Closed forms for ``m <= 3`` (complex: ``m <= 2``); even and odd polynomials in ``A^2`` with squaring for moderate
/// norms; the real Schur form of Ward and Gray (1978) or the Hermitian eigenvalue problem for large norms.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import skew_exp
/// >>> bool(np.allclose(skew_exp([[0.0, -np.pi / 2], [np.pi / 2, 0.0]]), [[0, -1], [1, 0]]))
/// True
/// >>> bool(np.allclose(skew_exp([[0, 1j * np.pi / 2], [1j * np.pi / 2, 0]]), [[0, 1j], [1j, 0]]))
/// True
#[pyfunction]
#[pyo3(signature = (A, *, num_threads=None))]
pub fn skew_exp<'py>(A: &Any<'py>, num_threads: Option<i64>) -> PyResult<Any<'py>> {
    map(&EXP, &COMPLEX_EXP, A, num_threads)
}

/// Return the principal skew logarithm of a rotation or a unitary matrix.
///
/// The angles of a rotation (real) must be below pi; those of a unitary matrix lie in (-pi, pi].
///
/// Parameters
/// ----------
/// Q : array_like, shape (..., m, m)
///     Real and orthogonal with determinant +1, or complex and unitary: ``|Q^H Q - I| <= 1e-9``.
/// num_threads : int, optional
///     Number of threads for a batch; by default the size of the global pool.
///
/// Returns
/// -------
/// ndarray, shape (..., m, m)
///     ``L = -L^H`` with ``e^L = Q``; complex128 if ``Q`` is complex, else float64. The backward error is at most 1e-13
///     for ``m`` up to 50, even for repeated and clustered angles and for angles of ``pi - 1e-10``.
///
/// Raises
/// ------
/// InvalidInputError
///     Not square, not finite, or not orthogonal or unitary (with the measured defect).
/// OutsideDomainError
///     Only for real ``Q``: the determinant is -1, or an angle is pi to working precision, so that no real principal
///     logarithm exists; carries ``angle``. ``orthogonal_log(Q.astype(complex))`` returns the complex logarithm.
///
/// Notes
/// -----
/// Real: closed forms for ``m <= 3``; for larger ``m``, the skew Schur form of ``(Q - Q^T) / 2``, or the symmetric
/// eigenvalue problem of ``(Q + Q^T) / 2`` and the skew Schur form within each group of equal cosines, and one Newton
/// correction.
///
/// Complex: closed forms for ``m <= 2``; for larger ``m``, the eigenvalue problem of a Hermitian combination of ``Q``
/// and ``Q^H``, a second one within each group of equal eigenvalues, and one Newton correction. On the eigenspace of -1
/// the logarithm is ``i pi``. To working precision the angles pi and -pi are the same: angles closer to -pi than
/// ``4 m eps`` are returned as pi.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import orthogonal_log
/// >>> bool(np.allclose(orthogonal_log([[0, -1], [1, 0]]), [[0, -np.pi / 2], [np.pi / 2, 0]]))
/// True
/// >>> bool(np.allclose(orthogonal_log(np.diag([1j, -1])), np.diag([0.5j * np.pi, 1j * np.pi])))
/// True
#[pyfunction]
#[pyo3(signature = (Q, *, num_threads=None))]
pub fn orthogonal_log<'py>(Q: &Any<'py>, num_threads: Option<i64>) -> PyResult<Any<'py>> {
    map(&LOG, &UNITARY_LOG, Q, num_threads)
}
