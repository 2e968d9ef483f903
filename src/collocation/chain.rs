//! A chain of legs between given points: all equations of all legs at once, and the step that solves their
//! linearisation.

use super::expansion::Expansion;
use super::leg::{self, Leg};
use crate::curve::nodes::Nodes;
use crate::error::Result;
use crate::legs::{Dense, Knots, ThirdDerivative};
use crate::linalg::field::{Field, larger, largest};
use crate::linalg::simd::{each, vectorised};
use crate::space::Homogeneous;

/// Number of Picard iterations for frames without rotation, and additional ones per radian.
const SWEEPS: [f64; 2] = [3.0, 2.0];

/// Maximal number of Picard iterations: a motion that needs more has gone astray.
const MOST_SWEEPS: f64 = 48.0;

/// Frames with a larger defect are computed by Picard's iteration.
const FRAMES_AWAY: f64 = 0.3;

/// Frames are corrected until their defect is below this.
const FRAMES_NEAR: f64 = 1e-2;

/// Consecutive legs, or groups of eight, with the residuals of their equations.
pub(super) struct Chain<'k, T, S> {
    pub(super) space: S,
    pub(super) knots: &'k Knots<'k>,
    pub(super) groups: Vec<Group<T>>,
    /// Buffers of a thread.
    pub(super) buffers: leg::Scratch<T>,
    pub(super) velocities: Vec<f64>,
    /// Jumps of the covariant acceleration at the knots: before minus after; at an end, minus the given one.
    pub(super) jumps: Vec<f64>,
    /// The largest residual.
    pub(super) size: f64,
}

/// One leg, or eight of them, with `x'''` before the sweep.
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
        let (d, r) = (space.dim(), space.size());
        let groups = knots.lengths.len().div_ceil(T::COUNT);
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
            knots.write_targets(r, group, &mut leg.target);
            leg.tension = knots.tensions(group);
            let ends = [&mut leg.velocity, &mut leg.last_velocity].map(Vec::as_mut_slice);
            knots.write_velocities(velocities, group, ends);
            for lane in 0..T::COUNT {
                let i = knots.leg_in::<T>(group, lane);
                for p in 0..d {
                    leg.acceleration[p].set_lane(lane, bends[2 * i * d + p]);
                    leg.third[p].set_lane(lane, bends[(2 * i + 1) * d + p]);
                }
            }
        }
        chain
    }

    /// Sets `x'''` of every leg at the nodes.
    pub(super) fn set_third_derivatives(
        &mut self,
        nodes: &Nodes,
        third_derivative: &ThirdDerivative<'_>,
    ) -> Result<()> {
        for (group, Group { leg, .. }) in self.groups.iter_mut().enumerate() {
            for lane in 0..T::COUNT {
                let values = third_derivative(self.knots.leg_in::<T>(group, lane), &nodes.s)?;
                for (f, value) in leg.f.iter_mut().zip(values) {
                    f.set_lane(lane, value);
                }
            }
        }
        Ok(())
    }

    /// Changes from few nodes to many.
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

    /// Updates `x'''` from the equations, and the frames from the motion; evaluates all residuals.
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
        let (d, groups) = (space.dim(), &self.groups);
        self.jumps = self.knots.jumps(d, |leg| {
            let leg = &groups[leg / T::COUNT].leg;
            [&leg.acceleration, &leg.last_acceleration].map(Vec::as_slice)
        });
        self.size = self.knots.largest_jump(&self.jumps, d);
        for Group { leg, .. } in groups {
            self.size = larger(self.size, leg.residual.size);
        }
    }

    /// Number of products of a sweep.
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
        let (space, expansion) = (self.space, Expansion::of(nodes));
        let mut dense = Dense::new(self.knots.lengths.len(), nodes.len(), space);
        vectorised(
            #[inline(always)]
            || {
                for (group, Group { leg, .. }) in self.groups.iter().enumerate() {
                    expansion.write(space, group * T::COUNT, leg, &mut dense);
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
}

/// Updates the frames for the motion of a leg: corrected, or recomputed if their defect is large.
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
