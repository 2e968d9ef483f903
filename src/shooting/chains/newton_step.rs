//! The step of Newton's method for a chain: legs are condensed to the velocities at the knots, which solve a block
//! tridiagonal system.

use super::chain::{ChainBuffers, LegGroup, SeriesChain, terms};
use crate::legs::Ends;
use crate::linalg::field::{Field, larger, largest};
use crate::linalg::simd::{Buffers, each};
use crate::shooting::taylor::condensed_leg::CondensedLeg;
use crate::shooting::taylor::durations::{micros_of_derivative, micros_of_step};
use crate::space::Homogeneous;

impl<T: Field, S: Homogeneous> SeriesChain<'_, T, S> {
    /// Sets up the linear equations of those legs that need new ones at the current state; `false` if they are
    /// singular.
    pub(crate) fn linearise(&mut self) -> bool {
        let space = self.space;
        let stale = self.groups.iter().filter(|group| group.progress.is_stale);
        let stale = stale.count();
        if stale == 0 {
            return true;
        }
        let share = stale as f64 / self.groups.len() as f64;
        each::<S::Width, _, _>(
            &mut self.groups,
            share * micros_of_derivative(space),
            &mut self.buffers,
            #[inline(always)]
            |ChainBuffers {
                 leg: scratch,
                 variation,
             },
             _,
             LegGroup {
                 leg,
                 linear,
                 progress,
                 ..
             }| {
                progress.is_new = progress.is_stale;
                if progress.is_stale {
                    linear.linearise(space, leg, terms(space, leg), scratch, variation);
                    progress.is_stale = false;
                }
            },
        );
        self.factor_velocity_system();
        self.factors.is_some()
    }

    /// Computes the step that solves the linear equations for the current residuals; `false` if it is not finite.
    pub(crate) fn set_step(&mut self) -> bool {
        let (space, knots, d) = (self.space, self.knots, self.space.dim());
        each::<S::Width, _, _>(
            &mut self.groups,
            micros_of_step(space),
            &mut Buffers::new(()),
            #[inline(always)]
            |(), _, LegGroup { leg, linear, .. }| linear.set_constants(space, leg),
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
        let mut buffers = Buffers::new([(); 3].map(|()| vec![T::ZERO; d]));
        each::<S::Width, _, _>(
            &mut self.groups,
            micros_of_step(space),
            &mut buffers,
            #[inline(always)]
            |[first, last, turned],
             group,
             LegGroup {
                 leg,
                 step,
                 linear,
                 progress,
             }| {
                knots.write_velocities(&steps, group, [first, last]);
                linear.write_step(space, leg, [first, last], turned, step);
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

    /// Factors the system for the changes of the velocities, block tridiagonal, from the accelerations at the knots;
    /// the factors are `None` if it is singular.
    fn factor_velocity_system(&mut self) {
        let d = self.space.dim();
        let SeriesChain {
            knots,
            groups,
            system,
            factors,
            ..
        } = self;
        let is_new = |knot: usize| {
            let mut legs = knots.legs_at(knot).into_iter().flatten();
            legs.any(|leg| groups[leg / T::COUNT].progress.is_new)
        };
        let is_set = |knot: &usize| is_new(*knot) && !knots.is_fixed(*knot);
        for knot in (0..knots.count()).filter(is_set) {
            let [below, diagonal, above] = system.row_mut(knot);
            for block in [&mut *below, &mut *diagonal, &mut *above] {
                block.fill(0.0);
            }
            let [before, after] = knots.legs_at(knot);
            let add = |leg: usize, end: usize, sign: f64, blocks: [&mut [f64]; 2]| {
                let form = &groups[leg / T::COUNT].linear.by_velocities[end];
                add_lane(d, form, leg % T::COUNT, sign / knots.lengths[leg], blocks);
            };
            if let Some(leg) = before {
                add(leg, 1, 1.0, [below, diagonal]);
            }
            if let Some(leg) = after {
                add(leg, 0, -1.0, [diagonal, above]);
            }
        }
        *factors = match (knots.ends, factors.take()) {
            (Ends::Periodic, _) => system.clone().factored_cyclic(),
            (Ends::Open(_), None) => system.factored(),
            (Ends::Open(_), Some(mut factors)) => factors.update(system, is_new).map(|()| factors),
        };
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

/// Adds a lane of a matrix of shape `(d, 2 d)`, times a factor, to two matrices of shape `(d, d)`.
#[inline(always)]
fn add_lane<T: Field>(
    d: usize,
    matrix: &[T],
    lane: usize,
    factor: f64,
    [first, last]: [&mut [f64]; 2],
) {
    let blocks = first.chunks_exact_mut(d).zip(last.chunks_exact_mut(d));
    for (row, (first, last)) in matrix.chunks_exact(2 * d).zip(blocks) {
        let (by_first, by_last) = row.split_at(d);
        for (out, x) in first.iter_mut().zip(by_first) {
            *out += x.lane(lane) * factor;
        }
        for (out, x) in last.iter_mut().zip(by_last) {
            *out += x.lane(lane) * factor;
        }
    }
}
