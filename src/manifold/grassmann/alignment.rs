//! The relative position of two bases: principal cosines with their vectors, and the part of the second basis outside
//! the span of the first.
//!
//! With `C = Y0^T Y1 = U diag(c) Z^T`, the symmetric matrix `C^T C = Z diag(c^2) Z^T` yields `c`, `Z` and `U = C Z
//! diag(1/c)` in about 0.57 of the time of the singular value decomposition (4.4 us instead of 7.6 us for k = 8, 164 us
//! instead of 288 us for k = 50). The round-off of `C^T C` is `eps`, that of a cosine `eps / (2 c)` and that of `U`
//! `eps / c^2`, so small cosines are left to the decomposition.

use std::f64::consts::FRAC_PI_2;

use faer::{Mat, MatRef};

use super::{Grassmann, remove_part};
use crate::error::{Error, Result};
use crate::linalg::complex_embedding::{embed, embedding_defect, nearest, paired_columns};
use crate::linalg::decomp::{Svd, SymmetricEigen, complex_svd};
use crate::linalg::one_sided_jacobi::orthogonalise_few;
use crate::linalg::product::{mul_add, mul_into, product, scale};
use crate::linalg::structure::gram;
use crate::manifold::stiefel::POINT_TOLERANCE;

/// A principal angle is `pi/2` to working precision if its cosine is below this.
const RIGHT_ANGLE: f64 = 32.0 * f64::EPSILON;

/// Mean of the squared sines from which subspaces count as far apart: the round-off of `Y1` is then at most twice that
/// of the result.
const FAR: f64 = 0.25;

/// Smallest squared cosine that is computed from `C^T C`. For angles up to this bound (k = 5, 12, 30), entries of
/// logarithms have errors of at most 4.8 units of round-off and distances of 16; by singular values, 3.0 and 10.
const MODERATE: f64 = 0.1;

/// Embedded complex bases with a cosine below this are decomposed as complex ones. Real singular vectors of cosines `c`
/// are embedded only to `eps / c`: at two angles 1e-8 below `pi/2` logarithms were off by 2.4e-8, at this bound they are by
/// some 1e-13.
const SMALL: f64 = 1e-3;

/// Largest distance of a product of embedded complex bases from an embedded matrix, for each column: round-off of the
/// sums, which may be added in another order in the two copies.
const EMBEDDED: f64 = 16.0 * f64::EPSILON;

/// Whether the matrix is an embedded complex one to round-off.
fn is_embedded(product: MatRef<'_, f64>) -> bool {
    let k = product.ncols();
    k.is_multiple_of(2) && embedding_defect(product) <= EMBEDDED * k as f64
}

/// `Y0^T Y1 = U diag(c) Z^T`.
pub(super) struct Alignment {
    product: Mat<f64>,
    /// In decreasing order.
    pub(super) cosines: Vec<f64>,
    pub(super) u: Mat<f64>,
    pub(super) z: Mat<f64>,
}

/// The sine of an angle between 0 and `pi/2` with the given cosine, which may exceed 1 by round-off.
pub(super) fn sine(cosine: f64) -> f64 {
    ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt()
}

impl Alignment {
    pub(super) fn new(y0: MatRef<'_, f64>, y1: MatRef<'_, f64>) -> Result<Self> {
        let found = Self::of_product(product(y0.transpose(), y1))?;
        match found.cosines.last() {
            Some(&cosine) if cosine < SMALL && is_embedded(found.product.as_ref()) => {
                Self::by_complex_svd(found.product)
            }
            _ => Ok(found),
        }
    }

    fn of_product(product: Mat<f64>) -> Result<Self> {
        let k = product.ncols();
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
        Self::by_squares(product).or_else(Self::by_svd)
    }

    /// Computed from the eigenvectors of `C^T C`; returns `C` if a cosine is small, or if the eigenvalue iteration does
    /// not converge.
    fn by_squares(product: Mat<f64>) -> std::result::Result<Self, Mat<f64>> {
        let k = product.ncols();
        let square = gram(product.as_ref());
        // The smallest eigenvalue is at most the smallest diagonal entry.
        if (0..k).any(|j| square[(j, j)] < MODERATE) {
            return Err(product);
        }
        let mut eigen = SymmetricEigen::new(k);
        if eigen.compute(square.as_ref()).is_err() || eigen.value(0) < MODERATE {
            return Err(product);
        }
        let z = eigen.vectors().reverse_cols().to_owned();
        let cosines: Vec<f64> = (0..k).rev().map(|j| eigen.value(j).sqrt()).collect();
        let mut u = square;
        mul_into(&mut u, 1.0, &product, &z);
        for (column, cosine) in u.col_iter_mut().zip(&cosines) {
            scale(column.as_mat_mut(), 1.0 / cosine);
        }
        Ok(Alignment {
            product,
            cosines,
            u,
            z,
        })
    }

