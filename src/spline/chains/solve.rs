//! The spline of a chain: from a single start or, if its knots are distant or its legs fast, the cheapest from several.

use super::ambient::Ambient;
use super::chain::Chain as _;
use super::descent;
use super::embedded::InEmbedding as _;
use super::framed::{Framed, work_of_leg};
use super::low_cost::{self, Cheapest};
use super::solution::{ChainSolution, Effort};
use crate::cubic::taylor::blocks::Sizes;
use crate::cubic::taylor::work::{TRIALS, Work};
use crate::error::{Result, unless_interrupted};
use crate::interrupt::Interrupt;
use crate::manifold::only_bases::Appearance;
use crate::report::{StopReason, Strategy};
use crate::spline::ends::Ends;
use crate::spline::options::SplineOptions;

pub(crate) const SOLVER: &str = "spline of Riemannian cubics";

/// Minimal number of trials allowed for many knots in few dimensions. With 60, a spline through 40 points of St(20,5)
/// is not solved.
const TRIALS_IN_FRAMES: f64 = 120.0;

/// Work limit of all solutions together, in units of the first one's. With 1, one more of 78 splines with given
/// accelerations and uneven times is not solved.
const FURTHER: f64 = 1.7;

/// Solves a chain in few dimensions: from the flat spline and, if its knots are distant, its legs fast, or that fails, from
/// the results of descents. Returns the cheapest solution.
///
/// # Errors
/// `Interrupted`, and the errors of the chain.
pub(crate) fn in_frames(
    chain: &Framed<'_>,
    ends: &Ends,
    options: &SplineOptions,
    interrupt: Interrupt<'_>,
) -> Result<ChainSolution> {
    let work = work_in_frames(chain, options);
    cheapest(chain, ends, Effort::new(options, &work, interrupt), FURTHER)
}

/// The same within given work, whose limit is multiplied by `further` after the first solution.
///
/// # Errors
/// As [`in_frames`].
pub(crate) fn cheapest(
    chain: &Framed<'_>,
    ends: &Ends,
    effort: Effort<'_>,
    further: f64,
) -> Result<ChainSolution> {
    let work = effort.work;
    // A start that fails is left to descents.
    let first = unless_interrupted(chain.solve(ends, effort))?;
    let first = first.unwrap_or_else(|| ChainSolution::unsolved(effort));
    let first = first.found_by(Strategy::Direct);
    let is_clear = first.report.converged
        && !low_cost::is_far(chain.longest())
        && !low_cost::is_fast(ends, &first.motion, chain.lengths());
    if is_clear || effort.is_spent(first.report.iterations) {
        return Ok(first);
    }
    work.allow(further);
    let mut best = Cheapest::new(chain, first, effort.interrupt)?;
    for course in descent::starts(chain, ends)? {
        if work.is_done() {
            break;
        }
        let found = course.end(chain, ends, effort)?;
        best.compare(chain, found.found_by(Strategy::Descent), effort.interrupt)?;
    }
    let mut solution = best.into_solution();
    if !solution.report.converged && work.is_done() {
        solution.report.reason = StopReason::WorkLimit;
    }
    Ok(solution)
}

/// The work limit of a chain in few dimensions.
fn work_in_frames(chain: &Framed<'_>, options: &SplineOptions) -> Work {
    work_of_legs(chain.lengths().len(), chain.blocks(), options)
}

/// The same for a number of legs.
pub(crate) fn work_of_legs(legs: usize, blocks: Sizes, options: &SplineOptions) -> Work {
    let trial = legs as f64 * work_of_leg(legs, blocks);
    options.work(TRIALS_IN_FRAMES, trial, Appearance::Usual)
}

/// Solves a chain in many dimensions.
///
/// If its knots are distant, the solution need not be the cheapest.
///
/// # Errors
/// `Interrupted`, `Overflow` (times that differ too much).
pub(crate) fn in_ambient(
    chain: &Ambient<'_>,
    ends: &Ends,
    points: Appearance,
    options: &SplineOptions,
    interrupt: Interrupt<'_>,
) -> Result<ChainSolution> {
    let trial = chain.lengths().len() as f64 * chain.work_of_leg();
    let work = options.work(TRIALS, trial, points);
    let solution = chain.in_embedding(ends, Effort::new(options, &work, interrupt))?;
    Ok(solution.found_by(Strategy::Direct))
}
