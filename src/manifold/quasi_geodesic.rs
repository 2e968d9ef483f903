//! Quasi-geodesics `e^{tX} S e^{t Omega}` in `O(n k^2)`, from an initial velocity or between two points.
//!
//! # Source
//! Krakowski, Machado, Silva Leite, Batista (2017), "A modified Casteljau algorithm to solve interpolation problems on
//! Stiefel manifolds", J. Comput. Appl. Math. 311, 84-99; arXiv 2404.19407, Proposition 1. Deviations: a thin
//! factorisation (no `n x n` matrix), and end points with angles beyond pi/2.

use std::f64::consts::PI;

use faer::{Mat, MatRef};

use super::only_bases::advised;
use super::principal_vectors::PrincipalVectors;
use super::stiefel::{POINT_TOLERANCE, Stiefel, TANGENT_TOLERANCE};
use crate::error::{Error, Result};
use crate::linalg::decomp::Svd;
use crate::linalg::jet::{MatrixJet, ORDER};
use crate::linalg::one_sided_jacobi::orthogonalise_few;
use crate::linalg::product::{mul_add, mul_into, product};
use crate::linalg::{OrthogonalLog, SkewExp};

/// A principal direction shorter than this is round-off: its angle is 0 (or pi, in which case the curve is not unique).
const NEGLIGIBLE: f64 = 4.0 * f64::EPSILON;

/// A principal angle is pi to working precision if its sine is below this.
const ANTIPODAL: f64 = 32.0 * f64::EPSILON;

/// The quasi-geodesic `beta(t) = e^{tX} S e^{t Omega}`.
///
/// With a thin singular value decomposition `K = Q Sigma W^T` of the normal part of the velocity
/// `V = K + S Omega`:
///
/// ```math
/// \beta(t) = (S W \cos(t\Sigma) + Q \sin(t\Sigma))\, W^T e^{t\Omega}
/// ```
///
/// The curve is defined for all `t`. Orthonormality defect at most `1e-14` for `|t Sigma|, |t Omega| <= 10`, asserted
/// in `tests/quasi_geodesic/`.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Curve, QuasiGeodesic};
/// let (x, y) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let quarter = QuasiGeodesic::between(x.as_ref(), y.as_ref())?;
/// let middle = quarter.point(0.5)?;
/// assert!((middle[(0, 0)] - 0.5f64.sqrt()).abs() < 1e-15);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct QuasiGeodesic {
    /// `[S W, Q]`, shape `(n, 2k)`; a direction with angle 0 has a zero column in `Q`.
    pub(super) frame: Mat<f64>,
    /// The diagonal of `Sigma`.
    pub(super) angles: Vec<f64>,
    /// `W^T`.
    pub(super) right: Mat<f64>,
    pub(super) omega: Mat<f64>,
}

