//! From the flat spline to the spline: at once, from parts of it, from a relaxed chain of nodes, or along a family of easier
//! splines.

use super::ambient::Ambient;
use super::chain::{Chain as _, Motion};
use super::continuation;
use super::ends::Ends;
use super::framed::Framed;
use super::interpolation::Interpolation;
use super::iteration::{Effort, Iteration, Outcome};
use super::joined::Joined;
use super::low_cost::{self, Cheapest, Solution, unless_interrupted};
use super::parts;
use super::riemannian::SplineOptions;
use crate::cubic::work::TRIALS;
use crate::error::{Error, Result};
use crate::report::{SolverReport, StopReason};

/// Trials that many knots may take at least. With 120, and twice the work for both directions, 120 random knots of St(9, 7) are
/// refused after 2.7 s instead of 1.3.
pub(super) const TRIALS_IN_FRAMES: f64 = 60.0;

/// Work for both directions, in that for the first. With 1.5 two more of 101 splines through random knots on nine manifolds are
/// lost; with 2 random knots are refused after 2.4 s.
const BOTH_WAYS: f64 = 1.7;

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

    fn is_final(&self, effort: Effort<'_>) -> bool {
        let spent = self.iterations >= effort.max_iterations || effort.work.is_done();
        self.reason == StopReason::Converged || spent
    }
}

/// How the whole is started, one after the other.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
pub(super) enum Start {
    /// From the flat spline.
    Flat,
    /// From parts that are solved by themselves.
    Parts,
    /// From a relaxed chain of nodes.
    Relaxed,
    /// From easier splines.
    Continued,
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
    let chain = knots.chain(1.0)?;
    let work = options.work(TRIALS_IN_FRAMES, knots.len() as f64 * chain.work_of_leg());
    let effort = Effort::new(options, &work);
    let (start, first) = forwards(knots, &chain, ends, effort)?;
    if !low_cost::is_far(&knots.curves) {
        return Ok(first);
    }
    work.allow(BOTH_WAYS);
    let problem = Interpolation::new(&chain, ends)?;
    let mut best = Cheapest::new(&chain, first, effort.interrupt)?;
    if matches!(ends, Ends::Open(_)) && start < Start::Relaxed {
        let relaxed = knots.relaxed(&chain, &problem.start()?, ends, &work);
        best.try_start(&problem, unless_interrupted(relaxed)?.flatten(), effort)?;
    }
    let at_rest = relaxed_at_rest(knots, &problem, effort)?;
    best.try_start(&problem, at_rest, effort)?;
    // And backwards; what is relaxed from the flat spline is the same there.
    let (back, ends) = (knots.reversed()?, ends.reversed());
    let chain = back.chain(1.0)?;
    let backwards = Interpolation::new(&chain, &ends)?;
    let at_rest = relaxed_at_rest(&back, &backwards, effort)?;
    let found = [
        low_cost::solved(&backwards, backwards.start()?, effort)?,
        low_cost::near(&backwards, at_rest, effort)?,
    ];
    for solution in found {
        let start = low_cost::forwards(&chain, solution, &work)?;
        best.try_start(&problem, start, effort)?;
    }
    Ok(best.into_solution())
}

/// A chain relaxed from the spline that is at rest at its free ends; `None` if there is none.
fn relaxed_at_rest(
    knots: &Joined<'_>,
    problem: &Interpolation<'_, Framed<'_>>,
    effort: Effort<'_>,
) -> Result<Option<Motion>> {
    let Some(clamped) = low_cost::clamped(problem, effort)? else {
        return Ok(None);
    };
    let relaxed = knots.relaxed(problem.chain, &clamped, problem.ends, effort.work);
    Ok(unless_interrupted(relaxed)?.flatten())
}

/// The knots of a chain of few dimensions, in the direction of its times; and the last start that was tried.
///
/// # Errors
/// `Interrupted`, those of the chains.
pub(super) fn forwards(
    knots: &Joined<'_>,
    chain: &Framed<'_>,
    ends: &Ends,
    effort: Effort<'_>,
) -> Result<(Start, Solution)> {
    let problem = Interpolation::new(chain, ends)?;
    let flat = problem.start()?;
    let (mut iterations, mut least) = (0, f64::INFINITY);
    for start in [Start::Flat, Start::Parts, Start::Relaxed] {
        let motion = match start {
            Start::Flat => Ok(Some(flat.clone())),
            Start::Parts if parts::exist(knots.len(), ends) => {
                parts::solve(knots, chain, ends, effort)
            }
            Start::Relaxed if matches!(ends, Ends::Open(_)) => {
                knots.relaxed(chain, &flat, ends, effort.work)
            }
            _ => Ok(None),
        };
        let solved = motion.and_then(|motion| {
            let Some(mut motion) = motion else {
                return Ok(None);
            };
            let max_iterations = effort.max_iterations - iterations;
            let left = Effort {
                max_iterations,
                ..effort
            };
            let outcome = Iteration::solve(&problem, &mut motion, left)?;
            Ok(Some((motion, outcome)))
        });
        match solved {
            Err(error) if error.is_interrupted() => return Err(error),
            // A start that is too fast to be integrated is left to what follows.
            Err(_) | Ok(None) => {}
            Ok(Some((motion, mut outcome))) => {
                outcome.iterations += iterations;
                if outcome.is_final(effort) {
                    return Ok((start, (motion, outcome)));
                }
                iterations = outcome.iterations;
                least = least.min(outcome.residual);
            }
        }
    }
    let max_iterations = effort.max_iterations - iterations;
    let left = Effort {
        max_iterations,
        ..effort
    };
    let (motion, mut outcome) = continuation::solve(knots, ends, left, least)?;
    outcome.iterations += iterations;
    Ok((Start::Continued, (motion, outcome)))
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
    let work = options.work(TRIALS, problem.work_of_residual());
    let effort = Effort::new(options, &work);
    let outcome = Iteration::solve(&problem, &mut motion, effort)?;
    if !low_cost::is_far(chain.curves()) {
        return Ok((motion, outcome));
    }
    work.allow(BOTH_WAYS);
    let mut best = Cheapest::new(chain, (motion, outcome), effort.interrupt)?;
    let (back, ends) = (chain.reversed()?, ends.reversed());
    let backwards = Interpolation::new(&back, &ends)?;
    let solution = low_cost::solved(&backwards, backwards.start()?, effort)?;
    let start = low_cost::forwards(&back, solution, &work)?;
    best.try_start(&problem, start, effort)?;
    Ok(best.into_solution())
}
