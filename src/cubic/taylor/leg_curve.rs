//! The curve of a solved leg as one polynomial about its middle, from a series or from values at Gauss nodes: points,
//! and the vectors of the equation.

use faer::Mat;

use super::blocks::{BlockSizes, Sizes};
use super::piecewise_taylor::PiecewiseTaylor;
use super::state::State;
use crate::legs::Dense;
use crate::linalg::field::{accumulate, set_identity};
use crate::linalg::simd::vectorised;
use crate::linalg::structure::row_by_row;
use crate::space::{Homogeneous, in_space};

/// The curve of a leg that starts with the given frame or the identity, from its polynomials; the tension is in the
/// time of the leg.
pub(crate) fn leg_curve(
    polynomials: &Dense,
    leg: usize,
    frame: Option<&Mat<f64>>,
    solved: Sizes,
    columns: usize,
    tension: f64,
) -> PiecewiseTaylor {
    let r = solved.m + solved.k;
    let blocks = Sizes::new(r - columns, columns, solved.quotient);
    let dim = solved.dim();
    let (square, rows) = (r * r, blocks.r::<f64>());
    let terms = polynomials.order + 1;
    let frame: Option<Vec<f64>> = frame.map(|frame| row_by_row(frame.as_ref()).collect());
    let moved_into = |turn: &[f64], columns: usize, out: &mut [f64]| match &frame {
        Some(frame) => product_into(frame, r, turn, columns, out),
        None => out.copy_from_slice(turn),
    };
    let mut points = vec![0.0; terms * rows * columns];
    let (mut turn, mut point) = (vec![0.0; r * columns], vec![0.0; r * columns]);
    let width = polynomials.width;
    let turns = polynomials.frames(leg, r).chunks_exact(r * width);
    for (points, frame) in points.chunks_exact_mut(rows * columns).zip(turns) {
        let of_frame = frame.chunks_exact(width);
        for (first, row) in turn.chunks_exact_mut(columns).zip(of_frame) {
            first.copy_from_slice(&row[..columns]);
        }
        moved_into(&turn, columns, &mut point);
        for (col, points) in points.chunks_exact_mut(rows).enumerate() {
            for (row, entry) in points.iter_mut().enumerate().take(r) {
                *entry = point[row * columns + col];
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
    let mut ends = vec![0.0; 2 * square];
    let (first, last) = ends.split_at_mut(square);
    set_identity(r, last);
    moved_into(last, r, first);
    moved_into(polynomials.last_frame(leg, square), r, last);
    PiecewiseTaylor::of_polynomial(
        [state(0, first), state(1, last)],
        polynomials.order,
        points,
        vectors,
    )
}

/// `out = a b` for `a` of shape `(r, r)` and `b` of shape `(r, columns)`, in row-major order.
fn product_into(a: &[f64], r: usize, b: &[f64], columns: usize, out: &mut [f64]) {
    out.fill(0.0);
    vectorised(
        #[inline(always)]
        || accumulate(a, r, b, columns, out),
    );
}

/// Appends `omega` and `b` of a skew matrix in row-major order, each in column-major order.
fn push_blocks(matrix: &[f64], [r, columns]: [usize; 2], out: &mut Vec<f64>) {
    for rows in [0..columns, columns..r] {
        for col in 0..columns {
            out.extend(rows.clone().map(|row| matrix[row * r + col]));
        }
    }
}
