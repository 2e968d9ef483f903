//! From the flat spline to the spline: at once, from parts of it, from a relaxed chain of nodes, or along a family of easier
//! splines.

use super::ambient::Ambient;
use super::chain::{Chain as _, Motion};
use super::continuation;
use super::ends::Ends;
use super::framed::Framed;
use super::interpolation::Interpolation;
use super::joined::Joined;
use super::low_cost::{self, Cheapest, unless_interrupted};
use super::parts;
use super::riemannian::SplineOptions;
use super::solvable::{Effort, Solution, Solvable, Start};
use crate::cubic::work::TRIALS;
use crate::error::Result;

/// Trials that many knots may take at least. With 120, and twice the work for both directions, 120 random knots of St(9, 7) are
/// refused after 2.7 s instead of 1.3.
pub(super) const TRIALS_IN_FRAMES: f64 = 60.0;

/// Work for both directions, in that for the first. With 1.5 two more of 101 splines through random knots on nine manifolds are
/// lost; with 2 random knots are refused after 2.4 s.
const BOTH_WAYS: f64 = 1.7;

/// How the whole is started, one after the other.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
pub(super) enum Stage {
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
    chain: &Framed<'_>,
    ends: &Ends,
    options: &SplineOptions<'_>,
) -> Result<Solution> {
    let work = options.work(TRIALS_IN_FRAMES, knots.len() as f64 * chain.work_of_leg());
    let effort = Effort::new(options, &work);
    let (stage, first) = forwards(knots, chain, ends, effort)?;
    if !low_cost::is_far(chain.longest()) {
        return Ok(first);
    }
    work.allow(BOTH_WAYS);
    let mut best = Cheapest::new(chain, first, effort.interrupt)?;
    if matches!(ends, Ends::Open(_)) && stage < Stage::Relaxed {
        let relaxed = knots.relaxed(chain, &flat(chain, ends)?, ends, &work);
        best.try_start(chain, ends, unless_interrupted(relaxed)?.flatten(), effort)?;
    }
    let at_rest = relaxed_at_rest(knots, chain, ends, effort)?;
    best.try_start(chain, ends, at_rest, effort)?;
    // And backwards; what is relaxed from the flat spline is the same there.
    let (back, reversed) = (knots.reversed(), ends.reversed());
    let backwards = back.chain(1.0)?;
    let at_rest = relaxed_at_rest(&back, &backwards, &reversed, effort)?;
    let found = [
        low_cost::solved(&backwards, &reversed, Start::Flat, effort)?,
        match at_rest {
            Some(motion) => low_cost::solved(&backwards, &reversed, Start::Near(motion), effort)?,
            None => None,
        },
    ];
    for solution in found.into_iter().flatten() {
        let motion = low_cost::forwards(&backwards, &solution, &work)?;
        best.try_start(chain, ends, motion, effort)?;
    }
    Ok(best.into_solution())
}

/// The spline of flat space.
fn flat(chain: &Framed<'_>, ends: &Ends) -> Result<Motion> {
    Interpolation::new(chain, ends)?.start()
}

/// A chain relaxed from the spline that is at rest at its free ends; `None` if there is none.
fn relaxed_at_rest(
    knots: &Joined<'_>,
    chain: &Framed<'_>,
    ends: &Ends,
    effort: Effort<'_>,
) -> Result<Option<Motion>> {
    let Some(clamped) = low_cost::clamped(chain, ends, effort)? else {
        return Ok(None);
    };
    let relaxed = knots.relaxed(chain, &clamped, ends, effort.work);
    Ok(unless_interrupted(relaxed)?.flatten())
}

/// The knots of a chain of few dimensions, in the direction of its times; and the last stage that was tried.
///
/// # Errors
/// `Interrupted`, those of the chains.
pub(super) fn forwards(
    knots: &Joined<'_>,
    chain: &Framed<'_>,
    ends: &Ends,
    effort: Effort<'_>,
) -> Result<(Stage, Solution)> {
    let (mut iterations, mut least) = (0, f64::INFINITY);
    for stage in [Stage::Flat, Stage::Parts, Stage::Relaxed] {
        let start = match stage {
            Stage::Flat => Ok(Some(Start::Flat)),
            Stage::Parts if parts::exist(knots.len(), ends) => {
                parts::solve(knots, chain, ends, effort).map(|motion| motion.map(Start::From))
            }
            Stage::Relaxed if matches!(ends, Ends::Open(_)) => {
                let motion = knots.relaxed(chain, &flat(chain, ends)?, ends, effort.work);
                motion.map(|motion| motion.map(Start::From))
            }
            _ => Ok(None),
        };
        let left = effort.after(iterations);
        let solved = start.and_then(|start| match start {
            Some(start) => chain.solve(ends, start, left).map(Some),
            None => Ok(None),
        });
        // A start that is too fast to be integrated is left to what follows.
        let Some(mut solution) = unless_interrupted(solved)?.flatten() else {
            continue;
        };
        solution.report.iterations += iterations;
        iterations = solution.report.iterations;
        if solution.report.converged || effort.is_spent(iterations) {
            return Ok((stage, solution));
        }
        least = least.min(solution.report.residual);
    }
    let mut solution = continuation::solve(knots, ends, effort.after(iterations), least)?;
    solution.report.iterations += iterations;
    Ok((Stage::Continued, solution))
}

/// A chain of many dimensions; where its knots are far apart, the cheaper of the solutions in both directions.
///
/// # Errors
/// `Interrupted`; where the start cannot be integrated.
pub(super) fn in_ambient(
    chain: &Ambient<'_>,
    ends: &Ends,
    options: &SplineOptions<'_>,
) -> Result<Solution> {
    let work = options.work(TRIALS, chain.lengths().len() as f64 * chain.work_of_leg());
    let effort = Effort::new(options, &work);
    let first = chain.solve(ends, Start::Flat, effort)?;
    if !low_cost::is_far(chain.longest()) {
        return Ok(first);
    }
    work.allow(BOTH_WAYS);
    let mut best = Cheapest::new(chain, first, effort.interrupt)?;
    let (back, reversed) = (chain.reversed()?, ends.reversed());
    if let Some(solution) = low_cost::solved(&back, &reversed, Start::Flat, effort)? {
        let motion = low_cost::forwards(&back, &solution, &work)?;
        best.try_start(chain, ends, motion, effort)?;
    }
    Ok(best.into_solution())
}
