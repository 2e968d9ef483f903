//! `skew_exp` and `orthogonal_log` for arrays.

use numpy::PyArrayDyn;
use pyo3::prelude::*;

use super::call::Call;
use super::convert::{Batch, map_batch, matrices, to_array, write};
use super::error::invalid_input;
use crate::error::Result;
use faer::{Mat, MatRef};

fn square_map<'py>(
    py: Python<'py>,
    object: &Bound<'py, PyAny>,
    name: &'static str,
    num_threads: Option<i64>,
    function: impl Fn(MatRef<'_, f64>) -> Result<Mat<f64>> + Sync + Send + 'static,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let [batch] = matrices([(object, name)])?;
    let (rows, cols) = (batch.rows, batch.cols);
    let call = Call::new(
        py,
        num_threads,
        batch.len() as f64 * (300.0 + 30.0 * (rows * rows * rows) as f64),
    )?;
    let shape: Vec<usize> = batch.shape.iter().chain(&[rows, cols]).copied().collect();
    // Also where the batch is empty.
    if rows != cols || rows == 0 {
        let expected = "(..., m, m) with m >= 1";
        let message = format!("{name}: expected shape {expected}, found (..., {rows}, {cols})");
        return Err(invalid_input(py, message));
    }
    let one = move |[batch]: [&Batch; 1], i: usize, out: &mut [f64], _: crate::Interrupt<'_>| {
        write(function(batch.get(i))?.as_ref(), out);
        Ok(())
    };
    to_array(py, map_batch(py, &call, [batch], rows * cols, one)?, &shape)
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
/// Closed forms for ``m <= 3``; even and odd Taylor parts in ``A^2`` with squaring for moderate norms, the real
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
#[allow(non_snake_case)]
pub fn skew_exp<'py>(
    py: Python<'py>,
    A: &Bound<'py, PyAny>,
    num_threads: Option<i64>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    square_map(py, A, "A", num_threads, crate::linalg::skew_exp)
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
/// Closed forms for ``m <= 3``; above, the symmetric eigenproblem of ``(Q + Q^T) / 2``, the skew Schur form inside of
/// each group of equal cosines, and one Newton correction.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from stiefel_rs import orthogonal_log
/// >>> bool(np.allclose(orthogonal_log([[0, -1], [1, 0]]), [[0, -np.pi / 2], [np.pi / 2, 0]]))
/// True
#[pyfunction]
#[pyo3(signature = (Q, *, num_threads=None))]
#[allow(non_snake_case)]
pub fn orthogonal_log<'py>(
    py: Python<'py>,
    Q: &Bound<'py, PyAny>,
    num_threads: Option<i64>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    square_map(py, Q, "Q", num_threads, crate::linalg::orthogonal_log)
}
