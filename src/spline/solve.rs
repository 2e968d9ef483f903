//! The spline of a chain: from one start, or, where its knots are far apart, the cheapest from several.

use super::ambient::Ambient;
use super::chain::{Chain as _, Motion};
use super::ends::Ends;
use super::framed::Framed;
use super::joined::Joined;
use super::low_cost::{self, Cheapest};
use super::options::SplineOptions;
use super::parts;
use super::solvable::{Effort, Solution, Solvable, Start, unless_interrupted};
use super::stages::{self, Stage, TRIALS_IN_FRAMES, flat};
use crate::cubic::work::TRIALS;
use crate::error::Result;

/// Work for both directions, in that for the first. With 1.5 two more of 101 splines through random knots on nine manifolds are
/// lost; with 2 random knots are refused after 2.4 s.
const BOTH_WAYS: f64 = 1.7;

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
    let of_parts = || match parts::exist(knots.len(), ends) {
        true => parts::solve(knots, chain, ends, effort),
        false => Ok(None),
    };
    let (stage, first) = stages::solve(knots, chain, ends, effort, of_parts)?;
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
