//! From the flat spline to the spline: at once, or along a family of easier splines.

use super::ambient::Ambient;
use super::chain::Motion;
use super::continuation;
use super::ends::Ends;
use super::framed::Framed;
use super::interpolation::Interpolation;
use super::iteration::{Iteration, Outcome};
use super::riemannian::SplineOptions;
use crate::error::Result;
use crate::report::{SolverReport, StopReason};

impl Outcome {
    pub(super) fn nothing_to_do() -> Self {
        Outcome {
            reason: StopReason::Converged,
            iterations: 0,
            residual: 0.0,
        }
    }

    pub(super) fn report(&self, tolerance: f64) -> SolverReport {
        SolverReport {
            converged: self.reason == StopReason::Converged,
            iterations: self.iterations,
            residual: self.residual,
            tolerance,
            reason: self.reason,
        }
    }

    fn is_final(&self, options: &SplineOptions<'_>) -> bool {
        self.reason == StopReason::Converged || self.iterations >= options.max_iterations
    }
}

/// A chain of few dimensions, given as a family.
///
/// # Errors
/// `Interrupted`, those of the chains; where the start cannot be integrated.
pub(super) fn in_frames<'a>(
    chain_at: &dyn Fn(f64) -> Result<Framed<'a>>,
    ends: &Ends,
    options: &SplineOptions<'_>,
) -> Result<(Motion, Outcome)> {
    let chain = chain_at(1.0)?;
    let problem = Interpolation::new(&chain, ends)?;
    let (tolerance, most) = (options.tolerance, options.max_iterations);
    let mut motion = problem.start()?;
    let first = match Iteration::solve(&problem, &mut motion, tolerance, most) {
        Err(error) if error.is_interrupted() => return Err(error),
        // A start that is too fast to be integrated is left to the family.
        other => other.ok(),
    };
    let iterations = match first {
        Some(outcome) if outcome.is_final(options) => return Ok((motion, outcome)),
        Some(outcome) => outcome.iterations,
        None => 0,
    };
    let left = most - iterations;
    let (motion, mut outcome) = continuation::solve(chain_at, ends, tolerance, left)?;
    outcome.iterations += iterations;
    Ok((motion, outcome))
}

/// A chain of many dimensions.
///
/// # Errors
/// `Interrupted`; where the start cannot be integrated.
pub(super) fn in_ambient(
    chain: &Ambient<'_>,
    ends: &Ends,
    options: &SplineOptions<'_>,
) -> Result<(Motion, Outcome)> {
    let problem = Interpolation::new(chain, ends)?;
    let mut motion = problem.start()?;
    let (tolerance, most) = (options.tolerance, options.max_iterations);
    let outcome = Iteration::solve(&problem, &mut motion, tolerance, most)?;
    Ok((motion, outcome))
}
