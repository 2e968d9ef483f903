//! Norms of the covariant derivatives of a curve at many parameters.

use faer::MatRef;

use super::quantity::Quantity;
use crate::error::Result;
use crate::linalg::jet::MatrixJet;
use crate::linalg::lanes::LANES;
use crate::linalg::structure::SAFE_SQUARES;
use crate::manifold::Stiefel;
use crate::manifold::lane_covariant::{FEW_COLUMNS, LaneCovariant};
use crate::space::Quotient;

/// Writes Taylor coefficients of the coordinates of a curve at many parameters, up to an order.
pub(super) trait NormEvaluation:
    FnMut(&[f64], usize, &mut [MatrixJet]) -> Result<()>
{
}

impl<F: FnMut(&[f64], usize, &mut [MatrixJet]) -> Result<()>> NormEvaluation for F {}

/// The norms along one curve, with buffers allocated once.
pub(super) struct Norms<F> {
    evaluate: F,
    quotient: Quotient,
    /// The name of the result in errors.
    result: &'static str,
    manifold: Stiefel,
    jets: Vec<MatrixJet>,
    lanes: Option<LaneCovariant>,
}

/// The norms at one parameter.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Norm {
    /// Canonical norms of velocity, covariant acceleration and covariant jerk.
    pub(super) covariant: [f64; 3],
    /// Frobenius norm of the ambient second derivative.
    pub(super) ambient: f64,
}

impl<F: NormEvaluation> Norms<F> {
    /// Built for a curve with coordinates of shape `(rows, k)`.
    ///
    /// # Errors
    /// `Shape`.
    pub(super) fn new(
        [rows, k]: [usize; 2],
        quotient: Quotient,
        result: &'static str,
        evaluate: F,
    ) -> Result<Self> {
        Ok(Norms {
            evaluate,
            quotient,
            result,
            manifold: Stiefel::new(rows.max(k), k)?,
            jets: (0..LANES).map(|_| MatrixJet::zeros(rows, k)).collect(),
            lanes: (k <= FEW_COLUMNS).then(|| LaneCovariant::new(rows, k)),
        })
    }

    /// Writes the norms up to an order from 1 (the velocity alone) to 3; higher ones are zero.
    ///
    /// # Errors
    /// `Overflow`, and an error if the curve does not exist at one of the parameters.
    pub(super) fn read(&mut self, t: &[f64], order: usize, out: &mut [Norm]) -> Result<()> {
        for (t, out) in t.chunks(LANES).zip(out.chunks_mut(LANES)) {
            let jets = &mut self.jets[..t.len()];
            (self.evaluate)(t, order, jets)?;
            let mut single = [true; LANES];
            if let Some(lanes) = &mut self.lanes {
                lanes.read(jets, order);
                let subspaces = self.quotient == Quotient::Subspaces;
                let squares = lanes.squared_norms(order, subspaces);
                for (lane, out) in out.iter_mut().enumerate() {
                    let found = squares.map(|square| square.0[lane]);
                    // Squares that overflow or lose digits are computed anew, in scaled form.
                    single[lane] = !found.iter().all(|x| *x == 0.0 || SAFE_SQUARES.contains(x));
                    let [velocity, acceleration, jerk, ambient] = found.map(f64::sqrt);
                    *out = Norm {
                        covariant: [velocity, acceleration, jerk],
                        ambient,
                    };
                }
            }
            for ((lane, jet), out) in self.jets[..t.len()].iter().enumerate().zip(out) {
                if single[lane] {
                    *out = self.single(jet, order)?;
                }
            }
        }
        Ok(())
    }

    /// Writes the velocity's norms.
    ///
    /// # Errors
    /// As [`Norms::read`].
    pub(super) fn speeds(&mut self, t: &[f64], out: &mut [f64]) -> Result<()> {
        let mut found = [Norm::default(); LANES];
        for (t, out) in t.chunks(LANES).zip(out.chunks_mut(LANES)) {
            self.read(t, 1, &mut found[..t.len()])?;
            for (out, norm) in out.iter_mut().zip(&found) {
                *out = norm.covariant[0];
            }
        }
        Ok(())
    }

    fn single(&self, jet: &MatrixJet, order: usize) -> Result<Norm> {
        let s = jet.c[0].as_ref();
        let length = |vector: MatRef<'_, f64>| self.manifold.norm_along(self.result, s, vector);
        let covariant = |quantity: Quantity| length(quantity.single(self.quotient, jet).as_ref());
        let mut out = Norm::default();
        out.covariant[0] = length(jet.c[1].as_ref())?;
        if order > 1 {
            out.covariant[1] = covariant(Quantity::Acceleration)?;
            out.ambient = 2.0 * jet.c[2].norm_l2();
        }
        if order > 2 {
            out.covariant[2] = covariant(Quantity::Jerk)?;
        }
        Ok(out)
    }
}
