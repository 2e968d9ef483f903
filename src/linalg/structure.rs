//! Norms, defects, and the input checks of public entries.

use faer::linalg::matmul::triangular;
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::traits::ComplexField;
use faer::traits::math_utils::is_finite;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use triangular::BlockStructure::{Rectangular, TriangularLower};

use crate::error::{Error, Result};
use crate::linalg::product::{mul_into, product};

/// Range of sums of squares that lose no accuracy to overflow or subnormal numbers.
pub(crate) const SAFE_SQUARES: std::ops::Range<f64> = 1e-280..1e280;

/// The columns or the rows, whichever are contiguous; `None` for other strides.
fn lines<'a>(a: MatRef<'a, f64>) -> Option<impl Iterator<Item = &'a [f64]>> {
    let a = if a.row_stride() == 1 {
        a
    } else {
        a.transpose()
    };
    (a.row_stride() == 1).then(|| {
        (0..a.ncols()).filter_map(move |j| a.col(j).try_as_col_major().map(|c| c.as_slice()))
    })
}

/// Sum of squares in eight partial sums.
fn sum_of_squares(line: &[f64]) -> f64 {
    let (groups, rest) = line.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for group in groups {
        for (sum, x) in sums.iter_mut().zip(group) {
            *sum += x * x;
        }
    }
    sums.iter().sum::<f64>() + rest.iter().map(|x| x * x).sum::<f64>()
}

/// Frobenius norm, scaled if it would otherwise overflow or lose accuracy to subnormal numbers.
pub fn norm(a: MatRef<'_, f64>) -> f64 {
    if let Some(lines) = lines(a) {
        let sum: f64 = lines.map(sum_of_squares).sum();
        if SAFE_SQUARES.contains(&sum) {
            return sum.sqrt();
        }
    }
    scaled_norm(a)
}

