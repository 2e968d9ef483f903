//! The linearised equations of a leg, solved for everything except the velocities at its ends.

use super::leg::{LegScratch, SeriesLeg};
use super::leg_equations::{combined, residual_into, set_equations};
use super::room::Room;
use super::variation::MiddleVariation;
use crate::linalg::field::{Field, accumulate, factor, substitute, substitute_rows};
use crate::space::Homogeneous;

/// The linear equations `C dm = b + V dv` for the change of a leg's middle, where `b` is the current residual and `V
/// dv` is the effect of changes of the velocities at the ends.
///
/// Everything except `b` belongs to the state at which [`CondensedLeg::linearise`] was called.
pub(crate) struct CondensedLeg<'a, T> {
    /// Factors of `C`, shape `(3 d, 3 d)`.
    factors: &'a mut [T],
    /// Changes of `x'` at both ends, the last one expressed in the next knot's frame: by `b`, shape `(d, 3 d)`; by
    /// `dv`, shape `(d, 2 d)`; and by the current `b`.
    by_conditions: [&'a mut [T]; 2],
    pub(crate) by_velocities: [&'a mut [T]; 2],
    pub(crate) constants: [&'a mut [T]; 2],
    /// `b`.
    right: &'a mut [T],
}

impl<'a, T: Field> CondensedLeg<'a, T> {
    /// Number of floating-point numbers of a condensed leg.
    pub(crate) fn len(space: impl Homogeneous) -> usize {
        let d = space.dim();
        19 * d * d + 5 * d
    }

    pub(crate) fn new(space: impl Homogeneous, room: &mut Room<'a, T>) -> Self {
        let d = space.dim();
        CondensedLeg {
            factors: room.take(9 * d * d),
            by_conditions: std::array::from_fn(|_| room.take(3 * d * d)),
            by_velocities: std::array::from_fn(|_| room.take(2 * d * d)),
            constants: std::array::from_fn(|_| room.take(d)),
            right: room.take(3 * d),
        }
    }

    /// Linearises at the current state of a leg, with `terms` terms of its series; `variation` has room for as many, and for
    /// `x` and `x'` at the ends.
    #[inline(always)]
    pub(crate) fn linearise(
        &mut self,
        space: impl Homogeneous,
        leg: &SeriesLeg<'_, T>,
        terms: usize,
        scratch: &mut LegScratch<T>,
        variation: &mut MiddleVariation<T>,
    ) {
        let wide = 3 * space.dim();
        set_equations(space, leg, terms, scratch, variation, self.factors);
        factor(wide, self.factors);
        for (end, slope) in variation.ends[1].iter().enumerate() {
            let by_conditions = &mut *self.by_conditions[end];
            match end {
                0 => by_conditions.copy_from_slice(slope),
                _ => space.turn_columns(leg.holonomy, slope, wide, by_conditions),
            }
            substitute_rows(wide, self.factors, by_conditions);
            set_by_velocities(space, leg, by_conditions, self.by_velocities[end]);
        }
    }

    /// Sets the residuals at the current state of a leg.
    #[inline(always)]
    pub(crate) fn set_constants(&mut self, space: impl Homogeneous, leg: &SeriesLeg<'_, T>) {
        let d = space.dim();
        residual_into(leg, self.right);
        for x in &mut *self.right {
            *x = -*x;
        }
        for (constant, by_conditions) in self.constants.iter_mut().zip(&self.by_conditions) {
            constant.fill(T::ZERO);
            accumulate(by_conditions, 3 * d, self.right, 1, constant);
        }
    }

    /// Writes the change of the middle for changes of the velocities at the ends; `turned` holds `d` numbers.
    #[inline(always)]
    pub(crate) fn write_step(
        &self,
        space: impl Homogeneous,
        leg: &SeriesLeg<'_, T>,
        [first, last]: [&[T]; 2],
        turned: &mut [T],
        step: &mut [T],
    ) {
        let d = space.dim();
        space.turn_back_into(leg.holonomy, last, turned);
        for p in 0..d {
            let rows = combined(T::ZERO, [first[p], turned[p]]);
            for (i, row) in rows.into_iter().enumerate() {
                step[i * d + p] = self.right[i * d + p] + row;
            }
        }
        substitute(3 * d, self.factors, 1, step);
    }
}

/// `by_conditions V`, in column-major order.
#[inline(always)]
fn set_by_velocities<T: Field>(
    space: impl Homogeneous,
    leg: &SeriesLeg<'_, T>,
    by_conditions: &[T],
    out: &mut [T],
) {
    let d = space.dim();
    if space.isotropy_dim() == 0 {
        // Without rotation.
        let rows = by_conditions.chunks_exact(3 * d);
        for (row, out) in rows.zip(out.chunks_exact_mut(2 * d)) {
            for q in 0..d {
                let (difference, both) = (row[d + q], row[2 * d + q] * 6.0);
                (out[q], out[d + q]) = (both - difference, both + difference);
            }
        }
        return;
    }
    let (mut unit, mut turned) = (vec![T::ZERO; d], vec![T::ZERO; d]);
    for q in 0..d {
        unit.fill(T::ZERO);
        unit[q] = T::constant(1.0);
        space.turn_back_into(leg.holonomy, &unit, &mut turned);
        let rows = by_conditions.chunks_exact(3 * d);
        for (row, out) in rows.zip(out.chunks_exact_mut(2 * d)) {
            let [_, first, both] = combined(T::ZERO, [unit[q], T::ZERO]);
            out[q] = row[d + q] * first + row[2 * d + q] * both;
            let mut sum = T::ZERO;
            for p in 0..d {
                let [_, last, both] = combined(T::ZERO, [T::ZERO, turned[p]]);
                sum += row[d + p] * last;
                sum += row[2 * d + p] * both;
            }
            out[d + q] = sum;
        }
    }
}
