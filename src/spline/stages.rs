//! From the flat spline to the spline: at once, from parts of it, from a relaxed chain of nodes, or along a family of easier
//! splines.

use super::chain::Motion;
use super::continuation;
use super::ends::Ends;
use super::framed::Framed;
use super::interpolation::Interpolation;
use super::joined::Joined;
use super::solvable::{Effort, Solution, Solvable as _, Start, unless_interrupted};
use crate::error::Result;

/// Trials that many knots may take at least. With 120, and twice the work for both directions, 120 random knots of St(9, 7) are
/// refused after 2.7 s instead of 1.3.
pub(super) const TRIALS_IN_FRAMES: f64 = 60.0;

/// How a chain is started, one after the other.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
pub(super) enum Stage {
    /// From the flat spline.
    Flat,
    /// From parts that are solved by themselves, where there are any.
    Parts,
    /// From a relaxed chain of nodes.
    Relaxed,
    /// From easier splines.
    Continued,
}

/// The spline of flat space.
pub(super) fn flat(chain: &Framed<'_>, ends: &Ends) -> Result<Motion> {
    Interpolation::new(chain, ends)?.start()
}

/// The knots of a chain of few dimensions, in the direction of its times; and the last stage that was tried. Its motion from
/// parts is `of_parts`, none where there are none or one of them is not solved.
///
/// # Errors
/// `Interrupted`, those of the chains.
pub(super) fn solve(
    knots: &Joined<'_>,
    chain: &Framed<'_>,
    ends: &Ends,
    effort: Effort<'_>,
    of_parts: impl Fn() -> Result<Option<Motion>>,
) -> Result<(Stage, Solution)> {
    let (mut iterations, mut least) = (0, f64::INFINITY);
    for stage in [Stage::Flat, Stage::Parts, Stage::Relaxed] {
        let start = match stage {
            Stage::Flat => Ok(Some(Start::Flat)),
            Stage::Parts => of_parts().map(|motion| motion.map(Start::From)),
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
