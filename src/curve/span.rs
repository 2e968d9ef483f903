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

    /// The matrix with the given coordinates.
    pub(crate) fn up(&self, a: &Mat<f64>) -> Mat<f64> {
        self.basis.as_ref().map_or_else(|| a.clone(), |e| e * a)
    }

    pub(crate) fn into_basis(self) -> Option<Mat<f64>> {
        self.basis
    }
}
