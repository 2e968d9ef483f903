//! `skew_exp` and `orthogonal_log` for arrays.

use std::cell::Cell;
use std::thread::LocalKey;

use super::batch::map_batch;
use super::prelude::*;
use crate::linalg::{OrthogonalLog, SkewExp};

/// Up to this size a thread keeps its buffers, and one matrix is computed where it stands.
const SMALL: usize = 128;

/// Up to this size it takes less than some ten microseconds, and the interpreter is not left for it.
const TINY: usize = 24;

/// A function of a square matrix, `K` its buffers.
struct Kernel<K: 'static> {
    /// Of the argument.
    name: &'static str,
    /// The buffers of the last size.
    kept: &'static LocalKey<Cell<Option<(usize, K)>>>,
    make: fn(usize) -> K,
    into: fn(&mut K, MatMut<'_, f64>, MatRef<'_, f64>) -> Result<()>,
}

thread_local! {
    static KEPT_EXP: Cell<Option<(usize, SkewExp)>> = const { Cell::new(None) };
    static KEPT_LOG: Cell<Option<(usize, OrthogonalLog)>> = const { Cell::new(None) };
}

static EXP: Kernel<SkewExp> = Kernel {
    name: "A",
    kept: &KEPT_EXP,
    make: SkewExp::new,
    into: SkewExp::checked_into,
};

static LOG: Kernel<OrthogonalLog> = Kernel {
    name: "Q",
    kept: &KEPT_LOG,
    make: OrthogonalLog::new,
    into: OrthogonalLog::checked_into,
};

impl<K> Kernel<K> {
    /// The value for one matrix, row by row.
    fn apply(&self, a: MatRef<'_, f64>, out: &mut [f64]) -> Result<()> {
        let m = a.nrows();
        let kept = self.kept.take().filter(|(size, _)| *size == m);
        let (_, mut buffers) = kept.unwrap_or_else(|| (m, (self.make)(m)));
        let result = (self.into)(&mut buffers, MatMut::from_row_major_slice_mut(out, m, m), a);
        if m <= SMALL {
            self.kept.set(Some((m, buffers)));
        }
        result
    }

    fn map<'py>(&'static self, object: &Any<'py>, threads: Option<i64>) -> PyResult<Any<'py>> {
        // Not of a subclass, which may mean something else by its numbers.
        if let Ok(array) = object.cast_exact::<PyArray2<f64>>()
            && let &[m, cols] = array.shape()
            && m == cols
            && (1..=SMALL).contains(&m)
            && array.data().is_aligned()
            && array.is_c_contiguous()
            && let Ok(entries) = array.to_vec()
        {
            Call::new(object.py(), threads, 0.0)?;
            return self.small(object.py(), &entries, m);
        }
        self.batch(object, threads)
    }

    /// One small matrix.
    fn small<'py>(&self, py: Python<'py>, entries: &[f64], m: usize) -> PyResult<Any<'py>> {
        let mut out = vec![0.0; m * m];
        let mut work = || self.apply(MatRef::from_row_major_slice(entries, m, m), &mut out);
        if m <= TINY { work() } else { py.detach(work) }?;
        if !out.iter().all(|x| x.is_finite()) {
            return Err(Error::Overflow { quantity: "result" }.into());
        }
        Ok(to_array(py, out, &[m, m])?.into_any())
    }

    fn batch<'py>(&'static self, object: &Any<'py>, threads: Option<i64>) -> PyResult<Any<'py>> {
        let (py, name) = (object.py(), self.name);
        let [batch] = matrix_batches([(object, name)])?;
        let (m, cols) = (batch.rows, batch.cols);
        let call = Call::new(py, threads, batch.numbers())?;
        // Also where the batch is empty.
        let expected = format!("{name}: expected shape (..., m, m) with m >= 1");
        ensure!(m == cols && m > 0, "{expected}, found (..., {m}, {cols})");
        let found = map_batch(&call, [batch], &[m, m], |[batch], i, out, _| {
            self.apply(batch.get(i), out)
        });
        found?.into_bound_py_any(py)
    }
}

/// Exponential of a skew-symmetric matrix: a rotation, orthogonal to round-off.
///
/// Parameters
/// ----------
/// A : array_like, shape (..., m, m)
///     Skew-symmetric, ``|A + A^T| / 2 <= 1e-12 |A|``.
/// num_threads : int, optional
///     Threads for a batch; by default those of the global pool.
///
/// Returns
/// -------
/// ndarray, shape (..., m, m)
///     ``e^A``, with orthogonality defect at most ``m * 1e-15``.
///
/// Raises
/// ------
/// InvalidInputError
///     Not square, not finite, not skew-symmetric (with the measured defect).
///
/// Notes
/// -----
/// Closed forms for ``m <= 3``; even and odd polynomials in ``A^2`` with squaring for moderate norms, the real
/// Schur form of Ward and Gray (1978) for large ones.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import skew_exp
/// >>> bool(np.allclose(skew_exp([[0.0, -np.pi / 2], [np.pi / 2, 0.0]]), [[0, -1], [1, 0]]))
/// True
#[pyfunction]
#[pyo3(signature = (A, *, num_threads=None))]
pub fn skew_exp<'py>(A: &Any<'py>, num_threads: Option<i64>) -> PyResult<Any<'py>> {
    EXP.map(A, num_threads)
}

/// Principal skew logarithm of a rotation: real, skew, all angles below pi.
///
/// Parameters
/// ----------
/// Q : array_like, shape (..., m, m)
///     Orthogonal of determinant +1, ``|Q^T Q - I| <= 1e-9``.
/// num_threads : int, optional
///     Threads for a batch; by default those of the global pool.
///
/// Returns
/// -------
/// ndarray, shape (..., m, m)
///     ``L = -L^T`` with ``e^L = Q``; backward error at most 1e-13 for ``m`` up to 50, repeated and clustered angles
///     and angles of ``pi - 1e-10`` included.
///
/// Raises
/// ------
/// InvalidInputError
///     Not square, not finite, not orthogonal (with the measured defect).
/// OutsideDomainError
///     Determinant -1, or an angle that is pi to working precision; carries ``angle``.
///
/// Notes
/// -----
/// Closed forms for ``m <= 3``; above, the skew Schur form of ``(Q - Q^T) / 2``, or the symmetric eigenproblem of
/// ``(Q + Q^T) / 2`` and the skew Schur form inside of each group of equal cosines, and one Newton correction.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import orthogonal_log
/// >>> bool(np.allclose(orthogonal_log([[0, -1], [1, 0]]), [[0, -np.pi / 2], [np.pi / 2, 0]]))
/// True
#[pyfunction]
#[pyo3(signature = (Q, *, num_threads=None))]
pub fn orthogonal_log<'py>(Q: &Any<'py>, num_threads: Option<i64>) -> PyResult<Any<'py>> {
    LOG.map(Q, num_threads)
}
