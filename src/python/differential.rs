//! Derivatives of `skew_exp` and `orthogonal_log` for arrays, and their transposes.

use super::batch::map_batch;
use super::prelude::*;
use crate::linalg::{OrthogonalLogDifferential, SkewExpDifferential};

/// The work for a number of a matrix, beside that of the value.
const WORK: f64 = 8.0;

/// A derivative at a matrix of an argument named first, applied to a matrix of one named second.
fn apply<'py>(
    [(at, name), (direction, other)]: [(&Any<'py>, &'static str); 2],
    one: impl Fn(MatRef<'_, f64>, MatRef<'_, f64>) -> Result<Mat<f64>> + Shared,
) -> PyResult<Array> {
    let batches = matrix_batches([(at, name), (direction, other)])?;
    let (m, cols) = (batches[0].rows, batches[0].cols);
    let expected = format!("{name}: expected shape (..., m, m) with m >= 1");
    ensure!(m == cols && m > 0, "{expected}, found (..., {m}, {cols})");
    let call = Call::new(at.py(), None, WORK * batches[0].numbers())?;
    map_batch(
        &call,
        batches,
        &[m, m],
        move |[at, direction], i, out, _| {
            let value = one(at.get(i), direction.get(i))?;
            for (row, out) in out.chunks_exact_mut(m).enumerate() {
                for (column, out) in out.iter_mut().enumerate() {
                    *out = value[(row, column)];
                }
            }
            Ok(())
        },
    )
}

/// Derivative of the exponential of a skew-symmetric matrix in a direction.
///
/// Parameters
/// ----------
/// A : array_like, shape (..., m, m)
///     Skew-symmetric, as for :func:`skew_exp`.
/// dA : array_like, shape (..., m, m)
///     Direction, of which the skew part counts.
///
/// Returns
/// -------
/// ndarray, shape (..., m, m)
///     Derivative of ``skew_exp(A + h * dA)`` by ``h`` at 0, to about ``m * 1e-15``.
///
/// Raises
/// ------
/// InvalidInputError
///     As :func:`skew_exp`; shape.
#[pyfunction]
pub fn skew_exp_variation(A: &Any, dA: &Any) -> PyResult<Array> {
    apply(named![A, dA], |a, e| SkewExpDifferential::new(a)?.apply(e))
}

/// Gradient of ``sum(W * skew_exp(A))``: the transpose of :func:`skew_exp_variation`.
///
/// Parameters
/// ----------
/// A : array_like, shape (..., m, m)
///     Skew-symmetric, as for :func:`skew_exp`.
/// W : array_like, shape (..., m, m)
///     Derivatives of a function by the entries of the exponential.
///
/// Returns
/// -------
/// ndarray, shape (..., m, m)
///     The skew-symmetric ``G`` with ``sum(G * dA) == sum(W * skew_exp_variation(A, dA))``.
///
/// Raises
/// ------
/// InvalidInputError
///     As :func:`skew_exp`; shape.
#[pyfunction]
pub fn skew_exp_pullback(A: &Any, W: &Any) -> PyResult<Array> {
    apply(named![A, W], |a, w| {
        SkewExpDifferential::new(a)?.pull_back(w)
    })
}

/// Derivative of the principal logarithm of a rotation in a direction.
///
/// Parameters
/// ----------
/// Q : array_like, shape (..., m, m)
///     Real rotation, as for :func:`orthogonal_log`.
/// dQ : array_like, shape (..., m, m)
///     Direction, of which the part tangent at Q counts.
///
/// Returns
/// -------
/// ndarray, shape (..., m, m)
///     The derivative, skew-symmetric.
///
/// Raises
/// ------
/// InvalidInputError, OutsideDomainError
///     As :func:`orthogonal_log`; shape.
#[pyfunction]
pub fn orthogonal_log_variation(Q: &Any, dQ: &Any) -> PyResult<Array> {
    apply(named![Q, dQ], |q, f| {
        OrthogonalLogDifferential::new(q)?.apply(f)
    })
}

/// Gradient of ``sum(W * orthogonal_log(Q))``: the transpose of :func:`orthogonal_log_variation`.
///
/// Parameters
/// ----------
/// Q : array_like, shape (..., m, m)
///     Real rotation, as for :func:`orthogonal_log`.
/// W : array_like, shape (..., m, m)
///     Derivatives of a function by the entries of the logarithm.
///
/// Returns
/// -------
/// ndarray, shape (..., m, m)
///     The ``G`` tangent at Q with ``sum(G * dQ) == sum(W * orthogonal_log_variation(Q, dQ))`` for ``dQ`` tangent at Q.
///
/// Raises
/// ------
/// InvalidInputError, OutsideDomainError
///     As :func:`orthogonal_log`; shape.
#[pyfunction]
pub fn orthogonal_log_pullback(Q: &Any, W: &Any) -> PyResult<Array> {
    apply(named![Q, W], |q, w| {
        OrthogonalLogDifferential::new(q)?.pull_back(w)
    })
}
