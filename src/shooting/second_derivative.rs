//! The second derivative of the cost of a chain by its inner knots, and that of flat space.

use super::free_chain::{FreeChain, Group};
use crate::linalg::field::Field;
use crate::solve::block_cholesky::SymmetricBlocks;
use crate::space::Homogeneous;

/// Second derivative of the cost of a cubic of flat space by `(p_0, v_0, p_1, v_1)`.
const BEAM: [[f64; 4]; 4] = [
    [12.0, 6.0, -12.0, 6.0],
    [6.0, 4.0, -6.0, 2.0],
    [-12.0, -6.0, 12.0, -6.0],
    [6.0, 2.0, -6.0, 4.0],
];

impl<T: Field, S: Homogeneous> FreeChain<'_, T, S> {
    /// The second derivative of the cost by `(p, v)` of the inner knots, and that of flat space.
    pub(super) fn second_derivatives(&self) -> [SymmetricBlocks; 2] {
        let count = self.legs - 1;
        let width = 2 * self.space.dim();
        let [mut exact, mut flat] = [(); 2].map(|()| SymmetricBlocks::zeros(count, width));
        for leg in 0..self.legs {
            let (group, lane) = (&self.groups[leg / T::COUNT], leg % T::COUNT);
            let turn = turn(self.space, group, lane);
            add_leg(&mut exact, leg, |row, column| {
                let [a, b] = [[row, column], [column, row]].map(|at| exact_entry(group, lane, at));
                0.5 * (a + b)
            });
            add_leg(&mut flat, leg, |row, column| flat_entry(&turn, row, column));
        }
        [exact, flat]
    }
}

/// Adds the matrix of a leg, shape `(4 d, 4 d)`, to the blocks of those of its knots that are free.
fn add_leg(blocks: &mut SymmetricBlocks, leg: usize, entry: impl Fn(usize, usize) -> f64) {
    let width = blocks.size;
    let square = width * width;
    let count = blocks.diagonal.len() / square;
    let add = |block: &mut [f64], [first_row, first_column]: [usize; 2]| {
        for (row, out) in block.chunks_exact_mut(width).enumerate() {
            for (column, out) in out.iter_mut().enumerate() {
                *out += entry(first_row + row, first_column + column);
            }
        }
    };
    if leg > 0 {
        add(&mut blocks.diagonal[(leg - 1) * square..][..square], [0, 0]);
    }
    if leg < count {
        add(
            &mut blocks.diagonal[leg * square..][..square],
            [width, width],
        );
    }
    if leg > 0 && leg < count {
        add(
            &mut blocks.below[(leg - 1) * square..][..square],
            [width, 0],
        );
    }
}

/// Of the derivative of the gradient by the knots of a leg: accelerations at the first knot and third vectors at the last one
/// count with the other sign.
fn exact_entry<T: Field>(group: &Group<'_, T>, lane: usize, [row, column]: [usize; 2]) -> f64 {
    let wide = 4 * group.leg.velocity.len();
    let sign = match 4 * row / wide {
        0 | 3 => 1.0,
        _ => -1.0,
    };
    sign * group.stiffness.matrix[row * wide + column].lane(lane)
}

/// Of the same for flat space, where `turn` takes coordinates at the first knot to those at the last one.
fn flat_entry(turn: &[Vec<f64>], row: usize, column: usize) -> f64 {
    let d = turn.len();
    let (p, q) = (row % d, column % d);
    let share = match (row / d / 2, column / d / 2) {
        (1, 0) => turn[p][q],
        (0, 1) => turn[q][p],
        _ => f64::from(u8::from(p == q)),
    };
    BEAM[row / d][column / d] * share
}

/// What takes coordinates at the first knot of a leg to those at the last one, row by row.
fn turn<T: Field>(space: impl Homogeneous, group: &Group<'_, T>, lane: usize) -> Vec<Vec<f64>> {
    let d = space.dim();
    let q: Vec<f64> = group.leg.holonomy.iter().map(|x| x.lane(lane)).collect();
    let mut rows = vec![vec![0.0; d]; d];
    for (row, out) in rows.iter_mut().enumerate() {
        let mut unit = vec![0.0; d];
        unit[row] = 1.0;
        // A row of an isometry is what its inverse makes of a unit vector.
        space.turn_back_into(&q, &unit, out);
    }
    rows
}
