//! Truncated Taylor polynomials with matrix coefficients: exact derivatives of curves built from matrices.
//!
//! `A(tau) = A_0 + A_1 tau + A_2 tau^2 + A_3 tau^3 + O(tau^4)`. These are coefficients, not derivatives: the j-th
//! derivative at `tau = 0` is `j! A_j`.

use faer::{Mat, MatRef};

use super::product::{axpy, mul_add, mul_into, scale};

/// Highest order stored.
pub const ORDER: usize = 3;

/// A scalar Taylor polynomial.
pub type ScalarJet = [f64; ORDER + 1];

/// A matrix Taylor polynomial; operations take the highest order to compute.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::linalg::jet::MatrixJet;
/// // The exponential e^{tA}, by its Taylor coefficients A^j / j!.
/// let a = mat![[0.0, -1.0], [1.0, 0.0]];
/// let (mut forward, mut product) = (MatrixJet::zeros(2, 2), MatrixJet::zeros(2, 2));
/// forward.set_scalar(1.0, 3);
/// for j in 1..=3 {
///     forward.c[j] = &a * &forward.c[j - 1] * faer::Scale(1.0 / j as f64);
/// }
/// // A is skew, so e^{tA} is orthogonal: all coefficients of the product but the first vanish.
/// product.set_product_tn(&forward, &forward, 3);
/// assert_eq!(product.c[0], mat![[1.0, 0.0], [0.0, 1.0]]);
/// assert!(product.c[1..].iter().all(|c| c.norm_l2() < 1e-14));
/// ```
pub struct MatrixJet {
    /// Coefficients `A_0 ..= A_3`.
    pub c: [Mat<f64>; ORDER + 1],
}

impl MatrixJet {
    /// The zero polynomial with `rows x cols` coefficients.
    pub fn zeros(rows: usize, cols: usize) -> Self {
        MatrixJet {
            c: std::array::from_fn(|_| Mat::zeros(rows, cols)),
        }
    }

    /// The zero polynomial with coefficients up to the given order; the others have no entries.
    pub(crate) fn zeros_up_to(order: usize, rows: usize, cols: usize) -> Self {
        MatrixJet {
            c: std::array::from_fn(|j| match j <= order {
                true => Mat::zeros(rows, cols),
                false => Mat::new(),
            }),
        }
    }

    /// `self = other`.
    pub fn copy_from(&mut self, other: &MatrixJet, order: usize) {
        for j in 0..=order {
            self.c[j].copy_from(&other.c[j]);
        }
    }

    /// The constant `alpha I`.
    pub fn set_scalar(&mut self, alpha: f64, order: usize) {
        for j in 0..=order {
            self.c[j].fill(0.0);
        }
        for i in 0..self.c[0].ncols() {
            self.c[0][(i, i)] = alpha;
        }
    }

    /// `self = a b`.
    pub fn set_product(&mut self, a: &MatrixJet, b: &MatrixJet, order: usize) {
        for j in 0..=order {
            mul_into(&mut self.c[j], 1.0, &a.c[0], &b.c[j]);
            for i in 1..=j {
                mul_add(&mut self.c[j], 1.0, &a.c[i], &b.c[j - i]);
            }
        }
    }

    /// `self = a^T b`.
    pub fn set_product_tn(&mut self, a: &MatrixJet, b: &MatrixJet, order: usize) {
        for j in 0..=order {
            mul_into(&mut self.c[j], 1.0, a.c[0].transpose(), &b.c[j]);
            for i in 1..=j {
                mul_add(&mut self.c[j], 1.0, a.c[i].transpose(), &b.c[j - i]);
            }
        }
    }

    /// `self = a b^T`.
    pub fn set_product_nt(&mut self, a: &MatrixJet, b: &MatrixJet, order: usize) {
        for j in 0..=order {
            mul_into(&mut self.c[j], 1.0, &a.c[0], b.c[j].transpose());
            for i in 1..=j {
                mul_add(&mut self.c[j], 1.0, &a.c[i], b.c[j - i].transpose());
            }
        }
    }

    /// `self = a m` with a constant matrix `m`.
    pub fn set_product_constant(&mut self, a: &MatrixJet, m: MatRef<'_, f64>, order: usize) {
        for j in 0..=order {
            mul_into(&mut self.c[j], 1.0, &a.c[j], m);
        }
    }

    /// `self = s a` with a scalar polynomial `s`.
    pub fn set_scaled(&mut self, s: &ScalarJet, a: &MatrixJet, order: usize) {
        for j in 0..=order {
            self.c[j].fill(0.0);
            for i in 0..=j {
                axpy(&mut self.c[j], s[i], &a.c[j - i]);
            }
        }
    }

    /// `self += alpha a`.
    pub fn add(&mut self, alpha: f64, a: &MatrixJet, order: usize) {
        for j in 0..=order {
            axpy(&mut self.c[j], alpha, &a.c[j]);
        }
    }

    /// `self *= alpha`.
    pub fn rescale(&mut self, alpha: f64, order: usize) {
        for j in 0..=order {
            scale(&mut self.c[j], alpha);
        }
    }

    /// `self += alpha I`.
    pub fn add_identity(&mut self, alpha: f64) {
        for i in 0..self.c[0].ncols() {
            self.c[0][(i, i)] += alpha;
        }
    }
}
