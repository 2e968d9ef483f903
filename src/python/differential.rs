//! Derivatives of `skew_exp` and `orthogonal_log`, and of the exponential and logarithm of frames, for arrays, and their
//! transposes. Derivatives of complex functions are computed in the embedding, which commutes with differentiation, but for
//! the logarithm of unitary matrices.

use super::batch::map_batch;
use super::convert::write;
use super::linalg::check_square;
use super::prelude::*;
use crate::linalg::complex_embedding::{embed, nearest};
use crate::linalg::{OrthogonalLogDifferential, SkewExpDifferential, UnitaryLogDifferential};
use crate::manifold::{ExponentialDifferential, LogarithmDifferential};

/// Work per number of a matrix, relative to the value.
const WORK: f64 = 8.0;

/// A derivative at a matrix (first name), applied to a matrix (second name).
fn apply<'py>(
    [(at, name), (direction, other)]: [(&Any<'py>, &'static str); 2],
    one: impl Fn(Field, MatRef<'_, f64>, MatRef<'_, f64>) -> Result<Mat<f64>> + Shared,
) -> PyResult<Numbers> {
    let arguments = [(at, name), (direction, other)];
    let field = Field::of_named(&arguments)?;
    let batches = field.batches(arguments)?;
    let (rows, cols) = batches[0].own_shape();
    check_square(name, rows, cols)?;
    let m = batches[0].rows;
    let call = Call::new(at.py(), None, WORK * batches[0].numbers())?.over(field);
    let found = map_batch(
        &call,
        batches,
        &[m, m],
        move |[at, direction], i, out, _| {
            write(one(field, at.get(i), direction.get(i))?.as_ref(), out);
            Ok(())
        },
    )?;
    field.numbers(found)?.like(arguments)
}

/// Return the derivative of :func:`skew_exp` in a direction.
///
/// Parameters
/// ----------
/// A : array_like, shape (..., m, m)
///     Skew-symmetric or skew-Hermitian, as for :func:`skew_exp`.
/// dA : array_like, shape (..., m, m)
///     Direction, of which only the skew-symmetric or skew-Hermitian part is used.
///
/// Returns
/// -------
/// ndarray, shape (..., m, m)
///     Derivative of ``skew_exp(A + h * dA)`` with respect to ``h`` at 0, to about ``m * 1e-15``.
///
/// Raises
/// ------
/// InvalidInputError
///     As for :func:`skew_exp`, or mismatched shapes.
#[pyfunction]
pub fn skew_exp_variation(A: &Any, dA: &Any) -> PyResult<Numbers> {
    apply(named![A, dA], |_, a, e| {
        SkewExpDifferential::new(a)?.apply(e)
    })
}

/// Return the gradient of ``sum(W * skew_exp(A))``: the transpose of :func:`skew_exp_variation`.
///
/// Parameters
/// ----------
/// A : array_like, shape (..., m, m)
///     Skew-symmetric or skew-Hermitian, as for :func:`skew_exp`.
/// W : array_like, shape (..., m, m)
///     Derivatives of a function with respect to the entries of the exponential.
///
/// Returns
/// -------
/// ndarray, shape (..., m, m)
///     The skew-symmetric ``G`` with ``sum(G * dA) == sum(W * skew_exp_variation(A, dA))``; for complex matrices the
///     equation holds for the real parts with conjugate ``G`` and ``W``.
///
/// Raises
/// ------
/// InvalidInputError
///     As for :func:`skew_exp`, or mismatched shapes.
#[pyfunction]
pub fn skew_exp_pullback(A: &Any, W: &Any) -> PyResult<Numbers> {
    apply(named![A, W], |_, a, w| {
        SkewExpDifferential::new(a)?.pull_back(w)
    })
}

/// Return the derivative of :func:`orthogonal_log` in a direction.
///
/// Parameters
/// ----------
/// Q : array_like, shape (..., m, m)
///     Rotation or unitary matrix, as for :func:`orthogonal_log`; a unitary matrix must not have an angle of pi.
/// dQ : array_like, shape (..., m, m)
///     Direction, of which only the part tangent at ``Q`` is used.
///
/// Returns
/// -------
/// ndarray, shape (..., m, m)
///     The derivative, skew-symmetric or skew-Hermitian.
///
/// Raises
/// ------
/// InvalidInputError, OutsideDomainError
///     As for :func:`orthogonal_log`, or mismatched shapes; two angles next to pi, or next to pi and -pi, where the
///     logarithm is not differentiable.
#[pyfunction]
pub fn orthogonal_log_variation(Q: &Any, dQ: &Any) -> PyResult<Numbers> {
    apply(named![Q, dQ], |field, q, f| match field {
        Field::Real => OrthogonalLogDifferential::new(q)?.apply(f),
        Field::Complex => {
            let found = UnitaryLogDifferential::new(nearest(q).as_ref())?;
            Ok(embed(found.apply(nearest(f).as_ref())?.as_ref()))
        }
    })
}

/// Return the gradient of ``sum(W * orthogonal_log(Q))``: the transpose of :func:`orthogonal_log_variation`.
///
/// Parameters
/// ----------
/// Q : array_like, shape (..., m, m)
///     Rotation or unitary matrix, as for :func:`orthogonal_log`; a unitary matrix must not have an angle of pi.
/// W : array_like, shape (..., m, m)
///     Derivatives of a function with respect to the entries of the logarithm.
///
/// Returns
/// -------
/// ndarray, shape (..., m, m)
///     The ``G`` tangent at ``Q`` with ``sum(G * dQ) == sum(W * orthogonal_log_variation(Q, dQ))`` for ``dQ`` tangent
///     at ``Q``.
///
/// Raises
/// ------
/// InvalidInputError, OutsideDomainError
///     As for :func:`orthogonal_log`, or mismatched shapes; two angles next to pi, or next to pi and -pi, where the
///     logarithm is not differentiable.
#[pyfunction]
pub fn orthogonal_log_pullback(Q: &Any, W: &Any) -> PyResult<Numbers> {
    apply(named![Q, W], |field, q, w| match field {
        Field::Real => OrthogonalLogDifferential::new(q)?.pull_back(w),
        Field::Complex => {
            let found = UnitaryLogDifferential::new(nearest(q).as_ref())?;
            Ok(embed(found.pull_back(nearest(w).as_ref())?.as_ref()))
        }
    })
}