impl QuasiGeodesic {
    /// The quasi-geodesic from `s` with initial velocity `v` (its value at 1 is the retraction).
    ///
    /// # Arguments
    /// * `s` - point, shape `(n, k)`; `v` - tangent vector at `s`, shape `(n, k)`
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`, `Decomposition`.
    pub fn from_velocity(s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<Self> {
        let manifold = Stiefel::of("S", s)?;
        manifold.check_point("S", s, POINT_TOLERANCE)?;
        manifold.check_tangent("V", s, v, TANGENT_TOLERANCE)?;
        let (n, k) = (manifold.n(), manifold.k());
        let mut out = Self::zeros(n, k);
        out.leave(s, v, &mut Departure::new(n, k))?;
        Ok(out)
    }

    /// Replaces this curve by the one from `s` with initial velocity `v`, in existing buffers.
    ///
    /// # Errors
    /// `Overflow`, `Decomposition`.
    pub(crate) fn leave(
        &mut self,
        s: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
        work: &mut Departure,
    ) -> Result<()> {
        let k = self.k();
        work.split(s, v);
        work.factor()?;
        let floor = NEGLIGIBLE * crate::linalg::structure::norm(v);
        self.right.copy_from(work.w.transpose());
        mul_into(self.frame.as_mut().subcols_mut(0, k), 1.0, s, &work.w);
        self.frame.as_mut().subcols_mut(k, k).fill(0.0);
        self.angles.fill(0.0);
        for i in 0..k {
            let angle = crate::linalg::structure::norm(work.normal.as_ref().subcols(i, 1));
            if angle > floor {
                self.angles[i] = angle;
                for row in 0..self.frame.nrows() {
                    self.frame[(row, k + i)] = work.normal[(row, i)] / angle;
                }
            }
        }
        for j in 0..k {
            for i in 0..k {
                self.omega[(i, j)] = 0.5 * (work.along[(i, j)] - work.along[(j, i)]);
            }
        }
        Ok(())
    }

    /// The principal quasi-geodesic with `beta(0) = s0`, `beta(1) = s1`.
    ///
    /// With the singular value decomposition `S0^T S1 = U C Z^T` and angles `theta_i = atan2(s_i, c_i)`, where
    /// column `i` of `(I - S0 S0^T) S1 Z` is `s_i q_i`:
    ///
    /// ```math
    /// \Omega = \log(U Z^T),\qquad K = Q\, \mathrm{diag}(\theta)\, U^T
    /// ```
    ///
    /// If `det(U Z^T) = -1` and `k < n`, the last column of `U` and the smallest cosine change sign: the angle becomes
    /// `pi - theta_k` and the determinant +1. So almost any two points are joined. Changing other pairs of signs gives
    /// other branches. This one has the shortest normal part `|K|`, but not always the least length `(|K|^2 + |Omega|^2
    /// / 2)^{1/2}`: for 8 to 25 % of random pairs another branch is shorter, with a smaller `Omega`. The shortest
    /// branch is not used because it costs a logarithm of a rotation for each pair of signs, and because it changes,
    /// with a jump of the curve, at points where the principal one is smooth.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`; `DifferentComponents` (k = n); `OutsideLogDomain` if `U Z^T` has an
    /// eigenvalue -1; `NoJoiningCurve` if a principal angle is pi (antipodal points), the last two in `OnlyBases` if the
    /// points look like mere bases; angles are compared to working precision.
    pub fn between(s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Result<Self> {
        Self::joining(s0, s1).map_err(|error| advised(error, s0, s1))
    }

    /// As [`QuasiGeodesic::between`], without the hint that the points may be mere bases.
    ///
    /// # Errors
    /// As [`QuasiGeodesic::between`].
    pub(crate) fn joining(s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Result<Self> {
        let manifold = Stiefel::of("S0", s0)?;
        manifold.check_point("S0", s0, POINT_TOLERANCE)?;
        manifold.check_point("S1", s1, POINT_TOLERANCE)?;
        let mut out = Self::zeros(manifold.n(), manifold.k());
        out.join(
            s0,
            s1,
            &mut EndpointProblem::new(manifold.n(), manifold.k()),
        )?;
        Ok(out)
    }

    pub(crate) fn zeros(n: usize, k: usize) -> Self {
        QuasiGeodesic {
            frame: Mat::zeros(n, 2 * k),
            angles: vec![0.0; k],
            right: Mat::zeros(k, k),
            omega: Mat::zeros(k, k),
        }
    }

    /// Rows of a point.
    pub fn n(&self) -> usize {
        self.frame.nrows()
    }

    /// Columns of a point.
    pub fn k(&self) -> usize {
        self.frame.ncols() / 2
    }

    /// The skew factor `Omega`, shape `(k, k)`.
    pub fn omega(&self) -> MatRef<'_, f64> {
        self.omega.as_ref()
    }

    pub(crate) fn omega_mut(&mut self) -> faer::MatMut<'_, f64> {
        self.omega.as_mut()
    }

    /// The principal angles `Sigma` of the normal part, in radians per unit of `t`.
    pub fn angles(&self) -> &[f64] {
        &self.angles
    }

    /// The initial velocity `V = K + S Omega`, shape `(n, k)`.
    pub fn initial_velocity(&self) -> Mat<f64> {
        let k = self.k();
        let mut rates = Mat::zeros(2 * k, k);
        for j in 0..k {
            for i in 0..k {
                rates[(k + i, j)] = self.angles[i] * self.right[(i, j)];
            }
        }
        mul_into(
            rates.as_mut().subrows_mut(0, k),
            1.0,
            &self.right,
            &self.omega,
        );
        product(&self.frame, &rates)
    }

