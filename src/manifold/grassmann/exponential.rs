//! Exponential and parallel transport, as even functions of the principal rotation rates.
//!
//! With a thin singular value decomposition `V = Q S W^T`, the geodesic from `Y` ends at `(Y W cos S + Q sin S) W^T`.
//! Since cosine and `sin(s) / s` are even, this is
//!
//! ```math
//! Y \cos\sqrt{G} + V\, \mathrm{sinc}\sqrt{G},\qquad G = V^T V,
//! ```
//!
//! and it only takes a symmetric eigenproblem of size `k`. The round-off of `G` is `eps |V|^2`, so for fast geodesics
//! the decomposition of `V` is used instead.

use faer::{Mat, MatRef, Scale};

use super::Grassmann;
use crate::error::Result;
use crate::linalg::decomp::{SymmetricEigen, thin_q};
use crate::linalg::product::{mul_add, mul_into};
use crate::linalg::structure::{check_finite, check_range, gram, norm};
use crate::manifold::Geodesic;
use crate::manifold::QuasiGeodesic;
use crate::manifold::quasi_geodesic::Departure;
use crate::manifold::stiefel::POINT_TOLERANCE;
use crate::manifold::stiefel::{Stiefel, TANGENT_TOLERANCE};
use crate::space::Quotient;

/// Squared rotation rate up to which the round-off of `V^T V` causes errors of a few units in the last place of the
/// result. The value is `pi^2`.
const SLOW: f64 = 9.87;

/// `sin(s) / s` at `s = sqrt(square)`.
fn sinc(square: f64) -> f64 {
    let s = square.max(0.0).sqrt();
    if s > 0.0 { s.sin() / s } else { 1.0 }
}

/// `(cos(s) - 1) / s^2` at `s = sqrt(square)`, without cancellation.
fn versine(square: f64) -> f64 {
    let half = sinc(0.25 * square);
    -0.5 * half * half
}

/// The factors of a geodesic.
enum SpanFactors {
    /// Eigenvalues and eigenvectors of `V^T V`.
    Slow(SymmetricEigen),
    /// `V = Q diag(angles) W^T`.
    Fast {
        /// `[Y W, Q]`, shape `(n, 2k)`; for a direction with angle 0, the column in `Q` is arbitrary.
        frame: Mat<f64>,
        angles: Vec<f64>,
        /// `W^T`.
        right: Mat<f64>,
    },
}

