//! Derivatives of a spline of Riemannian cubics with respect to all its data, by the implicit function theorem.
//!
//! A spline makes half the cost stationary in the velocities at its knots. In frames at the knots, with the state `(x, x', x'')`
//! there, let a variation of the data displace the curve at knot `i`, at the time where the knot was, by `u_i`, and change its
//! velocity beside that by `w_i`:
//!
//! ```math
//! u_i = dS_i - x_i\,dt_i,\qquad w_i = v_i - x'_i\,dt_i
//! ```
//!
//! with `v_i` the change of the velocity at the moved knot. The second derivative `H` of half the cost of a piece by
//! `(u_0, w_0, u_1, w_1)` gives the changes of accelerations at its ends; that they stay equal at the moved knots is one linear
//! system for the `v_i`, symmetric and block tridiagonal (cyclic for periodic ends):
//!
//! ```math
//! \sum_{\text{pieces}} (H z)_{w_i} + (x''_- - x''_+)_i\,dt_i = 0
//! ```
//!
//! Transposed, the gradients `g` by `(u, w)` of all pieces are made those by the data with one solution of the same system for the
//! multipliers of the velocities, whatever the number of times.
//!
//! The first variation of the cost needs no solution where no acceleration is given at an end:
//!
//! ```math
//! \delta J = 2 \sum_{\text{pieces}} \bigl[\langle x', w\rangle - \langle x'', u\rangle\bigr] + \bigl[|x'|^2\,dt\bigr]
//! ```

use faer::{Mat, MatRef, Scale};
use rayon::prelude::*;

use super::data_variation::{Given, SplineGradient, SplineVariation, check};
use super::ends::EndConditions;
use super::knot_states::{KnotStates, State, local_state};
use super::knot_system::{Freedom, KnotSystem, check_size};
use super::multipliers::{Bars, Linear, cost_bars, cost_factor, finished};
use super::piecewise::Piecewise;
use super::spline_ends::check_ends;
use crate::cubic::RiemannianCubic;
use crate::cubic::linear_piece::LinearPiece;
use crate::cubic::pull_back::check_cotangents;
use crate::cubic::turning::turned;
use crate::curve::span::Span;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::structure::{check_range, norm};

/// What an `Overflow` is about.
const VARIATION: &str = "variation of a spline";

/// How a spline of Riemannian cubics depends on its data.
///
/// # Examples
/// ```
/// use faer::{MatRef, mat};
/// use stiefel_rs::spline::{EndConditions, SplineOptions, cubic_spline};
/// use stiefel_rs::{Curve, Interrupt};
/// // On the circle, through the angles 0, 1 and 0 at the times 0, 1 and 2.
/// let points = [0.0_f64, 1.0, 0.0].map(|a| mat![[a.cos()], [a.sin()]]);
/// let views: Vec<MatRef<'_, f64>> = points.iter().map(|point| point.as_ref()).collect();
/// let ends = EndConditions::Natural;
/// let (curve, _) = cubic_spline(&[0.0, 1.0, 2.0], &views, &ends, &SplineOptions::default())?;
/// let derivative = curve.data_derivative(&ends, Interrupt::NEVER)?;
/// // The angle at 1/2, as a function of the angles of the points and of the times.
/// let angle = curve.point(0.5)?[(1, 0)].asin();
/// let cotangent = mat![[-angle.sin()], [angle.cos()]];
/// let gradient = derivative.pull_back(&[0.5], &[cotangent.as_ref()], Interrupt::NEVER)?;
/// let slope = gradient.points[1].transpose() * mat![[-1.0_f64.sin()], [1.0_f64.cos()]];
/// assert!((slope[(0, 0)] - 11.0 / 16.0).abs() < 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct SplineDerivative {
    curve: Piecewise<RiemannianCubic>,
    states: KnotStates,
    given: [Given; 2],
    pieces: Vec<LinearPiece>,
    system: KnotSystem,
}

impl Piecewise<RiemannianCubic> {
    /// How the spline depends on its points, times and end conditions.
    ///
    /// # Arguments
    /// * `ends` - the end conditions that the spline was made with
    /// # Errors
    /// `InvalidArgument` where the curve is not a spline with these ends, to 1e-6 in the time of a leg, or where the number of knots
    /// times the square of the dimension is above 2.5e7; `ConjugateEnds` where it does not depend smoothly on its data, to 1e-11; `Overflow`, `TooManySteps`, `Decomposition`, `Interrupted`.
    pub fn data_derivative(
        &self,
        ends: &EndConditions,
        interrupt: Interrupt<'_>,
    ) -> Result<SplineDerivative> {
        let states = KnotStates::new(self, interrupt)?;
        let given = Given::of(ends);
        check_ends(&states, ends)?;
        let span = span(&states, given);
        check_size(&states, &span)?;
        let pieces: Vec<LinearPiece> = self
            .pieces()
            .par_iter()
            .map(|piece| {
                let state = local_state(piece, 0.0)?;
                let state = state.each_ref().map(|x| x.as_ref());
                LinearPiece::new(state, piece.tension(), interrupt)
            })
            .collect::<Result<_>>()?;
        let freedom = Freedom {
            closed: given[0] == Given::OtherEnd,
            fixed: given.map(|given| given == Given::Velocity),
        };
        let system = KnotSystem::new(&states, &pieces, span, freedom, interrupt)?;
        Ok(SplineDerivative {
            curve: self.clone(),
            states,
            given,
            pieces,
            system,
        })
    }