    /// The same curve traversed backwards: `t -> beta(1 - t)`.
    ///
    /// # Errors
    /// `Decomposition`.
    pub fn reversed(&self) -> Result<Self> {
        let (n, k) = (self.n(), self.k());
        let mut out = Self::zeros(n, k);
        for i in 0..k {
            let (sin, cos) = self.angles[i].sin_cos();
            for row in 0..n {
                let (x, q) = (self.frame[(row, i)], self.frame[(row, k + i)]);
                out.frame[(row, i)] = x * cos + q * sin;
                out.frame[(row, k + i)] = x * sin - q * cos;
            }
            out.angles[i] = self.angles[i];
            if self.angles[i] == 0.0 {
                out.frame.as_mut().col_mut(k + i).fill(0.0);
            }
        }
        let mut turn = Mat::zeros(k, k);
        SkewExp::new(k).exp_into(turn.as_mut(), self.omega.as_ref(), 1.0)?;
        mul_into(&mut out.right, 1.0, &self.right, &turn);
        out.omega = -&self.omega;
        Ok(out)
    }

    /// Replaces this curve by the principal quasi-geodesic from `s0` to `s1`, in existing buffers.
    pub(crate) fn join(
        &mut self,
        s0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        problem: &mut EndpointProblem,
    ) -> Result<()> {
        let EndpointProblem { principal, log } = problem;
        principal.compute(s0, s1)?;
        let k = self.k();
        self.right.copy_from(principal.u.as_ref().transpose());
        mul_into(self.frame.as_mut().subcols_mut(0, k), 1.0, s0, &principal.u);
        self.frame.as_mut().subcols_mut(k, k).fill(0.0);
        self.angles.fill(0.0);
        if self.n() > k {
            self.principal_angles(s0, principal)?;
        }
        log.log_into(self.omega.as_mut(), principal.rotation.as_ref())
    }

    /// Angles and unit normal directions from `(I - S0 S0^T) S1 Z`, in order of decreasing sine.
    fn principal_angles(
        &mut self,
        s0: MatRef<'_, f64>,
        principal: &mut PrincipalVectors,
    ) -> Result<()> {
        let k = self.k();
        for i in (0..k).rev() {
            // Twice is enough: a direction that loses half of its length twice is round-off.
            let first = principal.orthogonalise(s0, self.frame.as_ref().subcols(k, k), i);
            let second = principal.orthogonalise(s0, self.frame.as_ref().subcols(k, k), i);
            let sine = if second > NEGLIGIBLE && second >= 0.5 * first {
                second
            } else {
                0.0
            };
            let cosine = principal.cosines[i];
            if cosine < 0.0 && sine <= ANTIPODAL {
                return Err(Error::NoJoiningCurve { angle: PI - sine });
            }
            if sine > 0.0 {
                self.angles[i] = sine.atan2(cosine);
                for row in 0..self.n() {
                    self.frame[(row, k + i)] = principal.normal[(row, i)] / sine;
                }
            }
        }
        Ok(())
    }

    /// Coordinates of the curve in its frame, as Taylor coefficients of shape `(2k, k)` up to the given order.
    pub(crate) fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        turning: &mut Turning,
        out: &mut MatrixJet,
    ) -> Result<()> {
        let k = self.k();
        turning.compute(self, t, order)?;
        for j in 0..=order {
            out.c[j].fill(0.0);
        }
        for i in 0..k {
            let theta = self.angles[i];
            let (sin, cos) = (t * theta).sin_cos();
            let mut factor = 1.0;
            for a in 0..=order {
                // The a-th Taylor coefficients of cos(t theta) and sin(t theta).
                let (c, s) = [(cos, sin), (-sin, cos), (-cos, -sin), (sin, -cos)][a % 4];
                for b in 0..=order - a {
                    for l in 0..k {
                        let g = turning.rates[b][(i, l)];
                        out.c[a + b][(i, l)] += factor * c * g;
                        out.c[a + b][(k + i, l)] += factor * s * g;
                    }
                }
                factor *= theta / (a + 1) as f64;
            }
        }
        Ok(())
    }

    /// Taylor coefficients of the curve, shape `(n, k)`, up to the given order.
    pub(crate) fn jet_into(
        &self,
        t: f64,
        order: usize,
        work: &mut Evaluation,
        out: &mut MatrixJet,
    ) -> Result<()> {
        self.coordinates_into(t, order, &mut work.turning, &mut work.coordinates)?;
        for j in 0..=order {
            mul_into(&mut out.c[j], 1.0, &self.frame, &work.coordinates.c[j]);
        }
        Ok(())
    }

    /// The factor `W^T`, shape `(k, k)`.
    pub(crate) fn right(&self) -> MatRef<'_, f64> {
        self.right.as_ref()
    }

    /// The frame `[S W, Q]`, shape `(n, 2k)`.
    pub(crate) fn frame(&self) -> MatRef<'_, f64> {
        self.frame.as_ref()
    }
}

