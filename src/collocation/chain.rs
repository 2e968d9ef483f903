//! A chain of legs between given points: all equations of all legs at once, and the step that solves them linearised.

use super::dense::{Dense, Expansion};
use super::knots::{End, Ends, Knots};
use super::leg::{self, Leg};
use super::linear_leg::LinearLeg;
use super::linearisation::Linearisation;
use super::nodes::{Grid, Nodes};
use crate::error::Result;
use crate::linalg::field::{Field, larger, largest};
use crate::linalg::simd::vectorised;
use crate::solve::block_tridiagonal::BlockTridiagonal;
use crate::space::Homogeneous;

/// Sweeps of Picard's iteration for frames along which nothing turns, and more of them for a radian.
const SWEEPS: [f64; 2] = [3.0, 2.0];

/// Sweeps at the most: a motion that needs more has gone astray.
const MOST_SWEEPS: f64 = 48.0;

/// Frames that are farther off than this are found by Picard's iteration.
const FRAMES_AWAY: f64 = 0.3;

/// Frames are corrected until they are off by less than this.
const FRAMES_NEAR: f64 = 1e-2;

/// `x'''` of a leg at some times between 0 and 1, one vector after the other.
pub(super) type ThirdDerivative<'a> = dyn Fn(usize, &[f64]) -> Result<Vec<f64>> + 'a;

/// Legs in a row, or groups of eight, with what is left of their equations.
pub(super) struct Chain<'k, T, S> {
    space: S,
    knots: &'k Knots<'k>,
    legs: Vec<Leg<T>>,
    linear: Vec<LinearLeg<T>>,
    scratch: leg::Scratch<T>,
    linearisation: Linearisation<T>,
    velocities: Vec<f64>,
    /// Of the covariant acceleration at the knots: before less after, at an end less the wanted one.
    jumps: Vec<f64>,
    /// Changes of the velocities by the step.
    step: Vec<f64>,
    /// Root of the sum of squares of what is left of the equations, but for the frames, and the largest entry, with them.
    pub(super) merit: f64,
    pub(super) size: f64,
}

impl<'k, T: Field, S: Homogeneous> Chain<'k, T, S> {
    pub(super) fn new(
        space: S,
        knots: &'k Knots<'k>,
        velocities: &[f64],
        bends: &[f64],
        grid: &Grid,
    ) -> Self {
        let (d, r, count) = (space.dim(), space.size(), knots.lengths.len());
        let groups = count.div_ceil(T::COUNT);
        let mut chain: Self = Chain {
            space,
            knots,
            legs: (0..groups)
                .map(|_| Leg::new(space, grid.fine.len()))
                .collect(),
            linear: (0..groups).map(|_| LinearLeg::new(space, grid)).collect(),
            scratch: leg::Scratch::new(space, grid.fine.len()),
            linearisation: Linearisation::new(space, grid),
            velocities: velocities.to_vec(),
            jumps: Vec::new(),
            step: Vec::new(),
            merit: f64::INFINITY,
            size: f64::INFINITY,
        };
        for (group, leg) in chain.legs.iter_mut().enumerate() {
            for lane in 0..T::COUNT {
                // The last one stands in for those that are not there.
                let i = (group * T::COUNT + lane).min(count - 1);
                let h = knots.lengths[i];
                for row in 0..r {
                    for col in 0..r {
                        leg.target[row * r + col].set_lane(lane, knots.targets[i][row + r * col]);
                    }
                }
                for p in 0..d {
                    leg.velocity[p].set_lane(lane, h * velocities[i * d + p]);
                    leg.last_velocity[p].set_lane(lane, h * velocities[(i + 1) * d + p]);
                    leg.acceleration[p].set_lane(lane, bends[2 * i * d + p]);
                    leg.third[p].set_lane(lane, bends[(2 * i + 1) * d + p]);
                }
            }
        }
        chain
    }

    /// `x'''` of every leg at the nodes.
    pub(super) fn set_third_derivatives(
        &mut self,
        nodes: &Nodes,
        third_derivative: &ThirdDerivative<'_>,
    ) -> Result<()> {
        let count = self.knots.lengths.len();
        for (group, leg) in self.legs.iter_mut().enumerate() {
            for lane in 0..T::COUNT {
                let values = third_derivative((group * T::COUNT + lane).min(count - 1), &nodes.s)?;
                for (f, value) in leg.f.iter_mut().zip(values) {
                    f.set_lane(lane, value);
                }
            }
        }
        Ok(())
    }

    /// From few nodes to many.
    pub(super) fn refine(&mut self, from: &Nodes, grid: &Grid) {
        let (space, to) = (self.space, &grid.fine);
        let mut points = to.s.clone();
        points.push(1.0);
        let [values, integral, ..] = from.integrals_at(&points);
        let matrices = [&values[..to.len() * from.len()], &integral];
        let mut scratch = leg::Scratch::new(space, to.len());
        vectorised(
            #[inline(always)]
            || {
                for leg in &mut self.legs {
                    *leg = leg.on_nodes(space, [from, to], matrices, &mut self.scratch);
                    leg.correct_frames(space, to, &mut scratch);
                    leg.smooth(space, to, &mut scratch);
                }
            },
        );
        self.scratch = scratch;
        self.linearisation = Linearisation::new(space, grid);
        self.linear = self
            .legs
            .iter()
            .map(|_| LinearLeg::new(space, grid))
            .collect();
    }