    /// The gradient of the cost `J` with respect to points, times and end conditions.
    ///
    /// By the first variation of the cost: the jumps of `x''` at the knots. Where an acceleration is given at an end the velocity
    /// there depends on all data, and the linear system of [`Piecewise::data_derivative`] is solved once.
    ///
    /// # Arguments
    /// * `ends` - the end conditions that the spline was made with
    /// # Errors
    /// `InvalidArgument` where the curve is not a spline with these ends, to 1e-6 in the time of a leg; `Overflow`. With a given
    /// acceleration those of [`Piecewise::data_derivative`] too.
    pub fn cost_gradient(
        &self,
        ends: &EndConditions,
        interrupt: Interrupt<'_>,
    ) -> Result<SplineGradient> {
        let given = Given::of(ends);
        if given.contains(&Given::Acceleration) {
            return self.data_derivative(ends, interrupt)?.cost_gradient();
        }
        let states = KnotStates::new(self, interrupt)?;
        check_ends(&states, ends)?;
        let mut bars = cost_bars(&states);
        for knot in 0..states.count() {
            let fixed = [0, states.count() - 1]
                .into_iter()
                .zip(given)
                .any(|(end, given)| end == knot && given != Given::Nothing);
            if !fixed {
                bars.w[knot].fill(0.0);
            }
        }
        finished(&states, given, bars, None, cost_factor(&states))
    }
}

