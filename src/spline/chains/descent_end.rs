//! The spline at the end of a descent: its short legs, integrated and put together between the knots.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::chain::Chain as _;
use super::framed::Framed;
use super::motion::Motion;
use super::solution::{ChainSolution, Effort, SolvedLegs};
use crate::cubic::boundary::descent_start::FASTEST;
use crate::cubic::taylor::march::Accuracy;
use crate::cubic::taylor::piecewise_taylor::PiecewiseTaylor;
use crate::cubic::taylor::state::State;
use crate::cubic::taylor::work::work_of_step;
use crate::error::{Error, Result, unless_interrupted};
use crate::interrupt::Interrupt;
use crate::linalg::field::larger;
use crate::manifold::grassmann::alignment::alignment;
use crate::report::{SolverReport, StopReason};
use crate::shooting::LeastCost;
use crate::solve::gmres::norm;
use crate::space::Quotient;
use crate::threads::{self, scaled};

/// Microseconds of integrating a leg between rotations.
const LEG: f64 = 10.0;

/// Integration accuracy of the curves of a start.
const ROUGH: f64 = 1e-6;

/// The curve of a leg of a motion, roughly, in the frame at its start.
///
/// # Errors
/// An error if it is too fast for a chain, or cannot be integrated; `Interrupted`.
pub(crate) fn roughly_integrated(
    chain: &Framed<'_>,
    leg: usize,
    motion: &Motion,
    effort: Effort<'_>,
) -> Result<PiecewiseTaylor> {
    let (r, h) = (chain.frames()[leg].nrows(), chain.lengths()[leg]);
    let start = motion.start(leg, h);
    let sizes = start.chunks_exact(chain.size()).map(norm);
    // As in flat space.
    let speed: f64 = sizes.zip([1.0, 1.0, 0.5]).map(|(x, part)| part * x).sum();
    if speed > FASTEST {
        return Err(Error::Overflow { quantity: "speed" });
    }
    let state = chain.state_in(&Mat::identity(r, r), leg, &start);
    let mut taylor = PiecewiseTaylor::at(state, Accuracy::of_tolerance(ROUGH));
    taylor.extend_to(1.0, effort.interrupt)?;
    effort
        .work
        .count(taylor.len() as f64 * work_of_step(chain.blocks()));
    Ok(taylor)
}

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
struct ShortLegs<'a> {
    chain: &'a Framed<'a>,
    at: &'a [usize],
    found: &'a LeastCost,
}

impl ShortLegs<'_> {
    /// The curve of a leg of the spline, and the largest [difference] between a short leg and the next one or, at the next
    /// knot of the spline, the point and velocity there.
    ///
    /// # Errors
    /// An error if it cannot be integrated; `Interrupted`.
    fn together(&self, leg: usize, interrupt: Interrupt<'_>) -> Result<(PiecewiseTaylor, f64)> {
        let (mut curve, mut gap) = (self.short(leg, 0, interrupt)?, 0.0);
        let step = 1.0 / self.parts(leg) as f64;
        for part in 1..self.parts(leg) {
            let next = self.turned(&curve, self.short(leg, part, interrupt)?)?;
            gap = larger(gap, difference(&curve.last, &next.first, 2, step));
            curve = curve.followed_by(next);
        }
        let knot = self.state(leg, self.at[leg + 1]);
        let knot = self.turned(&curve, PiecewiseTaylor::at(knot, Accuracy::FULL))?;
        let away = difference(&curve.last, &knot.first, 1, step);
        Ok((curve, larger(gap, away)))
    }

    fn parts(&self, leg: usize) -> usize {
        self.at[leg + 1] - self.at[leg]
    }

    /// A short leg, integrated from its first knot.
    fn short(&self, leg: usize, part: usize, interrupt: Interrupt<'_>) -> Result<PiecewiseTaylor> {
        let mut state = self.state(leg, self.at[leg] + part);
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

    /// The state at a knot of the chain, in the time of a leg of the spline.
    fn state(&self, leg: usize, index: usize) -> State {
        let r = self.chain.frames()[leg].nrows();
        let frame = &self.found.knots.frames[index * r * r..][..r * r];
        let frame = MatRef::from_row_major_slice(frame, r, r).to_owned();
        let vectors = self.vectors(index, self.chain.lengths()[leg]);
        self.chain.state_in(&frame, leg, &vectors)
    }

    /// Velocity, acceleration and third vector at a knot of the chain, where a short leg starts, in the time of a leg of
    /// length `h`; without acceleration and third vector at the last knot.
    fn vectors(&self, index: usize, h: f64) -> Vec<f64> {
        let d = self.chain.size();
        let velocity = &self.found.knots.velocities[index * d..][..d];
        let mut derivatives = self.found.derivatives.chunks_exact(2 * d);
        let derivatives = derivatives.nth(index).unwrap_or(&[]);
        let all = velocity.iter().chain(derivatives).enumerate();
        let mut vectors: Vec<f64> = all.map(|(i, x)| x * h.powi(1 + (i / d) as i32)).collect();
        vectors.resize(3 * d, 0.0);
        vectors
    }

    /// The next part of a curve, for subspaces in the basis that the curve has reached.
    fn turned(&self, curve: &PiecewiseTaylor, next: PiecewiseTaylor) -> Result<PiecewiseTaylor> {
        if self.chain.blocks().quotient == Quotient::Frames {
            return Ok(next);
        }
        let turn = alignment(point(&curve.last), point(&next.first))?;
        Ok(next.in_terms_of(turn.as_ref()))
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

/// The largest difference of the points of two states and of their derivatives up to the given order, velocity and
/// acceleration, in a unit of time; relative to their sizes above 1, and to [`JOINED`].
fn difference(reached: &State, next: &State, order: usize, unit: f64) -> f64 {
    let [a, b] = [reached, next].map(|state| (state.frame(), state.vectors()));
    let points = (point(reached) - point(next)).norm_l2() / JOINED[0];
    (0..order).fold(points, |most, i| {
        let [a, b] = [&a, &b].map(|(frame, vectors)| frame * vectors[i].tangent());
        let unit = unit.powi(1 + i as i32);
        let change = unit * (&a - b).norm_l2() / (unit * a.norm_l2()).max(1.0);
        larger(most, change / JOINED[i + 1])
    })
}
