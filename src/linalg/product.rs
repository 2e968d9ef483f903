//! Matrix products into a given destination: sequential, and without allocation for small sizes.

use faer::linalg::matmul::matmul;
use faer::mat::{AsMatMut, AsMatRef};
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// Number of multiplications below which plain loops are faster than setting up the blocked product.
const SMALL: usize = 6 * 6 * 6;

/// Whether an `m x l` times `l x n` product uses plain loops.
pub fn is_small(m: usize, l: usize, n: usize) -> bool {
    m * l * n <= SMALL
}

/// A matrix or a view of one, to be read.
///
/// # Examples
/// ```
/// use faer::{Mat, mat};
/// use stiefel_rs::linalg::product::{Readable, mul_into};
/// /// The Gram matrix of two columns.
/// fn gram(a: impl Readable) -> Mat<f64> {
///     let (a, mut out) = (a.as_mat_ref(), Mat::zeros(2, 2));
///     mul_into(&mut out, 1.0, a.transpose(), a);
///     out
/// }
/// let a = mat![[1.0, 2.0], [3.0, 4.0]];
/// // A matrix and a view, with rows and columns exchanged.
/// assert_eq!(gram(&a), mat![[10.0, 14.0], [14.0, 20.0]]);
/// assert_eq!(gram(a.transpose()), mat![[5.0, 11.0], [11.0, 25.0]]);
/// ```
pub trait Readable: AsMatRef<T = f64, Rows = usize, Cols = usize> {}
impl<M: AsMatRef<T = f64, Rows = usize, Cols = usize>> Readable for M {}

/// A matrix or a view of one, to be written.
///
/// # Examples
/// ```
/// use faer::{Mat, mat};
/// use stiefel_rs::linalg::product::{Writable, mul_into};
/// /// `e_1 e_1^T`, twice.
/// fn fill(out: impl Writable) {
///     mul_into(out, 2.0, mat![[1.0], [0.0]], mat![[1.0, 0.0]]);
/// }
/// // A matrix, and a block of one.
/// let (mut small, mut large) = (Mat::zeros(2, 2), Mat::<f64>::identity(3, 3));
/// fill(&mut small);
/// fill(large.as_mut().submatrix_mut(1, 1, 2, 2));
/// assert_eq!(small, mat![[2.0, 0.0], [0.0, 0.0]]);
/// assert_eq!(large, mat![[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.0]]);
/// ```
pub trait Writable: AsMatMut<T = f64, Rows = usize, Cols = usize> {}
impl<M: AsMatMut<T = f64, Rows = usize, Cols = usize>> Writable for M {}

/// `a * b`.
pub(crate) fn product(a: impl Readable, b: impl Readable) -> Mat<f64> {
    let (a, b) = (a.as_mat_ref(), b.as_mat_ref());
    let mut out = Mat::zeros(a.nrows(), b.ncols());
    mul_into(&mut out, 1.0, a, b);
    out
}

/// `dst = alpha * a * b`.
pub fn mul_into(mut dst: impl Writable, alpha: f64, a: impl Readable, b: impl Readable) {
    let (dst, a, b) = (dst.as_mat_mut(), a.as_mat_ref(), b.as_mat_ref());
    accumulate(
        dst.as_dyn_stride_mut(),
        Accum::Replace,
        alpha,
        a.as_dyn_stride(),
        b.as_dyn_stride(),
    );
}

/// `dst += alpha * a * b`.
pub fn mul_add(mut dst: impl Writable, alpha: f64, a: impl Readable, b: impl Readable) {
    let (dst, a, b) = (dst.as_mat_mut(), a.as_mat_ref(), b.as_mat_ref());
    accumulate(
        dst.as_dyn_stride_mut(),
        Accum::Add,
        alpha,
        a.as_dyn_stride(),
        b.as_dyn_stride(),
    );
}

fn accumulate(
    dst: MatMut<'_, f64>,
    beta: Accum,
    alpha: f64,
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
) {
    debug_assert_eq!(a.ncols(), b.nrows());
    debug_assert_eq!((dst.nrows(), dst.ncols()), (a.nrows(), b.ncols()));
    if !is_small(a.nrows(), a.ncols(), b.ncols()) {
        return matmul(dst, beta, a, b, alpha, Par::Seq);
    }
    let mut dst = dst;
    for j in 0..b.ncols() {
        for i in 0..a.nrows() {
            let mut sum = 0.0;
            for l in 0..a.ncols() {
                sum += a[(i, l)] * b[(l, j)];
            }
            match beta {
                Accum::Replace => dst[(i, j)] = alpha * sum,
                Accum::Add => dst[(i, j)] += alpha * sum,
            }
        }
    }
}

/// A matrix with the given number of rows, from its columns.
pub(crate) fn columns(entries: &[f64], rows: usize) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(entries, rows, entries.len() / rows)
}

/// The same to be written.
pub(crate) fn columns_mut(entries: &mut [f64], rows: usize) -> MatMut<'_, f64> {
    let count = entries.len() / rows;
    MatMut::from_column_major_slice_mut(entries, rows, count)
}

/// The entries in column-major order.
pub(crate) fn entries(a: impl Readable) -> Vec<f64> {
    let a = a.as_mat_ref();
    a.col_iter().flat_map(|c| c.iter().copied()).collect()
}

/// `dst += alpha * a`, entry by entry.
pub fn axpy(mut dst: impl Writable, alpha: f64, a: impl Readable) {
    let (mut dst, a) = (dst.as_mat_mut(), a.as_mat_ref());
    debug_assert_eq!((dst.nrows(), dst.ncols()), (a.nrows(), a.ncols()));
    for j in 0..a.ncols() {
        for i in 0..a.nrows() {
            dst[(i, j)] += alpha * a[(i, j)];
        }
    }
}

/// `dst *= alpha`, entry by entry.
pub fn scale(mut dst: impl Writable, alpha: f64) {
    let mut dst = dst.as_mat_mut();
    for j in 0..dst.ncols() {
        for i in 0..dst.nrows() {
            dst[(i, j)] *= alpha;
        }
    }
}

/// Sign of the determinant of a square matrix, by elimination with partial pivoting; `a` is overwritten.
pub fn determinant_sign(mut a: MatMut<'_, f64>) -> f64 {
    let m = a.nrows();
    let mut sign = 1.0;
    for j in 0..m {
        let mut pivot = j;
        for i in j + 1..m {
            if a[(i, j)].abs() > a[(pivot, j)].abs() {
                pivot = i;
            }
        }
        if a[(pivot, j)] == 0.0 {
            return 0.0;
        }
        if pivot != j {
            sign = -sign;
            for l in j..m {
                let swap = a[(j, l)];
                a[(j, l)] = a[(pivot, l)];
                a[(pivot, l)] = swap;
            }
        }
        if a[(j, j)] < 0.0 {
            sign = -sign;
        }
        for i in j + 1..m {
            let factor = a[(i, j)] / a[(j, j)];
            for l in j + 1..m {
                let x = a[(j, l)];
                a[(i, l)] -= factor * x;
            }
        }
    }
    sign
}