    fn by_svd(product: Mat<f64>) -> Result<Self> {
        let k = product.ncols();
        let mut svd = Svd::new(k, k);
        svd.compute(product.as_ref())?;
        Ok(Alignment {
            product,
            cosines: (0..k).map(|i| svd.s(i)).collect(),
            u: svd.u().to_owned(),
            z: svd.v().to_owned(),
        })
    }

    /// Computed for embedded complex bases, whose factors are then embedded to round-off.
    fn by_complex_svd(product: Mat<f64>) -> Result<Self> {
        let (u, values, z) = complex_svd(nearest(product.as_ref()).as_ref())?;
        let [u, z] = [u, z].map(|factor| paired_columns(embed(factor.as_ref()).as_ref()));
        let cosines = values.into_iter().flat_map(|cosine| [cosine; 2]).collect();
        Ok(Alignment {
            product,
            cosines,
            u,
            z,
        })
    }

    /// Whether the subspaces are so far apart that there is little cancellation in `(I - Y0 Y0^T) Y1`.
    pub(super) fn is_far(&self) -> bool {
        let squares = self.cosines.iter().map(|cosine| sine(*cosine).powi(2));
        squares.sum::<f64>() >= FAR * self.cosines.len() as f64
    }

    /// The principal angles in increasing order, from their cosines: an error of `eps / sine`.
    pub(super) fn angles(&self) -> impl Iterator<Item = f64> {
        self.cosines
            .iter()
            .map(|cosine| sine(*cosine).atan2(*cosine))
    }

    /// `(2 I - G) Y0^T Y1` for `G = Y0^T Y0`, given by its lower triangle: the coefficients along `Y0` that a double
    /// projection subtracts from `Y1`.
    pub(super) fn along(&self, gram: Mat<f64>) -> Mat<f64> {
        let k = gram.ncols();
        let mut twice = gram;
        for j in 0..k {
            twice[(j, j)] = 2.0 - twice[(j, j)];
            for i in j + 1..k {
                twice[(i, j)] = -twice[(i, j)];
                twice[(j, i)] = twice[(i, j)];
            }
        }
        product(&twice, &self.product)
    }

    /// `(I - Y0 Y0^T) Y1`, exactly zero if the subspace is the whole space.
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

    /// `Z diag(f) U^T` for a function `f` of the cosines.
    pub(super) fn function(&self, f: fn(f64) -> f64) -> Mat<f64> {
        let mut scaled = self.z.clone();
        for (j, &cosine) in self.cosines.iter().enumerate() {
            let factor = f(cosine);
            for i in 0..scaled.nrows() {
                scaled[(i, j)] *= factor;
            }
        }
        product(&scaled, self.u.transpose())
    }

    /// Return `RightAngle` if the largest principal angle is `pi/2` to working precision.
    pub(super) fn check_unique(&self) -> Result<()> {
        match self.cosines.last() {
            Some(&cosine) if cosine <= RIGHT_ANGLE => Err(Error::RightAngle {
                angle: FRAC_PI_2 - cosine,
            }),
            _ => Ok(()),
        }
    }
}

/// The orthogonal matrix `Q` for which `Y1 Q` is the basis of its span nearest to `Y0`.
///
/// # Errors
/// `Decomposition`.
pub(crate) fn alignment(y0: MatRef<'_, f64>, y1: MatRef<'_, f64>) -> Result<Mat<f64>> {
    Ok(Alignment::new(y0, y1)?.function(|_| 1.0))
}

/// As [`alignment`], with the cosine of the largest principal angle.
///
/// # Errors
/// `RightAngle` if that angle is pi/2 to working precision; `Decomposition`.
pub(crate) fn unique_alignment(
    y0: MatRef<'_, f64>,
    y1: MatRef<'_, f64>,
) -> Result<(Mat<f64>, f64)> {
    let alignment = Alignment::new(y0, y1)?;
    alignment.check_unique()?;
    let least = alignment.cosines.iter().fold(1.0, |a: f64, b| a.min(*b));
    Ok((alignment.function(|_| 1.0), least))
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
    /// `Shape`, `NonFinite`, `NotOrthonormal`; `RightAngle` if a principal angle is `pi/2` to working precision, so
    /// that the nearest basis is not unique; `Decomposition`.
    /// # Source
    /// The orthogonal Procrustes problem: Golub, Van Loan (2013), "Matrix Computations", 4th ed., sec. 6.4.1.
    pub fn align(&self, y0: MatRef<'_, f64>, y1: MatRef<'_, f64>) -> Result<Mat<f64>> {
        self.check_point("Y0", y0, POINT_TOLERANCE)?;
        self.check_point("Y1", y1, POINT_TOLERANCE)?;
        self.aligned(y0, y1)
    }

    /// [`Grassmann::align`] for matrices already checked to be points.
    ///
    /// # Errors
    /// `RightAngle`, `Decomposition`.
    pub(crate) fn aligned(&self, y0: MatRef<'_, f64>, y1: MatRef<'_, f64>) -> Result<Mat<f64>> {
        let alignment = Alignment::new(y0, y1)?;
        alignment.check_unique()?;
        Ok(product(y1, alignment.function(|_| 1.0)))
    }
}
