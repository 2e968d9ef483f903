//! The step of Newton's method for a chain: legs are condensed to the velocities at the knots, which solve a block
//! tridiagonal system.

use super::chain::{Buffers, Chain, Group};
use super::condensed_leg::CondensedLeg;
use crate::legs::Ends;
use crate::linalg::field::{Field, larger, largest};
use crate::linalg::simd::each;
use crate::solve::block_tridiagonal::{BlockTridiagonal, Factors};
use crate::space::Homogeneous;

impl<T: Field, S: Homogeneous> Chain<'_, T, S> {
    /// Sets up the linear equations of those legs that need new ones at the current state; `false` if they are
    /// singular.
    pub(super) fn linearise(&mut self) -> bool {
        let (space, terms) = (self.space, self.terms());
        if self.groups.iter().all(|group| !group.progress.is_stale) {
            return true;
        }
        each(
            &mut self.groups,
            &mut self.buffers,
            #[inline(always)]
            |Buffers {
                 leg: scratch,
                 condensing,
             },
             _,
             Group {
                 leg,
                 linear,
                 progress,
                 ..
             }| {
                if progress.is_stale {
                    linear.linearise(space, leg, terms, scratch, condensing);
                    progress.is_stale = false;
                }
            },
        );
        self.factors = self.velocity_system();
        self.factors.is_some()
    }

    /// Computes the step that solves the linear equations for the current residuals; `false` if it is not finite.
    pub(super) fn set_step(&mut self) -> bool {
        let (space, knots, d) = (self.space, self.knots, self.space.dim());
        each(
            &mut self.groups,
            &mut (),
            #[inline(always)]
            |(), _, Group { leg, linear, .. }| linear.set_constants(space, leg),
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
        let mut buffers = [d, d, 4 * d].map(|count| vec![T::ZERO; count]);
        each(
            &mut self.groups,
            &mut buffers,
            #[inline(always)]
            |[first, last, work],
             group,
             Group {
                 leg,
                 step,
                 linear,
                 progress,
             }| {
                knots.write_velocities(&steps, group, [first, last]);
                linear.write_step(space, leg, [first, last], work, step);
                let sizes = [largest(first), largest(last), largest(step)];
                progress.moved = sizes.into_iter().fold(progress.moved, larger);
            },
        );
        self.step = steps;
        true
    }

    fn linear(&self, leg: usize) -> &CondensedLeg<'_, T> {
        &self.groups[leg / T::COUNT].linear
    }

    /// The system for the changes of the velocities, block tridiagonal, from the accelerations at the knots; `None` if
    /// it is singular.
    fn velocity_system(&self) -> Option<Factors> {
        let (d, count) = (self.space.dim(), self.knots.count());
        let mut system = BlockTridiagonal::zeros(count, d);
        for knot in 0..count {
            let block = knot * d * d;
            if self.knots.is_fixed(knot) {
                for p in 0..d {
                    system.diagonal[block + p * d + p] = 1.0;
                }
                continue;
            }
            let [before, after] = self.knots.legs_at(knot);
            if let Some(leg) = before {
                let (rate, lane) = (1.0 / self.knots.lengths[leg], leg % T::COUNT);
                let form = &self.linear(leg).by_velocities[1];
                for (p, form) in form.chunks_exact(2 * d).enumerate() {
                    for q in 0..d {
                        system.below[block + p * d + q] += form[q].lane(lane) * rate;
                        system.diagonal[block + p * d + q] += form[d + q].lane(lane) * rate;
                    }
                }
            }
            if let Some(leg) = after {
                let (rate, lane) = (1.0 / self.knots.lengths[leg], leg % T::COUNT);
                let form = &self.linear(leg).by_velocities[0];
                for (p, form) in form.chunks_exact(2 * d).enumerate() {
                    for q in 0..d {
                        system.diagonal[block + p * d + q] -= form[q].lane(lane) * rate;
                        system.above[block + p * d + q] -= form[d + q].lane(lane) * rate;
                    }
                }
            }
        }
        match self.knots.ends {
            Ends::Open(_) => system.factored(),
            Ends::Periodic => system.factored_cyclic(),
        }
    }

    /// The changes of the velocities.
    fn velocity_steps(&self) -> Option<Vec<f64>> {
        let d = self.space.dim();
        let mut right: Vec<f64> = self.jumps.iter().map(|jump| -jump).collect();
        for (knot, right) in right.chunks_exact_mut(d).enumerate() {
            if self.knots.is_fixed(knot) {
                continue;
            }
            let [before, after] = self.knots.legs_at(knot);
            if let Some(leg) = before {
                let rate = self.knots.lengths[leg].powi(-2);
                for (right, constant) in right.iter_mut().zip(&*self.linear(leg).constants[1]) {
                    *right -= rate * constant.lane(leg % T::COUNT);
                }
            }
            if let Some(leg) = after {
                let rate = self.knots.lengths[leg].powi(-2);
                for (right, constant) in right.iter_mut().zip(&*self.linear(leg).constants[0]) {
                    *right += rate * constant.lane(leg % T::COUNT);
                }
            }
        }
        self.factors.as_ref()?.solve(&mut right);
        Some(right)
    }
}
