//! Splines through knots that are distant or at very uneven times: the cheapest of several solutions.
//!
//! If legs are long or fast, the equations have many solutions, and the one found from the flat spline depends on the
//! direction in which the knots are passed. Solutions are therefore also sought near the ends of descents, and the one of
//! least cost is returned. Its cost is low, and the same in both directions.

use super::chain::Chain;
use super::framed::Framed;
use super::motion::Motion;
use super::solution::{ChainSolution, piece};
use crate::error::{Result, unless_interrupted};
use crate::interrupt::Interrupt;
use crate::spline::ends::{Ends, gives_velocity};

/// Leg length above which knots count as distant. Of 400 natural splines through eight points whose neighbours are all
/// between 0.1 less and a distance apart, at intervals that differ by a factor of up to three, some cost more if no
/// other solutions are sought, mostly 1.5 to 3 times as much:
///
/// | distance | 1.4 | 1.5 | 1.6 | 1.7 | 1.9 | 2.1 |
/// |---|---|---|---|---|---|---|
/// | St(3,1) | 1 | 4 | 10 | 19 | 63 | 74 |
/// | rotations | 0 | 0 | 1 | 1 | 6 | 11 |
/// | St(4,2), of 100 | 0 | 0 | 0 | 0 | 1 | 3 |
///
/// The search takes three to nine times as long as the first solution.
const FAR: f64 = 1.4;

/// Speed in the time of a leg above which a solution may be far from the cheapest one, though its knots are near:
/// where lengths of legs differ much. Of 1220 natural and periodic splines through 5 to 100 rotations up to 1.2 apart,
/// with legs whose lengths differ by up to a factor of 3 to 100, 118 cost up to 6.3 times as much if no others are
/// sought, all but one of them faster than this. Up to a factor of 3 none is faster than 3.5, also of 10000 legs; the
/// search takes 20 to 28 times as long as the first solution.
pub(crate) const FAST: f64 = 5.0;

/// Solutions whose costs differ by a smaller relative amount count as one: the first is kept.
const SAME_COST: f64 = 1e-3;

/// Whether legs are so long that several solutions should be compared.
pub(crate) fn is_far(longest: f64) -> bool {
    longest > FAR
}

/// Whether a solution is so fast that others should be sought: not if velocities are given, which make legs fast by
/// themselves.
pub(crate) fn is_fast(ends: &Ends, motion: &Motion, lengths: &[f64]) -> bool {
    !gives_velocity(ends) && motion.speed(0..lengths.len() + 1, lengths) > FAST
}

/// The cheapest of several solutions, with its cost; unconverged solutions have infinite cost.
pub(crate) struct Cheapest {
    solution: ChainSolution,
    cost: f64,
}

impl Cheapest {
    /// # Errors
    /// An error if a leg cannot be integrated; `Interrupted`.
    pub(crate) fn new(
        chain: &Framed<'_>,
        solution: ChainSolution,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let cost = match solution.report.converged {
            true => cost(chain, &solution, interrupt)?,
            false => f64::INFINITY,
        };
        Ok(Cheapest { solution, cost })
    }

    /// Keeps the cheaper one of this and another solution; of two that are not converged the first one with a residual.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn compare(
        &mut self,
        chain: &Framed<'_>,
        other: ChainSolution,
        interrupt: Interrupt<'_>,
    ) -> Result<()> {
        let other = Self::new(chain, other, interrupt);
        if let Some(other) = unless_interrupted(other)?
            && (other.cost < (1.0 - SAME_COST) * self.cost || self.has_no_residual())
        {
            *self = other;
        }
        Ok(())
    }

    fn has_no_residual(&self) -> bool {
        self.solution.report.residual.is_infinite()
    }

    pub(crate) fn into_solution(self) -> ChainSolution {
        self.solution
    }
}

/// `int |D_t S'|^2 + tau |S'|^2 dt` in units of time.
///
/// # Errors
/// An error if a leg cannot be integrated; `Interrupted`.
pub(crate) fn cost(
    chain: &impl Chain,
    solution: &ChainSolution,
    interrupt: Interrupt<'_>,
) -> Result<f64> {
    let mut sum = 0.0;
    for (leg, h) in chain.lengths().iter().enumerate() {
        let (_, taylor) = piece(chain, leg, solution, interrupt)?;
        sum += taylor.cost(0.0, 1.0) / h.powi(3);
    }
    Ok(sum)
}
