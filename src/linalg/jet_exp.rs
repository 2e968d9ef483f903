//! Exponential of a matrix Taylor polynomial.

use super::jet::{MatrixJet, ScalarJet};
use crate::error::{Error, Result};

/// Degree of the exponential series, for arguments of norm at most 1 and derivatives up to the third.
const DEGREE: usize = 22;

/// Buffers for exponentials of square matrix polynomials of one size.
pub(crate) struct JetExp {
    argument: MatrixJet,
    product: MatrixJet,
    /// The last computed exponential.
    pub(crate) value: MatrixJet,
}

impl JetExp {
    pub(crate) fn new(m: usize) -> Self {
        JetExp {
            argument: MatrixJet::zeros(m, m),
            product: MatrixJet::zeros(m, m),
            value: MatrixJet::zeros(m, m),
        }
    }

    /// `value = e^{t A}` up to the given order, by a series for a scaled argument and squaring.
    ///
    /// # Errors
    /// `Overflow` of `quantity`.
    pub(crate) fn compute(
        &mut self,
        t: &ScalarJet,
        a: &MatrixJet,
        order: usize,
        quantity: &'static str,
    ) -> Result<()> {
        self.argument.set_scaled(t, a, order);
        let size = self.argument.c[0].norm_l2();
        if !size.is_finite() {
            return Err(Error::Overflow { quantity });
        }
        let squarings = if size > 1.0 {
            size.log2().ceil() as i32
        } else {
            0
        };
        self.argument.rescale(0.5_f64.powi(squarings), order);
        self.value.set_scalar(1.0, order);
        for j in (1..=DEGREE).rev() {
            self.product.set_product(&self.value, &self.argument, order);
            self.product.rescale(1.0 / j as f64, order);
            self.product.add_identity(1.0);
            std::mem::swap(&mut self.product, &mut self.value);
        }
        for _ in 0..squarings {
            self.product.set_product(&self.value, &self.value, order);
            std::mem::swap(&mut self.product, &mut self.value);
        }
        Ok(())
    }
}
