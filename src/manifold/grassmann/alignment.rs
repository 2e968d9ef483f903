//! How one basis lies to another: principal cosines with their vectors, and what of the second is not in the span of the first.

use std::f64::consts::FRAC_PI_2;

use faer::{Mat, MatRef};

use super::{Grassmann, remove_part};
use crate::error::{Error, Result};
use crate::linalg::decomp::Svd;
use crate::linalg::one_sided_jacobi::orthogonalise_few;
use crate::linalg::product::{mul_add, mul_into};
use crate::manifold::stiefel::POINT_TOLERANCE;

/// A principal angle is `pi/2` to working precision where its cosine is below this.
const RIGHT_ANGLE: f64 = 32.0 * f64::EPSILON;

/// `Y0^T Y1 = U diag(c) Z^T`.
pub(super) struct Alignment {
    product: Mat<f64>,
    /// Decreasing.
    pub(super) cosines: Vec<f64>,
    pub(super) u: Mat<f64>,
    pub(super) z: Mat<f64>,
}

impl Alignment {
    pub(super) fn new(y0: MatRef<'_, f64>, y1: MatRef<'_, f64>) -> Result<Self> {
        let k = y0.ncols();
        let mut product = Mat::zeros(k, k);
        mul_into(&mut product, 1.0, y0.transpose(), y1);
        let (mut u, mut z) = (product.clone(), Mat::zeros(k, k));
        if orthogonalise_few(&mut u, &mut z) {
            let cosines: Vec<f64> = u.col_iter().map(|column| column.norm_l2()).collect();
            for (j, &cosine) in cosines.iter().enumerate().filter(|(_, c)| **c > 0.0) {
                for i in 0..k {
                    u[(i, j)] /= cosine;
                }
            }
            return Ok(Alignment {
                product,
                cosines,
                u,
                z,
            });
        }
        let mut svd = Svd::new(k, k);
        svd.compute(product.as_ref())?;
        Ok(Alignment {
            product,
            cosines: (0..k).map(|i| svd.s(i)).collect(),
            u: svd.u().to_owned(),
            z: svd.v().to_owned(),
        })
    }

    /// `(I - Y0 Y0^T) Y1`, exactly zero where the subspaces are all of the space.
    pub(super) fn normal(&self, y0: MatRef<'_, f64>, y1: MatRef<'_, f64>) -> Mat<f64> {
        let (n, k) = y0.shape();
        if n == k {
            return Mat::zeros(n, k);
        }
        let mut normal = y1.to_owned();
        mul_add(&mut normal, -1.0, y0, &self.product);
        remove_part(y0, &mut normal);
        normal
    }

    /// `Z diag(f) U^T` of a function of the cosines.
    pub(super) fn function(&self, f: fn(f64) -> f64) -> Mat<f64> {
        let mut scaled = self.z.clone();
        for (j, &cosine) in self.cosines.iter().enumerate() {
            let factor = f(cosine);
            for i in 0..scaled.nrows() {
                scaled[(i, j)] *= factor;
            }
        }
        let mut out = Mat::zeros(scaled.nrows(), scaled.ncols());
        mul_into(&mut out, 1.0, &scaled, self.u.transpose());
        out
    }

    /// Error `RightAngle` where the largest principal angle is `pi/2` to working precision.
    pub(super) fn check_unique(&self) -> Result<()> {
        match self.cosines.last() {
            Some(&cosine) if cosine <= RIGHT_ANGLE => Err(Error::RightAngle {
                angle: FRAC_PI_2 - cosine,
            }),
            _ => Ok(()),
        }
    }
}

impl Grassmann {
    /// The basis of the span of `y1` that is nearest to `y0` in the Frobenius norm.
    ///
    /// ```math
    /// Y_1 Z U^T,\qquad Y_0^T Y_1 = U C Z^T
    /// ```
    ///
    /// It is also `exp(Y0, log(Y0, Y1))`.
    ///
    /// # Arguments
    /// * `y0`, `y1` - points, shapes `(n, k)`
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`; `RightAngle` where a principal angle is `pi/2` to working precision, and the
    /// nearest basis is not unique; `Decomposition`.
    /// # Source
    /// The orthogonal Procrustes problem: Golub, Van Loan (2013), "Matrix Computations", 4th ed., sec. 6.4.1.
    pub fn align(&self, y0: MatRef<'_, f64>, y1: MatRef<'_, f64>) -> Result<Mat<f64>> {
        self.check_point("Y0", y0, POINT_TOLERANCE)?;
        self.check_point("Y1", y1, POINT_TOLERANCE)?;
        self.aligned(y0, y1)
    }

    /// [`Grassmann::align`] of matrices that are known to be points.
    ///
    /// # Errors
    /// `RightAngle`, `Decomposition`.
    pub(crate) fn aligned(&self, y0: MatRef<'_, f64>, y1: MatRef<'_, f64>) -> Result<Mat<f64>> {
        let alignment = Alignment::new(y0, y1)?;
        alignment.check_unique()?;
        let mut out = Mat::zeros(self.n(), self.k());
        mul_into(&mut out, 1.0, y1, alignment.function(|_| 1.0));
        Ok(out)
    }
}
