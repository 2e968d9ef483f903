//! The spline at the end of a descent: its short legs, integrated and put together between the knots.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::chain::Chain as _;
use super::framed::Framed;
use super::motion::Motion;
use super::solution::{ChainSolution, Effort, SolvedLegs};
use crate::cubic::taylor::march::Accuracy;
use crate::cubic::taylor::piecewise_taylor::PiecewiseTaylor;
use crate::cubic::taylor::state::State;
use crate::cubic::taylor::work::work_of_step;
use crate::error::{Result, unless_interrupted};
use crate::interrupt::Interrupt;
use crate::linalg::field::larger;
use crate::manifold::grassmann::alignment::alignment;
use crate::shooting::LeastCost;
use crate::space::Quotient;
use crate::threads::{self, scaled};

/// Microseconds of integrating a leg between rotations.
const LEG: f64 = 10.0;

/// Integration accuracy of the curves of a start.
const ROUGH: f64 = 1e-6;

/// The curve of a leg of a motion, roughly, in the frame at its start.
///
/// # Errors
/// An error if it cannot be integrated; `Interrupted`.
pub(crate) fn roughly_integrated(
    chain: &Framed<'_>,
    leg: usize,
    motion: &Motion,
    interrupt: Interrupt<'_>,
) -> Result<PiecewiseTaylor> {
    let (r, h) = (chain.frames()[leg].nrows(), chain.lengths()[leg]);
    let state = chain.state_in(&Mat::identity(r, r), leg, &motion.start(leg, h));
    let mut taylor = PiecewiseTaylor::at(state, Accuracy::of_tolerance(ROUGH));
    taylor.extend_to(1.0, interrupt)?;
    Ok(taylor)
}

/// The spline of a chain at rest whose knots with the indices `at` are those of the spline; `None` if its legs, as they are
/// integrated, do not meet.
///
/// # Errors
/// `Interrupted`.
pub(crate) fn solution(
    chain: &Framed<'_>,
    at: &[usize],
    found: &LeastCost,
    effort: Effort<'_>,
) -> Result<Option<ChainSolution>> {
    let legs = ShortLegs { chain, at, found };
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
            return Ok(None);
        };
        effort
            .work
            .count(curve.len() as f64 * work_of_step(chain.blocks()));
        gap = larger(gap, between);
        curves.push(curve);
    }
    if gap.is_nan() || gap > effort.tolerance {
        return Ok(None);
    }
    Ok(Some(ChainSolution {
        motion: legs.motion(),
        report: found.report,
        legs: Some(SolvedLegs {
            polynomials: None,
            turns: None,
            piece: Arc::new(move |leg| Some((None, curves[leg].clone().into()))),
        }),
    }))
}

/// The legs of a chain between the knots of a spline.
struct ShortLegs<'a> {
    chain: &'a Framed<'a>,
    at: &'a [usize],
    found: &'a LeastCost,
}

impl ShortLegs<'_> {
    /// The curve of a leg of the spline, and the largest distance between the end of a short leg and the next knot.
    ///
    /// # Errors
    /// An error if it cannot be integrated; `Interrupted`.
    fn together(&self, leg: usize, interrupt: Interrupt<'_>) -> Result<(PiecewiseTaylor, f64)> {
        let (mut curve, mut gap) = (self.short(leg, 0, interrupt)?, 0.0);
        for part in 1..self.parts(leg) {
            let mut next = self.short(leg, part, interrupt)?;
            if let Some(turn) = self.turn(&curve.last, &next.first)? {
                next = next.in_terms_of(turn.as_ref());
            }
            gap = larger(gap, distance(&curve.last, &next.first));
            curve = curve.followed_by(next);
        }
        let d = self.chain.size();
        let knot = self
            .chain
            .state_in(&self.chain.frames()[leg + 1], leg, &vec![0.0; 3 * d]);
        let away = match self.turn(&curve.last, &knot)? {
            Some(turn) => (point(&knot) * turn - point(&curve.last)).norm_l2(),
            None => distance(&curve.last, &knot),
        };
        Ok((curve, larger(gap, away)))
    }

    fn parts(&self, leg: usize) -> usize {
        self.at[leg + 1] - self.at[leg]
    }

    /// A short leg, integrated from its first knot.
    fn short(&self, leg: usize, part: usize, interrupt: Interrupt<'_>) -> Result<PiecewiseTaylor> {
        let (r, h) = (self.chain.frames()[leg].nrows(), self.chain.lengths()[leg]);
        let index = self.at[leg] + part;
        let frame = &self.found.knots.frames[index * r * r..][..r * r];
        let frame = MatRef::from_row_major_slice(frame, r, r).to_owned();
        let mut state = self.chain.state_in(&frame, leg, &self.vectors(index, h));
        let step = 1.0 / self.parts(leg) as f64;
        state.time = step * part as f64;
        let mut taylor = PiecewiseTaylor::at(state, Accuracy::FULL);
        let end = match part + 1 == self.parts(leg) {
            true => 1.0,
            false => step * (part + 1) as f64,
        };
        taylor.extend_to(end, interrupt)?;
        Ok(taylor)
    }

    /// Velocity, acceleration and third vector at the first knot of a short leg, in the time of a leg of length `h`.
    fn vectors(&self, index: usize, h: f64) -> Vec<f64> {
        let d = self.chain.size();
        let velocity = &self.found.knots.velocities[index * d..][..d];
        let derivatives = &self.found.derivatives[2 * index * d..][..2 * d];
        let all = velocity.iter().chain(derivatives).enumerate();
        all.map(|(i, x)| x * h.powi(1 + (i / d) as i32)).collect()
    }

    /// For subspaces, what turns a basis to another one of nearly the same subspace.
    fn turn(&self, reached: &State, basis: &State) -> Result<Option<Mat<f64>>> {
        match self.chain.blocks().quotient {
            Quotient::Frames => Ok(None),
            Quotient::Subspaces => alignment(point(reached), point(basis)).map(Some),
        }
    }

    /// The motion between the knots of the spline.
    fn motion(&self) -> Motion {
        let d = self.chain.size();
        let mut motion = Motion::zeros(d, self.at.len());
        for (knot, at) in self.at.iter().enumerate() {
            let velocity = &self.found.knots.velocities[at * d..][..d];
            motion.velocity_mut(knot).copy_from_slice(velocity);
        }
        for (leg, h) in self.chain.lengths().iter().enumerate() {
            let vectors = self.vectors(self.at[leg], *h);
            motion.derivatives_mut(leg).copy_from_slice(&vectors[d..]);
        }
        motion
    }
}

/// The point of a state, shape `(r, k)`.
fn point(state: &State) -> MatRef<'_, f64> {
    state.frame().subcols(0, state.blocks.k)
}

fn distance(reached: &State, next: &State) -> f64 {
    (point(reached) - point(next)).norm_l2()
}
