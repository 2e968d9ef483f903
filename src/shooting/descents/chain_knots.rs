//! The knots of a chain, and whether those of two chains are near each other.

use crate::linalg::field::{larger, largest, multiply_transposed, transposed_multiply};
use crate::space::{Homogeneous, orthonormalise};

/// Consecutive knots of a chain.
#[derive(Debug, Clone, Default)]
pub(crate) struct ChainKnots {
    /// Shape `(r, r)` each, in row-major order.
    pub(crate) frames: Vec<f64>,
    /// In coordinates of the frames, per unit of time.
    pub(crate) velocities: Vec<f64>,
}

/// Largest coordinate of a displacement, in radians, or of a change of a velocity, and largest energy of the difference
/// between the knots of two chains from which descents are expected to end at the same curve.
///
/// Of 9746 hard problems on St(3,1), (3,2), (4,2), (5,2), (6,3), (10,3) and (12,4), 219 cost at least a percent less by a
/// second descent; its start differs from the end of the first one by 0.40 at least, with an energy of 18 at least.
const NEAR: f64 = 0.5;
const STIFF: f64 = 4.5;

/// Second derivative of the cost of a cubic of flat space with respect to `(p_0, v_0, p_1, v_1)`.
pub(crate) const BEAM: [[f64; 4]; 4] = [
    [12.0, 6.0, -12.0, 6.0],
    [6.0, 4.0, -6.0, 2.0],
    [-12.0, -6.0, 12.0, -6.0],
    [6.0, 2.0, -6.0, 4.0],
];

impl ChainKnots {
    /// Whether descents from these knots and from others are expected to end at the same curve, for legs of unit duration.
    pub(crate) fn is_near(&self, space: impl Homogeneous, others: &Self) -> bool {
        if self.velocities.len() != others.velocities.len() {
            return false;
        }
        let [largest, energy] = self.difference(space, others);
        largest <= NEAR && energy <= STIFF
    }

    /// The largest coordinate of the differences of points and velocities, and the energy `int |z''|^2 / 2` of the cubics
    /// of flat space through them, for points less than a right angle apart.
    pub(crate) fn difference(&self, space: impl Homogeneous, others: &Self) -> [f64; 2] {
        let (d, square) = (space.dim(), space.size().pow(2));
        let change = |i: usize| {
            let knots = [self, others];
            let velocities = knots.map(|knots| &knots.velocities[i * d..][..d]);
            change(space, knots.map(|knots| knots.frame(i, square)), velocities)
        };
        let changes: Vec<Vec<f64>> = (0..self.velocities.len() / d).map(change).collect();
        let largest = changes.iter().fold(0.0, |most, x| larger(most, largest(x)));
        let legs = changes.windows(2).enumerate().map(|(i, ends)| {
            let [_, q] = relative(space, self.frame(i, square), self.frame(i + 1, square));
            energy_of_leg(space, [&ends[0], &ends[1]], &q)
        });
        [largest, legs.sum()]
    }

    fn frame(&self, knot: usize, square: usize) -> &[f64] {
        &self.frames[knot * square..][..square]
    }
}

/// The displacement of a knot and the change of its velocity, `2 d` coordinates.
fn change(space: impl Homogeneous, frames: [&[f64]; 2], velocities: [&[f64]; 2]) -> Vec<f64> {
    let (d, r) = (space.dim(), space.size());
    let [u, q] = relative(space, frames[0], frames[1]);
    let mut moved = vec![0.0; r * r];
    multiply_transposed(r, &u, &q, &mut moved);
    let mut out = vec![0.0; 2 * d];
    // The sine of the displacement.
    space.each_entry(|p, i, j| out[p] = space.skew_coordinate(&moved, [i, j]));
    space.turn_into(&q, velocities[1], &mut out[d..]);
    for (out, v) in out[d..].iter_mut().zip(velocities[0]) {
        *out -= v;
    }
    out
}

/// A frame relative to another one, and its nearest element of `H`.
fn relative(space: impl Homogeneous, from: &[f64], to: &[f64]) -> [Vec<f64>; 2] {
    let r = space.size();
    let [mut u, mut q] = [(); 2].map(|()| vec![0.0; r * r]);
    transposed_multiply(r, from, to, &mut u);
    space.isotropy_part_into(&u, &mut q);
    if space.isotropy_dim() > 0 {
        orthonormalise(r, &mut q, &mut vec![0.0; 2 * r * r]);
    }
    [u, q]
}

/// The energy of the cubic of flat space between the changes of two knots; `q` turns coordinates at the last one to
/// coordinates at the first one.
fn energy_of_leg(space: impl Homogeneous, ends: [&[f64]; 2], q: &[f64]) -> f64 {
    let d = space.dim();
    let mut last = vec![0.0; 2 * d];
    let (position, velocity) = last.split_at_mut(d);
    space.turn_into(q, &ends[1][..d], position);
    space.turn_into(q, &ends[1][d..], velocity);
    let coordinates = [&ends[0][..d], &ends[0][d..], &*position, &*velocity];
    let mut sum = 0.0;
    for (row, x) in BEAM.iter().zip(coordinates) {
        for (entry, y) in row.iter().zip(coordinates) {
            let product: f64 = x.iter().zip(y).map(|(x, y)| x * y).sum();
            sum += 0.5 * entry * product;
        }
    }
    sum
}
