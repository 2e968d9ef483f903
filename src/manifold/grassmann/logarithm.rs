//! Logarithm and distance in closed form.
//!
//! With `Y0^T Y1 = U C Z^T`, column `i` of `(I - Y0 Y0^T) Y1 Z` has length `s_i`, the sine of the angle `theta_i`, and
//! `log(Y0, Y1) = (I - Y0 Y0^T) Y1 Z diag(theta_i / s_i) U^T`. The factor `theta / s` is a smooth function of the
//! cosine for angles below `pi`, and tends to 1 for small angles. So small sines are neither computed nor divided by,
//! and principal vectors with nearly equal cosines need not be separated. The logarithm is as accurate for angles of
//! 1e-300 as for large ones.
//!
//! Between subspaces that are far apart nothing cancels in `Y1 F - Y0 (B F)`, with `F = Z diag(theta / s) U^T` and `B =
//! (2 I - Y0^T Y0) Y0^T Y1`. This equals a double projection, even if `Y0` is orthonormal only to 1e-9, and takes half
//! as many products of tall matrices.

use faer::reborrow::ReborrowMut;
use faer::{Mat, MatMut, MatRef};

use super::Grassmann;
use super::alignment::{Alignment, sine};
use crate::error::Result;
use crate::linalg::product::{mul_add, mul_into};
use crate::linalg::structure::norm;
use crate::manifold::stiefel::{POINT_TOLERANCE, Stiefel};

/// `theta / sin(theta)` for the angle with the given cosine.
fn angle_by_sine(cosine: f64) -> f64 {
    // Sine and angle are computed from the same cosine; if it is off by a few units of round-off, their quotient is
    // still accurate to round-off.
    let sine = sine(cosine);
    if sine > 0.0 {
        sine.atan2(cosine) / sine
    } else {
        1.0
    }
}

impl Grassmann {
    /// The Riemannian logarithm: the horizontal `V` at `y0` for which `exp(Y0, V)` spans the subspace of `y1`, and
    /// which is the velocity of the shortest geodesic.
    ///
    /// ```math
    /// V = (I - Y_0 Y_0^T) Y_1 Z\, \mathrm{diag}\Big( \frac{\theta_i}{\sin\theta_i} \Big) U^T,\qquad
    /// Y_0^T Y_1 = U \cos(\Theta) Z^T
    /// ```
    ///
    /// It does not depend on the choice of the basis `y1`, and is `V Q` for the basis `Y0 Q`.
    ///
    /// # Arguments
    /// * `y0`, `y1` - points, shapes `(n, k)`
    /// # Accuracy
    /// Backward stable: the error is the round-off of the entries, divided by the smallest cosine if several angles are
    /// near `pi/2`. For nearby subspaces the error is relative to the size of the logarithm, as far as the entries of
    /// the bases determine it; asserted in `tests/grassmann/`.
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`; `RightAngle` if the largest principal angle is `pi/2` to working
    /// precision; `Decomposition`.
    /// # Source
    /// Bendokat, Zimmermann, Absil (2024), algorithm 5.3. Deviation: the factors of `Y0^T Y1` give the angles as well,
    /// without a second decomposition.
    pub fn log(&self, y0: MatRef<'_, f64>, y1: MatRef<'_, f64>) -> Result<Mat<f64>> {
        let mut out = Mat::zeros(self.n(), self.k());
        self.log_into(out.as_mut(), y0, y1)?;
        Ok(out)
    }

    /// Writes [`Grassmann::log`] to a matrix of shape `(n, k)` with contiguous rows or columns.
    ///
    /// # Errors
    /// The errors of [`Grassmann::log`].
    pub(crate) fn log_into(
        &self,
        mut out: MatMut<'_, f64>,
        y0: MatRef<'_, f64>,
        y1: MatRef<'_, f64>,
    ) -> Result<()> {
        let (gram, alignment) = self.alignment(y0, y1)?;
        alignment.check_unique()?;
        let factor = alignment.function(angle_by_sine);
        if alignment.is_far() {
            let along = alignment.along(gram) * &factor;
            mul_into(out.rb_mut(), 1.0, y1, &factor);
            mul_add(out, -1.0, y0, &along);
        } else {
            mul_into(out, 1.0, alignment.normal(y0, y1), &factor);
        }
        Ok(())
    }

    /// The Riemannian distance, `(sum theta_i^2)^{1/2}` over the principal angles. It is defined also if an angle is
    /// `pi/2`, when several geodesics have that length.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `Decomposition`.
    /// # Source
    /// Edelman, Arias, Smith (1998), section 4.3 (arc length).
    pub fn dist(&self, y0: MatRef<'_, f64>, y1: MatRef<'_, f64>) -> Result<f64> {
        let (_, alignment) = self.alignment(y0, y1)?;
        if alignment.is_far() {
            return Ok(alignment
                .angles()
                .map(|angle| angle * angle)
                .sum::<f64>()
                .sqrt());
        }
        let normal = alignment.normal(y0, y1);
        let mut out = Mat::zeros(self.n(), self.k());
        mul_into(&mut out, 1.0, &normal, &alignment.z);
        for (j, &cosine) in alignment.cosines.iter().enumerate() {
            let factor = angle_by_sine(cosine);
            for i in 0..self.n() {
                out[(i, j)] *= factor;
            }
        }
        Ok(norm(out.as_ref()))
    }

    /// The alignment of two points, after checking them, and `Y0^T Y0` in the lower triangle.
    pub(super) fn alignment(
        &self,
        y0: MatRef<'_, f64>,
        y1: MatRef<'_, f64>,
    ) -> Result<(Mat<f64>, Alignment)> {
        let gram = Stiefel::new(self.n(), self.k())?.checked_gram("Y0", y0, POINT_TOLERANCE)?;
        self.check_point("Y1", y1, POINT_TOLERANCE)?;
        Ok((gram, Alignment::new(y0, y1)?))
    }
}
