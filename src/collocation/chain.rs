//! A chain of legs between given points: all equations of all legs at once, and the step that solves them linearised.

use rayon::prelude::*;

use super::dense::{Dense, Expansion};
use super::knots::{End, Knots};
use super::leg::{self, Leg};
use super::nodes::Nodes;
use crate::error::Result;
use crate::linalg::field::{Field, larger, largest};
use crate::linalg::simd::vectorised;
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
pub(crate) type ThirdDerivative<'a> = dyn Fn(usize, &[f64]) -> Result<Vec<f64>> + 'a;

/// Groups that one task of the pool takes, and so many in all are not worth it.
const TASK: usize = 8;

/// Legs in a row, or groups of eight, with what is left of their equations.
pub(super) struct Chain<'k, T, S> {
    pub(super) space: S,
    pub(super) knots: &'k Knots<'k>,
    pub(super) groups: Vec<Group<T>>,
    /// What a thread needs.
    pub(super) buffers: leg::Scratch<T>,
    pub(super) velocities: Vec<f64>,
    /// Of the covariant acceleration at the knots: before less after, at an end less the wanted one.
    pub(super) jumps: Vec<f64>,
    /// The largest entry of what is left of the equations.
    pub(super) size: f64,
}

/// A leg, or eight of them, with `x'''` before the sweep.
pub(super) struct Group<T> {
    pub(super) leg: Leg<T>,
    pub(super) before: Vec<T>,
}

impl<T: Field> Group<T> {
    fn new(leg: Leg<T>) -> Self {
        Group {
            before: vec![T::ZERO; leg.f.len()],
            leg,
        }
    }
}

