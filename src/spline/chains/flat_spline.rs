//! The cubic spline of flat space, from which splines on the manifold are solved.
//!
//! With the displacement `p` of a leg at its start, and vectors carried from knot to knot along the curves that join them,
//! continuous accelerations at a knot mean
//!
//! ```math
//! \frac{2}{h_-} v_{j-1} + \Bigl(\frac{4}{h_-} + \frac{4}{h_+}\Bigr) v_j + \frac{2}{h_+} v_{j+1}
//!     = \frac{6 p_-}{h_-^2} + \frac{6 p_+}{h_+^2}
//! ```
//!
//! # Source
//! de Boor (2001), "A Practical Guide to Splines", ch. IV.

use super::chain::{Carrying, Chain};
use super::motion::Motion;
use crate::error::Result;
use crate::legs::{End, Ends, Knots};
use crate::linalg::field::add;
use crate::solve::direction::Direction;
use crate::solve::tridiagonal::Isometries;

/// The spline of flat space through the knots of a chain.
///
/// # Errors
/// `Overflow` (times that differ too much), and the errors of carrying.
pub(crate) fn flat_spline<C: Chain>(chain: &C, ends: &Ends) -> Result<Motion> {
    let (size, legs) = (chain.size(), chain.lengths().len());
    let mut displacements = vec![0.0; size * legs];
    for (leg, out) in displacements.chunks_exact_mut(size).enumerate() {
        chain.displacement_into(leg, out);
    }
    let knots = Knots::of_points(chain.lengths(), ends);
    let worker = &mut chain.worker();
    flat_spline_along(&knots, &displacements, &mut Carrying { chain, worker })
}

/// The same from the displacements of the legs, one vector after another.
///
/// # Errors
/// As [`flat_spline`].
pub(crate) fn flat_spline_along(
    knots: &Knots<'_>,
    displacements: &[f64],
    isometries: &mut impl Isometries,
) -> Result<Motion> {
    let (d, lengths) = (isometries.size(), knots.lengths);
    let displacement = |leg: usize| &displacements[d * leg..][..d];
    let mut right = vec![0.0; d * knots.count()];
    let mut carried = vec![0.0; d];
    for (knot, right) in right.chunks_exact_mut(d).enumerate() {
        let end = knots.end_at(knot);
        if let Some((End::Velocity(v), _)) = end {
            right.copy_from_slice(v);
            continue;
        }
        let [before, after] = knots.legs_at(knot);
        if let Some(leg) = before {
            isometries.carry_into(leg, Direction::Forward, displacement(leg), &mut carried)?;
            add(right, 6.0 / lengths[leg] / lengths[leg], &carried);
        }
        if let Some(leg) = after {
            add(right, 6.0 / lengths[leg] / lengths[leg], displacement(leg));
        }
        if let Some((End::Acceleration(a), sign)) = end {
            add(right, -sign, a);
        }
    }
    knots.flat_system()?.solve(isometries, &mut right)?;
    if matches!(knots.ends, Ends::Periodic) {
        right.extend_from_within(..d);
    }
    let mut motion = Motion::zeros(d, lengths.len() + 1);
    motion.entries[..right.len()].copy_from_slice(&right);
    for (leg, h) in lengths.iter().enumerate() {
        let (from, to) = right[d * leg..].split_at(d);
        isometries.carry_into(leg, Direction::Backward, &to[..d], &mut carried)?;
        let (first, second) = motion.derivatives_mut(leg).split_at_mut(d);
        for (i, step) in displacement(leg).iter().enumerate() {
            let [from, to] = [h * from[i], h * carried[i]];
            first[i] = 6.0 * step - 4.0 * from - 2.0 * to;
            second[i] = 6.0 * (from + to) - 12.0 * step;
        }
    }
    Ok(motion)
}
