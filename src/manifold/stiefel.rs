//! `St(n, k)` with a metric: membership, projections, and the paper's parametrisation.

use faer::{Mat, MatRef};

use super::metric::Metric;
use crate::error::{Error, Result};
use crate::linalg::decomp::polar_factor;
use crate::linalg::product::{mul_add, product};
use crate::linalg::skew_exp::check_skew;
use crate::linalg::structure::{
    check_finite, check_range, check_shape, frobenius_inner, gram, gram_defect, norm,
    orthonormality_defect, skew_defect, skew_part, symmetric_part, with_inner_products,
};

/// Allowed defect of a point, `|S^T S - I|_F`.
pub const POINT_TOLERANCE: f64 = 1e-9;

/// Largest number of entries of a point that memory can hold.
const MAX_ENTRIES: usize = isize::MAX as usize / size_of::<f64>();

/// Allowed defect of a tangent vector, `|S^T V + V^T S|_F / 2`, relative to `max(1, |V|_F)`.
pub const TANGENT_TOLERANCE: f64 = 1e-9;

/// The manifold of `n x k` matrices with orthonormal columns, with the canonical [`Metric`] unless another is chosen.
///
/// ```math
/// St(n,k) = \{ S \in R^{n \times k} : S^T S = I_k \},\qquad
/// \langle V, W \rangle_S = \mathrm{tr}\, V^T (I - \tfrac12 S S^T) W
/// ```
///
/// # Source
/// Edelman, Arias, Smith (1998), section 2.4.1 (canonical metric).
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::Stiefel;
/// let manifold = Stiefel::new(3, 2)?;
/// assert_eq!(manifold.dim(), 3);
/// let s = manifold.project(mat![[1.0, 0.1], [0.2, 1.0], [0.0, 0.3]].as_ref())?;
/// assert!((s.transpose() * &s - mat![[1.0, 0.0], [0.0, 1.0]]).norm_l2() < 1e-14);
/// let v = manifold.project_tangent(s.as_ref(), mat![[0.0, 1.0], [0.0, 0.0], [1.0, 0.0]].as_ref())?;
/// manifold.check_tangent("v", s.as_ref(), v.as_ref(), 1e-14)?;
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Stiefel {
    n: usize,
    k: usize,
    metric: Metric,
}

impl Stiefel {
    /// The manifold `St(n, k)` with the canonical metric.
    ///
    /// # Errors
    /// `Shape` unless `1 <= k <= n` and a point fits in memory.
    pub fn new(n: usize, k: usize) -> Result<Self> {
        if k == 0 || k > n || n.checked_mul(k).is_none_or(|entries| entries > MAX_ENTRIES) {
            return Err(Error::Shape {
                name: "St(n, k)",
                expected: "1 <= k <= n, and a point that fits in memory".to_owned(),
                found: format!("n = {n}, k = {k}"),
            });
        }
        Ok(Stiefel {
            n,
            k,
            metric: Metric::CANONICAL,
        })
    }

    /// The same manifold with another metric.
    pub fn with_metric(self, metric: Metric) -> Self {
        Stiefel { metric, ..self }
    }

    /// The metric.
    pub fn metric(&self) -> Metric {
        self.metric
    }

    /// The manifold for points with the shape of the `n x k` matrix `s`.
    ///
    /// # Errors
    /// `Shape` unless `1 <= k <= n`.
    pub fn of(name: &'static str, s: MatRef<'_, f64>) -> Result<Self> {
        Stiefel::new(s.nrows(), s.ncols()).map_err(|_| Error::Shape {
            name,
            expected: "(n, k) with 1 <= k <= n".to_owned(),
            found: format!("({}, {})", s.nrows(), s.ncols()),
        })
    }

    /// Rows of a point.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Columns of a point.
    pub fn k(&self) -> usize {
        self.k
    }

    /// Dimension of the manifold, `nk - k(k+1)/2`.
    pub fn dim(&self) -> usize {
        self.n * self.k - self.k * (self.k + 1) / 2
    }

    /// Checks shape, finiteness and `|S^T S - I|_F <= tolerance`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`.
    pub fn check_point(
        &self,
        name: &'static str,
        s: MatRef<'_, f64>,
        tolerance: f64,
    ) -> Result<()> {
        check_shape(name, s, self.n, self.k)?;
        check_defect(name, s, orthonormality_defect(s), tolerance)
    }

    /// As [`Stiefel::check_point`]; returns `S^T S`, in the lower triangle.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`.
    pub(crate) fn checked_gram(
        &self,
        name: &'static str,
        s: MatRef<'_, f64>,
        tolerance: f64,
    ) -> Result<Mat<f64>> {
        check_shape(name, s, self.n, self.k)?;
        let gram = gram(s);
        check_defect(name, s, gram_defect(gram.as_ref()), tolerance)?;
        Ok(gram)
    }

    /// Checks shape, finiteness and `|S^T V + V^T S|_F / 2 <= tolerance max(1, |V|_F)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotTangent`.
    pub fn check_tangent(
        &self,
        name: &'static str,
        s: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
        tolerance: f64,
    ) -> Result<()> {
        self.check_matrices([("S", s), (name, v)])?;
        let defect = with_inner_products(s, v, skew_defect);
        check_tangency(name, v, defect, tolerance)
    }

    /// `S^T V` for a vector that is checked as by [`Stiefel::check_tangent`], at a finite point.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotTangent`.
    pub(super) fn checked_product(
        &self,
        name: &'static str,
        s: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
        tolerance: f64,
    ) -> Result<Mat<f64>> {
        self.check_matrices([(name, v)])?;
        let inner = product(s.transpose(), v);
        check_tangency(name, v, skew_defect(inner.as_ref()), tolerance)?;
        Ok(inner)
    }

