//! The span of the data of a curve. Isometries that fix it pointwise fix every curve built from the data, so the curve
//! stays in the span, and computations take place in its dimension.

use faer::{Mat, MatRef};

use crate::error::{Error, Result};
use crate::linalg::complex_embedding::{embed, nearest};
use crate::linalg::decomp::{thin_q, unitary_q};
use crate::manifold::stiefel::{POINT_TOLERANCE, Stiefel};
use crate::space::ScalarField;

/// An orthonormal basis of the span of a few `n x k` matrices, if the span is smaller than `R^n`.
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

    /// As [`Span::of`], over a field: for embedded complex matrices the basis is embedded too.
    pub(crate) fn over(field: ScalarField, matrices: &[MatRef<'_, f64>]) -> Self {
        if field == ScalarField::Real {
            return Span::of(matrices);
        }
        let (n, k) = matrices[0].shape();
        let columns = matrices.len() * k;
        if n <= columns {
            return Span { basis: None };
        }
        let mut stacked = Mat::zeros(n / 2, columns / 2);
        for (i, matrix) in matrices.iter().enumerate() {
            let mut part = stacked.as_mut().subcols_mut(i * k / 2, k / 2);
            part.copy_from(nearest(*matrix));
        }
        Span {
            basis: Some(embed(unitary_q(stacked.as_ref(), false).as_ref())),
        }
    }

    /// All of `R^n`.
    pub(crate) fn whole() -> Self {
        Span { basis: None }
    }

    /// Coordinates of a matrix contained in the span.
    pub(crate) fn down(&self, a: MatRef<'_, f64>) -> Mat<f64> {
        self.basis
            .as_ref()
            .map_or_else(|| a.to_owned(), |e| e.transpose() * a)
    }

    /// The matrix with the given coordinates.
    pub(crate) fn lift(&self, a: MatRef<'_, f64>) -> Mat<f64> {
        self.basis.as_ref().map_or_else(|| a.to_owned(), |e| e * a)
    }

    pub(crate) fn basis(&self) -> Option<MatRef<'_, f64>> {
        self.basis.as_ref().map(Mat::as_ref)
    }

    pub(crate) fn into_basis(self) -> Option<Mat<f64>> {
        self.basis
    }
}

/// The manifold of control points, their span, and their coordinates in it.
///
/// # Errors
/// `Shape` for fewer than two, `NonFinite`, `NotOrthonormal`.
pub(super) fn control_points(points: &[MatRef<'_, f64>]) -> Result<(Stiefel, Span, Vec<Mat<f64>>)> {
    const NAME: &str = "control points";
    if points.len() < 2 {
        return Err(Error::Shape {
            name: NAME,
            expected: "(degree + 1, n, k) with degree >= 1".to_owned(),
            found: format!("{} points", points.len()),
        });
    }
    let manifold = Stiefel::of(NAME, points[0])?;
    for point in points {
        manifold.check_point(NAME, *point, POINT_TOLERANCE)?;
    }
    let span = Span::of(points);
    let low = points.iter().map(|point| span.down(*point)).collect();
    Ok((manifold, span, low))
}

/// The matrices with the given coordinates in a frame, or the coordinates themselves if there is no frame.
pub(crate) fn lifted(frame: Option<&Mat<f64>>, points: &[Mat<f64>]) -> Vec<Mat<f64>> {
    let lift = |point: &Mat<f64>| frame.map_or_else(|| point.clone(), |frame| frame * point);
    points.iter().map(lift).collect()
}

/// Number of rows of the result of [`lifted`].
pub(crate) fn rows(frame: Option<&Mat<f64>>, points: &[Mat<f64>]) -> usize {
    frame.unwrap_or(&points[0]).nrows()
}
