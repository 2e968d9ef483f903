//! The equations of a smoothing spline, whose knots are unknown too, and the step that would solve them in flat space.
//!
//! With `r, w` the distance and lag of a leg of length `h`, carried back to its start, and `p, v` the changes of position and
//! velocity of its knots, likewise, flat space gives
//!
//! ```math
//! dx' = 6 P - 2 Q,\quad dx'' = 6 Q - 12 P,\qquad
//! P = -r + p_{j+1} - p_j - h v_j,\quad Q = -w + h (v_{j+1} - v_j)
//! ```
//!
//! The jumps of acceleration and jerk at the knots, with what the data pull, are then a block tridiagonal system for `(p, v)`
//! with blocks of two by two numbers.

use faer::Mat;
use rayon::prelude::*;

use super::chain::{Arrivals, Chain, Motion, Movable, square};
use super::iteration::Outcome;
use super::tridiagonal::{Row, Shape, Tridiagonal};
use crate::anderson::Anderson;
use crate::cubic::taylor::Accuracy;
use crate::error::{Error, Result};
use crate::linalg::gmres::{Gmres, norm};
use crate::manifold::carrier::Direction;
use crate::report::StopReason;

/// Vectors that an arrival has here: distance, velocity, acceleration and the third vector.
const VECTORS: usize = 4;

/// Past steps that are mixed in.
const DEPTH: usize = 6;

/// Residuals are integrated to this share of the one before.
const ACCURACY_SHARE: f64 = 2e-5;

/// Differences of the equations, relative to the motion, and what is left out of an integration there.
const DIFFERENCE: f64 = 1e-7;
const DIFFERENCE_ACCURACY: f64 = 1e-13;

/// A step by GMRES leaves this share of the linear equations.
const KRYLOV_SHARE: f64 = 1e-2;

/// A Newton step is shortened until what is left falls by this share of what it predicts.
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// Halvings of a step before it is given up.
const MAX_HALVINGS: i32 = 8;

/// Where the equations are met but for soft ones, knots may still be this far from their place.
const IN_PLACE: f64 = 1e-7;

/// What a step would still take off the objective, as a share of it, or of what all data out of place by [`IN_PLACE`] are worth.
const NO_GAIN: f64 = 1e-3;

/// A system of flat space whose solutions are further off says little of motions at constant speed.
const BELIEVED: f64 = 0.1;

/// Steps in a row that may leave more than half of the least residual so far.
const PATIENCE: usize = 8;

/// Data, sorted by knots.
pub(super) struct Data {
    points: Vec<Mat<f64>>,
    knots: Vec<usize>,
    pub(super) weights: Vec<f64>,
}

