//! Derivatives of a spline of Riemannian cubics with respect to all its data, by the implicit function theorem.
//!
//! The velocities at the knots of a spline make half the cost stationary. In frames at the knots, with state `(x, x',
//! x'')`, let a variation of the data displace the curve by `u_i` at the old time of knot `i`, and change its velocity
//! there by `w_i` relative to that displacement:
//!
//! ```math
//! u_i = dS_i - x_i\,dt_i,\qquad w_i = v_i - x'_i\,dt_i
//! ```
//!
//! where `v_i` is the change of the velocity at the moved knot. The second derivative `H` of half the cost of a piece
//! with respect to `(u_0, w_0, u_1, w_1)` yields the changes of the accelerations at its ends. Requiring that
//! accelerations stay continuous at the moved knots gives one linear system for the `v_i`, symmetric and block
//! tridiagonal (cyclic for periodic ends):
//!
//! ```math
//! \sum_{\text{pieces}} (H z)_{w_i} + (x''_- - x''_+)_i\,dt_i = 0
//! ```
//!
//! In the transposed direction, the gradients `g` with respect to `(u, w)` of all pieces are converted to gradients
//! with respect to the data by one solution of the same system, for the multipliers of the velocities, for any number
//! of times.
//!
//! The first variation of the cost needs no solution if no acceleration is given at an end:
//!
//! ```math
//! \delta J = 2 \sum_{\text{pieces}} \bigl[\langle x', w\rangle - \langle x'', u\rangle\bigr] + \bigl[|x'|^2\,dt\bigr]
//! ```

use faer::{Mat, MatRef, Scale};

use super::data_variation::{SplineGradient, SplineVariation, check};
use super::given::GivenEnd;
use super::knot_gradient::KnotGradient;
use super::knot_states::{KnotStates, SOLVER};
use super::knot_system::{KnotSystem, check_size};
use super::spline_ends::check_ends;
use crate::cubic::RiemannianCubic;
use crate::cubic::sensitivity::linear_cubic::{LinearCubic, is_on};
use crate::cubic::sensitivity::linear_flow::{VARIATION, check_cotangents};
use crate::cubic::sensitivity::linear_piece::{LinearPiece, PieceVariation};
use crate::cubic::sensitivity::linear_start::LinearStart;
use crate::cubic::turning::turned;
use crate::curve::Curve;
use crate::curve::span::Span;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::field::add;
use crate::linalg::product::entries;
use crate::linalg::structure::{check_range, norm};
use crate::spline::ends::EndConditions;
use crate::spline::piecewise::Piecewise;
use crate::threads::{self, ALWAYS, scaled};

/// Microseconds of the start of a piece, and of a few of its points, for rotations.
const START: f64 = 0.2;
const POINTS: f64 = 3.0;

/// The derivative of a spline of Riemannian cubics with respect to its data.
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
/// let (curve, _) = cubic_spline(&[0.0, 1.0, 2.0], &views, &ends, &SplineOptions::default(), Interrupt::NEVER)?;
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
    given: [GivenEnd; 2],
    pieces: Vec<LinearPiece>,
    system: KnotSystem,
}

