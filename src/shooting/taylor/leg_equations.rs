//! The linearised equations of a leg for its middle.

use super::leg::{LegScratch, SeriesLeg};
use super::variation::MiddleVariation;
use crate::linalg::field::Field;
use crate::space::Homogeneous;

/// Sets the matrix of the equations from `terms` terms of the series of a leg, shape `(3 d, 3 d)`, not factored. The
/// changes at both ends caused by the middle stay in `variation`; those of `x` and `x'` include the rotation of the
/// frame reached.
#[inline(always)]
pub(crate) fn set_equations<T: Field>(
    space: impl Homogeneous,
    leg: &SeriesLeg<'_, T>,
    terms: usize,
    scratch: &mut LegScratch<T>,
    variation: &mut MiddleVariation<T>,
    matrix: &mut [T],
) {
    let (d, wide) = (space.dim(), 3 * space.dim());
    let series = &mut scratch.series;
    series.set_curve(space, leg.middle(), leg.tension, terms);
    series.set_frames(space, terms + 3);
    variation.set(space, series, leg.tension, terms);
    let MiddleVariation { ends, eta, .. } = variation;
    for (reached, ends) in leg.reached.iter().zip(ends.iter_mut()) {
        space.add_turning(reached, eta, wide, &mut ends[1]);
    }
    let [first, last] = &ends[0];
    for row in 0..d {
        for column in 0..wide {
            let at = row * wide + column;
            for (i, combined) in combined(eta[at], [first[at], last[at]])
                .into_iter()
                .enumerate()
            {
                matrix[(i * d + row) * wide + column] = combined;
            }
        }
    }
}

/// The residuals of a leg's equations, in the combinations of [`combined`].
#[inline(always)]
pub(crate) fn residual_into<T: Field>(leg: &SeriesLeg<'_, T>, out: &mut [T]) {
    let d = out.len() / 3;
    let [first, last] = &leg.residual.velocities;
    for p in 0..d {
        let rows = combined(leg.residual.point[p], [first[p], last[p]]);
        for (i, row) in rows.into_iter().enumerate() {
            out[i * d + p] = row;
        }
    }
}

/// Point and velocities at the ends, in combinations that are close to `x, x', x''` at the middle: without rotation,
/// the first is `x + x'' / 24`, and the others are `x'` and `x''`.
#[inline(always)]
pub(crate) fn combined<T: Field>(point: T, [first, last]: [T; 2]) -> [T; 3] {
    [point, last - first, (first + last - point * 2.0) * 6.0]
}

/// Converts a derivative with respect to the combinations to one with respect to point and velocities.
#[inline(always)]
pub(crate) fn uncombined<T: Field>([point, difference, sum]: [T; 3]) -> [T; 3] {
    let both = sum * 6.0;
    [point - sum * 12.0, both - difference, both + difference]
}