impl Data {
    pub(super) fn new(points: Vec<Mat<f64>>, knots: Vec<usize>, weights: Vec<f64>) -> Self {
        Data {
            points,
            knots,
            weights,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// Which knot each belongs to.
    pub(super) fn knots(&self) -> &[usize] {
        &self.knots
    }

    /// The sum of the weights at each knot.
    pub(super) fn weight_of_knots(&self) -> Vec<f64> {
        let count = self.knots.last().map_or(0, |last| last + 1);
        let mut sums = vec![0.0; count];
        for (&knot, weight) in self.knots.iter().zip(&self.weights) {
            sums[knot] += weight;
        }
        sums
    }

    /// The tangent vectors from the knots of a chain to the data, one after the other.
    ///
    /// # Errors
    /// In `AtKnot`, where there is none.
    pub(super) fn displacements<C: Movable>(&self, chain: &C) -> Result<Vec<Vec<f64>>> {
        self.points
            .par_iter()
            .zip(&self.knots)
            .map(|(point, &knot)| {
                let found = chain.towards(knot, point);
                found.map_err(|error| error.at_knot(knot))
            })
            .collect()
    }
}

/// Rows for `(p, v)` of a smoothing spline in flat space, for weights over `lambda` at the knots.
pub(super) fn rows(lengths: &[f64], pulls: &[f64]) -> Vec<Row<2>> {
    let mut rows = vec![Row::ZERO; lengths.len() + 1];
    for (row, pull) in rows.iter_mut().zip(pulls) {
        row.diagonal[0][0] = *pull;
    }
    for (leg, h) in lengths.iter().enumerate() {
        let [r1, r2, r3] = [1, 2, 3].map(|power| h.powi(-power));
        let before = &mut rows[leg];
        add(
            &mut before.diagonal,
            [[12.0 * r3, 6.0 * r2], [6.0 * r2, 4.0 * r1]],
        );
        before.above = [[-12.0 * r3, 6.0 * r2], [-6.0 * r2, 2.0 * r1]];
        let after = &mut rows[leg + 1];
        add(
            &mut after.diagonal,
            [[12.0 * r3, -6.0 * r2], [-6.0 * r2, 4.0 * r1]],
        );
        after.below = [[-12.0 * r3, -6.0 * r2], [6.0 * r2, 2.0 * r1]];
    }
    rows
}

fn add(block: &mut [[f64; 2]; 2], more: [[f64; 2]; 2]) {
    for (entry, more) in block.iter_mut().flatten().zip(more.iter().flatten()) {
        *entry += more;
    }
}

/// Round-off of stiff legs is more than the pulls of the data, or the other way around.
pub(super) fn extreme(lambda: f64) -> Error {
    Error::InvalidArgument {
        name: "lam",
        requirement: "neither so small nor so large, beside the cubes of the steps of time, that the data are lost in round-off",
        found: lambda,
    }
}

/// How far the system of flat space misses a motion at constant speed, that only the pulls hold in its place.
fn lost<C: Chain>(chain: &C, system: &Tridiagonal<2>, pulls: &[f64]) -> Result<f64> {
    let d = chain.size();
    let whole: f64 = chain.lengths().iter().sum();
    let (mut worker, mut place) = (chain.worker(), 1.0);
    let mut direction = vec![1.0; d];
    let (mut exact, mut right) = (Vec::new(), Vec::new());
    for (knot, pull) in pulls.iter().enumerate() {
        exact.extend(direction.iter().map(|x| place * x));
        exact.extend(direction.iter().map(|x| x / whole));
        right.extend(direction.iter().map(|x| pull * place * x));
        right.extend(std::iter::repeat_n(0.0, d));
        if let Some(h) = chain.lengths().get(knot) {
            let here = direction.clone();
            chain.carry_into(&mut worker, knot, Direction::Forward, &here, &mut direction)?;
            place += h / whole;
        }
    }
    system.solve(chain, &mut worker, &mut right)?;
    let misses = exact.iter().zip(&right).map(|(x, y)| (x - y).abs());
    // A NaN stays.
    Ok(misses.fold(0.0, |most, x| if x <= most { most } else { x }))
}

/// A chain and a motion along it.
struct State<C> {
    chain: C,
    motion: Motion,
}

impl<C: Movable> State<C> {
    /// Knots moved, with the velocities there, and the motion changed, by a share of a step.
    fn advanced(&self, share: f64, step: &[f64]) -> Result<Self> {
        let count = self.chain.size() * (self.chain.lengths().len() + 1);
        let (shifts, change) = step.split_at(count);
        let shifts: Vec<f64> = shifts.iter().map(|x| share * x).collect();
        let mut motion = self.motion.clone();
        motion.add(share, change);
        let chain = self.chain.moved(&shifts, &mut motion)?;
        Ok(State { chain, motion })
    }
}

/// A smoothing spline on its way.
pub(super) struct Fit<'d, C> {
    state: State<C>,
    data: &'d Data,
    lambda: f64,
    /// Diagonal entries of the positions: from forces to distances.
    stiffness: Vec<f64>,
    system: Tridiagonal<2>,
    /// Whether round-off of stiff legs leaves the pulls alone.
    believed: bool,
    misfit: f64,
}

/// What is left of the equations.
struct Balance {
    arrivals: Arrivals,
    /// At each knot: jump of the jerk less the pull of the data, jump of the acceleration, in units of the mean leg.
    forces: Vec<f64>,
    size: f64,
    misfit: f64,
}

impl<'d, C: Movable> Fit<'d, C> {
    /// The smoothing spline of flat space, for a chain through data.
    ///
    /// # Errors
    /// Where the knots cannot be moved there.
    pub(super) fn new(chain: C, data: &'d Data, lambda: f64) -> Result<Self> {
        let pulls: Vec<f64> = data.weight_of_knots().iter().map(|w| w / lambda).collect();
        let rows = rows(chain.lengths(), &pulls);
        let system = Tridiagonal::new(&rows, Shape::Open).ok_or_else(|| extreme(lambda))?;
        let believed = lost(&chain, &system, &pulls)? <= BELIEVED;
        let motion = Motion::zeros(chain.size(), pulls.len());
        let mut fit = Fit {
            state: State { chain, motion },
            data,
            lambda,
            stiffness: rows.iter().map(|row| row.diagonal[0][0]).collect(),
            system,
            believed,
            misfit: 0.0,
        };
        let arrivals = Arrivals::flat(&fit.state.chain, &fit.state.motion, VECTORS)?;
        let start = fit.balance_of(&fit.state, arrivals)?;
        let step = fit.step(&fit.state, &start)?;
        fit.state = fit.state.advanced(1.0, &step)?;
        Ok(fit)
    }