impl Piecewise<RiemannianCubic> {
    /// The derivative of the spline with respect to its points, times and end conditions.
    ///
    /// # Arguments
    /// * `ends` - the end conditions with which the spline was computed
    /// # Errors
    /// `InvalidArgument` if the curve is not a spline with these ends, to 1e-6 in the time of a leg, or if the
    /// derivative would take more than four gigabytes; `ConjugateEnds` if the curve does not depend smoothly on its
    /// data, to 1e-11; `Overflow`, `TooManySteps`, `Decomposition`, `Interrupted`.
    pub fn data_derivative(
        &self,
        ends: &EndConditions,
        interrupt: Interrupt<'_>,
    ) -> Result<SplineDerivative> {
        let states = KnotStates::new(self, interrupt)?;
        let given = GivenEnd::of(ends);
        check_ends(&states, ends)?;
        let span = span(&states, given);
        check_size(&states, &span)?;
        let start = |(): &mut (), leg: usize| {
            interrupt.check(SOLVER)?;
            LinearStart::of_curve(&self.pieces()[leg])
        };
        let starts = threads::map(
            self.pieces().len(),
            scaled(START, (self.n(), self.k())),
            || (),
            start,
        )?;
        let pieces = LinearPiece::all(starts, interrupt)?;
        let system = KnotSystem::new(&states, &pieces, &span, given, interrupt)?;
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
    /// Computed by the first variation of the cost, from the jumps of `x''` at the knots. If an acceleration is given
    /// at an end, the velocity there depends on all data, and the linear system of [`Piecewise::data_derivative`] is
    /// solved once.
    ///
    /// # Arguments
    /// * `ends` - the end conditions with which the spline was computed
    /// # Errors
    /// `InvalidArgument` if the curve is not a spline with these ends, to 1e-6 in the time of a leg; `Overflow`. With a
    /// given acceleration also the errors of [`Piecewise::data_derivative`].
    pub fn cost_gradient(
        &self,
        ends: &EndConditions,
        interrupt: Interrupt<'_>,
    ) -> Result<SplineGradient> {
        let given = GivenEnd::of(ends);
        if given.contains(&GivenEnd::Acceleration) {
            return self.data_derivative(ends, interrupt)?.cost_gradient();
        }
        let states = KnotStates::new(self, interrupt)?;
        check_ends(&states, ends)?;
        // The cost is stationary in the free velocities.
        KnotGradient::of_cost(&states).by_data(&states, given, None)
    }
}

impl SplineDerivative {
    /// The variations of the points of the curve at several times, shape `(n, k)` each.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotTangent`, `InvalidArgument` for a variation, wrapped in `AtKnot` if they concern one
    /// knot, and for times at which the curve is not defined; `TooManySteps`, `Overflow`, `Interrupted`. Pieces in more than 64
    /// dimensions, and extended ones, are linearised for every call, with the errors of
    /// [`RiemannianCubic::boundary_derivative`].
    pub fn points(
        &self,
        variation: &SplineVariation<'_>,
        times: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Mat<f64>>> {
        check(&self.states, self.given, variation)?;
        let runs = self.curve.runs(times)?;
        let [u, w] = self.at_knots(variation);
        let part = |(): &mut (), run: usize| {
            let (piece, from, to) = runs[run];
            let local: Vec<f64> = times[from..to]
                .iter()
                .map(|t| self.curve.local(piece, *t))
                .collect();
            let z = self.ends_of(piece, &u, &w);
            if let Some(alone) = self.alone(piece, &local, interrupt)? {
                let z = z.each_ref().map(|z| self.states.matrix(z).to_owned());
                return alone.points(&z, &local, interrupt);
            }
            let found = self.pieces[piece].points(z.each_ref().map(Vec::as_slice), &local);
            let point = |x: &Vec<f64>| {
                let point = self.states.matrix(x);
                check_range(VARIATION, point)?;
                Ok(point.to_owned())
            };
            found.iter().map(point).collect()
        };
        let parts = threads::map(runs.len(), self.work_of_points(), || (), part)?;
        Ok(parts.into_iter().flatten().collect())
    }

    /// Microseconds of a few points of a piece.
    fn work_of_points(&self) -> f64 {
        match self.pieces.iter().all(LinearPiece::has_points) {
            true => scaled(POINTS, self.states.shape),
            // Linearised for every call.
            false => ALWAYS,
        }
    }

    /// A piece linearised by itself, if it does not keep displacements or is to be extended beyond its ends for some of the
    /// given times; `None` otherwise.
    fn alone(
        &self,
        piece: usize,
        times: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<Option<LinearCubic>> {
        if self.pieces[piece].has_points() && times.iter().all(|t| is_on(*t)) {
            return Ok(None);
        }
        let curve = &self.curve.pieces()[piece];
        LinearCubic::new(curve, interrupt).map(Some)
    }

    /// The gradient with respect to all data of `sum tr(W^T S(t))` over cotangents `W` at given times `t`.
    ///
    /// This is the transpose of [`SplineDerivative::points`]; it solves the linear system once for any number of times.
    ///
    /// # Arguments
    /// * `cotangents` - one per time, shape `(n, k)`, any matrices; named `W` in errors
    /// # Errors
    /// `Shape`, `NonFinite`, the errors of the curve for its times; `TooManySteps`, `Overflow`, `Interrupted`.
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
        let part = |(): &mut (), group: usize| {
            let runs = grouped[group];
            let piece = runs[0].0;
            let indices = || runs.iter().flat_map(|run| run.1..run.2);
            let local: Vec<f64> = indices()
                .map(|i| self.curve.local(piece, times[i]))
                .collect();
            let cotangents: Vec<MatRef<'_, f64>> = indices().map(|i| cotangents[i]).collect();
            let found = match self.alone(piece, &local, interrupt)? {
                Some(alone) => {
                    let found = alone.pull_back(&local, &cotangents, interrupt)?;
                    found.each_ref().map(entries)
                }
                None => self.pieces[piece].pull_back(local.into_iter().zip(cotangents)),
            };
            Ok((piece, found))
        };
        let parts: Vec<(usize, PieceVariation)> =
            threads::map(grouped.len(), self.work_of_points(), || (), part)?;
        let mut gradient = KnotGradient::zeros(&self.states);
        for (piece, by_ends) in parts {
            let h = self.states.lengths[piece];
            gradient.add(piece, &by_ends, [1.0, h]);
        }
        self.by_data(gradient)
    }

    /// The gradient of the cost `J`: [`Piecewise::cost_gradient`].
    ///
    /// # Errors
    /// `Overflow`.
    pub fn cost_gradient(&self) -> Result<SplineGradient> {
        self.by_data(KnotGradient::of_cost(&self.states))
    }

    /// Converts to the gradient with respect to the data, using the multipliers of the velocities.
    fn by_data(&self, mut gradient: KnotGradient) -> Result<SplineGradient> {
        let multipliers = self.system.solve(&gradient.w);
        let still = KnotGradient::zeros(&self.states).u;
        self.add_forces(&mut gradient, -1.0, [&still, &multipliers]);
        gradient.add_jumps(&self.states, &multipliers);
        gradient.by_data(&self.states, self.given, Some(&multipliers))
    }

    /// Displacements and velocities at the knots, at the old times of the knots; in units of the mean leg.
    fn at_knots(&self, variation: &SplineVariation<'_>) -> [Vec<f64>; 2] {
        let states = &self.states;
        let (count, size) = (states.count(), states.size());
        let time = |knot: usize| variation.times.get(knot).map_or(0.0, |t| t / states.unit);
        let mut u = Vec::with_capacity(count * size);
        let mut w = vec![0.0; count * size];
        for knot in 0..count {
            let [_, v, a, _] = states.at(knot);
            u.extend(entries(variation.points[knot]));
            add(&mut u[knot * size..], -time(knot), v);
            add(&mut w[knot * size..][..size], -time(knot), a);
        }
        let ends = self.end_changes(variation);
        let at_end = |end: usize| end * (count - 1) * size;
        for (end, given) in self.given.into_iter().enumerate() {
            if let (GivenEnd::Velocity, Some(v)) = (given, &ends[end]) {
                add(&mut w[at_end(end)..][..size], 1.0, v);
            }
        }
        // Residual of the equations with unchanged velocities.
        let mut rest = KnotGradient::zeros(states);
        self.add_forces(&mut rest, 1.0, [&u, &w]);
        let mut rest = rest.w;
        for (piece, [start, end]) in states.ends.iter().enumerate() {
            add(&mut rest[piece * size..][..size], -time(piece), &start[3]);
            add(
                &mut rest[(piece + 1) * size..][..size],
                time(piece + 1),
                &end[3],
            );
        }
        for (end, given) in self.given.into_iter().enumerate() {
            if let (GivenEnd::Acceleration, Some(a)) = (given, &ends[end]) {
                add(&mut rest[at_end(end)..][..size], [1.0, -1.0][end], a);
            }
        }
        add(&mut w, -1.0, &self.system.solve(&rest));
        [u, w]
    }

    /// The changes of the vectors given at the ends, relative to the rotations there, in units of the mean leg.
    fn end_changes(&self, variation: &SplineVariation<'_>) -> [Option<Vec<f64>>; 2] {
        let states = &self.states;
        let knots = [0, states.count() - 1];
        std::array::from_fn(|end| {
            let (order, change) = (self.given[end].order()?, variation.ends[end]?);
            let (ds, vector) = (variation.points[knots[end]], &states.at(knots[end])[order]);
            let turned = turned(states.point(knots[end]), ds, states.matrix(vector));
            let change = change * Scale(states.unit.powi(order as i32)) - turned;
            Some(entries(&change))
        })
    }

    /// `(u_0, w_0, u_1, w_1)` of a piece, in its own time.
    fn ends_of(&self, piece: usize, u: &[f64], w: &[f64]) -> PieceVariation {
        let (size, h) = (self.states.size(), self.states.lengths[piece]);
        std::array::from_fn(|i| {
            let at = (piece + i / 2) * size;
            match i % 2 {
                0 => u[at..][..size].to_vec(),
                _ => w[at..][..size].iter().map(|w| w * h).collect(),
            }
        })
    }

    /// Adds a multiple of the change of the gradient of half the cost, in units of the mean leg.
    fn add_forces(&self, to: &mut KnotGradient, factor: f64, [u, w]: [&[f64]; 2]) {
        for (piece, h) in self.states.lengths.iter().enumerate() {
            let z = self.ends_of(piece, u, w);
            let found = self.pieces[piece].stiffness(z.each_ref().map(Vec::as_slice));
            to.add(piece, &found, [-3, -2].map(|order| factor * h.powi(order)));
        }
    }
}

/// The span of points and given vectors, if it contains everything the spline needs and is smaller than the spans of
/// the pieces.
fn span(states: &KnotStates, given: [GivenEnd; 2]) -> Span {
    let (n, k) = states.shape;
    if n <= 4 * k {
        return Span::whole();
    }
    let count = states.count();
    let mut all: Vec<MatRef<'_, f64>> = (0..count).map(|knot| states.point(knot)).collect();
    for (knot, given) in [0, count - 1].into_iter().zip(given) {
        if let Some(order) = given.order() {
            all.push(states.matrix(&states.at(knot)[order]));
        }
    }
    let span = Span::of(&all);
    let Some(basis) = span.basis() else {
        return span;
    };
    let leaves = |x: &Vec<f64>| {
        let x = states.matrix(x);
        let off = x - basis * (basis.transpose() * x);
        norm(off.as_ref()) > OFF * (1.0 + norm(x))
    };
    let vectors = states.ends.iter().flatten().flat_map(|state| &state[1..]);
    if vectors.into_iter().any(leaves) {
        return Span::whole();
    }
    span
}

/// Largest component outside the span of the points for which a spline counts as contained in it.
const OFF: f64 = 1e-9;
