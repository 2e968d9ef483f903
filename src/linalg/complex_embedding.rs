//! Complex matrices as real matrices of twice the size.
//!
//! ```math
//! S \mapsto \begin{pmatrix} \operatorname{Re} S & -\operatorname{Im} S \\ \operatorname{Im} S & \operatorname{Re} S \end{pmatrix}
//! ```
//!
//! The map preserves products and maps the conjugate transpose to the transpose: unitary matrices become orthogonal,
//! skew-Hermitian ones skew, and complex St(n, k) a submanifold of the real St(2n, 2k). The embedded set is the fixed
//! set of an isometry, `S -> J S J^T` with the complex structures `J` on both sides, hence totally geodesic: geodesics,
//! quasi-geodesics, de Casteljau curves, Riemannian cubics and splines of embedded data are embeddings of the complex
//! ones. Squared lengths double.

use faer::{Mat, MatMut, MatRef, c64};

use super::dual::Number;
use crate::error::{Error, Result};

/// Allowed distance of results of the real library from the embedded set, relative to their norm if it exceeds 1.
pub const COMPLEX_TOLERANCE: f64 = 1e-9;

/// Writes the embedding of an `n x k` complex matrix to `out`, shape `(2n, 2k)`.
pub fn embed_into(mut out: MatMut<'_, f64>, s: MatRef<'_, c64>) {
    let (n, k) = s.shape();
    debug_assert_eq!(out.shape(), (2 * n, 2 * k));
    for j in 0..k {
        for i in 0..n {
            let c64 { re, im } = s[(i, j)];
            out[(i, j)] = re;
            out[(n + i, j)] = im;
            out[(i, k + j)] = -im;
            out[(n + i, k + j)] = re;
        }
    }
}

/// The embedding of an `n x k` complex matrix, shape `(2n, 2k)`.
///
/// # Examples
/// ```
/// use faer::{c64, mat};
/// use stiefel_rs::linalg::complex_embedding::embed;
/// let embedded = embed(mat![[c64::new(1.0, 2.0)]].as_ref());
/// assert_eq!(embedded, mat![[1.0, -2.0], [2.0, 1.0]]);
/// ```
pub fn embed(s: MatRef<'_, c64>) -> Mat<f64> {
    let mut out = Mat::zeros(2 * s.nrows(), 2 * s.ncols());
    embed_into(out.as_mut(), s);
    out
}

/// `out = i x` for complex numbers in blocks of `size` real ones, real parts before imaginary ones: the second half of
/// the columns of an embedded matrix from the first half.
#[inline(always)]
pub(crate) fn times_i<T: Number>(x: &[T], size: usize, out: &mut [T]) {
    for (x, out) in x.chunks_exact(size).zip(out.chunks_exact_mut(size)) {
        let ((re, im), (upper, lower)) = (x.split_at(size / 2), out.split_at_mut(size / 2));
        for (out, x) in upper.iter_mut().zip(im) {
            *out = -*x;
        }
        lower.copy_from_slice(re);
    }
}

/// Writes the complex matrix whose embedding is nearest to `a`, shape `(2n, 2k)`, to `out`, shape `(n, k)`: the mean of
/// both copies. Returns the distance of `a` from that embedding (Frobenius norm), and the norm of `a`.
pub(crate) fn nearest_into(mut out: MatMut<'_, c64>, a: MatRef<'_, f64>) -> (f64, f64) {
    let (n, k) = out.shape();
    debug_assert_eq!(a.shape(), (2 * n, 2 * k));
    let (mut off, mut all) = (0.0, 0.0);
    for j in 0..k {
        for i in 0..n {
            let [first, second] = [a[(i, j)], a[(n + i, k + j)]];
            let [lower, upper] = [a[(n + i, j)], a[(i, k + j)]];
            let (re, im) = (first - second, lower + upper);
            off += re * re + im * im;
            all += first * first + second * second + lower * lower + upper * upper;
            // Halve first, so that no sum overflows.
            out[(i, j)] = c64::new(0.5 * first + 0.5 * second, 0.5 * lower - 0.5 * upper);
        }
    }
    ((off / 2.0).sqrt(), all.sqrt())
}

