//! Parallel transport along geodesics, for every metric of the alpha family.

use faer::{Mat, MatRef, Scale};

use super::stiefel::{POINT_TOLERANCE, Stiefel, TANGENT_TOLERANCE};
use crate::error::{Error, Result};
use crate::linalg::decomp::{spectral_norm, thin_q};
use crate::linalg::exponential_action::{MAX_RADIUS, skew_exponential_action};
use crate::linalg::product::{mul_add, mul_into};
use crate::linalg::structure::{check_range, norm};
use crate::linalg::{SkewExp, skew_exp};

/// The parallel transport from `S` along the geodesic with initial velocity `V = S Omega + K` to its end `exp(S, V)`.
///
/// Let `w` be the weight of the metric (1/2 for the canonical, 1 for the Euclidean one), `Q` an orthonormal basis of a
/// space that contains the columns of `K` and is orthogonal to `S`, and `B = Q^T K`. For a tangent vector `W = S C + Q
/// D + W_p`, with `W_p` orthogonal to `S` and `Q`:
///
/// ```math
/// W(1) = [S\ Q]\, E \begin{pmatrix} C_1 \\ D_1 \end{pmatrix} e^{(1 - 2w)\Omega} + W_p\, e^{(1 - w)\Omega},\qquad
/// E = \exp \begin{pmatrix} 2 w \Omega & -B^T \\ B & 0 \end{pmatrix},
/// ```
///
/// where `(C_1, D_1) = e^L (C, D)` is the action of the exponential of an operator that is skew in the metric,
///
/// ```math
/// L(C, D) = \big( (\tfrac12 - 2w) [\Omega, C] + \tfrac12 (B^T D - D^T B),\ w (D \Omega - B C) \big).
/// ```
///
/// This is the equation of parallel fields in a frame that rotates with the geodesic, in which its coefficients are
/// constant.
///
/// The cost is `O(n k^2)`, plus about `|V| + 15` products of `2k x k` matrices per vector.
///
/// # Accuracy
/// Isometric to `2e-14` for `|V| <= 10`; within `1e-13` of a numerical integration of the equation for `|V| = 2`;
/// asserted in `tests/transport.rs`.
/// # Source
/// Nguyen, Sommer (2024), "Parallel transport on matrix manifolds and exponential action", arXiv 2408.06054. Deviation:
/// the action is computed by Chebyshev polynomials, which suit a skew operator, instead of scaled Taylor polynomials.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{ParallelTransport, Stiefel};
/// // A quarter of a great circle turns its own direction by a right angle and leaves the other one.
/// let s = mat![[1.0], [0.0], [0.0]];
/// let v = mat![[0.0], [std::f64::consts::FRAC_PI_2], [0.0]];
/// let transport = ParallelTransport::new(Stiefel::new(3, 1)?, s.as_ref(), v.as_ref())?;
/// let along = transport.transport(v.as_ref())?;
/// assert!((along[(0, 0)] + std::f64::consts::FRAC_PI_2).abs() < 1e-15);
/// let across = transport.transport(mat![[0.0], [0.0], [1.0]].as_ref())?;
/// assert!((across[(2, 0)] - 1.0).abs() < 1e-15);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ParallelTransport {
    manifold: Stiefel,
    s: Mat<f64>,
    /// `Q`, shape `(n, r)` with `r = min(k, n - k)`.
    q: Mat<f64>,
    omega: Mat<f64>,
    /// `B`, shape `(r, k)`.
    b: Mat<f64>,
    /// `[S Q] E`, shape `(n, k + r)`.
    moved: Mat<f64>,
    /// `e^{(1 - 2w) Omega}`.
    turn: Mat<f64>,
    /// `e^{(1 - w) Omega}`.
    normal_turn: Mat<f64>,
    /// A bound on the spectral norm of `L` in the metric.
    radius: f64,
}

