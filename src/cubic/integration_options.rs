//! Options for integrating a Riemannian cubic from initial data.

use super::taylor::march::Accuracy;
use crate::space::Quotient;

/// Options of the initial value solver.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{IntegrationOptions, RiemannianCubic};
/// use stiefel_rs::{Curve, Interrupt};
/// let (s, v) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (a, j) = (mat![[0.0], [0.0], [2.0]], mat![[0.0], [3.0], [0.0]]);
/// let [s, v, a, j] = [&s, &v, &a, &j].map(|a| a.as_ref());
/// let full = IntegrationOptions { t_end: 2.0, ..Default::default() };
/// let exact = RiemannianCubic::from_initial(s, v, a, j, &full, Interrupt::NEVER)?;
/// assert_eq!(exact.t_span(), (0.0, 2.0));
/// let rough =
///     RiemannianCubic::from_initial(s, v, a, j, &IntegrationOptions { tolerance: 1e-6, ..full }, Interrupt::NEVER)?;
/// let error = (rough.point(2.0)? - exact.point(2.0)?).norm_l2();
/// assert!(1e-12 < error && error < 1e-6);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct IntegrationOptions {
    /// End time: the curve is computed between 0 and this time, which may be negative.
    pub t_end: f64,
    /// Truncation error per step of the Taylor method, relative to the state, in `[1e-17, 0.1]`. It also bounds the
    /// accuracy to which points are orthonormal.
    pub tolerance: f64,
    /// `tau >= 0` of a cubic in tension, which makes `int |D_t S'|^2 + tau |S'|^2 dt` stationary; in units of `1 / t^2`.
    pub tension: f64,
    /// The meaning of the points: frames or subspaces.
    pub quotient: Quotient,
}

impl Default for IntegrationOptions {
    /// The interval `[0, 1]`, to round-off, for frames without tension.
    fn default() -> Self {
        IntegrationOptions {
            t_end: 1.0,
            tolerance: Accuracy::FULL.truncation,
            tension: 0.0,
            quotient: Quotient::Frames,
        }
    }
}
