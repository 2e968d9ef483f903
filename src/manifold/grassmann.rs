//! `Gr(n, k)`, the subspaces of dimension `k` of `R^n`: membership, projections and the metric.

pub(crate) mod alignment;
mod curvature;
mod exponential;
mod gradient;
pub(crate) mod joining;
mod logarithm;
mod principal_angles;

use faer::{Mat, MatRef};

use super::stiefel::{Stiefel, TANGENT_TOLERANCE};
use crate::error::{Error, Result};
use crate::linalg::product::{mul_add, product};
use crate::linalg::structure::{check_finite, check_range, check_shape, frobenius_inner, norm};

/// Relative size of the component along the point up to which it is attributed to round-off of a horizontal vector.
const ROUND_OFF: f64 = 4.0 * f64::EPSILON;

/// The Grassmann manifold of `k`-dimensional subspaces of `R^n`.
///
/// A point is represented by an orthonormal basis `Y` of a subspace, shape `(n, k)`; all bases `Y Q` with orthogonal
/// `Q` represent the same point. Tangent vectors are horizontal matrices of the same shape:
///
/// ```math
/// Gr(n,k) = St(n,k) / O(k),\qquad Y^T V = 0,\qquad \langle V, W \rangle = \mathrm{tr}\, V^T W
/// ```
///
/// A tangent vector `V` at `Y` is `V Q` at the basis `Y Q`. Results of methods refer to the given basis.
///
/// # Source
/// Edelman, Arias, Smith (1998), section 2.5; Bendokat, Zimmermann, Absil (2024), "A Grassmann manifold handbook", Adv. Comput.
/// Math. 50, 6.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::Grassmann;
/// // Two planes of R^3 that meet in the first axis, at an angle of 0.3.
/// let manifold = Grassmann::new(3, 2)?;
/// let (sin, cos) = 0.3_f64.sin_cos();
/// let y0 = mat![[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];
/// let y1 = mat![[0.0, 1.0], [cos, 0.0], [sin, 0.0]];
/// let angles = manifold.principal_angles(y0.as_ref(), y1.as_ref())?;
/// assert!((angles[0] - 0.3).abs() < 1e-15 && angles[1] == 0.0);
/// let v = manifold.log(y0.as_ref(), y1.as_ref())?;
/// assert!((v - mat![[0.0, 0.0], [0.0, 0.0], [0.0, 0.3]]).norm_l2() < 1e-15);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Grassmann {
    n: usize,
    k: usize,
}

impl Grassmann {
    /// The manifold `Gr(n, k)`.
    ///
    /// # Errors
    /// `Shape` unless `1 <= k <= n` and a point fits in memory.
    pub fn new(n: usize, k: usize) -> Result<Self> {
        match Stiefel::new(n, k) {
            Ok(_) => Ok(Grassmann { n, k }),
            Err(_) => Err(Error::Shape {
                name: "Gr(n, k)",
                expected: "1 <= k <= n, and a point that fits in memory".to_owned(),
                found: format!("n = {n}, k = {k}"),
            }),
        }
    }

    /// The manifold of the subspace spanned by the columns of an `n x k` matrix.
    ///
    /// # Errors
    /// `Shape` unless `1 <= k <= n`.
    pub fn of(name: &'static str, y: MatRef<'_, f64>) -> Result<Self> {
        Stiefel::of(name, y)?;
        Grassmann::new(y.nrows(), y.ncols())
    }

    /// Rows of a basis.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Dimension of the subspaces.
    pub fn k(&self) -> usize {
        self.k
    }

    /// Dimension of the manifold, `k (n - k)`.
    pub fn dim(&self) -> usize {
        self.k * (self.n - self.k)
    }

    /// Checks shape, finiteness and `|Y^T Y - I|_F <= tolerance`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`.
    pub fn check_point(
        &self,
        name: &'static str,
        y: MatRef<'_, f64>,
        tolerance: f64,
    ) -> Result<()> {
        Stiefel::new(self.n, self.k)?.check_point(name, y, tolerance)
    }

    /// Checks shape, finiteness and `|Y^T V|_F <= tolerance max(1, |V|_F)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotHorizontal`.
    pub fn check_tangent(
        &self,
        name: &'static str,
        y: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
        tolerance: f64,
    ) -> Result<()> {
        self.along(name, y, v, tolerance).map(drop)
    }

