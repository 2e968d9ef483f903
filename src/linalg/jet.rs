//! Truncated Taylor polynomials with matrix coefficients: exact derivatives of curves built from matrices.
//!
//! `A(tau) = A_0 + A_1 tau + A_2 tau^2 + A_3 tau^3 + O(tau^4)`. Coefficients, not derivatives: the j-th
//! derivative at `tau = 0` is `j! A_j`.

use faer::{Mat, MatRef};

use super::product::{axpy, mul_add, mul_into, scale};

/// Highest order kept.
pub const ORDER: usize = 3;

/// A scalar Taylor polynomial.
pub type ScalarJet = [f64; ORDER + 1];

/// A matrix Taylor polynomial; operations take the order up to which they work.
pub struct Jet {
    /// Coefficients `A_0 ..= A_3`.
    pub c: [Mat<f64>; ORDER + 1],
}

impl Jet {
    /// The zero polynomial with `rows x cols` coefficients.
    pub fn zeros(rows: usize, cols: usize) -> Self {
        Jet {
            c: std::array::from_fn(|_| Mat::zeros(rows, cols)),
        }
    }

    /// `self = other`.
    pub fn copy_from(&mut self, other: &Jet, order: usize) {
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
    pub fn set_product(&mut self, a: &Jet, b: &Jet, order: usize) {
        for j in 0..=order {
            mul_into(self.c[j].as_mut(), 1.0, a.c[0].as_ref(), b.c[j].as_ref());
            for i in 1..=j {
                mul_add(
                    self.c[j].as_mut(),
                    1.0,
                    a.c[i].as_ref(),
                    b.c[j - i].as_ref(),
                );
            }
        }
    }

    /// `self = a^T b`.
    pub fn set_product_tn(&mut self, a: &Jet, b: &Jet, order: usize) {
        for j in 0..=order {
            mul_into(
                self.c[j].as_mut(),
                1.0,
                a.c[0].as_ref().transpose(),
                b.c[j].as_ref(),
            );
            for i in 1..=j {
                mul_add(
                    self.c[j].as_mut(),
                    1.0,
                    a.c[i].as_ref().transpose(),
                    b.c[j - i].as_ref(),
                );
            }
        }
    }

    /// `self = a b^T`.
    pub fn set_product_nt(&mut self, a: &Jet, b: &Jet, order: usize) {
        for j in 0..=order {
            mul_into(
                self.c[j].as_mut(),
                1.0,
                a.c[0].as_ref(),
                b.c[j].as_ref().transpose(),
            );
            for i in 1..=j {
                mul_add(
                    self.c[j].as_mut(),
                    1.0,
                    a.c[i].as_ref(),
                    b.c[j - i].as_ref().transpose(),
                );
            }
        }
    }

    /// `self = a m` with a constant matrix `m`.
    pub fn set_product_constant(&mut self, a: &Jet, m: MatRef<'_, f64>, order: usize) {
        for j in 0..=order {
            mul_into(self.c[j].as_mut(), 1.0, a.c[j].as_ref(), m);
        }
    }

    /// `self = s a` with a scalar polynomial `s`.
    pub fn set_scaled(&mut self, s: &ScalarJet, a: &Jet, order: usize) {
        for j in 0..=order {
            self.c[j].fill(0.0);
            for i in 0..=j {
                axpy(self.c[j].as_mut(), s[i], a.c[j - i].as_ref());
            }
        }
    }

    /// `self += alpha a`.
    pub fn add(&mut self, alpha: f64, a: &Jet, order: usize) {
        for j in 0..=order {
            axpy(self.c[j].as_mut(), alpha, a.c[j].as_ref());
        }
    }

    /// `self *= alpha`.
    pub fn rescale(&mut self, alpha: f64, order: usize) {
        for j in 0..=order {
            scale(self.c[j].as_mut(), alpha);
        }
    }

    /// `self += alpha I`.
    pub fn add_identity(&mut self, alpha: f64) {
        for i in 0..self.c[0].ncols() {
            self.c[0][(i, i)] += alpha;
        }
    }
}
