//! The spline at the end of a descent: its short legs, integrated and put together between the knots.

use std::sync::Arc;

use faer::Mat;

use super::chain::Chain as _;
use super::framed::Framed;
use super::motion::Motion;
use super::solution::{ChainSolution, Effort, SolvedLegs};
use crate::cubic::boundary::short_legs::ShortLegs;
use crate::cubic::taylor::piecewise_taylor::PiecewiseTaylor;
use crate::cubic::taylor::work::work_of_step;
use crate::error::{Result, unless_interrupted};
use crate::interrupt::Interrupt;
use crate::linalg::field::larger;
use crate::report::{SolverReport, StopReason};
use crate::shooting::LeastCost;
use crate::threads::{self, scaled};

/// Microseconds of integrating a leg between rotations.
const LEG: f64 = 10.0;

/// Largest differences of points, velocities and accelerations where short legs meet. Integrated from their first knots they
/// amplify round-off, most in tension: with 1e-12 for accelerations too, and not relative to these, splines in tension
/// between rotations at uneven times are lost, and others are found that cost 1.2 to 1.7 times as much.
const JOINED: [f64; 3] = [1e-12, 1e-12, 1e-11];

/// The spline of a chain at rest whose knots with the indices `at` are those of the spline; not converged if its legs, as
/// they are integrated, do not meet.
///
/// # Errors
/// `Interrupted`.
pub(crate) fn solution(
    chain: &Framed<'_>,
    at: &[usize],
    found: &LeastCost,
    effort: Effort<'_>,
) -> Result<ChainSolution> {
    let legs = SplineLegs { chain, at, found };
    let micros = scaled(LEG, chain.frames()[0].shape());
    let all = threads::map(
        at.len() - 1,
        micros,
        || (),
        |(), leg| Ok(legs.together(leg, effort.interrupt)),
    )?;
    let (mut curves, mut gap) = (Vec::with_capacity(all.len()), 0.0);
    for one in all {
        let Some((curve, between)) = unless_interrupted(one)? else {
            return Ok(ChainSolution::unsolved(effort));
        };
        effort
            .work
            .count(curve.len() as f64 * work_of_step(chain.blocks()));
        gap = larger(gap, between);
        curves.push(curve);
    }
    if gap.is_nan() || gap > 1.0 {
        let SolverReport {
            iterations,
            tolerance,
            ..
        } = found.report;
        let residual = if gap.is_nan() {
            f64::INFINITY
        } else {
            JOINED[0] * gap
        };
        let report = SolverReport::new(StopReason::Stagnated, iterations, residual, tolerance);
        return Ok(ChainSolution::none(report));
    }
    Ok(ChainSolution {
        motion: legs.motion(),
        report: found.report,
        legs: Some(SolvedLegs {
            polynomials: None,
            turns: None,
            piece: Arc::new(move |leg| Some((None, curves[leg].clone().into()))),
        }),
    })
}

/// The legs of a chain between the knots of a spline.
struct SplineLegs<'a> {
    chain: &'a Framed<'a>,
    at: &'a [usize],
    found: &'a LeastCost,
}

impl SplineLegs<'_> {
    /// The curve of a leg of the spline, and the largest difference where short legs meet, relative to [`JOINED`].
    ///
    /// # Errors
    /// An error if it cannot be integrated; `Interrupted`.
    fn together(&self, leg: usize, interrupt: Interrupt<'_>) -> Result<(PiecewiseTaylor, f64)> {
        let state = |frame: &Mat<f64>, vectors: &[f64]| self.chain.state_in(frame, leg, vectors);
        let legs = ShortLegs {
            chain: self.found,
            between: [self.at[leg], self.at[leg + 1]],
            h: self.chain.lengths()[leg],
            state: &state,
        };
        let (curve, gaps) = legs.together(interrupt)?;
        let gaps = gaps.iter().zip(JOINED);
        Ok((
            curve,
            gaps.fold(0.0, |most, (gap, size)| larger(most, gap / size)),
        ))
    }

    /// The motion between the knots of the spline.
    fn motion(&self) -> Motion {
        let d = self.chain.size();
        let mut motion = Motion::zeros(d, self.at.len());
        for (knot, at) in self.at.iter().enumerate() {
            let vectors = self.found.vectors(*at, 1.0);
            motion.velocity_mut(knot).copy_from_slice(&vectors[..d]);
        }
        for (leg, h) in self.chain.lengths().iter().enumerate() {
            let vectors = self.found.vectors(self.at[leg], *h);
            motion.derivatives_mut(leg).copy_from_slice(&vectors[d..]);
        }
        motion
    }
}
