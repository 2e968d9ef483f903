//! Riemannian gradient and Hessian from the derivatives of a function of bases.

use faer::{Mat, MatRef};

use super::{Grassmann, horizontal_part};
use crate::error::Result;
use crate::linalg::structure::check_range;
use crate::manifold::stiefel::POINT_TOLERANCE;

impl Grassmann {
    /// The Riemannian gradient of a function with the Euclidean gradient `g` at `y`, `(I - Y Y^T) G`; shapes `(n, k)`.
    ///
    /// The function must depend on the subspace alone, `f(Y Q) = f(Y)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `Overflow`.
    /// # Source
    /// Edelman, Arias, Smith (1998), eq. (2.70).
    pub fn euclidean_to_riemannian_gradient(
        &self,
        y: MatRef<'_, f64>,
        g: MatRef<'_, f64>,
    ) -> Result<Mat<f64>> {
        self.check_point("Y", y, POINT_TOLERANCE)?;
        self.check_matrices([("G", g)])?;
        let out = horizontal_part(y, g);
        check_range("gradient", out.as_ref())?;
        Ok(out)
    }

    /// The Riemannian Hessian applied to the tangent vector `v`, from the Euclidean gradient `g` and the Euclidean
    /// Hessian applied to `v`, `h`; shapes `(n, k)`.
    ///
    /// ```math
    /// (I - Y Y^T) H - V\, Y^T G
    /// ```
    ///
    /// It is the covariant derivative of the gradient along `v`. The function must depend on the subspace alone; then
    /// `Y^T G` is symmetric.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotHorizontal`, `Overflow`.
    /// # Source
    /// Edelman, Arias, Smith (1998), eq. (2.71).
    pub fn euclidean_to_riemannian_hessian(
        &self,
        y: MatRef<'_, f64>,
        g: MatRef<'_, f64>,
        h: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
    ) -> Result<Mat<f64>> {
        self.check_point("Y", y, POINT_TOLERANCE)?;
        self.check_matrices([("G", g), ("H", h)])?;
        let v = self.horizontal("V", y, v)?;
        let out = horizontal_part(y, (h - &v * (y.transpose() * g)).as_ref());
        check_range("Hessian", out.as_ref())?;
        Ok(out)
    }
}
