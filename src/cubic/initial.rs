//! Initial data of a Riemannian cubic, in the coordinates of a frame of their span.

use faer::{Mat, MatRef};

use crate::curve::span::Span;
use crate::error::Result;
use crate::linalg::decomp::thin_q;
use crate::linalg::product::mul_into;
use crate::manifold::stiefel::{POINT_TOLERANCE, Stiefel, TANGENT_TOLERANCE};

/// A vector of `m`: `[[omega, -normal^T], [normal, 0]]` with `omega` skew, shape `(k, k)`, and `normal`, shape `(r - k, k)`.
#[derive(Debug, Clone)]
pub(crate) struct Horizontal {
    pub(crate) omega: Mat<f64>,
    pub(crate) normal: Mat<f64>,
}

impl Horizontal {
    /// The vector of `m` whose tangent vector at the first `k` columns of `g` is `v`; shapes `(r, r)` and `(r, k)`.
    pub(crate) fn of_tangent(g: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Self {
        let (r, k) = v.shape();
        let mut all = Mat::zeros(r, k);
        mul_into(&mut all, 1.0, g.transpose(), v);
        let omega = Mat::from_fn(k, k, |i, j| 0.5 * (all[(i, j)] - all[(j, i)]));
        let normal = all.as_ref().subrows(k, r - k).to_owned();
        Horizontal { omega, normal }
    }
}

/// Point, velocity, covariant acceleration and covariant jerk of a curve.
///
/// The isometries that fix the span of all four pointwise fix the cubic with these data, so it stays in the span.
#[derive(Debug, Clone)]
pub(crate) struct InitialData {
    /// Orthonormal basis of the span, shape `(n, r)`, `r = min(n, 4k)`; none where that is all of `R^n`.
    pub(crate) frame: Option<Mat<f64>>,
    /// Orthogonal, shape `(r, r)`; the first `k` columns are the point.
    pub(crate) g: Mat<f64>,
    pub(crate) velocity: Horizontal,
    pub(crate) acceleration: Horizontal,
    pub(crate) jerk: Horizontal,
}

impl InitialData {
    /// From the point and the three tangent vectors at it, all of shape `(n, k)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`.
    pub(crate) fn new(
        s: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
        a: MatRef<'_, f64>,
        j: MatRef<'_, f64>,
    ) -> Result<Self> {
        let manifold = Stiefel::of("S", s)?;
        manifold.check_point("S", s, POINT_TOLERANCE)?;
        for (name, vector) in [("V", v), ("A", a), ("J", j)] {
            manifold.check_tangent(name, s, vector, TANGENT_TOLERANCE)?;
        }
        let span = Span::of(&[s, v, a, j]);
        let g = complete(span.down(s).as_ref());
        let horizontal = |vector| Horizontal::of_tangent(g.as_ref(), span.down(vector).as_ref());
        let (velocity, acceleration, jerk) = (horizontal(v), horizontal(a), horizontal(j));
        Ok(InitialData {
            frame: span.into_basis(),
            g,
            velocity,
            acceleration,
            jerk,
        })
    }
}

/// An orthogonal matrix whose first columns are those of `s`, shape `(r, k)`, orthonormalised where they are not.
pub(crate) fn complete(s: MatRef<'_, f64>) -> Mat<f64> {
    let (r, k) = s.shape();
    let spanning = Mat::from_fn(r, k + r, |i, j| match j.checked_sub(k) {
        None => s[(i, j)],
        Some(column) => f64::from(u8::from(i == column)),
    });
    thin_q(spanning.as_ref())
}
