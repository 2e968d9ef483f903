//! The linearised equations of a leg, solved for everything but the velocities at its ends.

use super::leg::Leg;
use super::linearisation::{Linearisation, write_column};
use super::nodes::Grid;
use crate::linalg::field::{Field, accumulate, factor, substitute};
use crate::space::Homogeneous;

/// The changes of a leg's unknowns as `by_first dv_0 + by_last dv_1 + constant`.
///
/// With `F` what is left of the equation at the nodes, the change of `f = x'''` is `-F` and a polynomial `phi` through coarse
/// nodes, which solves
///
/// ```math
/// (I - K)\,\phi = K\bigl(dx_0 + dx_0'\,s + \tfrac12 dx_0''\,s^2 - \textstyle\iiint F\bigr)
/// ```
///
/// where `K` is the derivative of the right-hand side. `dx_0'` and `dx_0''` follow from the point and the velocity at the end: the
/// frame `g` changes by `g eta` with `eta = Ad_g^{-1} int Ad_g dx`.
pub(super) struct LinearLeg<T> {
    /// Change of `x'` and `x''` at the start, shape `(2 d, 2 d + 1)`.
    pub(super) start: Vec<T>,
    /// Change of `phi`, shape `(coarse d, 2 d + 1)`.
    phi: Vec<T>,
    /// Change of the last acceleration, in the frame of the next knot, shape `(d, 2 d + 1)`.
    pub(super) last_acceleration: Vec<T>,
    step: Step<T>,
}

/// Changes of a leg's unknowns, and of `phi`.
struct Step<T> {
    velocity: Vec<T>,
    last_velocity: Vec<T>,
    start: Vec<T>,
    phi: Vec<T>,
    f: Vec<T>,
}

impl<T: Field> LinearLeg<T> {
    pub(super) fn new(space: impl Homogeneous, grid: &Grid) -> Self {
        let (d, count) = (space.dim(), grid.coarse.len());
        let zeros = |count: usize| vec![T::ZERO; count];
        let narrow = 2 * d + 1;
        LinearLeg {
            start: zeros(2 * d * narrow),
            phi: zeros(count * d * narrow),
            last_acceleration: zeros(d * narrow),
            step: Step {
                velocity: zeros(d),
                last_velocity: zeros(d),
                start: zeros(2 * d),
                phi: zeros(count * d),
                f: zeros(grid.fine.len() * d),
            },
        }
    }

    /// At the present state of a leg.
    #[inline(always)]
    pub(super) fn set(
        &mut self,
        space: impl Homogeneous,
        grid: &Grid,
        leg: &Leg<T>,
        scratch: &mut Linearisation<T>,
    ) {
        scratch.interpolate(space, grid, leg);
        scratch.solve_for_phi(space, grid);
        scratch.set_eta(space, grid, leg);
        scratch.set_last(space, grid, leg);
        self.solve_for_start(space, leg, scratch);
    }

    /// `dx_0'` and `dx_0''` from the point and the velocity at the end, and what follows from them.
    #[inline(always)]
    fn solve_for_start(
        &mut self,
        space: impl Homogeneous,
        leg: &Leg<T>,
        scratch: &mut Linearisation<T>,
    ) {
        let d = space.dim();
        let (wide, narrow) = (3 * d + 1, 2 * d + 1);
        let Linearisation {
            eta,
            last: [velocity, acceleration],
            conditions,
            forms,
            matrices,
            ..
        } = scratch;
        let (unit, rest) = matrices.split_at_mut(d);
        let turned = &mut rest[..d];
        self.start.fill(T::ZERO);
        for (rows, form) in [&*velocity, &*eta].into_iter().enumerate() {
            for p in 0..d {
                let (row, form) = (rows * d + p, &form[p * wide..][..wide]);
                conditions[row * 2 * d..][..2 * d].copy_from_slice(&form[d..3 * d]);
                let start = &mut self.start[row * narrow..][..narrow];
                for q in 0..d {
                    start[q] = -form[q];
                }
                start[2 * d] = -form[3 * d];
            }
        }
        for q in 0..d {
            unit.fill(T::ZERO);
            unit[q] = T::constant(1.0);
            space.turn_back_into(&leg.holonomy, unit, turned);
            for (p, x) in turned.iter().enumerate() {
                self.start[p * narrow + d + q] = *x;
            }
        }
        for p in 0..d {
            self.start[p * narrow + 2 * d] -= leg.residual.velocity[p];
            self.start[(d + p) * narrow + 2 * d] -= leg.residual.point[p];
        }
        factor(2 * d, conditions);
        substitute(2 * d, conditions, narrow, &mut self.start);
        compose(d, forms, &self.start, &mut self.phi);
        compose(d, acceleration, &self.start, &mut self.last_acceleration);
        for column in 0..narrow {
            for (p, x) in unit.iter_mut().enumerate() {
                *x = self.last_acceleration[p * narrow + column];
            }
            space.turn_into(&leg.holonomy, unit, turned);
            write_column(&mut self.last_acceleration, narrow, column, turned);
        }
    }

    /// The change of all unknowns for changes of the velocities at the ends.
    #[inline(always)]
    pub(super) fn set_step(
        &mut self,
        space: impl Homogeneous,
        grid: &Grid,
        leg: &Leg<T>,
        [first, last]: [&[T]; 2],
    ) {
        let d = space.dim();
        let narrow = 2 * d + 1;
        let value = |form: &[T]| {
            let mut sum = form[2 * d];
            for q in 0..d {
                sum += form[q] * first[q];
                sum += form[d + q] * last[q];
            }
            sum
        };
        let Step {
            velocity,
            last_velocity,
            start,
            phi,
            f,
        } = &mut self.step;
        velocity.copy_from_slice(first);
        last_velocity.copy_from_slice(last);
        for (to, form) in start.iter_mut().zip(self.start.chunks_exact(narrow)) {
            *to = value(form);
        }
        for (to, form) in phi.iter_mut().zip(self.phi.chunks_exact(narrow)) {
            *to = value(form);
        }
        for (f, residual) in f.iter_mut().zip(&leg.residual.f) {
            *f = -*residual;
        }
        accumulate(&grid.up, grid.coarse.len(), phi, d, f);
    }

    /// Changes a leg by a share of the step.
    #[inline(always)]
    pub(super) fn advance(&self, space: impl Homogeneous, leg: &mut Leg<T>, share: f64) {
        let (acceleration, third) = self.step.start.split_at(space.dim());
        let pairs = [
            (&mut leg.velocity, &self.step.velocity[..]),
            (&mut leg.last_velocity, &self.step.last_velocity),
            (&mut leg.acceleration, acceleration),
            (&mut leg.third, third),
            (&mut leg.f, &self.step.f),
        ];
        for (to, step) in pairs {
            for (to, step) in to.iter_mut().zip(step) {
                *to += *step * share;
            }
        }
    }
}

/// From a form of `dx_0, dx_0', dx_0''` and constant to one of the velocities at both ends and constant.
#[inline(always)]
fn compose<T: Field>(d: usize, form: &[T], start: &[T], out: &mut [T]) {
    let (wide, narrow) = (3 * d + 1, 2 * d + 1);
    for (form, out) in form.chunks_exact(wide).zip(out.chunks_exact_mut(narrow)) {
        out[..d].copy_from_slice(&form[..d]);
        out[d..2 * d].fill(T::ZERO);
        out[2 * d] = form[3 * d];
        for (share, row) in form[d..3 * d].iter().zip(start.chunks_exact(narrow)) {
            for (out, entry) in out.iter_mut().zip(row) {
                *out += *share * *entry;
            }
        }
    }
}
