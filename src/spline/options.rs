//! Options of splines.

use super::knots::check_tolerance;
use crate::cubic::taylor::work::{Work, allowance};
use crate::cubic::tension::check_tension;
use crate::error::Result;
use crate::manifold::only_bases::Appearance;
use crate::space::{Kind, Quotient, ScalarField};

/// Default limit of steps.
pub(super) const MAX_ITERATIONS: usize = 200;

/// Options of a spline's solver.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Curve, Interrupt};
/// use stiefel_rs::spline::{EndConditions, SplineOptions, cubic_spline};
/// let points = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.6, 0.8]].map(|[x, y, z]| mat![[x], [y], [z]]);
/// let views = points.each_ref().map(|point| point.as_ref());
/// let options = SplineOptions { tolerance: 1e-10, ..Default::default() };
/// let (curve, report) = cubic_spline(&[0.0, 1.0, 2.0], &views, &EndConditions::Natural, &options, Interrupt::NEVER)?;
/// assert!(report.converged && report.residual <= 1e-10);
/// assert!((curve.point(1.0)? - &points[1]).norm_l2() < 1e-10);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct SplineOptions {
    /// The iteration has converged once all point and velocity defects of legs, and all jumps of the covariant
    /// acceleration, are at most this, in the time of a leg; at the end of a descent, once the gradient of the cost with respect
    /// to the free points and velocities is, in the time of the parts of legs.
    pub tolerance: f64,
    /// Maximal number of steps of each solver, of fixed-point iteration or Newton's method, not counting descents. Values
    /// above the default raise the [limit of work](crate::StopReason::WorkLimit) in proportion.
    pub max_iterations: usize,
    /// `tau >= 0` of a spline in tension, which makes `int |D_t S'|^2 + tau |S'|^2 dt` stationary, in units of `1 /
    /// t^2`. `tau` times the square of the longest leg must be at most 64, or 6.25 if the points have more than 12 rows
    /// and more than `4 k` rows, also within their span. Only for splines of Riemannian cubics.
    pub tension: f64,
    /// The meaning of the points: frames or subspaces.
    pub quotient: Quotient,
    /// Scalars of the points; complex points are embedded in real ones.
    pub field: ScalarField,
}

impl Default for SplineOptions {
    /// `1e-12`, at most 200 steps, no tension.
    fn default() -> Self {
        SplineOptions {
            tolerance: 1e-12,
            max_iterations: MAX_ITERATIONS,
            tension: 0.0,
            quotient: Quotient::Frames,
            field: ScalarField::Real,
        }
    }
}

impl SplineOptions {
    /// Checks what can be checked without points.
    ///
    /// # Errors
    /// `InvalidArgument` (tolerance, tension).
    pub(crate) fn check(&self) -> Result<()> {
        check_tolerance(self.tolerance)?;
        check_tension(self.tension)
    }

    /// The meaning of the points and their scalars.
    pub(super) fn kind(&self) -> Kind {
        let SplineOptions {
            quotient, field, ..
        } = *self;
        Kind { quotient, field }
    }

    /// The work limit for a spline between points of the given appearance that is allowed at least this many trials.
    pub(super) fn work(&self, trials: f64, trial: f64, points: Appearance) -> Work {
        let work = Work::of_trials(trials, trial, points);
        work.allow(allowance(self.max_iterations, MAX_ITERATIONS));
        work
    }
}