fn scaled_norm(a: MatRef<'_, f64>) -> f64 {
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

/// Number of columns up to which the whole product costs less than half of it: 0.14 us instead of 0.29 us at (50, 5),
/// equal at (50, 9).
const WHOLE: usize = 8;

/// `Y^T Y`; only the lower triangle is set.
pub(crate) fn gram(y: MatRef<'_, f64>) -> Mat<f64> {
    let k = y.ncols();
    let mut out = Mat::zeros(k, k);
    if k <= WHOLE {
        mul_into(&mut out, 1.0, y.transpose(), y);
        return out;
    }
    triangular::matmul(
        out.as_mut(),
        TriangularLower,
        Accum::Replace,
        y.transpose(),
        Rectangular,
        y,
        Rectangular,
        1.0,
        Par::Seq,
    );
    out
}

/// `|Y^T Y - I|_F`, the distance of the columns of `y` from orthonormality; infinite on overflow.
pub fn orthonormality_defect(y: MatRef<'_, f64>) -> f64 {
    match y.ncols() <= WHOLE {
        true => with_inner_products(y, y, gram_defect),
        false => gram_defect(gram(y).as_ref()),
    }
}

/// A function of `A^T B`, without allocation for few columns.
pub(crate) fn with_inner_products(
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    function: impl FnOnce(MatRef<'_, f64>) -> f64,
) -> f64 {
    let (k, l) = (a.ncols(), b.ncols());
    if k.max(l) > WHOLE {
        return function(product(a.transpose(), b).as_ref());
    }
    let mut entries = [0.0; WHOLE * WHOLE];
    let mut inner = MatMut::from_column_major_slice_mut(&mut entries[..k * l], k, l);
    mul_into(inner.rb_mut(), 1.0, a.transpose(), b);
    function(inner.rb())
}

/// `|G - I|_F` for a symmetric matrix given by its lower triangle; infinite on overflow.
pub(crate) fn gram_defect(gram: MatRef<'_, f64>) -> f64 {
    let k = gram.ncols();
    let (mut diagonal, mut below) = (0.0, 0.0);
    for j in 0..k {
        let d: f64 = gram[(j, j)] - 1.0;
        diagonal += d * d;
        for i in j + 1..k {
            below += gram[(i, j)] * gram[(i, j)];
        }
    }
    let defect = (diagonal + 2.0 * below).sqrt();
    // Overflowing products of both signs sum to NaN.
    if defect.is_nan() {
        f64::INFINITY
    } else {
        defect
    }
}

/// `|A + A^T|_F / 2`, the distance of a square matrix from skew-symmetry.
pub fn skew_defect(a: MatRef<'_, f64>) -> f64 {
    const TILE: usize = 16;
    let m = a.nrows();
    let (mut sum, mut largest) = (0.0_f64, 0.0_f64);
    for first in (0..m).step_by(TILE) {
        for start in (first..m).step_by(TILE) {
            for j in first..(first + TILE).min(m) {
                for i in start.max(j)..(start + TILE).min(m) {
                    let x = a[(i, j)] + a[(j, i)];
                    let weight = if i == j { 1.0 } else { 2.0 };
                    largest = largest.max(x.abs());
                    sum += weight * (x * x);
                }
            }
        }
    }
    if largest == 0.0 || SAFE_SQUARES.contains(&sum) {
        return 0.5 * sum.sqrt();
    }
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

/// Return `NonFinite` at the first entry, in column-major order, that is NaN or infinite.
pub fn check_finite(name: &'static str, a: MatRef<'_, f64>) -> Result<()> {
    // First without a branch per entry.
    if let Some(mut lines) = lines(a)
        && lines.all(|line| line.iter().fold(true, |all, x| all & x.is_finite()))
    {
        return Ok(());
    }
    check_finite_entries(name, a)
}

/// As [`check_finite`], for real or complex entries.
pub(crate) fn check_finite_entries<T: ComplexField>(
    name: &'static str,
    a: MatRef<'_, T>,
) -> Result<()> {
    for j in 0..a.ncols() {
        for i in 0..a.nrows() {
            if !is_finite(&a[(i, j)]) {
                return Err(Error::NonFinite {
                    name,
                    index: j * a.nrows() + i,
                });
            }
        }
    }
    Ok(())
}

/// Entries in row-major order.
pub(crate) fn row_by_row(a: MatRef<'_, f64>) -> impl Iterator<Item = f64> {
    let columns = a.ncols();
    (0..a.nrows() * columns).map(move |at| a[(at / columns, at % columns)])
}

/// The sum of products of entries.
pub(crate) fn dot(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> f64 {
    let columns = a.col_iter().zip(b.col_iter());
    columns.map(|(a, b)| a.transpose() * b).sum()
}

/// Return `Overflow` if a result of finite input is NaN or infinite.
pub fn check_range(quantity: &'static str, a: MatRef<'_, f64>) -> Result<()> {
    if check_finite(quantity, a).is_ok() {
        Ok(())
    } else {
        Err(Error::Overflow { quantity })
    }
}

/// Return `NonFinite` if a scalar is NaN or infinite.
pub fn check_finite_scalar(name: &'static str, t: f64) -> Result<()> {
    if t.is_finite() {
        Ok(())
    } else {
        Err(Error::NonFinite { name, index: 0 })
    }
}

/// Return `Shape` unless `a` has the given shape.
pub fn check_shape<T>(
    name: &'static str,
    a: MatRef<'_, T>,
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

/// Return `Shape` unless `a` is square and not empty; otherwise its size.
pub fn check_square<T>(name: &'static str, a: MatRef<'_, T>) -> Result<usize> {
    if a.nrows() == a.ncols() && a.nrows() > 0 {
        return Ok(a.nrows());
    }
    Err(Error::Shape {
        name,
        expected: "(m, m) with m >= 1".to_owned(),
        found: format!("({}, {})", a.nrows(), a.ncols()),
    })
}

/// The first `k` columns of the identity of size `r`.
pub(crate) fn identity_columns(r: usize, k: usize) -> Mat<f64> {
    Mat::from_fn(r, k, |i, j| f64::from(u8::from(i == j)))
}
