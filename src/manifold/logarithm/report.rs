//! Report and errors of the Riemannian logarithm.

use super::shooting::ShootingOutcome;
use crate::error::Error;
use crate::report::{SolverReport, StopReason};

/// Solver named in errors.
pub(super) const SOLVER: &str = "Riemannian logarithm";

/// How a logarithm was found, and whether it is the shortest one.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Interrupt, Stiefel};
/// let s0 = mat![[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [0.0, 0.0]];
/// let s1 = mat![[0.8, 0.0], [0.0, 0.6], [0.6, 0.0], [0.0, 0.8]];
/// let manifold = Stiefel::new(4, 2)?;
/// let (v, report) = manifold.log_with_report(s0.as_ref(), s1.as_ref(), Interrupt::NEVER)?;
/// // Two turns out of the columns, by the principal angles.
/// assert!((report.length - 0.8_f64.acos().hypot(0.6_f64.acos())).abs() < 1e-13);
/// assert!((report.length - manifold.norm(s0.as_ref(), v.as_ref())?).abs() < 1e-13);
/// assert!(report.converged && report.certainly_shortest);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogReport {
    /// Whether the residual is at the level of round-off. This is true for every logarithm that is returned.
    pub converged: bool,
    /// Newton steps of the first attempt from a close start, plus those from the start that found the logarithm.
    pub iterations: usize,
    /// `|exp(S0, V) - S1|_F`.
    pub residual: f64,
    /// Length of the geodesic in the manifold's metric.
    pub length: f64,
    /// Whether the geodesic is certainly the shortest one, because its length is below the known bound of the
    /// injectivity radius or because there is a closed form. If `false`, a shorter one may exist.
    pub certainly_shortest: bool,
}

/// The error for a rotation without principal logarithm: no unique shortest geodesic joins the points.
pub(super) fn not_joined(error: Error) -> Error {
    match error {
        Error::OutsideLogDomain { angle } => Error::NoJoiningCurve { angle },
        error => error,
    }
}

/// The error if no geodesic reaches the end to the tolerance.
pub(super) fn no_convergence(outcome: ShootingOutcome, tolerance: f64) -> Error {
    Error::NoConvergence {
        solver: SOLVER,
        report: SolverReport::new(
            StopReason::Stagnated,
            outcome.iterations,
            outcome.residual,
            tolerance,
        ),
    }
}
