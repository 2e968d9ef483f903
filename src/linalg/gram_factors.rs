//! Factors of tall matrices from their Gram matrix: products only, for matrices of moderate condition.
//!
//! A QR factorisation by reflections and a singular value decomposition pass over the matrix column by column; the Gram
//! matrix and the final product take two passes in all.
//!
//! # Source
//! Cholesky: Yamamoto, Nakatsukasa, Yanagisawa, Fukaya (2015), "Roundoff error analysis of the CholeskyQR2 algorithm",
//! ETNA 44, 306-326. Inverse square root: Higham (2008), "Functions of Matrices", section 6.3 (Newton-Schulz).

use faer::linalg::triangular_inverse::invert_lower_triangular;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Mat, MatMut, MatRef, Par, Side};

use super::product::{mul_add, mul_into, product};
use super::structure::{gram, norm};

/// Distance of the scaled Gram matrix from the identity up to which the inverse square root is computed by iteration: the
/// condition number is at most 3, so that the result is orthonormal to a few units of round-off. The iteration is stable
/// up to 9.
const NEAR_IDENTITY: f64 = 0.5;

/// Steps of the iteration from a residual of [`NEAR_IDENTITY`], of which six are needed: the residual `e` becomes at most
/// `e^2`.
const STEPS: usize = 7;

/// `A = Q R` by Cholesky's factorisation of `A^T A`.
pub(crate) struct CholeskyQr {
    /// Lower triangular, `R^T`.
    lower: Mat<f64>,
    /// `(k / (|R|_F |R^{-1}|_F))^2`, at most 1: the orthonormality defect of `Q` is about `eps` divided by this. The ratio
    /// of the pivots says nothing of the condition of matrices like Kahan's.
    pub(crate) conditioning: f64,
}

impl CholeskyQr {
    /// `None` if `A^T A` is not numerically positive definite.
    pub(crate) fn new(a: MatRef<'_, f64>) -> Option<Self> {
        CholeskyQr::of_gram(gram(a).as_ref())
    }

    /// The same from the lower triangle of `A^T A`.
    pub(crate) fn of_gram(gram: MatRef<'_, f64>) -> Option<Self> {
        let lower = gram.llt(Side::Lower).ok()?.L().to_owned();
        let k = lower.ncols();
        let mut inverse = Mat::zeros(k, k);
        invert_lower_triangular(inverse.as_mut(), lower.as_ref(), Par::Seq);
        let size = lower.norm_l2() * inverse.norm_l2();
        let conditioning = (k as f64 / size).powi(2);
        // False for NaN, too.
        (conditioning > 0.0).then_some(CholeskyQr {
            lower,
            conditioning,
        })
    }

    /// `A <- Q = A R^{-1}`.
    pub(crate) fn orthonormalise(&self, a: MatMut<'_, f64>) {
        solve_lower_triangular_in_place(self.lower.as_ref(), a.transpose_mut(), Par::Seq);
    }

    /// `B <- R^{-1} B`.
    pub(crate) fn divide(&self, b: MatMut<'_, f64>) {
        solve_upper_triangular_in_place(self.r(), b, Par::Seq);
    }

    /// `R`, upper triangular.
    pub(crate) fn r(&self) -> MatRef<'_, f64> {
        self.lower.transpose()
    }
}

/// The orthonormal polar factor `A (A^T A)^{-1/2}`, or `None` where the condition of `A` asks for a singular value
/// decomposition.
pub(crate) fn polar_near_orthonormal(a: MatRef<'_, f64>) -> Option<Mat<f64>> {
    let k = a.ncols();
    let mut gram = gram(a);
    let mean = (0..k).map(|j| gram[(j, j)]).sum::<f64>() / k as f64;
    // Squares of extreme entries overflow or vanish.
    if !(mean.is_finite() && (1.0 / mean).is_finite()) {
        return None;
    }
    for j in 0..k {
        for i in j..k {
            gram[(i, j)] /= mean;
            gram[(j, i)] = gram[(i, j)];
        }
    }
    let root = inverse_square_root(gram.as_ref())?;
    let mut out = product(a, &root);
    // A quotient: that of a number and its modulus is exactly one.
    let size = mean.sqrt();
    for j in 0..k {
        for x in out.col_as_slice_mut(j) {
            *x /= size;
        }
    }
    Some(out)
}

/// `G^{-1/2}` for a symmetric `G` with `|G - I|_F` at most [`NEAR_IDENTITY`], by Newton-Schulz iteration.
fn inverse_square_root(g: MatRef<'_, f64>) -> Option<Mat<f64>> {
    let k = g.ncols();
    let mut residual = Mat::from_fn(k, k, |i, j| f64::from(u8::from(i == j)) - g[(i, j)]);
    let mut size = norm(residual.as_ref());
    if size > NEAR_IDENTITY {
        return None;
    }
    let identity = || Mat::<f64>::identity(k, k);
    let (mut root, mut product) = (identity(), Mat::zeros(k, k));
    for _ in 0..STEPS {
        // Z <- Z (I + E / 2) with E = I - Z G Z; Z and E commute with G.
        mul_into(&mut product, 0.5, &root, &residual);
        root += &product;
        if size * size <= f64::EPSILON {
            return Some(root);
        }
        mul_into(&mut product, 1.0, &root, g);
        residual = identity();
        mul_add(&mut residual, -1.0, &product, &root);
        size = norm(residual.as_ref());
    }
    Some(root)
}