    pub(super) fn chain(&self) -> &C {
        &self.state.chain
    }

    pub(super) fn motion(&self) -> &Motion {
        &self.state.motion
    }

    /// `sum w d^2`, where the last balance was struck.
    pub(super) fn misfit(&self) -> f64 {
        self.misfit
    }

    /// By the fixed-point iteration of the step of flat space, with Anderson mixing; where that stalls, by Newton's method.
    ///
    /// # Errors
    /// Where the start cannot be integrated; `Interrupted`.
    pub(super) fn solve(&mut self, tolerance: f64, max_iterations: usize) -> Result<Outcome> {
        let mut accuracy = Accuracy::of_tolerance(ACCURACY_SHARE);
        let mut found = self.balance(&self.state, accuracy)?;
        let (mut mixing, mut newton, mut iterations) = (Anderson::new(DEPTH), false, 0);
        let (mut least, mut failures) = (found.size, 0);
        let reason = loop {
            if found.size <= tolerance && accuracy.truncation > Accuracy::FULL.truncation {
                accuracy = Accuracy::FULL;
                found = self.balance(&self.state, accuracy)?;
                continue;
            }
            let step = self.step(&self.state, &found)?;
            // Weak pulls are nothing beside stiff legs: what they would still move and gain says more.
            if found.size <= tolerance
                && self.largest_move(&step) <= IN_PLACE
                && self.gain(&step, &found)? <= NO_GAIN * self.worth(&found)
            {
                break StopReason::Converged;
            }
            if iterations == max_iterations {
                break StopReason::MaxIterations;
            }
            iterations += 1;
            let share = ACCURACY_SHARE * found.size.min(1.0);
            accuracy = accuracy.finer(Accuracy::of_tolerance(share));
            if newton {
                accuracy = accuracy.finer(Accuracy::of_tolerance(DIFFERENCE_ACCURACY));
                match self.descended(accuracy, &step)? {
                    Some((state, nearer)) => (self.state, found) = (state, nearer),
                    None => break StopReason::Stagnated,
                }
                continue;
            }
            match self.tried(accuracy, 1.0, &mixing.increment(step))? {
                Some((state, next)) if failures < PATIENCE => {
                    (self.state, found) = (state, next);
                    failures = if found.size > 0.5 * least {
                        failures + 1
                    } else {
                        0
                    };
                    least = least.min(found.size);
                }
                _ => newton = true,
            }
        };
        self.misfit = found.misfit;
        Ok(Outcome {
            reason,
            iterations,
            residual: found.size,
            tolerance,
        })
    }

    /// None where the state cannot be integrated, or its knots not be joined.
    fn tried(
        &self,
        accuracy: Accuracy,
        share: f64,
        step: &[f64],
    ) -> Result<Option<(State<C>, Balance)>> {
        let moved = self.state.advanced(share, step);
        let found = moved.and_then(|state| {
            let found = self.balance(&state, accuracy)?;
            Ok((state, found))
        });
        match found {
            Err(error) if error.is_interrupted() => Err(error),
            Ok((state, found)) if found.size.is_finite() => Ok(Some((state, found))),
            Ok(_) | Err(_) => Ok(None),
        }
    }

    /// After a Newton step from where the flat step is `here`, shortened until the flat step is shorter.
    fn descended(&self, accuracy: Accuracy, here: &[f64]) -> Result<Option<(State<C>, Balance)>> {
        let Some(step) = self.newton_step(accuracy, here)? else {
            return Ok(None);
        };
        let size = norm(here);
        for halving in 0..MAX_HALVINGS {
            let share = 0.5_f64.powi(halving);
            if let Some((state, found)) = self.tried(accuracy, share, &step)?
                && norm(&self.step(&state, &found)?) <= (1.0 - SUFFICIENT_DECREASE * share) * size
            {
                return Ok(Some((state, found)));
            }
        }
        Ok(None)
    }

