//! Riemannian logarithm and distance on `St(n, k)`, for every metric of the alpha family.
//!
//! | case | method |
//! |---|---|
//! | `k = 1` | closed form of the sphere |
//! | `k = n`; `k = n - 1`, canonical | one logarithm of a rotation |
//! | near points | Newton's method for the exponential, order 3: two or three steps (`shooting.rs`) |
//! | distant points | Newton's method for the shortest rotation over the fibre, then for the exponential (`descent.rs`) |
//! | other metrics | from the canonical solution, directly or along the family |
//! | other metrics, not certainly shortest | from the path along the canonical solution, shortened (`shortening.rs`) |
//! | other metrics, ends nearly conjugate | damped least squares for the exponential (`shooting/damped.rs`) |
//!
//! Everything except the first and the last product is computed in `k + p` dimensions, `p = min(k, n - k)`.

mod adjoint;
mod descent;
mod fibre_hessian;
mod report;
mod search;
mod shooting;
mod shortening;

pub use report::LogReport;

use std::f64::consts::PI;

use faer::{Mat, MatRef, Scale};

use super::metric::Metric;
use super::normal_frame::{normal_frame, normal_rank};
use super::only_bases::advised;
use super::stiefel::{POINT_TOLERANCE, Stiefel};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::OrthogonalLog;
use crate::linalg::product::{determinant_sign, mul_add, mul_into};
use crate::linalg::structure::orthonormality_defect;
use report::{no_convergence, not_joined};
use search::{CONTRACTION, Search};
use shooting::GeodesicShooting;

/// Residual of convergence, in units of the size times round-off.
const TOLERANCE: f64 = 32.0;

/// If the entries of the normal part are below this, a second projection removes the round-off of the first.
const SHORT_NORMAL: f64 = 0.1;

/// On the sphere, an angle whose sine is below this is pi to working precision.
const ANTIPODAL: f64 = 4.0 * f64::EPSILON;

