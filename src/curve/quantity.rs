//! Quantities along a curve: ambient derivatives, covariant acceleration and jerk.

use faer::prelude::*;
use faer::{Mat, MatMut};

use crate::linalg::jet::MatrixJet;
use crate::linalg::product::scale;
use crate::manifold::covariant;
use crate::manifold::lane_covariant::{FEW_COLUMNS, LaneCovariant};
use crate::manifold::tangent::tangent_part;
use crate::space::Quotient;

/// The quantity to sample along a curve.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Curve, Interrupt, Quantity, QuasiGeodesic};
/// // A great circle at speed 2: it accelerates towards the centre, and not at all along the sphere.
/// let circle = QuasiGeodesic::from_velocity(mat![[1.0], [0.0]].as_ref(), mat![[0.0], [2.0]].as_ref())?;
/// let at = |quantity| circle.sample(&[0.0], quantity, Interrupt::NEVER);
/// assert!((at(Quantity::Derivative(2))?.get(0) - mat![[-4.0], [0.0]]).norm_l2() < 1e-14);
/// assert!(at(Quantity::Acceleration)?.get(0).norm_l2() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The ambient derivative of this order, 0 (position) to 3.
    Derivative(usize),
    /// The covariant acceleration `D_t S'`.
    Acceleration,
    /// The covariant jerk `D_t D_t S'`.
    Jerk,
}

impl Quantity {
    /// The order of its derivative with respect to the parameter.
    pub(crate) fn order(self) -> usize {
        match self {
            Quantity::Derivative(order) => order,
            Quantity::Acceleration => 2,
            Quantity::Jerk => 3,
        }
    }

    /// Computes the quantity from Taylor coefficients of the curve at up to eight parameters, in the coordinates of its
    /// frame, side by side in `out`.
    pub(super) fn read_into(
        self,
        quotient: Quotient,
        jets: &[MatrixJet],
        work: &mut Option<Box<LaneCovariant>>,
        mut out: MatMut<'_, f64>,
    ) {
        let (rows, k) = jets[0].c[0].shape();
        if let Quantity::Derivative(order) = self {
            for (i, jet) in jets.iter().enumerate() {
                let mut out = out.rb_mut().subcols_mut(i * k, k);
                out.copy_from(&jet.c[order]);
                scale(out, [1.0, 1.0, 2.0, 6.0][order]);
            }
            return;
        }
        if k > FEW_COLUMNS {
            for (i, jet) in jets.iter().enumerate() {
                let value = self.single(quotient, jet);
                out.rb_mut().subcols_mut(i * k, k).copy_from(value);
            }
            return;
        }
        let work = work.get_or_insert_with(|| Box::new(LaneCovariant::new(rows, k)));
        work.read(jets, self.order());
        let found = match self {
            Quantity::Jerk => work.jerk(),
            _ => work.acceleration(),
        };
        for (lane, jet) in jets.iter().enumerate() {
            let mut out = out.rb_mut().subcols_mut(lane * k, k);
            found.lane_into(lane, out.rb_mut());
            // For a horizontal curve both manifolds have the same acceleration, and the Grassmann manifold has the
            // normal part of the jerk.
            if (self, quotient) == (Quantity::Jerk, Quotient::Subspaces) {
                out.copy_from(tangent_part(quotient, jet.c[0].as_ref(), out.rb()));
            }
        }
    }

    /// A covariant quantity at one parameter.
    pub(super) fn single(self, quotient: Quotient, jet: &MatrixJet) -> Mat<f64> {
        let c = |j: usize| jet.c[j].as_ref();
        let second = &jet.c[2] * Scale(2.0);
        if self != Quantity::Jerk {
            return covariant::acceleration(c(0), c(1), second.as_ref());
        }
        let third = &jet.c[3] * Scale(6.0);
        let jerk = covariant::jerk(c(0), c(1), second.as_ref(), third.as_ref());
        match quotient {
            Quotient::Frames => jerk,
            Quotient::Subspaces => tangent_part(quotient, c(0), jerk.as_ref()),
        }
    }
}
