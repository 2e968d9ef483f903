//! Options of boundary value problems of Riemannian cubics.

use faer::MatRef;

use super::taylor::work::allowance;
use super::tension::{check_leg_tension, check_tension};
use crate::error::{Error, Result};
use crate::space::{Kind, Quotient, ScalarField};

/// Default limit of steps from one start.
const MAX_ITERATIONS: usize = 50;

/// Options of the boundary value solver.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{BoundaryOptions, RiemannianCubic};
/// use stiefel_rs::{Curve, Interrupt};
/// let (s0, v0) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (s1, v1) = (mat![[0.0], [1.0], [0.0]], mat![[0.0], [0.0], [2.0]]);
/// let [s0, v0, s1, v1] = [&s0, &v0, &s1, &v1].map(|a| a.as_ref());
/// let first = RiemannianCubic::from_boundary(s0, v0, s1, v1, &BoundaryOptions::default(), Interrupt::NEVER)?;
/// assert!((first.point(1.0)? - s1).norm_l2() < 1e-12);
/// // From a solution there is less to do.
/// let (a, j) = (first.acceleration(0.0)?, first.jerk(0.0)?);
/// let options = BoundaryOptions { guess: Some((a.as_ref(), j.as_ref())), ..Default::default() };
/// let again = RiemannianCubic::from_boundary(s0, v0, s1, v1, &options, Interrupt::NEVER)?;
/// let iterations = |curve: &RiemannianCubic| curve.report().map(|report| report.iterations);
/// assert!(iterations(&again) < iterations(&first));
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct BoundaryOptions<'a> {
    /// The iteration has converged once `(|S(1) - S1|^2 + |V(1) - V1|^2 / u^2)^(1/2)` is at most this; between 1e-15
    /// and 0.1. For subspaces, `S1` and `V1` are in the basis that the curve reaches.
    ///
    /// The unit `u` is 1 if both end speeds are at most 10 (Frobenius norm), else it is the larger of them: along a
    /// curve of speed `|V|`, a round-off of `eps |V|` in the angle causes one of `eps |V|^2` in the velocity. The
    /// tolerance is raised to `32 eps` times the larger speed, at most to `1e-9`, also in the report; for speeds of 140
    /// this is about `1e-12`.
    pub tolerance: f64,
    /// Maximal number of Newton steps from each start; at least 1. Descents take up to 300 steps each and count only
    /// against the work limit. With 12 or fewer, only Newton's method from the first start is tried. Values above the
    /// default raise the [limit of work](crate::StopReason::WorkLimit) in proportion.
    pub max_iterations: usize,
    /// Covariant acceleration and covariant jerk at `S0` to start from, shape `(n, k)` each; by default those of the
    /// cubic of flat space; horizontal for subspaces. A guess between lines leads to the sense in which its curve ends.
    /// Components outside the span of the boundary data are dropped, since no solution has any.
    pub guess: Option<(MatRef<'a, f64>, MatRef<'a, f64>)>,
    /// `tau >= 0` of a cubic in tension, which makes `int |D_t S'|^2 + tau |S'|^2 dt` stationary. At most 64: errors at
    /// the start grow as `e^sqrt(tau)`, so for larger values the initial data no longer determine the end to the
    /// tolerance.
    pub tension: f64,
    /// The meaning of the points: frames or subspaces.
    pub quotient: Quotient,
    /// Scalars of the matrices; complex matrices are embedded in real ones.
    pub field: ScalarField,
}

impl Default for BoundaryOptions<'_> {
    /// Residual `1e-12`, at most 50 steps, starting from the cubic of flat space.
    fn default() -> Self {
        BoundaryOptions {
            tolerance: 1e-12,
            max_iterations: MAX_ITERATIONS,
            guess: None,
            tension: 0.0,
            quotient: Quotient::Frames,
            field: ScalarField::Real,
        }
    }
}

impl BoundaryOptions<'_> {
    /// Factor by which the work limit of a problem is raised.
    pub(super) fn allowance(&self) -> f64 {
        allowance(self.max_iterations, MAX_ITERATIONS)
    }

    /// The meaning of the points and their scalars.
    pub(crate) fn kind(&self) -> Kind {
        let BoundaryOptions {
            quotient, field, ..
        } = *self;
        Kind { quotient, field }
    }

    pub(crate) fn check(&self) -> Result<()> {
        if !(1e-15..=0.1).contains(&self.tolerance) {
            return Err(Error::InvalidArgument {
                name: "tolerance",
                requirement: "between 1e-15 and 0.1",
                found: self.tolerance,
            });
        }
        check_tension(self.tension)?;
        check_leg_tension(self.tension, true)?;
        if self.max_iterations == 0 {
            return Err(Error::InvalidArgument {
                name: "max_iterations",
                requirement: "at least 1",
                found: 0.0,
            });
        }
        Ok(())
    }
}
