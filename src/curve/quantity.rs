//! Quantities along a curve: ambient derivatives, covariant acceleration and jerk.

use faer::MatMut;

use crate::linalg::jet::Jet;
use crate::linalg::product::scale;
use crate::manifold::covariant;
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

    /// Computes the quantity from Taylor coefficients of the curve, in the coordinates of its frame.
    pub(super) fn read_into(self, quotient: Quotient, jet: &Jet, mut out: MatMut<'_, f64>) {
        let c = |j: usize| jet.c[j].as_ref();
        let d = |j: usize, factorial: f64| &jet.c[j] * faer::Scale(factorial);
        match self {
            Quantity::Derivative(order) => {
                out.copy_from(c(order));
                scale(out, [1.0, 1.0, 2.0, 6.0][order]);
            }
            Quantity::Acceleration => {
                out.copy_from(covariant::acceleration(c(0), c(1), d(2, 2.0).as_ref()))
            }
            Quantity::Jerk => {
                let (second, third) = (d(2, 2.0), d(3, 6.0));
                let jerk = covariant::jerk(c(0), c(1), second.as_ref(), third.as_ref());
                out.copy_from(match quotient {
                    Quotient::Frames => jerk,
                    // For a horizontal curve both manifolds have the same acceleration, and the Grassmann manifold has
                    // the normal part of the jerk.
                    Quotient::Subspaces => tangent_part(quotient, c(0), jerk.as_ref()),
                });
            }
        }
    }
}