impl SplineDerivative {
    /// The variation of the point of the curve at each of several times, shape `(n, k)` each.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotTangent`, `InvalidArgument` for a variation, in `AtKnot` where they are about one knot, and for
    /// times where the curve has no point; `TooManySteps`, `Overflow`, `Interrupted`.
    pub fn points(
        &self,
        variation: &SplineVariation<'_>,
        times: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Mat<f64>>> {
        check(&self.states, self.given, variation)?;
        let runs = self.curve.runs(times)?;
        let (u, w) = self.at_knots(variation)?;
        let part = |&(piece, from, to): &(usize, usize, usize)| {
            let local: Vec<f64> = times[from..to]
                .iter()
                .map(|t| self.curve.local(piece, *t))
                .collect();
            let z = self.ends_of(piece, &u, &w);
            self.pieces[piece].points(&z, &local, interrupt)
        };
        let parts: Vec<Vec<Mat<f64>>> = runs.par_iter().map(part).collect::<Result<_>>()?;
        let found: Vec<Mat<f64>> = parts.into_iter().flatten().collect();
        for point in &found {
            check_range(VARIATION, point.as_ref())?;
        }
        Ok(found)
    }

    /// The gradient, with respect to all data, of the sum of products of entries of cotangents with the points of the curve at
    /// some times.
    ///
    /// The transpose of [`SplineDerivative::points`]: one solution of the linear system, whatever the number of times.
    ///
    /// # Arguments
    /// * `cotangents` - one for each time, shape `(n, k)`, any matrices; `W` in errors
    /// # Errors
    /// `Shape`, `NonFinite`, those of the curve for its times; `TooManySteps`, `Overflow`, `Interrupted`.
    pub fn pull_back(
        &self,
        times: &[f64],
        cotangents: &[MatRef<'_, f64>],
        interrupt: Interrupt<'_>,
    ) -> Result<SplineGradient> {
        check_cotangents(self.states.point(0), times, cotangents)?;
        let mut runs = self.curve.runs(times)?;
        runs.sort_by_key(|run| run.0);
        let grouped: Vec<&[(usize, usize, usize)]> =
            runs.chunk_by(|one, other| one.0 == other.0).collect();
        let part = |runs: &&[(usize, usize, usize)]| {
            let piece = runs[0].0;
            let indices = || runs.iter().flat_map(|run| run.1..run.2);
            let local: Vec<f64> = indices()
                .map(|i| self.curve.local(piece, times[i]))
                .collect();
            let cotangents: Vec<MatRef<'_, f64>> = indices().map(|i| cotangents[i]).collect();
            let found = self.pieces[piece].pull_back(&local, &cotangents, interrupt)?;
            Ok((piece, found))
        };
        let parts: Vec<(usize, State)> = grouped.par_iter().map(part).collect::<Result<_>>()?;
        let mut bars = Bars::zeros(&self.states);
        for (piece, [u0, w0, u1, w1]) in parts {
            let h = Scale(self.states.lengths[piece]);
            bars.u[piece] += u0;
            bars.w[piece] += w0 * h;
            bars.u[piece + 1] += u1;
            bars.w[piece + 1] += w1 * h;
        }
        self.finished(bars, 1.0)
    }

    /// The gradient of the cost `J`: [`Piecewise::cost_gradient`].
    ///
    /// # Errors
    /// `Overflow`.
    pub fn cost_gradient(&self) -> Result<SplineGradient> {
        let states = &self.states;
        self.finished(cost_bars(states), cost_factor(states))
    }

    /// Displacements and velocities at the knots, at the times where the knots were; in units of the mean leg.
    #[allow(clippy::type_complexity)]
    fn at_knots(&self, variation: &SplineVariation<'_>) -> Result<(Vec<Mat<f64>>, Vec<Mat<f64>>)> {
        let states = &self.states;
        let count = states.count();
        let time = |knot: usize| variation.times.get(knot).map_or(0.0, |t| t / states.unit);
        let u: Vec<Mat<f64>> = (0..count)
            .map(|knot| variation.points[knot] - &states.at(knot)[1] * Scale(time(knot)))
            .collect();
        let mut w: Vec<Mat<f64>> = (0..count)
            .map(|knot| &states.at(knot)[2] * Scale(-time(knot)))
            .collect();
        let ends = self.end_changes(variation);
        for (end, given) in self.given.into_iter().enumerate() {
            if let (Given::Velocity, Some(v)) = (given, &ends[end]) {
                w[end * (count - 1)] += v;
            }
        }
        // What is left of the equations with the velocities where they are.
        let mut rest: Vec<Mat<f64>> = vec![Mat::zeros(u[0].nrows(), u[0].ncols()); count];
        for piece in 0..count - 1 {
            let found = self.linear().stiffness(piece, &self.ends_of(piece, &u, &w));
            let jumps = self.states.ends[piece].each_ref().map(|state| &state[3]);
            rest[piece] += &found[1] - jumps[0] * Scale(time(piece));
            rest[piece + 1] += &found[3] + jumps[1] * Scale(time(piece + 1));
        }
        for (end, given) in self.given.into_iter().enumerate() {
            if let (Given::Acceleration, Some(a)) = (given, &ends[end]) {
                rest[end * (count - 1)] += a * Scale([1.0, -1.0][end]);
            }
        }
        let linear = self.linear();
        for (w, v) in w.iter_mut().zip(linear.solve(rest)) {
            *w -= v;
        }
        Ok((u, w))
    }

    /// What is left of the changes of the vectors given at the ends beside the rotations there, in units of the mean leg.
    fn end_changes(&self, variation: &SplineVariation<'_>) -> [Option<Mat<f64>>; 2] {
        let states = &self.states;
        let knots = [0, states.count() - 1];
        std::array::from_fn(|end| {
            let (order, change) = (self.given[end].order()?, variation.ends[end]?);
            let state = states.at(knots[end]);
            let ds = variation.points[knots[end]];
            let turned = turned(state[0].as_ref(), ds, state[order].as_ref());
            Some(change * Scale(states.unit.powi(order as i32)) - turned)
        })
    }

    /// `(u_0, w_0, u_1, w_1)` of a piece in its own time.
    fn ends_of(&self, piece: usize, u: &[Mat<f64>], w: &[Mat<f64>]) -> State {
        let h = Scale(self.states.lengths[piece]);
        [
            u[piece].clone(),
            &w[piece] * h,
            u[piece + 1].clone(),
            &w[piece + 1] * h,
        ]
    }

    fn linear(&self) -> Linear<'_> {
        Linear {
            states: &self.states,
            given: self.given,
            pieces: &self.pieces,
            system: &self.system,
        }
    }

    fn finished(&self, bars: Bars, factor: f64) -> Result<SplineGradient> {
        let linear = self.linear();
        finished(&self.states, self.given, bars, Some(&linear), factor)
    }
}

/// The span of points and given vectors, where that is all that the spline needs and smaller than what its pieces span alone.
fn span(states: &KnotStates, given: [Given; 2]) -> Span {
    let (n, k) = states.point(0).shape();
    if n <= 4 * k {
        return Span::whole();
    }
    let count = states.count();
    let mut all: Vec<MatRef<'_, f64>> = (0..count).map(|knot| states.point(knot)).collect();
    for (knot, given) in [0, count - 1].into_iter().zip(given) {
        if let Some(order) = given.order() {
            all.push(states.at(knot)[order].as_ref());
        }
    }
    let span = Span::of(&all);
    let Some(basis) = span.basis() else {
        return span;
    };
    let leaves = |x: &Mat<f64>| {
        let off = x - basis * (basis.transpose() * x);
        norm(off.as_ref()) > OFF * (1.0 + norm(x.as_ref()))
    };
    let vectors = states.ends.iter().flatten().flat_map(|state| &state[1..]);
    if vectors.into_iter().any(leaves) {
        return Span::whole();
    }
    span
}

/// What vectors of a spline that stays in the span of its points may be outside of it.
const OFF: f64 = 1e-9;