    /// By GMRES with differences: the flat step has a derivative near minus the identity. None where a difference cannot be
    /// taken.
    fn newton_step(&self, accuracy: Accuracy, here: &[f64]) -> Result<Option<Vec<f64>>> {
        let found = self.balance(&self.state, accuracy)?;
        let base = self.step(&self.state, &found)?;
        let size = norm(&self.state.motion.entries).max(1.0);
        let mut failure = None;
        let mut step = here.to_vec();
        Gmres::new(step.len()).solve(&mut step, KRYLOV_SHARE, |v, out| {
            let share = DIFFERENCE * size / norm(v);
            let there = self.state.advanced(share, v).and_then(|state| {
                let found = self.balance(&state, accuracy)?;
                self.step(&state, &found)
            });
            match there {
                Ok(there) => {
                    for ((out, base), there) in out.iter_mut().zip(&base).zip(there) {
                        *out = (base - there) / share;
                    }
                }
                Err(error) => {
                    out.copy_from_slice(v);
                    failure = Some(error);
                }
            }
        });
        match failure {
            Some(error) if error.is_interrupted() => Err(error),
            Some(_) => Ok(None),
            None => Ok(Some(step)),
        }
    }

    /// Of the positions in a step.
    fn largest_move(&self, step: &[f64]) -> f64 {
        let positions = step.chunks_exact(self.state.chain.size());
        let moves = positions.take(self.stiffness.len()).map(square);
        // A NaN stays.
        let largest = moves.fold(0.0, |largest, x| if x <= largest { largest } else { x });
        largest.sqrt()
    }

    /// What a step takes off the objective of flat space, or what motions at constant speed do, where pulls are lost in round-off.
    fn gain(&self, step: &[f64], found: &Balance) -> Result<f64> {
        let d = self.state.chain.size();
        let (positions, change) = step.split_at(d * self.stiffness.len());
        let forces = found.forces.chunks_exact(2 * d);
        let changes = positions.chunks_exact(d).zip(change.chunks_exact(d));
        let products = forces
            .zip(changes)
            .map(|(force, (shift, change))| dot(&force[..d], shift) + dot(&force[d..], change));
        let gain = self.lambda * products.sum::<f64>().abs();
        match self.believed {
            true => Ok(gain),
            false => Ok(gain.max(self.gain_of_straight_motions()?)),
        }
    }

    /// What moving all knots by vectors that are carried along, and by such vectors times the time, takes off the misfit.
    fn gain_of_straight_motions(&self) -> Result<f64> {
        let State { chain, .. } = &self.state;
        let (d, mut worker) = (chain.size(), chain.worker());
        let displacements = self.data.displacements(chain)?;
        let mut pulls = vec![0.0; 2 * d];
        let (mut sums, mut time, mut here) = ([0.0; 3], 0.0, 0);
        let all = self.data.knots.iter().zip(&self.data.weights);
        for ((&knot, weight), away) in all.zip(&displacements) {
            for leg in here..knot {
                let before = pulls.clone();
                for (from, to) in before.chunks_exact(d).zip(pulls.chunks_exact_mut(d)) {
                    chain.carry_into(&mut worker, leg, Direction::Forward, from, to)?;
                }
                time += chain.lengths()[leg];
            }
            here = knot;
            add_scaled(&mut pulls, *weight, away);
            add_scaled(&mut pulls[d..], weight * time, away);
            for (power, sum) in sums.iter_mut().enumerate() {
                *sum += weight * time.powi(power as i32);
            }
        }
        let (constant, linear) = pulls.split_at(d);
        let whole = sums[2] * square(constant) - 2.0 * sums[1] * dot(constant, linear)
            + sums[0] * square(linear);
        Ok(whole / (sums[0] * sums[2] - sums[1] * sums[1]))
    }

    /// The objective, where accelerations are linear along legs as in flat space; no less than what is not seen of it.
    fn worth(&self, found: &Balance) -> f64 {
        let (d, motion) = (self.state.chain.size(), &self.state.motion);
        let legs = self.state.chain.lengths().iter().enumerate();
        let costs = legs.map(|(leg, h)| {
            let (first, third) = motion.bend(leg).split_at(d);
            h.powi(-3) * (square(first) + dot(first, third) + square(third) / 3.0)
        });
        let unseen = self.data.weights.iter().sum::<f64>() * IN_PLACE * IN_PLACE / NO_GAIN;
        (found.misfit + self.lambda * costs.sum::<f64>()).max(unseen)
    }

    fn balance(&self, state: &State<C>, accuracy: Accuracy) -> Result<Balance> {
        let arrivals = Arrivals::of(&state.chain, &state.motion, VECTORS, accuracy)?;
        self.balance_of(state, arrivals)
    }

