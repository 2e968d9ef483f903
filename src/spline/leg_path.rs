//! The curve of a leg as a path of a cubic: points, and the vectors of the equation.

use faer::Mat;

use crate::cubic::blocks::{Blocks, Sized};
use crate::cubic::path::Path;
use crate::cubic::state::State;
use crate::legs::Dense;
use crate::linalg::field::multiply;
use crate::linalg::structure::row_by_row;
use crate::space::{Homogeneous, in_space};

/// The curve of a leg that starts with the given frame, from its polynomials; the tension is in the time of the leg.
pub(super) fn leg_path(
    polynomials: &Dense,
    leg: usize,
    frame: &Mat<f64>,
    solved: Sized,
    columns: usize,
    tension: f64,
) -> Path {
    let r = solved.m + solved.k;
    let blocks = Sized::new(r - columns, columns, solved.quotient);
    let dim = solved.dim();
    let (square, rows) = (r * r, blocks.r::<f64>());
    let terms = polynomials.order + 1;
    let frame: Vec<f64> = row_by_row(frame.as_ref()).collect();
    let mut product = vec![0.0; square];
    let mut points = vec![0.0; terms * rows * columns];
    let turns = polynomials.frames(leg, square).chunks_exact(square);
    for (points, turn) in points.chunks_exact_mut(rows * columns).zip(turns) {
        multiply(r, &frame, turn, &mut product);
        for (col, points) in points.chunks_exact_mut(rows).enumerate() {
            for (row, point) in points.iter_mut().enumerate().take(r) {
                *point = product[row * r + col];
            }
        }
    }
    let mut matrix = vec![0.0; square];
    let mut write = |x: &[f64], out: &mut Vec<f64>| {
        in_space!(solved.shape(), |space| space.matrix_into(x, &mut matrix));
        push_blocks(&matrix, [r, columns], out);
    };
    let mut vectors = Vec::with_capacity(terms * r * columns);
    for x in polynomials.x(leg, dim).chunks_exact(dim) {
        write(x, &mut vectors);
    }
    let mut state = |end: usize, frame: &[f64]| {
        let mut entries = Vec::with_capacity(square + 3 * r * columns);
        entries.extend((0..square).map(|i| frame[(i % r) * r + i / r]));
        for x in polynomials.end(leg, end, dim) {
            write(x, &mut entries);
        }
        State::of_entries(blocks, end as f64, entries).in_tension(tension)
    };
    let first = state(0, &frame);
    multiply(r, &frame, polynomials.last_frame(leg, square), &mut product);
    Path::of_polynomial(
        [first, state(1, &product)],
        polynomials.order,
        points,
        vectors,
    )
}

/// Appends `omega` and `b` of a skew matrix in row-major order, each in column-major order.
fn push_blocks(matrix: &[f64], [r, columns]: [usize; 2], out: &mut Vec<f64>) {
    for rows in [0..columns, columns..r] {
        for col in 0..columns {
            out.extend(rows.clone().map(|row| matrix[row * r + col]));
        }
    }
}
