//! The response of a single leg to the data at its ends, by the changes at its middle.
//!
//! The changes of `x, x', x''` at the middle supply the point at the last end and the velocities at both, in the same
//! combinations as the equations of a [leg](crate::shooting::taylor::leg_equations): for slow curves their matrix is
//! near the identity.

use std::sync::Arc;

use super::linear_curve::{CurvePart, LinearCurve};
use super::linear_leg::{LegResponse, LinearLeg};
use crate::curve::barycentric::Barycentric;
use crate::linalg::field::{Field, accumulate, factor, largest_each, substitute};
use crate::linalg::lanes::LANES;
use crate::shooting::taylor::leg_equations::combined;
use crate::space::Homogeneous;

/// A leg is solved at its middle, without pivoting, if no entry of the solution is larger than this, and if that leaves this
/// fraction of it: its ends are then far from conjugate ones.
const REGULAR: f64 = 1e4;
const ROUND_OFF: f64 = 1e-13;

/// The curves of one leg, solved for the changes at their middles; `None` where the ends may be conjugate.
pub(crate) fn at_middle<T: Field>(
    space: impl Homogeneous,
    leg: &LinearLeg<T>,
    count: usize,
) -> Vec<Option<LinearCurve>> {
    let SolvedMiddle {
        stiffness,
        displacements,
        is_regular,
    } = space.vectorised(
        #[inline(always)]
        || SolvedMiddle::of(space.dim(), leg),
    );
    let last = &leg.frames[leg.frames.len() - space.size().pow(2)..];
    let through = Barycentric::of(&leg.nodes);
    let mut all =
        [last, &stiffness, &leg.frames, &displacements].map(|entries| by_lane(entries, count));
    let curve = |is_regular: bool| {
        let next = all.each_mut().map(|each| each.next().unwrap_or_default());
        let [frame, stiffness, frames, displacements] = next;
        is_regular.then(|| LinearCurve {
            frame,
            stiffness,
            parts: vec![CurvePart {
                start: 0.0,
                length: 1.0,
                through: Arc::clone(&through),
                frames,
                displacements,
            }],
        })
    };
    is_regular.into_iter().take(count).map(curve).collect()
}

/// The numbers of the first lanes, lane by lane; read in blocks that stay in the cache.
fn by_lane<T: Field>(x: &[T], count: usize) -> impl Iterator<Item = Vec<f64>> {
    let mut lanes: Vec<Vec<f64>> = (0..count).map(|_| Vec::with_capacity(x.len())).collect();
    for block in x.chunks(LANES) {
        for (lane, out) in lanes.iter_mut().enumerate() {
            out.extend(block.iter().map(|x| x.lane(lane)));
        }
    }
    lanes.into_iter()
}

/// The response of one leg to the data at its ends.
struct SolvedMiddle<T> {
    stiffness: Vec<T>,
    displacements: Vec<T>,
    is_regular: Vec<bool>,
}

impl<T: Field> SolvedMiddle<T> {
    #[inline(always)]
    fn of(d: usize, leg: &LinearLeg<T>) -> Self {
        let (wide, all) = (3 * d, 4 * d);
        let zeros = |size: usize| vec![T::ZERO; size];
        // Point and velocities at the ends by the changes at the middle, and what these have to supply for `(u_0, w_0, u_1,
        // w_1)`.
        let (mut matrix, mut right) = (zeros(wide * wide), zeros(wide * all));
        for p in 0..d {
            let (point, velocity) = (p, d + p);
            for j in 0..wide {
                let velocities = [leg.first[p * wide + j], leg.last.bent[velocity * wide + j]];
                let rows = combined(leg.last.bent[point * wide + j], velocities);
                for (i, row) in rows.into_iter().enumerate() {
                    matrix[(i * d + p) * wide + j] = row;
                }
            }
            for j in 0..all {
                let given = |level: usize| T::constant(f64::from(u8::from(j == level * d + p)));
                let caused = |row: usize| match j < d {
                    true => leg.last.direct[row * d + j],
                    false => T::ZERO,
                };
                let velocities = [given(1), given(3) - caused(velocity)];
                let rows = combined(given(2) - caused(point), velocities);
                for (i, row) in rows.into_iter().enumerate() {
                    right[(i * d + p) * all + j] = row;
                }
            }
        }
        let mut middle = right.clone();
        let mut factors = matrix.clone();
        factor(wide, &mut factors);
        substitute(wide, &factors, all, &mut middle);
        let is_regular = Self::are_regular(&matrix, &mut right, &middle, [wide, all]);
        // What is left, once more: there is no pivoting.
        substitute(wide, &factors, all, &mut right);
        for (x, rest) in middle.iter_mut().zip(&right) {
            *x -= *rest;
        }
        let mut stiffness = zeros(all * all);
        let block = d * wide;
        let [first, last] = [&leg.first, &leg.last.bent].map(|x| x.chunks_exact(block));
        let [accelerations, thirds] = [1, 2].map(|level| {
            let [first, last] = [first.clone().nth(level), last.clone().nth(level + 1)];
            [first.unwrap_or_default(), last.unwrap_or_default()]
        });
        let parts = [thirds[0], accelerations[0], thirds[1], accelerations[1]];
        for (part, out) in parts.into_iter().zip(stiffness.chunks_exact_mut(d * all)) {
            accumulate(part, wide, &middle, all, out);
        }
        let direct = leg.last.direct.chunks_exact(d * d).skip(2);
        for (direct, part) in direct.zip([3, 2]) {
            add_columns(d, direct, &mut stiffness[part * d * all..][..d * all]);
        }
        for x in &mut stiffness[d * all..3 * d * all] {
            *x = -*x;
        }
        let LegResponse { direct, bent } = &leg.displacements;
        let mut displacements = zeros(4 * direct.len());
        accumulate(bent, wide, &middle, all, &mut displacements);
        add_columns(d, direct, &mut displacements);
        SolvedMiddle {
            stiffness,
            displacements,
            is_regular,
        }
    }

    /// For each lane, whether the solution is accurate and not large; `right` becomes the negative residual.
    #[inline(always)]
    fn are_regular(
        matrix: &[T],
        right: &mut [T],
        solution: &[T],
        [wide, all]: [usize; 2],
    ) -> Vec<bool> {
        for x in &mut *right {
            *x = -*x;
        }
        accumulate(matrix, wide, solution, all, right);
        let (solution, rest) = (largest_each(solution), largest_each(right));
        let lanes = (0..T::COUNT).map(|lane| [solution.lane(lane), rest.lane(lane)]);
        lanes
            .map(|[solution, rest]| {
                solution <= REGULAR && rest <= ROUND_OFF * (1.0 + solution) * wide as f64
            })
            .collect()
    }
}

/// Adds a matrix of `d` columns to the first columns of one of `4 d` columns.
#[inline(always)]
fn add_columns<T: Field>(d: usize, matrix: &[T], out: &mut [T]) {
    for (row, out) in matrix.chunks_exact(d).zip(out.chunks_exact_mut(4 * d)) {
        for (x, out) in row.iter().zip(out) {
            *out += *x;
        }
    }
}
