//! `skew_exp` and `orthogonal_log` for arrays.

use std::cell::RefCell;
use std::thread::LocalKey;

use faer::MatMut;
use numpy::ndarray::ArrayView2;
use numpy::{PyArray2, PyArrayMethods, PyUntypedArrayMethods, ToPyArray};

use super::batch::map_batch;
use super::prelude::*;
use crate::linalg::{OrthogonalLog, SkewExp};

/// Up to this size one matrix is computed where it stands, in buffers that the thread keeps.
const SMALL: usize = 128;

/// Up to this size it takes less than some ten microseconds, and the interpreter is not left for it.
const TINY: usize = 24;

/// A function of a square matrix with its buffers.
trait Kernel: Sized + Send + 'static {
    const NAME: &'static str;
    fn kept() -> &'static LocalKey<RefCell<Option<Kept<Self>>>>;
    fn make(m: usize) -> Self;
    fn apply(&mut self, out: MatMut<'_, f64>, a: MatRef<'_, f64>) -> Result<()>;
}

/// The buffers of the last size.
struct Kept<K> {
    m: usize,
    kernel: K,
    out: Vec<f64>,
}

thread_local! {
    static EXP: RefCell<Option<Kept<SkewExp>>> = const { RefCell::new(None) };
    static LOG: RefCell<Option<Kept<OrthogonalLog>>> = const { RefCell::new(None) };
}

impl Kernel for SkewExp {
    const NAME: &'static str = "A";
    fn kept() -> &'static LocalKey<RefCell<Option<Kept<Self>>>> {
        &EXP
    }
    fn make(m: usize) -> Self {
        SkewExp::new(m)
    }
    fn apply(&mut self, out: MatMut<'_, f64>, a: MatRef<'_, f64>) -> Result<()> {
        self.checked_into(out, a)
    }
}

impl Kernel for OrthogonalLog {
    const NAME: &'static str = "Q";
    fn kept() -> &'static LocalKey<RefCell<Option<Kept<Self>>>> {
        &LOG
    }
    fn make(m: usize) -> Self {
        OrthogonalLog::new(m)
    }
    fn apply(&mut self, out: MatMut<'_, f64>, a: MatRef<'_, f64>) -> Result<()> {
        self.checked_into(out, a)
    }
}

fn square_map<'py, K: Kernel>(object: &Any<'py>, num_threads: Option<i64>) -> PyResult<Any<'py>> {
    let py = object.py();
    // Not of a subclass, which may mean something else by its numbers.
    if let Ok(array) = object.cast_exact::<PyArray2<f64>>()
        && let &[m, cols] = array.shape()
        && m == cols
        && (1..=SMALL).contains(&m)
        && array.data().is_aligned()
        && array.is_c_contiguous()
        && let Ok(entries) = array.to_vec()
    {
        Call::new(py, num_threads, 0.0)?;
        return small::<K>(py, &entries, m);
    }
    batch::<K>(py, object, num_threads)
}

/// One small matrix.
fn small<'py, K: Kernel>(py: Python<'py>, entries: &[f64], m: usize) -> PyResult<Any<'py>> {
    // Taken out while in use: making the result may run any Python code, this function included.
    let kept = K::kept().take().filter(|kept| kept.m == m);
    let mut kept = kept.unwrap_or_else(|| Kept {
        m,
        kernel: K::make(m),
        out: vec![0.0; m * m],
    });
    let Kept { kernel, out, .. } = &mut kept;
    let mut work = || {
        kernel.apply(
            MatMut::from_row_major_slice_mut(out, m, m),
            MatRef::from_row_major_slice(entries, m, m),
        )
    };
    let mut result = if m <= TINY { work() } else { py.detach(work) };
    if result.is_ok() && !out.iter().all(|x| x.is_finite()) {
        result = Err(Error::Overflow { quantity: "result" });
    }
    result?;
    let view = ArrayView2::from_shape((m, m), out.as_slice());
    let view = view.map_err(|error| invalid!("{error}"))?;
    let array = view.to_pyarray(py).into_any();
    K::kept().set(Some(kept));
    Ok(array)
}

fn batch<'py, K: Kernel>(
    py: Python<'py>,
    object: &Any<'py>,
    num_threads: Option<i64>,
) -> PyResult<Any<'py>> {
    let name = K::NAME;
    let [batch] = matrix_batches([(object, name)])?;
    let (m, cols) = (batch.rows, batch.cols);
    let call = Call::new(py, num_threads, batch.numbers())?;
    // Also where the batch is empty.
    if m != cols || m == 0 {
        let expected = "(..., m, m) with m >= 1";
        return Err(invalid!(
            "{name}: expected shape {expected}, found (..., {m}, {cols})"
        ));
    }
    let one = move |kernel: &mut K,
                    [batch]: [&Batch; 1],
                    i: usize,
                    out: &mut [f64],
                    _: crate::Interrupt<'_>| {
        kernel.apply(MatMut::from_row_major_slice_mut(out, m, m), batch.get(i))
    };
    let make = move || K::make(m);
    map_batch(&call, [batch], &[m, m], make, one)?.into_bound_py_any(py)
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
    square_map::<SkewExp>(A, num_threads)
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
    square_map::<OrthogonalLog>(Q, num_threads)
}