    fn balance_of(&self, state: &State<C>, arrivals: Arrivals) -> Result<Balance> {
        let (d, lengths) = (state.chain.size(), state.chain.lengths());
        let mut forces = vec![0.0; 2 * d * self.stiffness.len()];
        let mut misfit = 0.0;
        let displacements = self.data.displacements(&state.chain)?;
        for ((&knot, weight), away) in self
            .data
            .knots
            .iter()
            .zip(&self.data.weights)
            .zip(&displacements)
        {
            misfit += weight * state.chain.square(knot, away);
            add_scaled(&mut forces[2 * d * knot..], -weight / self.lambda, away);
        }
        for (leg, h) in lengths.iter().enumerate() {
            let [r2, r3] = [2, 3].map(|power| h.powi(-power));
            let [first, third] = [&state.motion.bend(leg)[..d], &state.motion.bend(leg)[d..]];
            let (before, after) = forces[2 * d * leg..].split_at_mut(2 * d);
            add_scaled(before, r3, third);
            add_scaled(&mut before[d..], -r2, first);
            add_scaled(after, -r3, arrivals.vector(leg, 3));
            add_scaled(&mut after[d..], r2, arrivals.vector(leg, 2));
        }
        let mut size = arrivals.miss;
        for (knot, force) in forces.chunks_exact(2 * d).enumerate() {
            let h = self.shortest(knot);
            let off = square(&force[..d]).sqrt() / self.stiffness[knot];
            let jump = h * h * square(&force[d..]).sqrt();
            // A NaN stays.
            for part in [off, jump] {
                size = if part <= size { size } else { part };
            }
        }
        Ok(Balance {
            arrivals,
            forces,
            size,
            misfit,
        })
    }

    /// Length of the shorter leg at a knot.
    fn shortest(&self, knot: usize) -> f64 {
        let lengths = self.state.chain.lengths();
        let from = knot.saturating_sub(1);
        lengths[from..(knot + 1).min(lengths.len())]
            .iter()
            .fold(f64::INFINITY, |h, x| h.min(*x))
    }

    /// Changes of the positions, then of the motion, that would solve the equations in flat space.
    fn step(&self, state: &State<C>, found: &Balance) -> Result<Vec<f64>> {
        let (d, lengths) = (state.chain.size(), state.chain.lengths());
        let mut worker = state.chain.worker();
        let mut right: Vec<f64> = found.forces.iter().map(|force| -force).collect();
        for (leg, h) in lengths.iter().enumerate() {
            let [r2, r3] = [2, 3].map(|power| h.powi(-power));
            let (before, after) = right[2 * d * leg..].split_at_mut(2 * d);
            let (r, w) = (
                found.arrivals.distance_back(leg),
                found.arrivals.lag_back(leg),
            );
            add_scaled(before, -12.0 * r3, r);
            add_scaled(before, 6.0 * r3, w);
            add_scaled(&mut before[d..], -6.0 * r2, r);
            add_scaled(&mut before[d..], 2.0 * r2, w);
            let (r, w) = (found.arrivals.vector(leg, 0), found.arrivals.vector(leg, 1));
            add_scaled(after, 12.0 * r3, r);
            add_scaled(after, -6.0 * r3, w);
            add_scaled(&mut after[d..], -6.0 * r2, r);
            add_scaled(&mut after[d..], 4.0 * r2, w);
        }
        self.system.solve(&state.chain, &mut worker, &mut right)?;
        let mut motion = Motion::zeros(d, lengths.len() + 1);
        let mut step = Vec::with_capacity(right.len() / 2 + motion.entries.len());
        for (knot, change) in right.chunks_exact(2 * d).enumerate() {
            step.extend_from_slice(&change[..d]);
            motion.velocity_mut(knot).copy_from_slice(&change[d..]);
        }
        let mut next = vec![0.0; 2 * d];
        for (leg, h) in lengths.iter().enumerate() {
            let (from, to) = right[2 * d * leg..].split_at(2 * d);
            for (to, next) in to.chunks_exact(d).zip(next.chunks_exact_mut(d)) {
                state
                    .chain
                    .carry_into(&mut worker, leg, Direction::Backward, to, next)?;
            }
            let (r, w) = (
                found.arrivals.distance_back(leg),
                found.arrivals.lag_back(leg),
            );
            let (first, second) = motion.bend_mut(leg).split_at_mut(d);
            for i in 0..d {
                let p = -r[i] + next[i] - from[i] - h * from[d + i];
                let q = -w[i] + h * (next[d + i] - from[d + i]);
                first[i] = 6.0 * p - 2.0 * q;
                second[i] = 6.0 * q - 12.0 * p;
            }
        }
        step.extend(motion.entries);
        Ok(step)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The leading entries.
fn add_scaled(to: &mut [f64], factor: f64, from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += factor * from;
    }
}