/// Distance of a matrix of shape `(2n, 2k)` from the embedded complex matrices, Frobenius norm.
pub fn embedding_defect(a: MatRef<'_, f64>) -> f64 {
    let mut nearest = Mat::zeros(a.nrows() / 2, a.ncols() / 2);
    nearest_into(nearest.as_mut(), a).0
}

/// Return an error unless a matrix is an embedded one.
///
/// # Errors
/// `Shape` if a size is odd, `NotComplex` if [`embedding_defect`] exceeds `COMPLEX_TOLERANCE * max(1, |a|)`.
pub(crate) fn check_embedded(a: MatRef<'_, f64>) -> Result<()> {
    let (rows, columns) = a.shape();
    if (rows % 2, columns % 2) != (0, 0) {
        return Err(Error::Shape {
            name: "an embedded complex matrix",
            expected: "(2 n, 2 k)".to_owned(),
            found: format!("({rows}, {columns})"),
        });
    }
    let mut out = Mat::zeros(rows / 2, columns / 2);
    restrict_into(out.as_mut(), a)
}

/// Writes the complex matrix whose embedding is `a`, shape `(2n, 2k)`, to `out`, shape `(n, k)`. NaN is propagated.
///
/// # Errors
/// `NotComplex` if [`embedding_defect`] exceeds `COMPLEX_TOLERANCE * max(1, |a|)`.
pub fn restrict_into(out: MatMut<'_, c64>, a: MatRef<'_, f64>) -> Result<()> {
    let (defect, norm) = nearest_into(out, a);
    let tolerance = COMPLEX_TOLERANCE * norm.max(1.0);
    if defect > tolerance {
        return Err(Error::NotComplex { defect, tolerance });
    }
    Ok(())
}

/// The complex matrix of shape `(n, k)` whose embedding is `a`, shape `(2n, 2k)`.
///
/// # Errors
/// As [`restrict_into`].
pub fn restrict(a: MatRef<'_, f64>) -> Result<Mat<c64>> {
    let mut out = Mat::zeros(a.nrows() / 2, a.ncols() / 2);
    restrict_into(out.as_mut(), a)?;
    Ok(out)
}

/// The complex matrix whose embedding is nearest to `a`, shape `(2n, 2k)`.
pub(crate) fn nearest(a: MatRef<'_, f64>) -> Mat<c64> {
    let mut out = Mat::zeros(a.nrows() / 2, a.ncols() / 2);
    nearest_into(out.as_mut(), a);
    out
}

/// Allowed distance of the points of a search from the embedded set, relative to their norm; the nearest embedded
/// matrix of an orthonormal one is orthonormal to the square of this.
const SEARCH_TOLERANCE: f64 = 1e-7;

/// The embedded matrix nearest to `a`, shape `(2n, 2k)`, which must be embedded to the tolerance of a search.
///
/// # Errors
/// `NotComplex` if [`embedding_defect`] exceeds `1e-7 * max(1, |a|)`.
pub fn nearest_embedded(a: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let mut nearest = Mat::zeros(a.nrows() / 2, a.ncols() / 2);
    let (defect, norm) = nearest_into(nearest.as_mut(), a);
    let tolerance = SEARCH_TOLERANCE * norm.max(1.0);
    match defect > tolerance {
        true => Err(Error::NotComplex { defect, tolerance }),
        false => Ok(embed(nearest.as_ref())),
    }
}

/// The columns of an embedded matrix in pairs: those of the real and of the imaginary part of the first complex column,
/// and so on. In this order, triangular complex matrices with a real diagonal are embedded as triangular ones.
pub fn paired_columns(a: MatRef<'_, f64>) -> Mat<f64> {
    let k = a.ncols() / 2;
    Mat::from_fn(a.nrows(), 2 * k, |i, j| a[(i, j / 2 + k * (j % 2))])
}

/// The inverse of [`paired_columns`].
pub fn unpaired_columns(a: MatRef<'_, f64>) -> Mat<f64> {
    let k = a.ncols() / 2;
    Mat::from_fn(a.nrows(), 2 * k, |i, j| a[(i, 2 * (j % k) + j / k)])
}