/// Buffers for quasi-geodesics from a velocity, for one shape.
pub(crate) struct Departure {
    svd: Option<Box<Svd>>,
    /// `K`, then `K W`.
    normal: Mat<f64>,
    w: Mat<f64>,
    along: Mat<f64>,
    again: Mat<f64>,
}

impl Departure {
    pub(crate) fn new(n: usize, k: usize) -> Self {
        Departure {
            svd: None,
            normal: Mat::zeros(n, k),
            w: Mat::zeros(k, k),
            along: Mat::zeros(k, k),
            again: Mat::zeros(k, k),
        }
    }

    /// `V = K + S (S^T V)`, projected twice, since a single projection leaves a component along `S` of size `eps |V|`.
    fn split(&mut self, s: MatRef<'_, f64>, v: MatRef<'_, f64>) {
        mul_into(&mut self.along, 1.0, s.transpose(), v);
        self.normal.copy_from(v);
        mul_add(&mut self.normal, -1.0, s, &self.along);
        mul_into(&mut self.again, 1.0, s.transpose(), &self.normal);
        mul_add(&mut self.normal, -1.0, s, &self.again);
    }

    /// `K W = Q Sigma`.
    fn factor(&mut self) -> Result<()> {
        if orthogonalise_few(&mut self.normal, &mut self.w) {
            return Ok(());
        }
        let (n, k) = self.normal.shape();
        let svd = self.svd.get_or_insert_with(|| Box::new(Svd::new(n, k)));
        svd.compute(self.normal.as_ref())?;
        self.w.copy_from(svd.v());
        for j in 0..k {
            for i in 0..n {
                self.normal[(i, j)] = svd.s(j) * svd.u()[(i, j)];
            }
        }
        Ok(())
    }
}

/// Buffers for evaluating quasi-geodesics with a given `k`.
pub(crate) struct Evaluation {
    turning: Turning,
    coordinates: MatrixJet,
}

impl Evaluation {
    pub(crate) fn new(k: usize) -> Self {
        Evaluation {
            turning: Turning::new(k),
            coordinates: MatrixJet::zeros(2 * k, k),
        }
    }
}

/// Taylor coefficients of `W^T e^{t Omega}`.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::linalg::jet::MatrixJet;
/// use stiefel_rs::manifold::quasi_geodesic::Turning;
/// use stiefel_rs::{Curve, QuasiGeodesic};
/// let s = mat![[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];
/// let v = mat![[0.0, -1.0], [1.0, 0.0], [2.0, 0.0]];
/// let curve = QuasiGeodesic::from_velocity(s.as_ref(), v.as_ref())?;
/// let frame = curve.frame().expect("a quasi-geodesic has one");
/// let (mut work, mut jet): (Turning, MatrixJet) = (curve.workspace(), MatrixJet::zeros(frame.ncols(), 2));
/// for t in [0.0, 0.5, 1.0] {
///     curve.coordinates_into(t, 1, &mut work, &mut jet)?;
///     // The speed is constant: |V|^2 = |K|^2 + |Omega|^2 in the Euclidean norm.
///     assert!(((frame * &jet.c[1]).norm_l2() - 6.0_f64.sqrt()).abs() < 1e-14);
/// }
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct Turning {
    exp: SkewExp,
    turn: Mat<f64>,
    rates: [Mat<f64>; ORDER + 1],
}

impl Turning {
    pub(crate) fn new(k: usize) -> Self {
        Turning {
            exp: SkewExp::new(k),
            turn: Mat::zeros(k, k),
            rates: std::array::from_fn(|_| Mat::zeros(k, k)),
        }
    }

    fn compute(&mut self, curve: &QuasiGeodesic, t: f64, order: usize) -> Result<()> {
        self.exp
            .exp_into(self.turn.as_mut(), curve.omega.as_ref(), t)?;
        mul_into(&mut self.rates[0], 1.0, &curve.right, &self.turn);
        for j in 1..=order {
            let (done, next) = self.rates.split_at_mut(j);
            mul_into(&mut next[0], 1.0 / j as f64, &done[j - 1], &curve.omega);
        }
        Ok(())
    }
}

/// Buffers for endpoint problems of one shape.
pub(crate) struct EndpointProblem {
    pub(super) principal: PrincipalVectors,
    log: OrthogonalLog,
}

impl EndpointProblem {
    pub(crate) fn new(n: usize, k: usize) -> Self {
        EndpointProblem {
            principal: PrincipalVectors::new(n, k),
            log: OrthogonalLog::new(k),
        }
    }
}
