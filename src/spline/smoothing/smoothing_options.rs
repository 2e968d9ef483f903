//! Options of smoothing splines.

use crate::space::{Quotient, ScalarField};
use crate::spline::options::{MAX_ITERATIONS, SplineOptions};

/// Options of a smoothing spline.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::spline::{SmoothingOptions, smoothing_spline};
/// let points = [0.0_f64, 0.5, 0.3, 0.9].map(|a| mat![[a.cos()], [a.sin()]]);
/// let (t, views) = ([0.0, 1.0, 2.0, 3.0], points.each_ref().map(|point| point.as_ref()));
/// let with = |lambda| SmoothingOptions { lambda: Some(lambda), ..Default::default() };
/// // Nothing but the data counts: the spline through them.
/// assert!(smoothing_spline(&t, &views, None, &with(0.0), Interrupt::NEVER)?.misfit < 1e-20);
/// // Nothing but the cost counts: the line of regression of the angle, here 0.25 t + 0.05.
/// let line = smoothing_spline(&t, &views, None, &with(1e6), Interrupt::NEVER)?;
/// assert!((line.misfit - 0.115).abs() < 1e-6);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct SmoothingOptions {
    /// `lambda`, in units of squared distance times time cubed; infinite for geodesic regression; chosen by generalised
    /// cross-validation if it is `None`.
    pub lambda: Option<f64>,
    /// The iteration has converged once all defects of legs, jumps of the acceleration and imbalances at knots are at
    /// most this, in the time of a leg, or at most round-off if there are thousands of legs.
    pub tolerance: f64,
    /// Maximal number of steps. Values above the default raise the [limit of work](crate::StopReason::WorkLimit) in
    /// proportion.
    pub max_iterations: usize,
    /// The meaning of the points: frames or subspaces.
    pub quotient: Quotient,
    /// Scalars of the points; complex points are embedded in real ones.
    pub field: ScalarField,
}

impl Default for SmoothingOptions {
    /// Cross-validation, `1e-11`, at most 200 steps.
    fn default() -> Self {
        SmoothingOptions {
            lambda: None,
            tolerance: 1e-11,
            max_iterations: MAX_ITERATIONS,
            quotient: Quotient::Frames,
            field: ScalarField::Real,
        }
    }
}

impl SmoothingOptions {
    /// Options of the interpolating spline through the data.
    pub(super) fn spline(&self) -> SplineOptions {
        SplineOptions {
            tolerance: self.tolerance,
            max_iterations: self.max_iterations,
            quotient: self.quotient,
            field: self.field,
            ..SplineOptions::default()
        }
    }
}
