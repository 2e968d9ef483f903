//! Riemannian geodesics from an initial velocity, for every metric of the alpha family, in `O(n k^2)`.
//!
//! # Source
//! Edelman, Arias, Smith (1998), section 2.4.2 (canonical metric) and section 2.2.2 (Euclidean); Hueper, Markina,
//! Silva Leite (2021), "A Lagrangian approach to extremal curves on Stiefel manifolds", J. Geometric Mechanics 13,
//! 55-72 (the family); Zimmermann, Hueper (2022), "Computing the Riemannian logarithm on the Stiefel manifold:
//! metrics, methods, and performance", SIAM J. Matrix Anal. Appl. 43, 953-980 (the thin form).

use faer::prelude::*;
use faer::{Mat, MatRef};

use super::metric::Metric;
use super::normal_frame::{normal_factor, normal_frame, normal_rank, set_normal_part};
use super::stiefel::{POINT_TOLERANCE, Stiefel, TANGENT_TOLERANCE};
use crate::error::Result;
use crate::linalg::SkewExp;
use crate::linalg::jet::{MatrixJet, ORDER};
use crate::linalg::product::{mul_add, mul_into};
use crate::linalg::structure::{check_range, skew_part};
use crate::space::Quotient;

/// Quantity named in `Overflow` errors.
const GEODESIC: &str = "geodesic";

/// A Riemannian geodesic.
///
/// For the velocity `V = S A + Q B` (`A` skew `(k, k)`, `Q` an orthonormal basis of the normal directions, shape
/// `(n, p)` with `p = min(k, n - k)`, `B` of shape `(p, k)`) and the weight `w` of the [`Metric`]:
///
/// ```math
/// \gamma(t) = [S\; Q]\, \exp\!\Big( t \begin{bmatrix} 2wA & -B^T \\ B & 0 \end{bmatrix} \Big)
/// \begin{bmatrix} I \\ 0 \end{bmatrix} \exp\big( t (1 - 2w) A \big)
/// ```
///
/// The canonical metric has `w = 1/2`, for which the second factor is the identity. The geodesic is defined for all
/// `t`. Orthonormality defect at most `1e-13` for `|t V| <= 10`, asserted in `tests/exponential.rs`. The covariant
/// derivatives of the [`Curve`](crate::Curve) trait are those of the canonical metric, also for geodesics of another
/// metric.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Curve, Geodesic};
/// let (x, y) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let quarter = Geodesic::between(x.as_ref(), y.as_ref())?;
/// let middle = quarter.point(0.5)?;
/// assert!((middle[(0, 0)] - 0.5f64.sqrt()).abs() < 1e-15);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Geodesic {
    /// `[S, Q]`, shape `(n, k + p)`.
    pub(super) frame: Mat<f64>,
    pub(super) motion: FrameMotion,
    pub(super) metric: Metric,
    pub(super) quotient: Quotient,
}

/// A geodesic in coordinates of its frame.
#[derive(Debug, Clone)]
pub(super) struct FrameMotion {
    /// `[[2 w A, -B^T], [B, 0]]`.
    pub(super) generator: Mat<f64>,
    /// `(1 - 2 w) A`, unless it is zero.
    pub(super) turning: Option<Mat<f64>>,
    /// Columns of a point.
    pub(super) k: usize,
}

