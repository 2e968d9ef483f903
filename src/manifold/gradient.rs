//! Riemannian gradient and Hessian from the derivatives of a function of `n x k` matrices, for every metric of the
//! alpha family, in `O(n k^2)`.

use faer::{Mat, MatRef, Scale};

use super::stiefel::{POINT_TOLERANCE, Stiefel, TANGENT_TOLERANCE};
use crate::error::Result;
use crate::linalg::structure::{check_finite, check_range, check_shape, skew_part, symmetric_part};

impl Stiefel {
    /// The Riemannian gradient of a function with the Euclidean gradient `g` at `s`; shapes `(n, k)`.
    ///
    /// ```math
    /// (I - S S^T) G + \tfrac1w S\, \mathrm{skew}(S^T G)
    /// ```
    ///
    /// with the weight `w` of the metric: `G - S G^T S` for the canonical one, the orthogonal projection for the Euclidean one.
    /// It is the tangent vector with `<grad, V>_S = tr G^T V` for every tangent `V`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `Overflow`.
    /// # Source
    /// Edelman, Arias, Smith (1998), eq. (2.53), for the canonical metric.
    pub fn euclidean_to_riemannian_gradient(
        &self,
        s: MatRef<'_, f64>,
        g: MatRef<'_, f64>,
    ) -> Result<Mat<f64>> {
        self.check_point("S", s, POINT_TOLERANCE)?;
        let (normal, inner) = self.components("G", s, g)?;
        let out = normal + s * skew_part(inner.as_ref()) * Scale(1.0 / self.metric().weight());
        check_range("gradient", out.as_ref())?;
        Ok(out)
    }

    /// The Riemannian Hessian applied to the tangent vector `v`, from the Euclidean gradient `g` and the Euclidean Hessian
    /// applied to `v`, `h`; shapes `(n, k)`.
    ///
    /// With `V = S A + B`, `Y = sym(S^T G)`, `N = (I - S S^T) G` and the weight `w` of the metric:
    ///
    /// ```math
    /// (I - S S^T) H - B Y - (1 - w) N A
    ///   + \tfrac1w S \big( \mathrm{skew}(S^T H) - \tfrac12 (A Y + Y A) + (1 - w)\, \mathrm{skew}(B^T N) \big)
    /// ```
    ///
    /// It is the covariant derivative of the gradient along `v`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`, `Overflow`.
    /// # Source
    /// Absil, Mahony, Sepulchre (2008), section 5.5 (`Hess f(V, W) = D^2 f(V, W) - Df Gamma(V, W)`); the Christoffel
    /// term of the family is our own derivation.
    pub fn euclidean_to_riemannian_hessian(
        &self,
        s: MatRef<'_, f64>,
        g: MatRef<'_, f64>,
        h: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
    ) -> Result<Mat<f64>> {
        self.check_point("S", s, POINT_TOLERANCE)?;
        self.check_tangent("V", s, v, TANGENT_TOLERANCE)?;
        let weight = self.metric().weight();
        let (n, gradient) = self.components("G", s, g)?;
        let (hessian_normal, hessian) = self.components("H", s, h)?;
        let (b, a) = self.split(s, v)?;
        let y = symmetric_part(gradient.as_ref());
        let anticommutator = &a * &y + &y * &a;
        let turned = skew_part((b.transpose() * &n).as_ref());
        let along = skew_part(hessian.as_ref()) - anticommutator * Scale(0.5)
            + turned * Scale(1.0 - weight);
        let across = hessian_normal - &b * &y - &n * &a * Scale(1.0 - weight);
        let out = across + s * along * Scale(1.0 / weight);
        check_range("Hessian", out.as_ref())?;
        Ok(out)
    }

    /// `((I - S S^T) Z, S^T Z)` of any matrix.
    fn components(
        &self,
        name: &'static str,
        s: MatRef<'_, f64>,
        z: MatRef<'_, f64>,
    ) -> Result<(Mat<f64>, Mat<f64>)> {
        check_shape(name, z, self.n(), self.k())?;
        check_finite(name, z)?;
        let inner = s.transpose() * z;
        let once = z - s * &inner;
        let normal = &once - s * (s.transpose() * &once);
        Ok((normal, inner))
    }
}