/// Work per number of a point: a matrix function of `n x n` matrices, for the logarithm one per dimension.
const WORK_OF_FRAMES: [f64; 2] = [30.0, 1000.0];

/// Return the derivative of ``Stiefel.exp`` (canonical metric) at ``(S, V)``.
///
/// Parameters
/// ----------
/// S, V, dS, dV : array_like, shape (n, k)
///     Point, tangent vector and their variations along a family of points and tangent vectors; real or complex.
///
/// Returns
/// -------
/// ndarray, shape (n, k)
///
/// Raises
/// ------
/// InvalidInputError
///     Wrong shape, non-finite entries, point not orthonormal, vector not tangent.
#[pyfunction]
pub fn exp_variation(S: &Any, V: &Any, dS: &Any, dV: &Any) -> PyResult<Numbers> {
    let arguments = named![S, V, dS, dV];
    let field = Field::of_named(&arguments)?;
    let data = field.matrices(arguments)?;
    let found = run_on(
        S.py(),
        field,
        data,
        WORK_OF_FRAMES[0],
        |[s, v, ds, dv], _| ExponentialDifferential::new(s, v)?.apply(ds, dv),
    )?;
    field.number_matrix(found)?.like(arguments)
}

/// Return the gradients of ``sum(W * exp(S, V))`` with respect to ``S`` and ``V``.
///
/// The transpose of :func:`exp_variation`.
///
/// Parameters
/// ----------
/// S, V, W : array_like, shape (n, k)
///     Real or complex; for complex matrices, the gradients of ``Re sum(conj(W) * exp(S, V))``.
///
/// Returns
/// -------
/// tuple of ndarray, each of shape (n, k)
///
/// Raises
/// ------
/// InvalidInputError
///     Wrong shape, non-finite entries, point not orthonormal, vector not tangent.
#[pyfunction]
pub fn exp_pullback(S: &Any, V: &Any, W: &Any) -> PyResult<(Numbers, Numbers)> {
    let arguments = named![S, V, W];
    let field = Field::of_named(&arguments)?;
    let data = field.matrices(arguments)?;
    let found = run_on(S.py(), field, data, WORK_OF_FRAMES[0], |[s, v, w], _| {
        ExponentialDifferential::new(s, v)?.pull_back(w)
    })?;
    pair(field, found, arguments)
}

/// Return the derivative of ``Stiefel.log`` (canonical metric) at ``(S0, S1)``.
///
/// Parameters
/// ----------
/// S0, S1, dS0, dS1 : array_like, shape (n, k)
///     Points and their variations along a family of points; real or complex.
///
/// Returns
/// -------
/// ndarray, shape (n, k)
///
/// Raises
/// ------
/// InvalidInputError
///     Wrong shape, non-finite entries, points not orthonormal.
/// OutsideDomainError, ConvergenceError
///     As for :meth:`Stiefel.log`, or the points are conjugate along the geodesic.
#[pyfunction]
pub fn log_variation(S0: &Any, S1: &Any, dS0: &Any, dS1: &Any) -> PyResult<Numbers> {
    let arguments = named![S0, S1, dS0, dS1];
    let field = Field::of_named(&arguments)?;
    let data = field.matrices(arguments)?;
    let work = WORK_OF_FRAMES[1];
    let found = run_on(
        S0.py(),
        field,
        data,
        work,
        move |[s0, s1, ds0, ds1], interrupt| {
            LogarithmDifferential::over(field, s0, s1, interrupt)?.apply(ds0, ds1)
        },
    )?;
    field.number_matrix(found)?.like(arguments)
}

/// Return the gradients of ``sum(W * log(S0, S1))`` with respect to ``S0`` and ``S1``.
///
/// The transpose of :func:`log_variation`.
///
/// Parameters
/// ----------
/// S0, S1, W : array_like, shape (n, k)
///     Real or complex; for complex matrices, the gradients of ``Re sum(conj(W) * log(S0, S1))``.
///
/// Returns
/// -------
/// tuple of ndarray, each of shape (n, k)
///
/// Raises
/// ------
/// InvalidInputError
///     Wrong shape, non-finite entries, points not orthonormal.
/// OutsideDomainError, ConvergenceError
///     As for :func:`log_variation`.
#[pyfunction]
pub fn log_pullback(S0: &Any, S1: &Any, W: &Any) -> PyResult<(Numbers, Numbers)> {
    let arguments = named![S0, S1, W];
    let field = Field::of_named(&arguments)?;
    let data = field.matrices(arguments)?;
    let work = WORK_OF_FRAMES[1];
    let found = run_on(S0.py(), field, data, work, move |[s0, s1, w], interrupt| {
        LogarithmDifferential::over(field, s0, s1, interrupt)?.pull_back(w)
    })?;
    pair(field, found, arguments)
}

fn pair<const N: usize>(
    field: Field,
    (first, second): (Mat<f64>, Mat<f64>),
    arguments: [Named<'_, '_>; N],
) -> PyResult<(Numbers, Numbers)> {
    let [first, second] =
        [first, second].map(|matrix| field.number_matrix(matrix)?.like(arguments));
    Ok((first?, second?))
}