impl ParallelTransport {
    /// The transport along the geodesic of the manifold's metric from `s` with initial velocity `v`, shapes `(n, k)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`; `InvalidArgument` if `v` is so long (about 1e5) that a
    /// parallel field would lose its accuracy; `Overflow`, `Decomposition`.
    pub fn new(manifold: Stiefel, s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<Self> {
        manifold.check_point("S", s, POINT_TOLERANCE)?;
        manifold.check_tangent("V", s, v, TANGENT_TOLERANCE)?;
        let k = manifold.k();
        let weight = manifold.metric().weight();
        let (normal, omega) = manifold.split(s, v)?;
        let q = orthonormal_complement(s, &normal);
        let b = q.transpose() * &normal;
        let radius = operator_bound(
            weight,
            spectral_norm(omega.as_ref())?,
            spectral_norm(b.as_ref())?,
        );
        if radius.is_nan() || radius > MAX_RADIUS {
            return Err(Error::InvalidArgument {
                name: "rate of turn of a parallel field along V",
                requirement: "at most 1e5",
                found: radius,
            });
        }
        let r = b.nrows();
        let mut generator = Mat::zeros(k + r, k + r);
        generator
            .as_mut()
            .submatrix_mut(0, 0, k, k)
            .copy_from(&omega * Scale(2.0 * weight));
        generator.as_mut().submatrix_mut(k, 0, r, k).copy_from(&b);
        generator
            .as_mut()
            .submatrix_mut(0, k, k, r)
            .copy_from(-b.transpose());
        let mut flow = Mat::zeros(k + r, k + r);
        SkewExp::new(k + r).exp_into(flow.as_mut(), generator.as_ref(), 1.0)?;
        let mut moved = s * flow.as_ref().subrows(0, k);
        mul_add(&mut moved, 1.0, &q, flow.as_ref().subrows(k, r));
        let turn = skew_exp((&omega * Scale(1.0 - 2.0 * weight)).as_ref())?;
        let normal_turn = skew_exp((&omega * Scale(1.0 - weight)).as_ref())?;
        Ok(ParallelTransport {
            manifold,
            s: s.to_owned(),
            q,
            omega,
            b,
            moved,
            turn,
            normal_turn,
            radius,
        })
    }

    /// The end of the geodesic, `exp(S, V)`, shape `(n, k)`.
    pub fn end(&self) -> Mat<f64> {
        self.moved.as_ref().subcols(0, self.manifold.k()) * &self.turn
    }

    /// The tangent vector at the end that is parallel to `w` at the start; shapes `(n, k)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotTangent`, `Overflow`.
    pub fn transport(&self, w: MatRef<'_, f64>) -> Result<Mat<f64>> {
        let s = self.s.as_ref();
        self.manifold.check_tangent("W", s, w, TANGENT_TOLERANCE)?;
        let size = norm(w);
        if size == 0.0 {
            return Ok(w.to_owned());
        }
        // The transport is linear: extreme lengths are factored out and restored at the end.
        let unit = Mat::from_fn(w.nrows(), w.ncols(), |i, j| w[(i, j)] / size);
        let (normal, c) = self.manifold.split(s, unit.as_ref())?;
        let d = self.q.transpose() * &normal;
        let rest = normal - &self.q * &d;
        let (k, r) = (c.ncols(), d.nrows());
        let mut start = Mat::zeros(k + r, k);
        start.as_mut().subrows_mut(0, k).copy_from(&c);
        start.as_mut().subrows_mut(k, r).copy_from(&d);
        let end = self.flow(start)?;
        let moved = &self.moved * (end * &self.turn) + rest * &self.normal_turn;
        let out = moved * Scale(size);
        check_range("parallel transport", out.as_ref())?;
        Ok(out)
    }

    /// `e^L` applied to `(C, D)`, stacked.
    fn flow(&self, start: Mat<f64>) -> Result<Mat<f64>> {
        let (k, r) = (self.omega.nrows(), self.b.nrows());
        let weight = self.manifold.metric().weight();
        let mut half = Mat::zeros(k, k);
        skew_exponential_action(start, self.radius, |out, x| {
            let (c, d) = (x.as_ref().subrows(0, k), x.as_ref().subrows(k, r));
            // [Omega, C] = Omega C - (Omega C)^T for skew factors.
            mul_into(&mut half, 0.5 - 2.0 * weight, &self.omega, c);
            mul_add(&mut half, 0.5, self.b.transpose(), d);
            for j in 0..k {
                for i in 0..k {
                    out[(i, j)] = half[(i, j)] - half[(j, i)];
                }
            }
            let mut lower = out.as_mut().subrows_mut(k, r);
            mul_into(&mut lower, -weight, &self.b, c);
            mul_add(&mut lower, weight, d, &self.omega);
        })
    }
}

/// The larger eigenvalue of `[[|4w - 1| a, sqrt(w) b], [sqrt(w) b, w a]]`, whose entries bound the blocks of the operator for
/// `|Omega|_2 = a`, `|K|_2 = b`.
fn operator_bound(weight: f64, a: f64, b: f64) -> f64 {
    let (first, last, off) = (
        (4.0 * weight - 1.0).abs() * a,
        weight * a,
        weight.sqrt() * b,
    );
    0.5 * (first + last) + (0.5 * (first - last)).hypot(off)
}

/// Defect of orthogonality to the point, per column, up to which columns are as good as those of the longer
/// factorisation.
const ORTHOGONAL: f64 = 4.0 * f64::EPSILON;

/// Orthonormal columns orthogonal to `s` whose span contains the columns of `normal`, `min(k, n - k)` of them.
fn orthonormal_complement(s: MatRef<'_, f64>, normal: &Mat<f64>) -> Mat<f64> {
    let (n, k) = s.shape();
    let size = norm(normal.as_ref());
    let mut both = Mat::zeros(n, 2 * k);
    both.as_mut().subcols_mut(0, k).copy_from(s);
    if size > 0.0 {
        for j in 0..k {
            for i in 0..n {
                both[(i, k + j)] = normal[(i, j)] / size;
            }
        }
        if n >= 2 * k {
            // If the columns are far from dependent, their own factorisation is enough.
            let q = thin_q(both.as_ref().subcols(k, k));
            if norm((s.transpose() * &q).as_ref()) <= ORTHOGONAL * k as f64 {
                return q;
            }
        }
    }
    let q = thin_q(both.as_ref());
    q.subcols(k, q.ncols() - k).to_owned()
}
