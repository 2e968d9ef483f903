//! The equations of a cubic spline of flat space, in tangent spaces.
//!
//! ```math
//! \frac{2 v_{i-1} + 4 v_i}{h_-} + \frac{4 v_i + 2 v_{i+1}}{h_+}
//!     = 6 \Bigl( \frac{\Delta_-}{h_-^2} + \frac{\Delta_+}{h_+^2} \Bigr)
//! ```
//!
//! Displacements are the initial velocities of the quasi-geodesics between neighbours, along which vectors are carried
//! from knot to knot. Carried to one knot, the equations have a tridiagonal matrix of numbers, so the Thomas algorithm
//! applies, with vectors as right-hand sides.

use faer::{MatMut, MatRef};

use super::ends::{EndCondition, EndConditions};
use super::links::Links;
use crate::linalg::product::axpy;
use crate::manifold::carrier::Direction;

/// A closed spline is unrolled by this many knots beyond both ends. The influence of the ends decays by at least one
/// half per knot, for equal legs by `2 - sqrt 3`: to `1e-13` and `1e-25`.
const OVERLAP: usize = 44;

/// The factored matrix.
pub(super) struct FlatSystem {
    lengths: Vec<f64>,
    /// The knot of each row: in order, with some knots repeated for a closed spline.
    knots: Vec<usize>,
    /// Number of leading rows that only unroll a closed spline.
    skipped: usize,
    /// Multiples of the previous row that elimination subtracts.
    factors: Vec<f64>,
    pivots: Vec<f64>,
    above: Vec<f64>,
}

impl FlatSystem {
    pub(super) fn new(lengths: &[f64], ends: &EndConditions) -> Self {
        let legs = lengths.len();
        let closed = matches!(ends, EndConditions::Periodic);
        let (skipped, count) = if closed {
            (OVERLAP, legs + 2 * OVERLAP)
        } else {
            (0, legs + 1)
        };
        let knots: Vec<usize> = if closed {
            let start = OVERLAP.next_multiple_of(legs) - OVERLAP;
            (0..count).map(|row| (start + row) % legs).collect()
        } else {
            (0..count).collect()
        };
        let before = |knot: usize| match knot {
            0 if closed => Some(legs - 1),
            _ => knot.checked_sub(1),
        };
        let (mut factors, mut pivots) = (vec![0.0; count], vec![0.0; count]);
        let mut above = vec![0.0; count];
        for row in 0..count {
            let knot = knots[row];
            if has_velocity(ends, knot, legs) {
                pivots[row] = 1.0;
                continue;
            }
            let below = before(knot).map_or(0.0, |leg| 2.0 / lengths[leg]);
            above[row] = lengths.get(knot).map_or(0.0, |h| 2.0 / h);
            pivots[row] = 2.0 * (below + above[row]);
            if row > 0 {
                factors[row] = below / pivots[row - 1];
                pivots[row] -= factors[row] * above[row - 1];
            }
        }
        FlatSystem {
            lengths: lengths.to_vec(),
            knots,
            skipped,
            factors,
            pivots,
            above,
        }
    }

    /// Number of knots with a separate velocity: the last knot of a closed spline is the first one.
    pub(super) fn unknown_knots(&self) -> usize {
        self.knots.len() - 2 * self.skipped
    }

    /// Replaces right-hand sides by velocities, with `size = n k` entries per knot.
    pub(super) fn solve(&self, chain: &mut Links, shape: (usize, usize), right: &mut [f64]) {
        let (rows, size) = (self.knots.len(), shape.0 * shape.1);
        let mut all: Vec<f64> = Vec::with_capacity(rows * size);
        for knot in &self.knots {
            all.extend_from_slice(&right[knot * size..(knot + 1) * size]);
        }
        let mut carried = vec![0.0; size];
        for row in 1..rows {
            if self.factors[row] == 0.0 {
                continue;
            }
            let (done, rest) = all.split_at_mut(row * size);
            carried.copy_from_slice(&done[(row - 1) * size..]);
            let link = self.knots[row - 1];
            chain.carry(link, matrix_mut(&mut carried, shape), Direction::Forward);
            axpy(
                matrix_mut(&mut rest[..size], shape),
                -self.factors[row],
                matrix(&carried, shape),
            );
        }
        for row in (0..rows).rev() {
            let (rest, done) = all.split_at_mut((row + 1) * size);
            let here = &mut rest[row * size..];
            if self.above[row] != 0.0 && row + 1 < rows {
                carried.copy_from_slice(&done[..size]);
                let link = self.knots[row];
                chain.carry(link, matrix_mut(&mut carried, shape), Direction::Backward);
                for (entry, other) in here.iter_mut().zip(&carried) {
                    *entry -= self.above[row] * other;
                }
            }
            here.iter_mut().for_each(|entry| *entry /= self.pivots[row]);
        }
        let first = self.skipped * size;
        for (row, &knot) in self.knots[self.skipped..][..self.unknown_knots()]
            .iter()
            .enumerate()
        {
            let from = first + row * size;
            right[knot * size..(knot + 1) * size].copy_from_slice(&all[from..from + size]);
        }
    }

    /// The right-hand sides of a spline; accelerations and velocities of `ends` enter the equations of their knots.
    pub(super) fn right_side(
        &self,
        chain: &Links,
        shape: (usize, usize),
        ends: &EndConditions,
    ) -> Vec<f64> {
        let (legs, size) = (self.lengths.len(), shape.0 * shape.1);
        let count = self.unknown_knots();
        let mut right = vec![0.0; count * size];
        for (leg, h) in self.lengths.iter().enumerate() {
            for (knot, displacement) in [
                (leg, chain.first(leg)),
                ((leg + 1) % count, chain.last(leg)),
            ] {
                let here = matrix_mut(&mut right[knot * size..(knot + 1) * size], shape);
                axpy(here, 6.0 / (h * h), displacement);
            }
        }
        if let EndConditions::Each(each) = ends {
            for (knot, end, sign) in [(0, &each[0], -1.0), (legs, &each[1], 1.0)] {
                let mut here = matrix_mut(&mut right[knot * size..(knot + 1) * size], shape);
                match end {
                    EndCondition::Velocity(v) => here.copy_from(v),
                    EndCondition::Acceleration(a) => axpy(here, sign, a),
                }
            }
        }
        right
    }
}

/// Whether the velocity at a knot is given.
pub(super) fn has_velocity(ends: &EndConditions, knot: usize, last: usize) -> bool {
    let EndConditions::Each(each) = ends else {
        return false;
    };
    let end = match knot {
        0 => &each[0],
        _ if knot == last => &each[1],
        _ => return false,
    };
    matches!(end, EndCondition::Velocity(_))
}

/// The entries of a vector as a matrix, in column-major order.
pub(super) fn matrix(entries: &[f64], shape: (usize, usize)) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(entries, shape.0, shape.1)
}

/// As [`matrix`], mutable.
pub(super) fn matrix_mut(entries: &mut [f64], shape: (usize, usize)) -> MatMut<'_, f64> {
    MatMut::from_column_major_slice_mut(entries, shape.0, shape.1)
}
