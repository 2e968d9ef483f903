//! The second derivative of the cost of a chain with respect to its knots, and its counterpart in flat space.

use super::chain_knots::BEAM;
use super::free_chain::{FreeChain, FreeLegGroup};
use super::layout::ChainLayout;
use crate::linalg::field::Field;
use crate::solve::block_cholesky::SymmetricBlocks;
use crate::space::Homogeneous;

impl<T: Field, S: Homogeneous> FreeChain<'_, T, S> {
    /// The second derivative of the cost with respect to `(p, v)` of the movable knots, and its counterpart in flat
    /// space.
    pub(crate) fn second_derivatives(&self) -> [SymmetricBlocks; 2] {
        let (d, layout) = (self.space.dim(), &self.layout);
        let [mut exact, mut flat] = [(); 2].map(|()| match layout.is_closed {
            true => SymmetricBlocks::closed(layout.count(), 2 * d),
            false => SymmetricBlocks::zeros(layout.count(), 2 * d),
        });
        for (leg, h) in layout.lengths.iter().enumerate() {
            let (group, lane) = (&self.groups[leg / T::COUNT], leg % T::COUNT);
            let matrix = &group.stiffness.matrix;
            // Factors from the time of the leg.
            let units = [1.0, *h, 1.0, *h];
            let rate = |[row, column]: [usize; 2]| h.powi(-3) * units[row] * units[column];
            add_leg(&mut exact, layout, leg, d, |[row, column], p, out| {
                let entries = &matrix[(row * d + p) * 4 * d + column * d..][..d];
                let rate = rate([row, column]);
                for (out, entry) in out.iter_mut().zip(entries) {
                    *out += rate * entry.lane(lane);
                }
            });
            // Converts to coordinates at the last knot.
            let turn = turn(self.space, &isometry(group, lane));
            add_leg(&mut flat, layout, leg, d, |[row, column], p, out| {
                let share = BEAM[row][column] * rate([row, column]);
                match (row / 2, column / 2) {
                    (0, 1) => {
                        for (out, turn) in out.iter_mut().zip(&turn) {
                            *out += share * turn[p];
                        }
                    }
                    (1, 0) => {
                        for (out, turn) in out.iter_mut().zip(&turn[p]) {
                            *out += share * turn;
                        }
                    }
                    _ => out[p] += share,
                }
            });
        }
        layout.constrain(&mut exact);
        layout.constrain(&mut flat);
        [exact, flat]
    }
}

/// Adds the matrix of a leg, shape `(4 d, 4 d)`, to the blocks of its movable knots; `add` adds the part of a row
/// within the block of size `d` at the given row and column.
fn add_leg(
    blocks: &mut SymmetricBlocks,
    layout: &ChainLayout,
    leg: usize,
    d: usize,
    add: impl Fn([usize; 2], usize, &mut [f64]),
) {
    let width = 2 * d;
    let square = width * width;
    let add = |block: &mut [f64], [first_row, first_column]: [usize; 2]| {
        for (row, out) in block.chunks_exact_mut(width).enumerate() {
            for (column, out) in out.chunks_exact_mut(d).enumerate() {
                add([first_row + row / d, first_column + column], row % d, out);
            }
        }
    };
    let ends = [leg, leg + 1].map(|knot| layout.block(knot));
    for (end, block) in ends.into_iter().enumerate() {
        if let Some(block) = block {
            add(
                &mut blocks.diagonal[block * square..][..square],
                [2 * end; 2],
            );
        }
    }
    if let [Some(first), Some(last)] = ends {
        match first < last {
            true => add(&mut blocks.beside[first * square..][..square], [0, 2]),
            false => add(&mut blocks.corner, [2, 0]),
        }
    }
}

/// The isometry between the frame carried along a leg and the frame of its last knot.
fn isometry<T: Field>(group: &FreeLegGroup<'_, T>, lane: usize) -> Vec<f64> {
    group.leg.holonomy.iter().map(|x| x.lane(lane)).collect()
}

/// `Ad_q` in coordinates, in row-major order.
fn turn(space: impl Homogeneous, q: &[f64]) -> Vec<Vec<f64>> {
    let d = space.dim();
    let mut rows = vec![vec![0.0; d]; d];
    for (row, out) in rows.iter_mut().enumerate() {
        let mut unit = vec![0.0; d];
        unit[row] = 1.0;
        // A row of an isometry is its inverse applied to a unit vector.
        space.turn_back_into(q, &unit, out);
    }
    rows
}