impl<'k, T: Field, S: Homogeneous> Chain<'k, T, S> {
    pub(super) fn new(
        space: S,
        knots: &'k Knots<'k>,
        velocities: &[f64],
        bends: &[f64],
        nodes: &Nodes,
    ) -> Self {
        let (d, r, count) = (space.dim(), space.size(), knots.lengths.len());
        let groups = count.div_ceil(T::COUNT);
        let mut chain: Self = Chain {
            space,
            knots,
            groups: (0..groups)
                .map(|_| Group::new(Leg::new(space, nodes.len())))
                .collect(),
            buffers: leg::Scratch::new(space, nodes.len()),
            velocities: velocities.to_vec(),
            jumps: Vec::new(),
            size: f64::INFINITY,
        };
        for (group, Group { leg, .. }) in chain.groups.iter_mut().enumerate() {
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
        for (group, Group { leg, .. }) in self.groups.iter_mut().enumerate() {
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
    pub(super) fn refine(&mut self, from: &Nodes, to: &Nodes) {
        let (space, between) = (self.space, from.onto(to));
        let matrices = between.each_ref().map(Vec::as_slice);
        let mut buffers = [self.buffers.clone(), leg::Scratch::new(space, to.len())];
        each(
            &mut self.groups,
            &mut buffers,
            #[inline(always)]
            |[coarse, fine], _, group| {
                let mut leg = group.leg.on_nodes(space, [from, to], matrices, coarse);
                leg.correct_frames(space, to, fine);
                leg.smooth(space, to, fine);
                *group = Group::new(leg);
            },
        );
        self.buffers = leg::Scratch::new(space, to.len());
    }

    /// `x'''` becomes what the equations say, and the frames go with the motion; evaluates what is left of all equations.
    pub(super) fn sweep_once(&mut self, nodes: &Nodes) {
        let space = self.space;
        each(
            &mut self.groups,
            &mut self.buffers,
            #[inline(always)]
            |scratch, _, Group { leg, before }| {
                before.copy_from_slice(&leg.f);
                leg.set_motion(space, nodes);
                leg.smooth(space, nodes, scratch);
                set_frames(space, leg, nodes, scratch);
                leg.set_residual(space, nodes, scratch);
            },
        );
        self.size = 0.0;
        for Group { leg, .. } in &self.groups {
            self.size = larger(self.size, leg.residual.size);
        }
        self.set_jumps();
        let d = self.space.dim();
        for knot in 0..self.knots.count() {
            let square = self.knots.shortest(knot).powi(2);
            for jump in &self.jumps[knot * d..][..d] {
                self.size = larger(self.size, square * jump.abs());
            }
        }
    }

    /// Products of a sweep.
    pub(super) fn products_of_sweep(&self, nodes: &Nodes) -> f64 {
        let [d, r] = [self.space.dim(), self.space.size()].map(|size| size as f64);
        let count = nodes.len() as f64;
        let leg = 4.0 * count * count * (d + r * r) + count * r * r * (6.0 * r + 2.0 * d);
        self.knots.lengths.len() as f64 * leg
    }

    /// The largest velocity on a leg.
    pub(super) fn speed(&self) -> f64 {
        let speeds = self.groups.iter().map(|group| group.leg.speed(self.space));
        speeds.fold(0.0, larger)
    }

    /// The last Legendre coefficients of the frames' derivative.
    pub(super) fn tail(&mut self, nodes: &Nodes) -> f64 {
        let (space, scratch) = (self.space, &mut self.buffers);
        vectorised(
            #[inline(always)]
            || {
                let groups = self.groups.iter_mut();
                let tails = groups.map(|group| group.leg.tail(space, nodes, scratch));
                tails.fold(0.0, larger)
            },
        )
    }

    /// The polynomials of all legs.
    pub(super) fn dense(&self, nodes: &Nodes) -> Dense {
        let (space, legs) = (self.space, self.knots.lengths.len());
        let expansion = Expansion::of(nodes);
        let mut dense = Dense::new(legs, nodes.len(), space);
        vectorised(
            #[inline(always)]
            || {
                for (i, group) in self.groups.iter().enumerate() {
                    dense.write(space, &expansion, i * T::COUNT, &group.leg, legs);
                }
            },
        );
        dense
    }

    /// The largest entry of an acceleration or a third vector.
    pub(super) fn largest_bend(&self) -> f64 {
        let groups = self.groups.iter();
        groups.fold(0.0, |size, Group { leg, .. }| {
            let here = larger(largest(&leg.acceleration), largest(&leg.third));
            larger(size, here)
        })
    }

    pub(super) fn write(&self, velocities: &mut [f64], bends: &mut [f64]) {
        let d = self.space.dim();
        velocities.copy_from_slice(&self.velocities);
        for (i, bend) in bends.chunks_exact_mut(2 * d).enumerate() {
            let (leg, lane) = (&self.groups[i / T::COUNT].leg, i % T::COUNT);
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
        let vector = vector(&self.groups[leg / T::COUNT].leg);
        for (to, x) in to.iter_mut().zip(vector) {
            *to += rate * x.lane(leg % T::COUNT);
        }
    }
}

/// Work on every item, in tasks of the pool where there are more than a few, compiled for the widest vector instructions; the
/// same for any number of threads.
#[inline(always)]
pub(crate) fn each<A: Send, B: Clone + Send + Sync>(
    items: &mut [A],
    buffers: &mut B,
    work: impl Fn(&mut B, usize, &mut A) + Sync,
) {
    if items.len() <= TASK || rayon::current_num_threads() == 1 {
        return vectorised(
            #[inline(always)]
            || {
                for (i, item) in items.iter_mut().enumerate() {
                    work(buffers, i, item);
                }
            },
        );
    }
    let buffers = &*buffers;
    let tasks = items.par_chunks_mut(TASK).enumerate();
    tasks.for_each(|(task, items)| {
        let mut buffers = buffers.clone();
        vectorised(
            #[inline(always)]
            || {
                for (i, item) in items.iter_mut().enumerate() {
                    work(&mut buffers, TASK * task + i, item);
                }
            },
        );
    });
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