impl Stiefel {
    /// The Riemannian exponential: the point at `t = 1` of the geodesic from `s` with velocity `v`.
    ///
    /// # Arguments
    /// * `s` - point, shape `(n, k)`; `v` - tangent vector at `s`, shape `(n, k)`
    /// # Accuracy
    /// As [`Geodesic`].
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`, `Overflow`, `Decomposition`.
    pub fn exp(&self, s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<Mat<f64>> {
        let [product, along] = self.checked_along(s, v)?;
        let mut out = Mat::zeros(self.n(), self.k());
        match normal_factor(v, product.as_ref(), along.as_ref()) {
            Some(factor) => {
                // With X = R^{-1} E_2 and V = S A + Q R, `S E_1 + Q E_2` is `S (E_1 - A X) + V X`.
                let omega = skew_part(product.as_ref());
                let motion = FrameMotion::new(omega.as_ref(), factor.r(), self.metric());
                let mut end = motion.at(1.0)?;
                let (mut start, mut normal) = end.as_mut().split_at_row_mut(self.k());
                factor.divide(normal.rb_mut());
                mul_add(start.rb_mut(), -1.0, &along, normal.rb());
                mul_into(&mut out, 1.0, s, start.rb());
                mul_add(&mut out, 1.0, v, normal.rb());
            }
            None => {
                let curve = self.geodesic_along(s, v, [&product, &along])?;
                mul_into(&mut out, 1.0, &curve.frame, curve.motion.at(1.0)?);
            }
        }
        check_range(GEODESIC, out.as_ref())?;
        Ok(out)
    }

    /// The geodesic of this manifold's metric from `s` with initial velocity `v`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`, `Overflow`.
    pub fn geodesic(&self, s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<Geodesic> {
        let [product, along] = self.checked_along(s, v)?;
        self.geodesic_along(s, v, [&product, &along])
    }

    /// `S^T V` of arguments that are checked, and `(2 I - S^T S) S^T V`: the coordinates of the projection of `V` to the span of
    /// `S`, up to the square of the defect of `S`.
    ///
    /// With `S^T V` in place of the second one, exponentials amplify that defect up to 50 times, and some tens of them in
    /// succession leave the manifold.
    fn checked_along(&self, s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<[Mat<f64>; 2]> {
        let gram = self.checked_gram("S", s, POINT_TOLERANCE)?;
        let product = self.checked_product("V", s, v, TANGENT_TOLERANCE)?;
        let k = self.k();
        let inverse = Mat::from_fn(k, k, |i, j| {
            2.0 * f64::from(u8::from(i == j)) - gram[(i.max(j), i.min(j))]
        });
        let mut along = Mat::zeros(k, k);
        mul_into(&mut along, 1.0, &inverse, &product);
        Ok([product, along])
    }

    /// [`Stiefel::geodesic`] with the results of [`Stiefel::checked_along`].
    fn geodesic_along(
        &self,
        s: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
        [product, along]: [&Mat<f64>; 2],
    ) -> Result<Geodesic> {
        let (n, k, p) = (self.n(), self.k(), normal_rank(self.n(), self.k()));
        let mut frame = Mat::zeros(n, 2 * k);
        let (mut left, mut right) = frame.as_mut().split_at_col_mut(k);
        left.copy_from(s);
        set_normal_part(s, v, along.as_ref(), right.rb_mut());
        let b = normal_frame(s, right);
        frame.truncate(n, k + p);
        let omega = skew_part(product.as_ref());
        let curve = Geodesic::new(frame, omega.as_ref(), b.as_ref(), self.metric());
        check_range(GEODESIC, curve.motion.generator.as_ref())?;
        Ok(curve)
    }

    /// The geodesic of this manifold's metric from `s0` to `s1` that [`Stiefel::log`] finds.
    ///
    /// # Errors
    /// The errors of [`Stiefel::log`].
    pub fn geodesic_between(&self, s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Result<Geodesic> {
        self.geodesic(s0, self.log(s0, s1)?.as_ref())
    }
}

impl Geodesic {
    /// The meaning of the points: frames or subspaces.
    pub(crate) fn quotient(&self) -> Quotient {
        self.quotient
    }

    /// The geodesic of the canonical metric from `s` with initial velocity `v`.
    ///
    /// # Errors
    /// The errors of [`Stiefel::geodesic`].
    pub fn from_velocity(s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<Self> {
        Stiefel::of("S", s)?.geodesic(s, v)
    }

    /// The geodesic of the canonical metric from `s0` to `s1` that [`Stiefel::log`] finds.
    ///
    /// # Errors
    /// The errors of [`Stiefel::log`].
    pub fn between(s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Result<Self> {
        Stiefel::of("S0", s0)?.geodesic_between(s0, s1)
    }

    fn new(frame: Mat<f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>, metric: Metric) -> Self {
        Geodesic {
            quotient: Quotient::Frames,
            frame,
            motion: FrameMotion::new(a, b, metric),
            metric,
        }
    }

    /// Rows of a point.
    pub fn n(&self) -> usize {
        self.frame.nrows()
    }

    /// Columns of a point.
    pub fn k(&self) -> usize {
        self.motion.k
    }

    /// The metric of the geodesic.
    pub fn metric(&self) -> Metric {
        self.metric
    }

    /// The initial velocity `V = S A + Q B`, shape `(n, k)`.
    pub fn initial_velocity(&self) -> Mat<f64> {
        let k = self.k();
        let mut rates = self.motion.generator.as_ref().subcols(0, k).to_owned();
        let twice = 2.0 * self.metric.weight();
        for j in 0..k {
            for i in 0..k {
                rates[(i, j)] /= twice;
            }
        }
        &self.frame * &rates
    }

    /// The length over `[0, 1]` in the geodesic's metric.
    pub fn length(&self) -> f64 {
        use crate::linalg::structure::norm;
        let (m, k) = (self.frame.ncols(), self.k());
        let twice = 2.0 * self.metric.weight();
        let generator = self.motion.generator.as_ref();
        let a = norm(generator.submatrix(0, 0, k, k)) / twice;
        let b = norm(generator.submatrix(k, 0, m - k, k));
        b.hypot(a * self.metric.weight().sqrt())
    }

    /// The frame `[S, Q]`, shape `(n, k + p)`.
    pub(crate) fn frame(&self) -> MatRef<'_, f64> {
        self.frame.as_ref()
    }

    /// Coordinates of the curve in its frame, as Taylor coefficients of shape `(k + p, k)` up to the given order.
    pub(crate) fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        flow: &mut Flow,
        out: &mut MatrixJet,
    ) -> Result<()> {
        self.motion.coordinates_into(t, order, flow, out)
    }
}

impl FrameMotion {
    fn new(a: MatRef<'_, f64>, b: MatRef<'_, f64>, metric: Metric) -> Self {
        let (p, k) = b.shape();
        let twice = 2.0 * metric.weight();
        let generator = Mat::from_fn(k + p, k + p, |i, j| match (i < k, j < k) {
            (true, true) => twice * a[(i, j)],
            (false, true) => b[(i - k, j)],
            (true, false) => -b[(j - k, i)],
            (false, false) => 0.0,
        });
        let turning = (twice != 1.0).then(|| Mat::from_fn(k, k, |i, j| (1.0 - twice) * a[(i, j)]));
        FrameMotion {
            generator,
            turning,
            k,
        }
    }

    /// Coordinates of the point at `t`, shape `(k + p, k)`.
    fn at(&self, t: f64) -> Result<Mat<f64>> {
        let mut jet = MatrixJet::zeros_up_to(0, self.generator.ncols(), self.k);
        self.coordinates_into(t, 0, &mut Flow::of(self), &mut jet)?;
        let [point, ..] = jet.c;
        Ok(point)
    }

    /// Taylor coefficients of the coordinates at `t`, of shape `(k + p, k)`, up to the given order.
    fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        flow: &mut Flow,
        out: &mut MatrixJet,
    ) -> Result<()> {
        let k = self.k;
        flow.exp
            .exp_into(flow.rotation.as_mut(), self.generator.as_ref(), t)?;
        out.c[0].copy_from(flow.rotation.as_ref().subcols(0, k));
        for j in 1..=order {
            let (done, next) = out.c.split_at_mut(j);
            mul_into(&mut next[0], 1.0 / j as f64, &self.generator, &done[j - 1]);
        }
        let (Some(a), Some(turn)) = (&self.turning, &mut flow.turn) else {
            return Ok(());
        };
        turn.exp.exp_into(turn.rates[0].as_mut(), a.as_ref(), t)?;
        for j in 1..=order {
            let (done, next) = turn.rates.split_at_mut(j);
            mul_into(&mut next[0], 1.0 / j as f64, &done[j - 1], a);
        }
        // The product rule, highest order first, since it only needs factors of its own order and below.
        for j in (0..=order).rev() {
            turn.product.fill(0.0);
            for i in 0..=j {
                let (left, right) = (&out.c[i], &turn.rates[j - i]);
                mul_add(&mut turn.product, 1.0, left, right);
            }
            out.c[j].copy_from(&turn.product);
        }
        Ok(())
    }
}

/// Buffers for evaluating geodesics of one shape and metric.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::linalg::jet::MatrixJet;
/// use stiefel_rs::manifold::exponential::Flow;
/// use stiefel_rs::{Curve, Geodesic};
/// let curve = Geodesic::from_velocity(mat![[1.0], [0.0], [0.0]].as_ref(), mat![[0.0], [3.0], [4.0]].as_ref())?;
/// let frame = curve.frame().expect("a geodesic has one");
/// let (mut work, mut jet): (Flow, MatrixJet) = (curve.workspace(), MatrixJet::zeros(frame.ncols(), 1));
/// for t in [0.0, 0.2, 0.4] {
///     curve.coordinates_into(t, 1, &mut work, &mut jet)?;
///     // The first entry of the point is cos(5 t); its speed is always 5.
///     assert!(((frame * &jet.c[0])[(0, 0)] - (5.0 * t).cos()).abs() < 1e-14);
///     assert!(((frame * &jet.c[1]).norm_l2() - 5.0).abs() < 1e-14);
/// }
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct Flow {
    exp: SkewExp,
    rotation: Mat<f64>,
    turn: Option<Turn>,
}

struct Turn {
    exp: SkewExp,
    rates: [Mat<f64>; ORDER + 1],
    product: Mat<f64>,
}

impl Flow {
    pub(crate) fn new(curve: &Geodesic) -> Self {
        Flow::of(&curve.motion)
    }

    fn of(motion: &FrameMotion) -> Self {
        let (m, k) = (motion.generator.ncols(), motion.k);
        Flow {
            exp: SkewExp::new(m),
            rotation: Mat::zeros(m, m),
            turn: motion.turning.is_some().then(|| Turn {
                exp: SkewExp::new(k),
                rates: std::array::from_fn(|_| Mat::zeros(k, k)),
                product: Mat::zeros(m, k),
            }),
        }
    }
}
