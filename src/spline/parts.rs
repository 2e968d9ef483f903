//! Long chains: parts of them by themselves, as starts of the whole.
//!
//! What happens at a knot reaches the `j`-th one from it by a factor of about `(2 - sqrt(3))^j`, as for splines of flat space.
//! So a few legs around a part make it what it is in the whole, and a part whose legs are hard to solve does not hold up
//! others.

use rayon::prelude::*;

use super::chain::{Chain, Motion};
use super::ends::{End, Ends};
use super::framed::Framed;
use super::joined::Joined;
use super::solvable::Effort;
use super::stages::{self, TRIALS_IN_FRAMES};
use crate::cubic::work::Work;
use crate::error::Result;

/// Legs of a part.
const CENTRAL: usize = 24;

/// Of the limit of work for a part. With all of it 120 random knots on St(8, 4) are refused after 3.2 s instead of 1.9; of 101
/// splines through random knots none is lost.
const SHARE: f64 = 1.0 / 16.0;

/// Legs that are solved with it on either side: what is beyond them counts by 3e-5.
const MARGIN: usize = 8;

/// Whether there is more than one part, or a part that is no closed chain.
pub(super) fn exist(legs: usize, ends: &Ends) -> bool {
    matches!(ends, Ends::Periodic) || legs > CENTRAL + 2 * MARGIN
}

/// The motion of the parts; none where one of them is not solved.
///
/// # Errors
/// `Interrupted`, those of the chains.
pub(super) fn solve(
    knots: &Joined<'_>,
    chain: &Framed<'_>,
    ends: &Ends,
    effort: Effort<'_>,
) -> Result<Option<Motion>> {
    let legs = knots.len();
    let parts: Vec<Part> = (0..legs)
        .step_by(CENTRAL)
        .map(|first| Part::new(first, legs, ends))
        .collect();
    let size = chain.size();
    let (tolerance, max_iterations) = (effort.tolerance, effort.max_iterations);
    let interrupt = effort.interrupt;
    // Each has a limit of its own: what parts take says nothing of the whole, which starts near its solution.
    let solve = |part: &Part| {
        let work = Work::of_trials(
            TRIALS_IN_FRAMES,
            part.legs_around() as f64 * chain.work_of_leg(),
        );
        work.allow(SHARE);
        let effort = Effort {
            tolerance,
            max_iterations,
            work: &work,
            interrupt,
        };
        // One that is not solved ends the others.
        part.solve(knots, ends, size, effort)
            .map_err(Some)?
            .ok_or(None)
    };
    let solved: Vec<Motion> = match parts.par_iter().map(solve).collect() {
        Ok(solved) => solved,
        Err(Some(error)) => return Err(error),
        Err(None) => return Ok(None),
    };
    let mut whole = Motion::zeros(size, legs + 1);
    for (part, motion) in parts.iter().zip(solved) {
        part.write(&motion, &mut whole);
    }
    if let Ends::Periodic = ends {
        let first = whole.velocity(0).to_vec();
        whole.velocity_mut(legs).copy_from_slice(&first);
    }
    Ok(Some(whole))
}

/// Legs in a row, and legs on either side.
struct Part {
    first: usize,
    count: usize,
    before: usize,
    after: usize,
    /// Legs of the whole chain.
    legs: usize,
}

impl Part {
    fn new(first: usize, legs: usize, ends: &Ends) -> Self {
        let count = CENTRAL.min(legs - first);
        let [before, after] = match ends {
            Ends::Periodic => [MARGIN; 2],
            Ends::Open(_) => [first, legs - first - count].map(|there| there.min(MARGIN)),
        };
        Part {
            first,
            count,
            before,
            after,
            legs,
        }
    }

    /// Legs of the part and on either side.
    fn legs_around(&self) -> usize {
        self.before + self.count + self.after
    }

    fn solve(
        &self,
        knots: &Joined<'_>,
        ends: &Ends,
        size: usize,
        effort: Effort<'_>,
    ) -> Result<Option<Motion>> {
        let free = || End::Acceleration(vec![0.0; size]);
        let (begins, stops) = (
            self.first == self.before,
            self.first + self.count + self.after == self.legs,
        );
        let ends = match ends {
            Ends::Periodic => [free(), free()],
            Ends::Open([first, last]) => [
                if begins { first.clone() } else { free() },
                if stops { last.clone() } else { free() },
            ],
        };
        let around = self.legs_around();
        let start = (self.first + self.legs * self.before - self.before) % self.legs;
        let part = knots.part(start, around);
        // A part has no parts.
        let none = || Ok(None);
        let (chain, ends) = (part.chain(1.0)?, Ends::Open(ends));
        let (_, solution) = stages::solve(&part, &chain, &ends, effort, none)?;
        Ok(solution.report.converged.then_some(solution.motion))
    }

    fn write(&self, from: &Motion, to: &mut Motion) {
        for i in 0..self.count {
            let (here, there) = (self.before + i, self.first + i);
            to.velocity_mut(there).copy_from_slice(from.velocity(here));
            to.bend_mut(there).copy_from_slice(from.bend(here));
        }
        if self.first + self.count == self.legs {
            let last = from.velocity(self.before + self.count);
            to.velocity_mut(self.legs).copy_from_slice(last);
        }
    }
}
