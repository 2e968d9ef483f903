//! The order of rows relative to a frame of embedded complex matrices.

use faer::{Mat, MatRef};

/// The order of rows relative to a frame of embedded matrices, which is the order of the frame's columns: real and
/// imaginary parts of the first `k`, then those of the others. Embedded matrices have all real parts before all
/// imaginary ones.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowOrder {
    pub(crate) r: usize,
    pub(crate) k: usize,
}

impl RowOrder {
    /// Reorders rows from frame order to embedded order.
    pub(crate) fn halves(self, a: MatRef<'_, f64>) -> Mat<f64> {
        let mut out = Mat::zeros(a.nrows(), a.ncols());
        for (row, from) in a.row_iter().enumerate() {
            out.row_mut(self.half_row(row)).copy_from(from);
        }
        out
    }

    /// The inverse of [`RowOrder::halves`].
    pub(crate) fn blocks(self, a: MatRef<'_, f64>) -> Mat<f64> {
        Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(self.half_row(i), j)])
    }

    fn half_row(self, row: usize) -> usize {
        let [columns, rows] = [self.k, self.r - self.k].map(|size| size / 2);
        match row {
            row if row < columns => row,
            row if row < self.k => row + rows,
            row if row < self.k + rows => row - columns,
            row => row,
        }
    }
}