impl Stiefel {
    /// The Riemannian logarithm: the velocity at `s0` of a geodesic that reaches `s1` at `t = 1`.
    ///
    /// # Errors
    /// The errors of [`Stiefel::log_with_report`].
    pub fn log(&self, s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Result<Mat<f64>> {
        Ok(self.log_with_report(s0, s1, Interrupt::NEVER)?.0)
    }

    /// The Riemannian distance, the length of the geodesic of [`Stiefel::log`].
    ///
    /// # Errors
    /// The errors of [`Stiefel::log_with_report`].
    pub fn dist(&self, s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Result<f64> {
        Ok(self.log_with_report(s0, s1, Interrupt::NEVER)?.1.length)
    }

    /// The Riemannian logarithm with a report.
    ///
    /// ```math
    /// \exp_{S_0}(V) = S_1
    /// ```
    ///
    /// The geodesic is the shortest one if its length is below [`Stiefel::injectivity_bound`], and always for `k = 1`,
    /// `k = n`, and (canonical metric) `k = n - 1`. Otherwise the report says that a shorter one may exist: it is the
    /// shortest one found from a close start and from up to four completions of the points to rotations, none of them a
    /// saddle over the fibre. With the canonical metric the search ends at a geodesic whose two largest angles of
    /// rotation add up to less than pi.
    ///
    /// # Arguments
    /// * `s0`, `s1` - points, shape `(n, k)`
    /// # Accuracy
    /// Residual at most `1e-11` (`32 (k + p) eps` in the coordinates of the frame), plus the defect of the points. At
    /// most 10 Newton steps for each of `10^4` random pairs of each of eight shapes at distances up to `0.89 pi`.
    /// Asserted in `tests/logarithm.rs`.
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`; `DifferentComponents` (`k = n`); `NoJoiningCurve` if an angle is pi to
    /// working precision, so that no unique geodesic is the shortest; `NoConvergence` if no geodesic was found, both
    /// in `OnlyBases` if the points look like mere bases; `Decomposition`, `Interrupted`.
    /// # Source
    /// The formulation on the rotation group: Zimmermann, Hueper (2022), "Computing the Riemannian logarithm on the
    /// Stiefel manifold: metrics, methods, and performance", SIAM J. Matrix Anal. Appl. 43, 953-980. The headers of the
    /// submodules describe the methods.
    pub fn log_with_report(
        &self,
        s0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        interrupt: Interrupt<'_>,
    ) -> Result<(Mat<f64>, LogReport)> {
        self.check_point("S0", s0, POINT_TOLERANCE)?;
        self.check_point("S1", s1, POINT_TOLERANCE)?;
        let found = self.log_of_points(s0, s1, interrupt);
        found.map_err(|error| advised(error, s0, s1))
    }

    fn log_of_points(
        &self,
        s0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        interrupt: Interrupt<'_>,
    ) -> Result<(Mat<f64>, LogReport)> {
        let (n, k) = (self.n(), self.k());
        let gram = s0.transpose() * s1;
        if k == n {
            return self.log_of_rotation(s0, gram);
        }
        let mut normal = s1.to_owned();
        mul_add(&mut normal, -1.0, s0, &gram);
        if normal.norm_max() < SHORT_NORMAL {
            let rest = s0.transpose() * &normal;
            mul_add(&mut normal, -1.0, s0, &rest);
        }
        if k == 1 {
            return self.log_on_sphere(s0, gram[(0, 0)], normal);
        }
        let p = normal_rank(n, k);
        let b = normal_frame(s0, normal.as_mut());
        let q = normal.as_ref().subcols(0, p);
        let mut target = Mat::zeros(k + p, k);
        target.as_mut().subrows_mut(0, k).copy_from(&gram);
        target.as_mut().subrows_mut(k, p).copy_from(&b);
        let found = Search::new(self, &target, interrupt).run()?;
        let mut velocity = Mat::zeros(n, k);
        mul_into(&mut velocity, 1.0, s0, found.a());
        mul_add(&mut velocity, 1.0, q, found.b());
        Ok((velocity, found.report))
    }

    /// Length below which every geodesic is the shortest one between its ends; 0 if no bound is known.
    ///
    /// The canonical metric has sectional curvature at most 5/4 and no closed geodesic shorter than `2 pi`, hence
    /// `sqrt(4/5) pi = 0.894 pi`. The bound is `pi` for the Euclidean metric, for the sphere and, with the canonical
    /// metric, for the rotation group (`k >= n - 1`).
    ///
    /// # Source
    /// Rentmeesters (2013), "Algorithms for data fitting on some common homogeneous spaces", thesis, UCLouvain (bound);
    /// Zimmermann, Stoye (2025), "High curvature means low-rank: on the sectional curvature of Grassmann and Stiefel
    /// manifolds and the underlying matrix trace inequalities" (curvature), and (2024), "The injectivity radius of the
    /// compact Stiefel manifold under the Euclidean metric" (`pi`).
    pub fn injectivity_bound(&self) -> f64 {
        let (n, k) = (self.n(), self.k());
        match self.metric() {
            _ if k == 1 => PI,
            // Closed geodesics of SO(n) rotate a plane: |Omega|_F = sqrt(2) 2 pi.
            metric if k == n => PI * (2.0 * metric.weight()).sqrt(),
            Metric::CANONICAL if k + 1 == n => PI,
            Metric::CANONICAL => 0.8_f64.sqrt() * PI,
            Metric::EUCLIDEAN => PI,
            _ => 0.0,
        }
    }

    /// `k = n`: the metrics of the family are multiples of the bi-invariant one.
    fn log_of_rotation(
        &self,
        s0: MatRef<'_, f64>,
        gram: Mat<f64>,
    ) -> Result<(Mat<f64>, LogReport)> {
        let n = self.n();
        if determinant_sign(gram.clone().as_mut()) < 0.0 {
            return Err(Error::DifferentComponents { n });
        }
        let mut log = Mat::zeros(n, n);
        OrthogonalLog::new(n)
            .log_into(log.as_mut(), gram.as_ref())
            .map_err(not_joined)?;
        let mut shooting = GeodesicShooting::new(&gram, 0.5);
        shooting.start_from(log.as_ref());
        let outcome = shooting.run(self.tolerance(&gram), CONTRACTION, 1)?;
        let report = LogReport {
            converged: true,
            iterations: outcome.iterations,
            residual: outcome.residual,
            length: shooting.norms().0 * self.metric().weight().sqrt(),
            certainly_shortest: true,
        };
        if !outcome.converged {
            return Err(no_convergence(outcome, self.tolerance(&gram)));
        }
        Ok((s0 * &shooting.generator, report))
    }

    /// `k = 1`: a great circle, from the angle between the unit vectors.
    fn log_on_sphere(
        &self,
        s0: MatRef<'_, f64>,
        cosine: f64,
        mut normal: Mat<f64>,
    ) -> Result<(Mat<f64>, LogReport)> {
        // Project twice: the component that one projection leaves along S0 may be large relative to a short remainder.
        let rest = s0.transpose() * &normal;
        mul_add(&mut normal, -1.0, s0, &rest);
        let sine = normal.norm_l2();
        let angle = sine.atan2(cosine);
        if cosine < 0.0 && sine <= ANTIPODAL {
            return Err(Error::NoJoiningCurve { angle });
        }
        let factor = if sine > 0.0 { angle / sine } else { 1.0 };
        let (sin, cos) = angle.sin_cos();
        let report = LogReport {
            converged: true,
            iterations: 0,
            residual: (sin - sine).hypot(cos - cosine),
            length: angle,
            certainly_shortest: true,
        };
        Ok((normal * Scale(factor), report))
    }

    /// The residual at which the coordinates of a target count as reached.
    fn tolerance(&self, target: &Mat<f64>) -> f64 {
        // A point that is off the manifold by its tolerance cannot be reached more closely.
        TOLERANCE * target.nrows() as f64 * f64::EPSILON
            + 2.0 * orthonormality_defect(target.as_ref())
    }
}
