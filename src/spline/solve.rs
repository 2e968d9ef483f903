//! From the flat spline to the spline: at once, from parts of it, from a relaxed chain of nodes, or along a family of easier
//! splines.

use super::ambient::Ambient;
use super::chain::Motion;
use super::continuation;
use super::ends::Ends;
use super::framed::Framed;
use super::interpolation::Interpolation;
use super::iteration::{Iteration, Outcome};
use super::joined::Joined;
use super::low_cost::{self, Cheapest, unless_interrupted};
use super::parts;
use super::riemannian::SplineOptions;
use crate::error::{Error, Result};
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

    /// The error of an iteration that has not converged, with the tolerance that was asked for, which round-off may exceed.
    pub(super) fn failure(&self, solver: &'static str, tolerance: f64) -> Error {
        let report = SolverReport {
            tolerance,
            ..self.report()
        };
        Error::NoConvergence { solver, report }
    }

    fn is_final(&self, options: &SplineOptions<'_>) -> bool {
        self.reason == StopReason::Converged || self.iterations >= options.max_iterations
    }
}

/// How the whole is started.
#[derive(Clone, Copy)]
enum Start {
    /// From the flat spline.
    Flat,
    /// From parts that are solved by themselves.
    Parts,
    /// From a relaxed chain of nodes.
    Relaxed,
}

/// A chain of few dimensions; where its knots are far apart, the cheapest of several solutions.
///
/// # Errors
/// `Interrupted`, those of the chains.
pub(super) fn in_frames(
    knots: &Joined<'_>,
    ends: &Ends,
    options: &SplineOptions<'_>,
) -> Result<(Motion, Outcome)> {
    let first = forwards(knots, ends, options)?;
    if !low_cost::is_far(&knots.curves) {
        return Ok(first);
    }
    let chain = knots.chain(1.0)?;
    let problem = Interpolation::new(&chain, ends)?;
    let mut best = Cheapest::new(&chain, first, options.interrupt)?;
    if matches!(ends, Ends::Open(_)) {
        let relaxed = knots.relaxed(&chain, &problem.start()?, ends);
        best.try_start(&problem, unless_interrupted(relaxed)?.flatten(), options)?;
    }
    let at_rest = relaxed_at_rest(knots, &problem, options)?;
    best.try_start(&problem, at_rest, options)?;
    // And backwards; what is relaxed from the flat spline is the same there.
    let (back, ends) = (knots.reversed()?, ends.reversed());
    let chain = back.chain(1.0)?;
    let backwards = Interpolation::new(&chain, &ends)?;
    let at_rest = relaxed_at_rest(&back, &backwards, options)?;
    let found = [
        low_cost::solved(&backwards, backwards.start()?, options)?,
        low_cost::near(&backwards, at_rest, options)?,
    ];
    for solution in found {
        best.try_start(&problem, low_cost::forwards(&chain, solution)?, options)?;
    }
    Ok(best.into_solution())
}

/// A chain relaxed from the spline that is at rest at its free ends; `None` if there is none.
fn relaxed_at_rest(
    knots: &Joined<'_>,
    problem: &Interpolation<'_, Framed<'_>>,
    options: &SplineOptions<'_>,
) -> Result<Option<Motion>> {
    let Some(clamped) = low_cost::clamped(problem, options)? else {
        return Ok(None);
    };
    let relaxed = knots.relaxed(problem.chain, &clamped, problem.ends);
    Ok(unless_interrupted(relaxed)?.flatten())
}

/// A chain of few dimensions, from its start on.
///
/// # Errors
/// `Interrupted`, those of the chains.
pub(super) fn forwards(
    knots: &Joined<'_>,
    ends: &Ends,
    options: &SplineOptions<'_>,
) -> Result<(Motion, Outcome)> {
    let chain = knots.chain(1.0)?;
    let problem = Interpolation::new(&chain, ends)?;
    let (tolerance, most) = (options.tolerance, options.max_iterations);
    let flat = problem.start()?;
    let (mut iterations, mut least) = (0, f64::INFINITY);
    for start in [Start::Flat, Start::Parts, Start::Relaxed] {
        let motion = match start {
            Start::Flat => Ok(Some(flat.clone())),
            Start::Parts if parts::exist(knots.len(), ends) => parts::solve(knots, ends, options),
            Start::Relaxed if matches!(ends, Ends::Open(_)) => knots.relaxed(&chain, &flat, ends),
            _ => Ok(None),
        };
        let solved = motion.and_then(|motion| {
            let Some(mut motion) = motion else {
                return Ok(None);
            };
            let left = most - iterations;
            let outcome = Iteration::solve(&problem, &mut motion, tolerance, left)?;
            Ok(Some((motion, outcome)))
        });
        match solved {
            Err(error) if error.is_interrupted() => return Err(error),
            // A start that is too fast to be integrated is left to what follows.
            Err(_) | Ok(None) => {}
            Ok(Some((motion, mut outcome))) => {
                outcome.iterations += iterations;
                if outcome.is_final(options) {
                    return Ok((motion, outcome));
                }
                iterations = outcome.iterations;
                least = least.min(outcome.residual);
            }
        }
    }
    let left = most - iterations;
    let (motion, mut outcome) = continuation::solve(knots, ends, tolerance, left, least)?;
    outcome.iterations += iterations;
    Ok((motion, outcome))
}

/// A chain of many dimensions; where its knots are far apart, the cheaper of the solutions in both directions.
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
    if !low_cost::is_far(chain.curves()) {
        return Ok((motion, outcome));
    }
    let mut best = Cheapest::new(chain, (motion, outcome), options.interrupt)?;
    let (back, ends) = (chain.reversed()?, ends.reversed());
    let backwards = Interpolation::new(&back, &ends)?;
    let solution = low_cost::solved(&backwards, backwards.start()?, options)?;
    best.try_start(&problem, low_cost::forwards(&back, solution)?, options)?;
    Ok(best.into_solution())
}
