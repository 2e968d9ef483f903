//! Splines through knots far apart: the cheapest of several.
//!
//! Where legs are long the equations have many solutions, and the iteration from the flat spline leads to one that depends on
//! the direction in which the knots are passed. The same knots are solved from where descents end as well, or backwards where
//! there are none, and the solution of least cost is the spline: so it costs little, and the same in both directions.

use super::chain::{Arrivals, Chain};
use super::ends::{End, Ends};
use super::motion::Motion;
use super::solvable::{Effort, Solution, Solvable, Start, unless_interrupted};
use crate::cubic::taylor::Accuracy;
use crate::cubic::work::Work;
use crate::error::Result;
use crate::interrupt::Interrupt;

/// Legs longer than this are far apart. Of natural splines through five random knots the iteration alone leads to different
/// costs in the two directions for 6 of 60 on St(3,1) and 6 of 40 on St(4,2); the value itself is a guess, below the 1.5 from
/// which on that was seen.
const FAR: f64 = 1.4;

/// Two solutions whose costs differ by less are one: the first is kept.
const SAME_COST: f64 = 1e-3;

/// Vectors of an arrival: distance, velocity, acceleration and third vector.
const VECTORS: usize = 4;

/// Whether legs are so long that the cheapest of several solutions is worth looking for.
pub(super) fn is_far(longest: f64) -> bool {
    longest > FAR
}

/// The cheapest of some solutions, with its cost; solutions that have not converged cost infinitely much.
pub(super) struct Cheapest {
    solution: Solution,
    cost: f64,
}

impl Cheapest {
    /// # Errors
    /// Where a leg cannot be integrated; `Interrupted`.
    pub(super) fn new<C: Solvable>(
        chain: &C,
        solution: Solution,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let cost = match solution.report.converged {
            true => cost(chain, &solution, interrupt)?,
            false => f64::INFINITY,
        };
        Ok(Cheapest { solution, cost })
    }

    /// Solves from another start, if there is one, and keeps the cheaper solution.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(super) fn try_start<C: Solvable>(
        &mut self,
        chain: &C,
        ends: &Ends,
        start: Option<Motion>,
        effort: Effort<'_>,
    ) -> Result<()> {
        let Some(motion) = start else {
            return Ok(());
        };
        let Some(found) = solved(chain, ends, Start::Near(motion), effort)? else {
            return Ok(());
        };
        let other = Self::new(chain, found, effort.interrupt);
        if let Some(other) = unless_interrupted(other)?
            && other.cost < (1.0 - SAME_COST) * self.cost
        {
            *self = other;
        }
        Ok(())
    }

    pub(super) fn into_solution(self) -> Solution {
        self.solution
    }
}

/// The solution that a start leads to; `None` if it leads to none.
///
/// # Errors
/// `Interrupted`.
pub(super) fn solved<C: Solvable>(
    chain: &C,
    ends: &Ends,
    start: Start,
    effort: Effort<'_>,
) -> Result<Option<Solution>> {
    let solution = unless_interrupted(chain.solve(ends, start, effort))?;
    Ok(solution.filter(|solution| solution.report.converged))
}

/// A solution of the knots passed backwards in forward direction; `None` if it cannot be integrated.
///
/// # Errors
/// `Interrupted`.
pub(super) fn forwards<C: Chain>(
    back: &C,
    solution: &Solution,
    work: &Work,
) -> Result<Option<Motion>> {
    unless_interrupted(reversed(back, &solution.motion, work))
}

/// A motion along the knots of a chain, passed backwards.
fn reversed<C: Chain>(back: &C, motion: &Motion, work: &Work) -> Result<Motion> {
    let (size, legs) = (back.size(), back.lengths().len());
    let arrivals = Arrivals::of(back, motion, VECTORS, Accuracy::FULL, work)?;
    let mut out = Motion::zeros(size, legs + 1);
    for knot in 0..=legs {
        let from = motion.velocity(legs - knot);
        for (to, v) in out.velocity_mut(knot).iter_mut().zip(from) {
            *to = -v;
        }
    }
    for leg in 0..legs {
        let (acceleration, third) = out.bend_mut(leg).split_at_mut(size);
        acceleration.copy_from_slice(arrivals.vector(legs - 1 - leg, 2));
        for (to, v) in third.iter_mut().zip(arrivals.vector(legs - 1 - leg, 3)) {
            *to = -v;
        }
    }
    Ok(out)
}

/// `int |D_t S'|^2 dt` in units of time.
fn cost<C: Solvable>(chain: &C, solution: &Solution, interrupt: Interrupt<'_>) -> Result<f64> {
    let mut sum = 0.0;
    for (leg, h) in chain.lengths().iter().enumerate() {
        let (_, path) = chain.piece(leg, solution, interrupt)?;
        sum += path.cost(0.0, 1.0) / h.powi(3);
    }
    Ok(sum)
}

impl Ends {
    /// The same ends, passed backwards.
    pub(super) fn reversed(&self) -> Self {
        let reversed = |end: &End| match end {
            End::Velocity(v) => End::Velocity(v.iter().map(|v| -v).collect()),
            End::Acceleration(a) => End::Acceleration(a.clone()),
        };
        match self {
            Ends::Periodic => Ends::Periodic,
            Ends::Open([first, last]) => Ends::Open([reversed(last), reversed(first)]),
        }
    }
}
