//! The space in which a cubic is linearised, and the positions of variations among its coordinates.
//!
//! A row outside the span of the curve is represented by one additional row of the blocks, in which the curve is zero;
//! variations in the span and in this row do not mix.
//!
//! Square matrices with more than one column are represented by all columns but the last, which is determined by the
//! others: the entries of `omega` in the last column become entries of `b`, with opposite sign.

use super::linear_start::LinearStart;
use crate::cubic::taylor::blocks::Sizes;
use crate::space::{Homogeneous, Quotient, Shape, in_space};

/// Positions of the coordinates.
#[derive(Debug)]
pub(crate) struct LinearLayout {
    /// The space of the equations.
    pub(crate) shape: Shape,
    /// Includes the row outside the span, if there is one.
    blocks: Sizes,
    /// Coordinates of a vector in the span, and of the row.
    inside: Vec<usize>,
    row: Vec<usize>,
    /// The coordinate from which on they change sign in the space of the equations.
    unchanged: usize,
}

impl LinearLayout {
    /// For curves in spans with the given blocks.
    pub(crate) fn of(inner: Sizes, has_rows: bool) -> Self {
        let blocks = Sizes {
            m: inner.m + usize::from(has_rows),
            ..inner
        };
        let (d, k) = (blocks.dim(), blocks.k);
        let is_square = blocks.m == 0 && k > 1 && blocks.quotient == Quotient::Frames;
        let (shape, unchanged) = match is_square {
            true => (Sizes::frames(1, k - 1).shape(), d + 1 - k),
            false => (blocks.shape(), d),
        };
        let mut is_row = vec![false; d];
        in_space!(blocks.shape(), |space| space
            .each_entry(|p, i, _| is_row[p] = i >= inner.m + inner.k));
        let (row, inside) = (0..d).partition(|p| is_row[*p]);
        LinearLayout {
            shape,
            blocks,
            inside,
            row,
            unchanged,
        }
    }

    /// Whether there is a row outside the span.
    pub(crate) fn has_row(&self) -> bool {
        !self.row.is_empty()
    }

    /// `x, x', x''` at the start of a curve, in the space of the equations.
    pub(crate) fn vectors(&self, start: &LinearStart) -> [Vec<f64>; 3] {
        start.vectors.each_ref().map(|x| {
            let mut all = vec![0.0; self.blocks.dim()];
            for (p, x) in self.inside.iter().zip(x) {
                all[*p] = if *p < self.unchanged { *x } else { -x };
            }
            all
        })
    }

    /// The rows and columns of a matrix that belong to the span, with the signs of its coordinates. The matrix has four
    /// vectors in each row, and any number in each column.
    pub(crate) fn of_span(&self, mut matrix: Vec<f64>) -> Vec<f64> {
        let d = self.blocks.dim();
        if self.has_row() {
            return self.selected(&matrix, &self.inside);
        }
        if self.unchanged < d {
            let sign = |p: usize| if p < self.unchanged { 1.0 } else { -1.0 };
            let signs: Vec<f64> = (0..4 * d).map(|j| sign(j % d)).collect();
            for (i, row) in matrix.chunks_exact_mut(4 * d).enumerate() {
                let own = sign(i % d);
                let pairs = row.iter_mut().zip(&signs);
                pairs.for_each(|(x, sign)| *x *= own * sign);
            }
        }
        matrix
    }

    /// The same for the row outside the span.
    pub(crate) fn of_row(&self, matrix: &[f64]) -> Vec<f64> {
        self.selected(matrix, &self.row)
    }

    /// With a row outside the span, coordinates do not change sign.
    fn selected(&self, matrix: &[f64], which: &[usize]) -> Vec<f64> {
        let d = self.blocks.dim();
        let mut out = Vec::with_capacity(matrix.len() / (d * d) * which.len().pow(2));
        for rows in matrix.chunks_exact(4 * d * d) {
            for i in which {
                for level in 0..4 {
                    let row = &rows[(4 * i + level) * d..][..d];
                    out.extend(which.iter().map(|j| row[*j]));
                }
            }
        }
        out
    }

    /// Frames of the span, shape `(r, r)` each, from those in the space of the equations.
    pub(crate) fn frames(&self, frames: Vec<f64>, r: usize) -> Vec<f64> {
        if !self.has_row() {
            return frames;
        }
        let size = self.blocks.m + self.blocks.k;
        let rows = frames.chunks_exact(size);
        let kept = rows.enumerate().filter(|(row, _)| row % size < r);
        kept.flat_map(|(_, row)| &row[..r]).copied().collect()
    }
}
