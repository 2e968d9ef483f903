//! The scalars of a matrix: real or complex.

use faer::{Mat, MatRef};

use crate::error::Result;
use crate::linalg::complex_embedding::{check_embedded, embed, nearest};

/// The scalars of a space: real matrices, or complex matrices represented by real ones of twice the size.
///
/// With `Complex` every matrix, of points and of vectors, is an [embedded](crate::linalg::complex_embedding) one of
/// even shape. The solutions are those of the embedded real problem; the equations are solved in complex unknowns,
/// about half as many.
///
/// # Examples
/// ```
/// use faer::{Mat, c64, mat};
/// use stiefel_rs::linalg::complex_embedding::{embed, restrict};
/// use stiefel_rs::spline::{EndConditions, SplineOptions, cubic_spline};
/// use stiefel_rs::{Curve, Interrupt, ScalarField};
/// // Phases.
/// let phase = |angle: f64| embed(mat![[c64::new(angle.cos(), angle.sin())]].as_ref());
/// let points = [0.0, 0.5, 1.0].map(phase);
/// let views = points.each_ref().map(Mat::as_ref);
/// let options = SplineOptions { field: ScalarField::Complex, ..Default::default() };
/// let (curve, _) = cubic_spline(&[0.0, 1.0, 2.0], &views, &EndConditions::Natural, &options, Interrupt::NEVER)?;
/// let middle = restrict(curve.point(0.5)?.as_ref())?;
/// assert!((middle[(0, 0)] - c64::new(0.25_f64.cos(), 0.25_f64.sin())).norm() < 1e-13);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ScalarField {
    /// Real matrices.
    #[default]
    Real,
    /// Complex matrices, embedded in real ones of twice the size.
    Complex,
}

impl ScalarField {
    /// Return an error unless the matrices belong to the field.
    ///
    /// # Errors
    /// `Shape`; `NotComplex` if a matrix is not the embedding of a complex one.
    pub(crate) fn check<'a>(
        self,
        matrices: impl IntoIterator<Item = MatRef<'a, f64>>,
    ) -> Result<()> {
        match self {
            ScalarField::Real => Ok(()),
            ScalarField::Complex => matrices.into_iter().try_for_each(check_embedded),
        }
    }

    /// The nearest matrix over the field.
    pub(crate) fn nearest(self, a: Mat<f64>) -> Mat<f64> {
        match self {
            ScalarField::Real => a,
            ScalarField::Complex => embed(nearest(a.as_ref()).as_ref()),
        }
    }
}