impl SpanFactors {
    fn new(y: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<Self> {
        let (n, k) = y.shape();
        let square = gram(v);
        if check_finite("V^T V", square.as_ref()).is_ok() {
            let mut eigen = SymmetricEigen::new(k);
            eigen.compute(square.as_ref())?;
            if eigen.value(k - 1) <= SLOW {
                return Ok(SpanFactors::Slow(eigen));
            }
        }
        let mut curve = QuasiGeodesic::zeros(n, k);
        curve.leave(y, v, &mut Departure::new(n, k))?;
        // Slow directions next to fast ones carry the round-off of the fast ones, along `Y` too.
        let (mut frame, basis) = (curve.frame().to_owned(), thin_q(curve.frame()));
        let normal = basis.as_ref().subcols(k, basis.ncols() - k);
        let mut free = frame.as_mut().subcols_mut(k, k);
        free.fill(0.0);
        free.subcols_mut(0, normal.ncols()).copy_from(normal);
        Ok(SpanFactors::Fast {
            frame,
            angles: curve.angles().to_vec(),
            right: curve.right().to_owned(),
        })
    }
}

/// The rows `f(angle) x` for `Y W` and `g(angle) x` for `Q`, where `(f, g)` is computed from sine and cosine.
fn coordinates(angles: &[f64], x: MatRef<'_, f64>, f: fn((f64, f64)) -> [f64; 2]) -> Mat<f64> {
    let k = angles.len();
    Mat::from_fn(2 * k, k, |i, j| {
        let factors = f(angles[i % k].sin_cos());
        factors[i / k] * x[(i % k, j)]
    })
}

/// `W diag(f) W^T` for eigenvectors `W` and a function `f` of the eigenvalues.
fn function(eigen: &SymmetricEigen, f: fn(f64) -> f64) -> Mat<f64> {
    let w = eigen.vectors();
    let k = w.ncols();
    let mut scaled = w.to_owned();
    for j in 0..k {
        scaled
            .as_mut()
            .col_mut(j)
            .copy_from(w.col(j) * Scale(f(eigen.value(j))));
    }
    let mut out = Mat::zeros(k, k);
    mul_into(&mut out, 1.0, &scaled, w.transpose());
    out
}

impl Grassmann {
    /// The geodesic from `y` with initial velocity `v`, as a curve of bases that rotate as little as possible.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotHorizontal`, `Overflow`, `Decomposition`.
    pub fn geodesic(&self, y: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<Geodesic> {
        self.check_tangent("V", y, v, TANGENT_TOLERANCE)?;
        let mut curve = Stiefel::new(self.n(), self.k())?.geodesic(y, v)?;
        // The geodesic of frames with the same velocity, without the rotation caused by round-off.
        let k = self.k();
        let generator = curve.motion.generator.as_mut();
        generator.submatrix_mut(0, 0, k, k).fill(0.0);
        curve.quotient = Quotient::Subspaces;
        Ok(curve)
    }

    /// The shortest geodesic from the subspace of `y0` to the subspace of `y1`.
    ///
    /// # Errors
    /// The errors of [`Grassmann::log`].
    pub fn geodesic_between(&self, y0: MatRef<'_, f64>, y1: MatRef<'_, f64>) -> Result<Geodesic> {
        self.geodesic(y0, self.log(y0, y1)?.as_ref())
    }

    /// The Riemannian exponential: the point at `t = 1` of the geodesic from `y` with velocity `v`.
    ///
    /// ```math
    /// (Y W \cos S + Q \sin S)\, W^T,\qquad V = Q S W^T
    /// ```
    ///
    /// Among all bases of that subspace it is the one reached without rotating within the subspace: the geodesic is
    /// horizontal. It is the basis nearest to `y` if no principal angle exceeds `pi/2`.
    ///
    /// # Arguments
    /// * `y` - point, shape `(n, k)`; `v` - tangent vector at `y`, shape `(n, k)`
    /// # Accuracy
    /// Orthonormal to `1e-14 k`, for any length of `v`; asserted in `tests/grassmann/`.
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotHorizontal`, `Overflow`, `Decomposition`.
    /// # Source
    /// Edelman, Arias, Smith (1998), theorem 2.3, whose last factor `W^T` makes the geodesic horizontal.
    pub fn exp(&self, y: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<Mat<f64>> {
        self.check_point("Y", y, POINT_TOLERANCE)?;
        let v = self.horizontal("V", y, v)?;
        let mut out = Mat::zeros(self.n(), self.k());
        match SpanFactors::new(y, v.as_ref())? {
            SpanFactors::Slow(eigen) => {
                mul_into(
                    &mut out,
                    1.0,
                    y,
                    function(&eigen, |x| x.max(0.0).sqrt().cos()),
                );
                mul_add(&mut out, 1.0, &v, function(&eigen, sinc));
            }
            SpanFactors::Fast {
                frame,
                angles,
                right,
            } => {
                let end = coordinates(&angles, right.as_ref(), |(sin, cos)| [cos, sin]);
                mul_into(&mut out, 1.0, &frame, &end);
            }
        }
        check_range("geodesic", out.as_ref())?;
        Ok(out)
    }

    /// Parallel transport of `w` along the geodesic `t -> exp(Y, t V)` to the basis that [`Grassmann::exp`] returns.
    ///
    /// ```math
    /// W + \big( Q (\cos S - I) - Y W_V \sin S \big) Q^T W,\qquad V = Q S W_V^T
    /// ```
    ///
    /// # Arguments
    /// * `y` - point; `v`, `w` - tangent vectors at `y`; shapes `(n, k)`
    /// # Accuracy
    /// Isometric and horizontal to `1e-14 k |W|`, asserted in `tests/grassmann/`.
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotHorizontal`, `Overflow`, `Decomposition`.
    /// # Source
    /// Edelman, Arias, Smith (1998), theorem 2.4.
    pub fn transport(
        &self,
        y: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
        w: MatRef<'_, f64>,
    ) -> Result<Mat<f64>> {
        self.check_point("Y", y, POINT_TOLERANCE)?;
        let (v, w) = (self.horizontal("V", y, v)?, self.horizontal("W", y, w)?);
        let (k, size) = (self.k(), norm(w.as_ref()));
        if size == 0.0 {
            return Ok(w);
        }
        // The transport is linear: extreme lengths are factored out and restored at the end.
        let mut out = Mat::from_fn(self.n(), k, |i, j| w[(i, j)] / size);
        let mut parts = Mat::zeros(k, k);
        match SpanFactors::new(y, v.as_ref())? {
            SpanFactors::Slow(eigen) => {
                mul_into(&mut parts, 1.0, v.transpose(), &out);
                mul_add(&mut out, -1.0, y, function(&eigen, sinc) * &parts);
                mul_add(&mut out, 1.0, &v, function(&eigen, versine) * &parts);
            }
            SpanFactors::Fast { frame, angles, .. } => {
                let q = frame.as_ref().subcols(k, k);
                mul_into(&mut parts, 1.0, q.transpose(), &out);
                let turned = coordinates(&angles, parts.as_ref(), |(sin, cos)| [-sin, cos - 1.0]);
                mul_add(&mut out, 1.0, &frame, &turned);
            }
        }
        let out = out * Scale(size);
        check_range("parallel transport", out.as_ref())?;
        Ok(out)
    }
}