    pub(super) fn advance(&mut self, share: f64) {
        let space = self.space;
        for (velocity, step) in self.velocities.iter_mut().zip(&self.step) {
            *velocity += share * step;
        }
        vectorised(
            #[inline(always)]
            || {
                for (linear, leg) in self.linear.iter().zip(&mut self.legs) {
                    linear.advance(space, leg, share);
                }
            },
        );
    }

    /// Evaluates what is left of all equations.
    pub(super) fn evaluate(&mut self, grid: &Grid) {
        let (space, nodes, scratch) = (self.space, &grid.fine, &mut self.scratch);
        let smooth = nodes.len() > grid.coarse.len();
        (self.merit, self.size) = vectorised(
            #[inline(always)]
            || {
                let (mut size, mut squares) = (0.0, T::ZERO);
                for leg in &mut self.legs {
                    leg.set_motion(space, nodes);
                    if smooth {
                        leg.smooth(space, nodes, scratch);
                    }
                    set_frames(space, leg, nodes, scratch);
                    leg.set_residual(space, nodes, scratch);
                    size = larger(size, leg.largest_residual());
                    size = larger(size, leg.largest_defect_of_frames());
                    squares += leg.sum_of_squares(space, nodes);
                }
                let squares = (0..T::COUNT).map(|lane| squares.lane(lane)).sum::<f64>();
                (squares, size)
            },
        );
        self.set_jumps();
        let d = self.space.dim();
        for knot in 0..self.knots.count() {
            let square = self.knots.shortest(knot).powi(2);
            for jump in &self.jumps[knot * d..][..d] {
                self.merit += (square * jump).powi(2);
                self.size = larger(self.size, square * jump.abs());
            }
        }
        self.merit = self.merit.sqrt();
    }

    /// The largest velocity on a leg.
    pub(super) fn speed(&self) -> f64 {
        let speeds = self.legs.iter().map(|leg| leg.speed(self.space));
        speeds.fold(0.0, larger)
    }

    /// The last Legendre coefficients of the frames' derivative.
    pub(super) fn tail(&mut self, nodes: &Nodes) -> f64 {
        let (space, scratch) = (self.space, &mut self.scratch);
        vectorised(
            #[inline(always)]
            || {
                let tails = self
                    .legs
                    .iter_mut()
                    .map(|leg| leg.tail(space, nodes, scratch));
                tails.fold(0.0, larger)
            },
        )
    }

    /// The polynomials of all legs.
    pub(super) fn dense(&self, nodes: &Nodes) -> Dense {
        let (space, legs) = (self.space, self.knots.lengths.len());
        let expansion = Expansion::new(nodes);
        let mut dense = Dense::new(legs, nodes.len(), space);
        vectorised(
            #[inline(always)]
            || {
                for (group, leg) in self.legs.iter().enumerate() {
                    dense.write(space, &expansion, group * T::COUNT, leg, legs);
                }
            },
        );
        dense
    }

    /// The largest entry of an acceleration or a third vector.
    pub(super) fn largest_bend(&self) -> f64 {
        let legs = self.legs.iter();
        legs.fold(0.0, |size, leg| {
            larger(
                size,
                larger(largest(&leg.acceleration), largest(&leg.third)),
            )
        })
    }

    pub(super) fn write(&self, velocities: &mut [f64], bends: &mut [f64]) {
        let d = self.space.dim();
        velocities.copy_from_slice(&self.velocities);
        for (i, bend) in bends.chunks_exact_mut(2 * d).enumerate() {
            let (leg, lane) = (&self.legs[i / T::COUNT], i % T::COUNT);
            let vectors = leg.acceleration.iter().chain(&leg.third);
            for (bend, x) in bend.iter_mut().zip(vectors) {
                *bend = x.lane(lane);
            }
        }
    }

    fn set_jumps(&mut self) {
        let d = self.space.dim();
        let mut jumps = vec![0.0; self.knots.count() * d];
        for (knot, jump) in jumps.chunks_exact_mut(d).enumerate() {
            match self.knots.end_at(knot) {
                Some((End::Velocity(_), _)) => continue,
                Some((End::Acceleration(wanted), sign)) => {
                    for (jump, wanted) in jump.iter_mut().zip(wanted) {
                        *jump = sign * wanted;
                    }
                }
                None => {}
            }
            let [before, after] = self.knots.legs_at(knot);
            if let Some(leg) = before {
                self.add(jump, leg, 1.0, |leg| &leg.last_acceleration);
            }
            if let Some(leg) = after {
                self.add(jump, leg, -1.0, |leg| &leg.acceleration);
            }
        }
        self.jumps = jumps;
    }

