//! The second derivative of half the cost of a linearised cubic with respect to the velocities at its ends, in frames of other
//! spans: the blocks of the equations of a spline.

use faer::{Mat, MatRef};

use super::linear_piece::{LinearPiece, PieceResponse};
use crate::cubic::taylor::blocks::Sizes;
use crate::linalg::field::add;
use crate::linalg::product::{columns, columns_mut, entries, mul_into};
use crate::linalg::structure::row_by_row;

impl LinearPiece {
    /// The second derivative of half the cost with respect to the velocities at both ends (rows and columns), in frames
    /// of shape `(n, r)` whose span contains the curve; shape `(d, d)` each, in row-major order.
    pub(crate) fn by_velocities(&self, frames: [MatRef<'_, f64>; 2]) -> [[Vec<f64>; 2]; 2] {
        let Sizes { m, k, quotient, .. } = self.blocks;
        let (wide, half) = (frames[0].ncols() - k, quotient.turns(k));
        let given = half + wide * k;
        let normals = frames.map(|frame| frame.subcols(k, wide));
        let products: [Vec<f64>; 2] = std::array::from_fn(|end| {
            let mut low = vec![0.0; wide * m];
            if m * wide > 0 {
                let own = self.frame(end).subcols(k, m);
                mul_into(
                    columns_mut(&mut low, wide),
                    1.0,
                    normals[end].transpose(),
                    own,
                );
            }
            low
        });
        let carry = |row: &[f64], end: usize, out: &mut [f64]| {
            out[..half].copy_from_slice(&row[..half]);
            let columns = row[half..].chunks_exact(m.max(1));
            for (column, out) in columns.zip(out[half..].chunks_exact_mut(wide.max(1))) {
                for (x, low) in column.iter().zip(products[end].chunks_exact(wide.max(1))) {
                    add(out, *x, low);
                }
            }
        };
        by_ends(|row, column| {
            let block = self.inside.of_velocities(row, column);
            let own = block.nrows();
            let [mut line, mut carried] = [own, given].map(|size| vec![0.0; size]);
            // Rows to the given coordinates, then columns.
            let mut half_way = vec![0.0; own * given];
            for (i, out) in half_way.chunks_exact_mut(given.max(1)).enumerate() {
                line.iter_mut()
                    .enumerate()
                    .for_each(|(j, x)| *x = block[(i, j)]);
                carry(&line, column, out);
            }
            let mut out = vec![0.0; given * given];
            for j in 0..given {
                line.iter_mut()
                    .enumerate()
                    .for_each(|(i, x)| *x = half_way[i * given + j]);
                carried.fill(0.0);
                carry(&line, row, &mut carried);
                for (i, x) in carried.iter().enumerate() {
                    out[i * given + j] = *x;
                }
            }
            if let Some(outside) = &self.outside {
                let mut off = entries(normals[column]);
                self.leave_span(&mut off);
                let off: Mat<f64> = normals[row].transpose() * columns(&off, self.n);
                let outer = outside.of_velocities(row, column);
                for (i, j) in (0..wide * k).flat_map(|i| (0..wide * k).map(move |j| (i, j))) {
                    out[(half + i) * given + half + j] +=
                        off[(i % wide, j % wide)] * outer[(i / wide, j / wide)];
                }
            }
            out
        })
    }

    /// The same for a row outside the span of both frames, shape `(k, k)` each; `None` if the span is all of `R^n`.
    pub(crate) fn by_velocity_rows(&self) -> Option<[[Vec<f64>; 2]; 2]> {
        let outside = self.outside.as_ref()?;
        Some(by_ends(|row, column| {
            row_by_row(outside.of_velocities(row, column)).collect()
        }))
    }
}

impl PieceResponse {
    /// The block of the second derivative belonging to the velocities at two ends.
    fn of_velocities(&self, row: usize, column: usize) -> MatRef<'_, f64> {
        let size = self.stiffness.len().isqrt();
        let d = size / 4;
        let all = MatRef::from_row_major_slice(&self.stiffness, size, size);
        all.submatrix((2 * row + 1) * d, (2 * column + 1) * d, d, d)
    }
}

fn by_ends<T>(part: impl Fn(usize, usize) -> T) -> [[T; 2]; 2] {
    [[part(0, 0), part(0, 1)], [part(1, 0), part(1, 1)]]
}
