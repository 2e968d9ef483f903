//! Where no step leads from the flat spline to the spline: along a family of chains whose legs grow from nothing.
//!
//! At the share `c` every leg is the part `c` of the way along the quasi-geodesic between its knots, and velocities and
//! accelerations at the ends are `c` times theirs. For small `c` space is flat on the scale of the legs, and the flat spline is
//! the solution up to `O(c^3)`.

use super::chain::Motion;
use super::ends::{End, Ends};
use super::joined::Joined;
use super::solvable::{Effort, Solution, Solvable, Start, unless_interrupted};
use crate::error::Result;
use crate::report::SolverReport;

/// The first share, and the largest step from one to the next.
const FIRST: f64 = 0.5;
const LARGEST_STEP: f64 = 0.25;

/// Smaller steps are given up.
const SMALLEST_STEP: f64 = 1.0 / 512.0;

/// Residual of the members of the family on the way.
const ON_THE_WAY: f64 = 1e-8;

/// Steps for each of them.
const STEPS: usize = 25;

/// The solution at share 1. Where the way there ends before, the residual is `known_residual`, of the best motion at share 1 so
/// far: what is left of a member on the way, and its tolerance, are of another problem.
///
/// # Errors
/// `Interrupted`, those of the chains.
pub(super) fn solve(
    knots: &Joined<'_>,
    ends: &Ends,
    effort: Effort<'_>,
    known_residual: f64,
) -> Result<Solution> {
    let mut known: Option<Known> = None;
    let mut before: Option<Known> = None;
    let (mut step, mut iterations) = (FIRST, 0);
    loop {
        let from = known.as_ref().map_or(0.0, |known| known.share);
        let share = (from + step).min(1.0);
        let last = share == 1.0;
        let (chain, scaled) = (knots.chain(share)?, ends.scaled(share));
        let start = match &known {
            None => Start::Flat,
            Some(known) => Start::From(known.predicted(before.as_ref(), share)),
        };
        let left = effort.max_iterations.saturating_sub(iterations);
        let on_the_way = Effort {
            tolerance: if last { effort.tolerance } else { ON_THE_WAY },
            max_iterations: STEPS.min(left),
            ..effort
        };
        let found = unless_interrupted(chain.solve(&scaled, start, on_the_way))?;
        iterations += match &found {
            Some(found) => found.report.iterations.max(1),
            None => 1,
        };
        match found {
            Some(mut found) if found.report.converged => {
                if last {
                    found.report.iterations = iterations;
                    return Ok(found);
                }
                let motion = found.motion;
                before = known.replace(Known { share, motion });
                step = (1.5 * step).min(LARGEST_STEP);
            }
            found => {
                if step < SMALLEST_STEP || effort.is_spent(iterations) {
                    let (residual, tolerance) = match &found {
                        Some(found) if last => (found.report.residual, found.report.tolerance),
                        _ => (known_residual, effort.tolerance),
                    };
                    let reason = effort.reason(iterations);
                    return Ok(Solution::none(SolverReport::new(
                        reason, iterations, residual, tolerance,
                    )));
                }
                step *= 0.4;
            }
        }
    }
}

/// A member of the family that is solved.
struct Known {
    share: f64,
    motion: Motion,
}

impl Known {
    /// By the line through the last two, or as much larger as the share.
    fn predicted(&self, before: Option<&Known>, share: f64) -> Motion {
        let mut motion = self.motion.clone();
        let (share_before, entries) = match before {
            Some(before) => (before.share, before.motion.entries.clone()),
            None => (0.0, vec![0.0; motion.entries.len()]),
        };
        let factor = (share - self.share) / (self.share - share_before);
        for (entry, before) in motion.entries.iter_mut().zip(entries) {
            *entry += factor * (*entry - before);
        }
        motion
    }
}

impl Ends {
    /// Velocities and accelerations times a factor.
    fn scaled(&self, factor: f64) -> Ends {
        let times = |v: &[f64]| v.iter().map(|v| factor * v).collect();
        match self {
            Ends::Periodic => Ends::Periodic,
            Ends::Open(ends) => Ends::Open(ends.each_ref().map(|end| match end {
                End::Velocity(v) => End::Velocity(times(v)),
                End::Acceleration(a) => End::Acceleration(times(a)),
            })),
        }
    }
}