    /// Adds an acceleration of a leg, per unit of time squared.
    fn add(&self, to: &mut [f64], leg: usize, sign: f64, vector: impl Fn(&Leg<T>) -> &Vec<T>) {
        let rate = sign * self.knots.lengths[leg].powi(-2);
        let vector = vector(&self.legs[leg / T::COUNT]);
        for (to, x) in to.iter_mut().zip(vector) {
            *to += rate * x.lane(leg % T::COUNT);
        }
    }

    /// Sets up the linear equations and the step that solves them; `false` where they are singular.
    pub(super) fn linearise(&mut self, grid: &Grid) -> bool {
        let space = self.space;
        let d = space.dim();
        vectorised(
            #[inline(always)]
            || {
                for (linear, leg) in self.linear.iter_mut().zip(&self.legs) {
                    linear.set(space, grid, leg, &mut self.linearisation);
                }
            },
        );
        let Some(mut steps) = self.velocity_steps() else {
            return false;
        };
        if steps.iter().any(|step| !step.is_finite()) {
            return false;
        }
        if matches!(self.knots.ends, Ends::Periodic) {
            steps.extend_from_within(..d);
        }
        let count = self.knots.lengths.len();
        let (mut first, mut last) = (vec![T::ZERO; d], vec![T::ZERO; d]);
        vectorised(
            #[inline(always)]
            || {
                for (group, (linear, leg)) in self.linear.iter_mut().zip(&self.legs).enumerate() {
                    for lane in 0..T::COUNT {
                        let i = (group * T::COUNT + lane).min(count - 1);
                        let h = self.knots.lengths[i];
                        for p in 0..d {
                            first[p].set_lane(lane, h * steps[i * d + p]);
                            last[p].set_lane(lane, h * steps[(i + 1) * d + p]);
                        }
                    }
                    linear.set_step(space, grid, leg, [&first, &last]);
                }
            },
        );
        self.step = steps;
        true
    }

    /// The changes of the velocities: a block tridiagonal system.
    fn velocity_steps(&self) -> Option<Vec<f64>> {
        let d = self.space.dim();
        let (count, narrow) = (self.knots.count(), 2 * d + 1);
        let mut system = BlockTridiagonal::zeros(count, d);
        let mut right: Vec<f64> = self.jumps.iter().map(|jump| -jump).collect();
        for knot in 0..count {
            let block = knot * d * d;
            if let Some((End::Velocity(_), _)) = self.knots.end_at(knot) {
                for p in 0..d {
                    system.diagonal[block + p * d + p] = 1.0;
                }
                continue;
            }
            let [before, after] = self.knots.legs_at(knot);
            if let Some(leg) = before {
                let (h, lane) = (self.knots.lengths[leg], leg % T::COUNT);
                let form = &self.linear[leg / T::COUNT].last_acceleration;
                for (p, form) in form.chunks_exact(narrow).enumerate() {
                    for q in 0..d {
                        system.below[block + p * d + q] += form[q].lane(lane) / h;
                        system.diagonal[block + p * d + q] += form[d + q].lane(lane) / h;
                    }
                    right[knot * d + p] -= form[2 * d].lane(lane) / (h * h);
                }
            }
            if let Some(leg) = after {
                let (h, lane) = (self.knots.lengths[leg], leg % T::COUNT);
                let form = &self.linear[leg / T::COUNT].start;
                for (p, form) in form.chunks_exact(narrow).take(d).enumerate() {
                    for q in 0..d {
                        system.diagonal[block + p * d + q] -= form[q].lane(lane) / h;
                        system.above[block + p * d + q] -= form[d + q].lane(lane) / h;
                    }
                    right[knot * d + p] += form[2 * d].lane(lane) / (h * h);
                }
            }
        }
        match self.knots.ends {
            Ends::Open(_) => system.solve(&mut right)?,
            Ends::Periodic => system.solve_cyclic(&mut right)?,
        }
        Some(right)
    }
}

/// Frames that go with the motion of a leg: corrected, or found anew where they are far off.
#[inline(always)]
fn set_frames<T: Field, S: Homogeneous>(
    space: S,
    leg: &mut Leg<T>,
    nodes: &Nodes,
    scratch: &mut leg::Scratch<T>,
) {
    leg.correct_frames(space, nodes, scratch);
    let mut defect = leg.largest_defect_of_frames();
    let is_near = defect < FRAMES_AWAY;
    if !is_near {
        leg.reset_frames(space);
        let sweeps = (SWEEPS[0] + SWEEPS[1] * leg.speed(space))
            .ceil()
            .min(MOST_SWEEPS);
        for _ in 0..sweeps as usize {
            leg.sweep_frames(space, nodes, scratch);
        }
        leg.correct_frames(space, nodes, scratch);
        defect = leg.largest_defect_of_frames();
    }
    while (FRAMES_NEAR..FRAMES_AWAY).contains(&defect) {
        leg.correct_frames(space, nodes, scratch);
        let before = std::mem::replace(&mut defect, leg.largest_defect_of_frames());
        if defect > before {
            break;
        }
    }
}
