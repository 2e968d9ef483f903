//! Where no step leads from the flat spline to the spline: along a family of chains whose legs grow from nothing.
//!
//! At the share `c` every leg is the part `c` of the way along the quasi-geodesic between its knots, and velocities and
//! accelerations at the ends are `c` times theirs. For small `c` space is flat on the scale of the legs, and the flat spline is
//! the solution up to `O(c^3)`.

use super::chain::Motion;
use super::ends::{End, Ends};
use super::interpolation::Interpolation;
use super::iteration::{Effort, Iteration, Outcome};
use super::joined::Joined;
use crate::error::Result;
use crate::report::StopReason;

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
) -> Result<(Motion, Outcome)> {
    let mut known: Option<Known> = None;
    let mut before: Option<Known> = None;
    let (mut step, mut iterations) = (FIRST, 0);
    loop {
        let from = known.as_ref().map_or(0.0, |known| known.share);
        let share = (from + step).min(1.0);
        let last = share == 1.0;
        let (chain, scaled) = (knots.chain(share)?, ends.scaled(share));
        let problem = Interpolation::new(&chain, &scaled)?;
        let mut motion = match &known {
            None => problem.start()?,
            Some(known) => known.predicted(before.as_ref(), share),
        };
        let goal = if last { effort.tolerance } else { ON_THE_WAY };
        let left = effort.max_iterations.saturating_sub(iterations);
        let on_the_way = Effort {
            tolerance: goal,
            max_iterations: STEPS.min(left),
            ..effort
        };
        let outcome = match Iteration::solve(&problem, &mut motion, on_the_way) {
            Err(error) if error.is_interrupted() => return Err(error),
            other => other.ok(),
        };
        iterations += outcome
            .as_ref()
            .map_or(1, |outcome| outcome.iterations.max(1));
        let solved = outcome
            .as_ref()
            .is_some_and(|o| o.reason == StopReason::Converged);
        let (residual, reached) = match outcome {
            Some(outcome) if last => (outcome.residual, outcome.tolerance),
            _ => (known_residual, effort.tolerance),
        };
        let spent = iterations >= effort.max_iterations || effort.work.is_done();
        let gave_up = step < SMALLEST_STEP || spent;
        if (solved && last) || (!solved && gave_up) {
            let reason = match solved {
                true => StopReason::Converged,
                false if effort.work.is_done() => StopReason::WorkLimit,
                false if spent => StopReason::MaxIterations,
                false => StopReason::Stagnated,
            };
            return Ok((
                motion,
                Outcome {
                    reason,
                    iterations,
                    residual,
                    tolerance: reached,
                },
            ));
        }
        if solved {
            before = known.replace(Known { share, motion });
            step = (1.5 * step).min(LARGEST_STEP);
        } else {
            step *= 0.4;
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