    /// Nearest point in the Frobenius norm, the polar factor of `y` (shape `(n, k)`).
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `RankDeficient`.
    pub fn project(&self, y: MatRef<'_, f64>) -> Result<Mat<f64>> {
        check_shape("Y", y, self.n, self.k)?;
        check_finite("Y", y)?;
        polar_factor("Y", y)
    }

    /// Orthogonal projection of `z` (shape `(n, k)`) to the tangent space at `s`.
    ///
    /// ```math
    /// Z - S\, \mathrm{sym}(S^T Z)
    /// ```
    ///
    /// # Errors
    /// `Shape`, `NonFinite`.
    pub fn project_tangent(&self, s: MatRef<'_, f64>, z: MatRef<'_, f64>) -> Result<Mat<f64>> {
        self.check_matrices([("S", s), ("Z", z)])?;
        Ok(z - s * symmetric_part((s.transpose() * z).as_ref()))
    }

    /// Inner product of two tangent vectors at `s`; `tr V^T (I - S S^T / 2) W` for the canonical metric.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `Overflow`.
    pub fn inner(&self, s: MatRef<'_, f64>, v: MatRef<'_, f64>, w: MatRef<'_, f64>) -> Result<f64> {
        self.check_matrices([("S", s), ("V", v), ("W", w)])?;
        let (sv, sw) = (s.transpose() * v, s.transpose() * w);
        let product = frobenius_inner(v, w)
            + (self.metric.weight() - 1.0) * frobenius_inner(sv.as_ref(), sw.as_ref());
        if product.is_finite() {
            Ok(product)
        } else {
            Err(Error::Overflow {
                quantity: "inner product",
            })
        }
    }

    /// Norm of a tangent vector at `s`, without cancellation; `sqrt(|K|^2 + |Omega|^2 / 2)` for the canonical metric.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `Overflow`.
    pub fn norm(&self, s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<f64> {
        let (normal, omega) = self.split(s, v)?;
        let length =
            norm(normal.as_ref()).hypot(norm(omega.as_ref()) * self.metric.weight().sqrt());
        if length.is_finite() {
            Ok(length)
        } else {
            Err(Error::Overflow { quantity: "norm" })
        }
    }

    /// [`Stiefel::norm`] for a point and a vector computed along a curve: `Overflow` of the named quantity if they are
    /// not finite.
    ///
    /// # Errors
    /// `Overflow`.
    pub(crate) fn norm_along(
        &self,
        quantity: &'static str,
        s: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
    ) -> Result<f64> {
        check_range(quantity, s)?;
        check_range(quantity, v)?;
        self.norm(s, v).map_err(|_| Error::Overflow { quantity })
    }

    /// The pair `(K, Omega)` with `V = K + S Omega` and `S^T K = 0`, shapes `(n, k)` and `(k, k)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`.
    pub fn split(&self, s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<(Mat<f64>, Mat<f64>)> {
        self.check_matrices([("S", s), ("V", v)])?;
        let (inner, mut normal) = (product(s.transpose(), v), v.to_owned());
        mul_add(&mut normal, -1.0, s, &inner);
        // Projected twice: a single projection leaves a component along S of size eps |V|, which may dominate a small
        // K.
        let rest = product(s.transpose(), &normal);
        mul_add(&mut normal, -1.0, s, &rest);
        Ok((normal, skew_part(inner.as_ref())))
    }

    /// The paper's pair `(X, Omega)` of a tangent vector: `V = X S + S Omega` with `X` skew `(n, n)` and `Omega` skew
    /// `(k, k)`.
    ///
    /// ```math
    /// X = V S^T - S V^T + 2 S V^T S S^T = K S^T - S K^T,\qquad \Omega = S^T V
    /// ```
    ///
    /// # Errors
    /// `Shape`, `NonFinite`.
    /// # Source
    /// arXiv 2404.19407, parametrisation of the tangent space; the right-hand form has rank at most `2k`.
    pub fn decompose(
        &self,
        s: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
    ) -> Result<(Mat<f64>, Mat<f64>)> {
        let (normal, omega) = self.split(s, v)?;
        Ok((&normal * s.transpose() - s * normal.transpose(), omega))
    }

    /// The tangent vector `V = X S + S Omega` from the paper's pair.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotSkew`.
    pub fn compose(
        &self,
        s: MatRef<'_, f64>,
        x: MatRef<'_, f64>,
        omega: MatRef<'_, f64>,
    ) -> Result<Mat<f64>> {
        self.check_matrices([("S", s)])?;
        for (name, skew, size) in [("X", x, self.n), ("Omega", omega, self.k)] {
            check_shape(name, skew, size, size)?;
            check_finite(name, skew)?;
            check_skew(name, skew)?;
        }
        Ok(x * s + s * omega)
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

/// Returns an error unless `S^T V` has at most the given defect, relative to `max(1, |V|_F)`.
fn check_tangency(
    name: &'static str,
    v: MatRef<'_, f64>,
    defect: f64,
    tolerance: f64,
) -> Result<()> {
    let tolerance = tolerance * norm(v).max(1.0);
    match defect <= tolerance {
        true => Ok(()),
        false => Err(Error::NotTangent {
            name,
            defect,
            tolerance,
        }),
    }
}

/// Returns an error unless the columns of a point have at most the given defect.
fn check_defect(name: &'static str, s: MatRef<'_, f64>, defect: f64, tolerance: f64) -> Result<()> {
    // An entry that is not finite makes the diagonal non-finite; finite entries can overflow.
    if !defect.is_finite() {
        check_finite(name, s)?;
    }
    if defect <= tolerance {
        return Ok(());
    }
    Err(Error::NotOrthonormal {
        name,
        defect,
        tolerance,
    })
}
