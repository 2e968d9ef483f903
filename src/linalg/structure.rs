//! Norms, defects and the checks of input that every public entry makes once.

use faer::{Mat, MatRef};

use crate::error::{Error, Result};

/// Frobenius norm, scaled so that it neither overflows nor loses denormals.
pub fn norm(a: MatRef<'_, f64>) -> f64 {
    let mut largest = 0.0_f64;
    for j in 0..a.ncols() {
        for i in 0..a.nrows() {
            largest = largest.max(a[(i, j)].abs());
        }
    }
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    let mut sum = 0.0;
    for j in 0..a.ncols() {
        for i in 0..a.nrows() {
            let x = a[(i, j)] / largest;
            sum += x * x;
        }
    }
    largest * sum.sqrt()
}

/// Frobenius norm of the difference of two matrices of one shape.
pub fn distance(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> f64 {
    debug_assert_eq!(a.shape(), b.shape());
    let mut sum = 0.0_f64;
    for j in 0..a.ncols() {
        for i in 0..a.nrows() {
            let d = a[(i, j)] - b[(i, j)];
            sum += d * d;
        }
    }
    sum.sqrt()
}

/// `|Y^T Y - I|_F`: how far the columns of `y` are from orthonormal.
pub fn orthonormality_defect(y: MatRef<'_, f64>) -> f64 {
    let gram = y.transpose() * y;
    distance(gram.as_ref(), Mat::identity(y.ncols(), y.ncols()).as_ref())
}

/// `|A + A^T|_F / 2`: how far a square matrix is from skew-symmetric.
pub fn skew_defect(a: MatRef<'_, f64>) -> f64 {
    0.5 * norm((a + a.transpose()).as_ref())
}

/// `(A + A^T) / 2`.
pub fn symmetric_part(a: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| 0.5 * (a[(i, j)] + a[(j, i)]))
}

/// `(A - A^T) / 2`.
pub fn skew_part(a: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| 0.5 * (a[(i, j)] - a[(j, i)]))
}

/// `tr(A^T B)`.
pub fn frobenius_inner(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> f64 {
    let mut sum = 0.0;
    for j in 0..a.ncols() {
        for i in 0..a.nrows() {
            sum += a[(i, j)] * b[(i, j)];
        }
    }
    sum
}

/// Error `NonFinite` at the first entry, column by column, that is NaN or infinite.
pub fn check_finite(name: &'static str, a: MatRef<'_, f64>) -> Result<()> {
    for j in 0..a.ncols() {
        for i in 0..a.nrows() {
            if !a[(i, j)].is_finite() {
                return Err(Error::NonFinite {
                    name,
                    index: j * a.nrows() + i,
                });
            }
        }
    }
    Ok(())
}

/// Error `Overflow` where a result of finite input is NaN or infinite.
pub fn check_range(quantity: &'static str, a: MatRef<'_, f64>) -> Result<()> {
    if check_finite(quantity, a).is_ok() {
        Ok(())
    } else {
        Err(Error::Overflow { quantity })
    }
}

/// Error `NonFinite` where a scalar is NaN or infinite.
pub fn check_finite_scalar(name: &'static str, t: f64) -> Result<()> {
    if t.is_finite() {
        Ok(())
    } else {
        Err(Error::NonFinite { name, index: 0 })
    }
}

/// Error `Shape` unless `a` has the given shape.
pub fn check_shape(
    name: &'static str,
    a: MatRef<'_, f64>,
    nrows: usize,
    ncols: usize,
) -> Result<()> {
    if a.nrows() == nrows && a.ncols() == ncols {
        return Ok(());
    }
    Err(Error::Shape {
        name,
        expected: format!("({nrows}, {ncols})"),
        found: format!("({}, {})", a.nrows(), a.ncols()),
    })
}

/// Error `Shape` unless `a` is square and not empty; its size otherwise.
pub fn check_square(name: &'static str, a: MatRef<'_, f64>) -> Result<usize> {
    if a.nrows() == a.ncols() && a.nrows() > 0 {
        return Ok(a.nrows());
    }
    Err(Error::Shape {
        name,
        expected: "(m, m) with m >= 1".to_owned(),
        found: format!("({}, {})", a.nrows(), a.ncols()),
    })
}