    /// The point whose basis is nearest to `y` in the Frobenius norm, the polar factor of `y` (shape `(n, k)`): its
    /// column space.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `RankDeficient`.
    pub fn project(&self, y: MatRef<'_, f64>) -> Result<Mat<f64>> {
        Stiefel::new(self.n, self.k)?.project(y)
    }

    /// Orthogonal projection of `z` (shape `(n, k)`) to the horizontal vectors at `y`, `Z - Y Y^T Z`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `Overflow`.
    pub fn project_tangent(&self, y: MatRef<'_, f64>, z: MatRef<'_, f64>) -> Result<Mat<f64>> {
        self.check_matrices([("Y", y), ("Z", z)])?;
        let out = horizontal_part(y, z);
        check_range("projection", out.as_ref())?;
        Ok(out)
    }

    /// Inner product of two tangent vectors at `y`, `tr V^T W`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `Overflow`.
    pub fn inner(&self, y: MatRef<'_, f64>, v: MatRef<'_, f64>, w: MatRef<'_, f64>) -> Result<f64> {
        self.check_matrices([("Y", y), ("V", v), ("W", w)])?;
        let product = frobenius_inner(v, w);
        if product.is_finite() {
            return Ok(product);
        }
        Err(Error::Overflow {
            quantity: "inner product",
        })
    }

    /// Norm of a tangent vector at `y`, `|V|_F`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `Overflow`.
    pub fn norm(&self, y: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<f64> {
        self.check_matrices([("Y", y), ("V", v)])?;
        let length = norm(v);
        if length.is_finite() {
            return Ok(length);
        }
        Err(Error::Overflow { quantity: "norm" })
    }

    /// The orthogonal projector on the subspace, `Y Y^T`, shape `(n, n)`. It is exactly symmetric, and the same for all
    /// bases up to round-off.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`.
    pub fn projector(&self, y: MatRef<'_, f64>) -> Result<Mat<f64>> {
        self.check_matrices([("Y", y)])?;
        let mut out = product(y, y.transpose());
        for j in 0..self.n {
            for i in 0..j {
                out[(i, j)] = out[(j, i)];
            }
        }
        Ok(out)
    }

    /// `Y^T V`, after checking that it is at most `tolerance max(1, |V|_F)`.
    fn along(
        &self,
        name: &'static str,
        y: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
        tolerance: f64,
    ) -> Result<Mat<f64>> {
        self.check_matrices([("Y", y), (name, v)])?;
        let tolerance = tolerance * norm(v).max(1.0);
        let along = product(y.transpose(), v);
        // Overflowing products of both signs sum to NaN.
        let defect = match norm(along.as_ref()) {
            defect if defect.is_nan() => f64::INFINITY,
            defect => defect,
        };
        if defect <= tolerance {
            return Ok(along);
        }
        Err(Error::NotHorizontal {
            name,
            defect,
            tolerance,
        })
    }

    /// A checked tangent vector, without the component along `y` that the tolerance allows.
    fn horizontal(
        &self,
        name: &'static str,
        y: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
    ) -> Result<Mat<f64>> {
        let along = self.along(name, y, v, TANGENT_TOLERANCE)?;
        let mut out = v.to_owned();
        if norm(along.as_ref()) > ROUND_OFF * norm(v) {
            mul_add(&mut out, -1.0, y, &along);
            remove_part(y, &mut out);
        }
        Ok(out)
    }

    /// Checks shape `(n, k)` and finiteness.
    fn check_matrices<const N: usize>(
        &self,
        matrices: [(&'static str, MatRef<'_, f64>); N],
    ) -> Result<()> {
        for (name, matrix) in matrices {
            check_shape(name, matrix, self.n, self.k)?;
            check_finite(name, matrix)?;
        }
        Ok(())
    }
}

/// `(I - Y Y^T) Z`, projected twice: a single projection leaves a component along `Y` of size `eps |Z|`, which may
/// dominate a small result.
fn horizontal_part(y: MatRef<'_, f64>, z: MatRef<'_, f64>) -> Mat<f64> {
    let mut out = z.to_owned();
    remove_part(y, &mut out);
    remove_part(y, &mut out);
    out
}

/// `Z -= Y Y^T Z`.
fn remove_part(y: MatRef<'_, f64>, z: &mut Mat<f64>) {
    let along = product(y.transpose(), &*z);
    mul_add(z, -1.0, y, &along);
}
