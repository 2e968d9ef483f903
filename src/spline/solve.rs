//! From the flat spline to the spline: at once, from a relaxed chain of nodes, or along a family of easier splines.

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
            tolerance: 0.0,
        }
    }

    pub(super) fn report(&self) -> SolverReport {
        SolverReport {
            converged: self.reason == StopReason::Converged,
            iterations: self.iterations,
            residual: self.residual,
            tolerance: self.tolerance,
            reason: self.reason,
        }
    }

    fn is_final(&self, options: &SplineOptions<'_>) -> bool {
        self.reason == StopReason::Converged || self.iterations >= options.max_iterations
    }
}

/// A chain of few dimensions, given as a family; `relaxed` makes a better start of one.
///
/// # Errors
/// `Interrupted`, those of the chains.
pub(super) fn in_frames<'a>(
    chain_at: &dyn Fn(f64) -> Result<Framed<'a>>,
    relaxed: &dyn Fn(&Framed<'a>, &Motion) -> Result<Motion>,
    ends: &Ends,
    options: &SplineOptions<'_>,
) -> Result<(Motion, Outcome)> {
    let chain = chain_at(1.0)?;
    let problem = Interpolation::new(&chain, ends)?;
    let (tolerance, most) = (options.tolerance, options.max_iterations);
    let start = problem.start()?;
    let mut iterations = 0;
    let closed = matches!(ends, Ends::Periodic);
    for attempt in 0..if closed { 1 } else { 2 } {
        let motion = match attempt {
            0 => Ok(start.clone()),
            _ => relaxed(&chain, &start),
        };
        let solved = motion.and_then(|mut motion| {
            let left = most - iterations;
            let outcome = Iteration::solve(&problem, &mut motion, tolerance, left)?;
            Ok((motion, outcome))
        });
        match solved {
            Err(error) if error.is_interrupted() => return Err(error),
            // A start that is too fast to be integrated is left to what follows.
            Err(_) => {}
            Ok((motion, mut outcome)) => {
                outcome.iterations += iterations;
                if outcome.is_final(options) {
                    return Ok((motion, outcome));
                }
                iterations = outcome.iterations;
            }
        }
    }
    let (motion, mut outcome) = continuation::solve(chain_at, ends, tolerance, most - iterations)?;
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
