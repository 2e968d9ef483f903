//! The span of the data of a curve: the isometries that fix it pointwise fix every curve built from the data, so the
//! curve stays in it, and work is done in its dimension.

use faer::{Mat, MatRef};

use crate::linalg::decomp::thin_q;

/// An orthonormal basis of the span of a few `n x k` matrices, where that is smaller than `R^n`.
pub(crate) struct Span {
    basis: Option<Mat<f64>>,
}

impl Span {
    /// The span of the columns of all matrices together.
    pub(crate) fn of(matrices: &[MatRef<'_, f64>]) -> Self {
        let (n, k) = (matrices[0].nrows(), matrices[0].ncols());
        let columns = matrices.len() * k;
        if n <= columns {
            return Span { basis: None };
        }
        let mut stacked = Mat::zeros(n, columns);
        for (i, matrix) in matrices.iter().enumerate() {
            stacked.as_mut().subcols_mut(i * k, k).copy_from(matrix);
        }
        Span {
            basis: Some(thin_q(stacked.as_ref())),
        }
    }

    /// Coordinates of a matrix of the span.
    pub(crate) fn down(&self, a: MatRef<'_, f64>) -> Mat<f64> {
        self.basis
            .as_ref()
            .map_or_else(|| a.to_owned(), |e| e.transpose() * a)
    }

    pub(crate) fn into_basis(self) -> Option<Mat<f64>> {
        self.basis
    }
}

/// The matrices with the given coordinates in a frame, or themselves where there is none.
pub(crate) fn lifted(frame: Option<&Mat<f64>>, points: &[Mat<f64>]) -> Vec<Mat<f64>> {
    let lift = |point: &Mat<f64>| frame.map_or_else(|| point.clone(), |frame| frame * point);
    points.iter().map(lift).collect()
}

/// Rows of what [`lifted`] gives.
pub(crate) fn rows(frame: Option<&Mat<f64>>, points: &[Mat<f64>]) -> usize {
    frame.unwrap_or(&points[0]).nrows()
}
