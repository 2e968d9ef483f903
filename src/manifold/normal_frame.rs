//! The part of a tangent vector that is normal to the span of its point, and orthonormal bases of such directions.

use faer::prelude::*;
use faer::{Mat, MatMut, MatRef};

use crate::linalg::decomp::thin_q;
use crate::linalg::gram_factors::CholeskyQr;
use crate::linalg::product::{mul_add, product};
use crate::linalg::structure::{gram, norm};

/// Conditioning above which one pass of Cholesky's factorisation is orthonormal to some tens of units of round-off; at
/// worst to `20 k^2` of them, and 1250 were seen, on St(200,100) for a vector of norm 100.
const WELL_CONDITIONED: f64 = 0.05;

/// Conditioning below which two passes are not enough either, and Householder reflections are used.
const ILL_CONDITIONED: f64 = 1e-8;

/// Normal parts, or whole vectors, below this get their frame from reflections, which make it orthogonal to the point in any
/// case.
const ROUND_OFF: f64 = 1e-12;

/// Normal parts, or whole vectors, beyond this are factored by reflections, in scaled form: their squares may overflow.
const HUGE: f64 = 1e100;

/// Normal parts shorter than this, relative to the part along `S`, are projected twice: one projection leaves a component
/// of size `eps |S^T V|` along `S`.
const SHORT_NORMAL: f64 = 0.5;

/// Maximal number of normal directions of a curve from a point of `St(n, k)`: `min(k, n - k)`.
pub(crate) fn normal_rank(n: usize, k: usize) -> usize {
    k.min(n - k)
}

/// `V - S A`, from the coordinates `A` of the projection of `V` to the span of `S`.
pub(crate) fn set_normal_part(
    s: MatRef<'_, f64>,
    v: MatRef<'_, f64>,
    along: MatRef<'_, f64>,
    mut normal: MatMut<'_, f64>,
) {
    normal.copy_from(v);
    mul_add(normal.rb_mut(), -1.0, s, along);
    if norm(normal.rb()) < SHORT_NORMAL * norm(along) {
        let rest = product(s.transpose(), normal.rb());
        mul_add(normal, -1.0, s, &rest);
    }
}

/// Replaces `normal` by an orthonormal `Q`, shape `(n, p)` with `p = min(k, n - k)`, orthogonal to `s`, whose span
/// contains that of `normal`; returns `B` of shape `(p, k)` with `normal = Q B`.
///
/// `normal` (shape `(n, k)`, any rank, `S^T normal = 0`) is factored by Cholesky's method on its Gram matrix if its
/// condition allows, and by Householder reflections otherwise. If `p < k`, `Q` is in the first `p` columns.
pub(crate) fn normal_frame(s: MatRef<'_, f64>, mut normal: MatMut<'_, f64>) -> Mat<f64> {
    let (n, k) = (s.nrows(), s.ncols());
    let p = normal_rank(n, k);
    if p == 0 {
        return Mat::zeros(0, k);
    }
    let size = norm(normal.rb());
    // A normal part of the size of round-off has no direction: repeated projections keep shrinking it. The squares of
    // huge ones overflow.
    if p == k
        && (ROUND_OFF..HUGE).contains(&size)
        && let Some(b) = orthonormalise(s, normal.rb_mut())
    {
        return b;
    }
    // A subnormal entry has no reciprocal.
    let largest = normal.norm_max();
    let scale = if largest > f64::MIN_POSITIVE {
        1.0 / largest
    } else {
        1.0
    };
    let both = Mat::from_fn(n, 2 * k, |i, j| {
        if j < k {
            s[(i, j)]
        } else {
            scale * normal[(i, j - k)]
        }
    });
    let q = thin_q(both.as_ref());
    let q = q.as_ref().subcols(k, p);
    let b = q.transpose() * &normal;
    normal.subcols_mut(0, p).copy_from(q);
    b
}

/// The normal part `V - S A = Q R` by Cholesky's method, without `Q`, from `S^T V` and the coordinates `A` of the projection
/// of `V` to the span of `S`; `None` if it is too ill-conditioned, or too short beside `V`, for products with `R^{-1}`.
pub(crate) fn normal_factor(
    v: MatRef<'_, f64>,
    product: MatRef<'_, f64>,
    along: MatRef<'_, f64>,
) -> Option<CholeskyQr> {
    let (n, k) = v.shape();
    let size = norm(v);
    if normal_rank(n, k) < k || !(ROUND_OFF..HUGE).contains(&size) {
        return None;
    }
    let mut gram = gram(v);
    mul_add(&mut gram, -1.0, product.transpose(), along);
    let factor = CholeskyQr::of_gram(gram.as_ref())?;
    let share = (norm(factor.r()) / size).powi(2);
    (factor.conditioning * share >= WELL_CONDITIONED).then_some(factor)
}

/// [`normal_frame`] by Cholesky's method; `None`, with `normal` unchanged, if it is too ill-conditioned.
fn orthonormalise(s: MatRef<'_, f64>, mut normal: MatMut<'_, f64>) -> Option<Mat<f64>> {
    let first = CholeskyQr::new(normal.rb())?;
    if first.conditioning >= WELL_CONDITIONED {
        first.orthonormalise(normal);
        return Some(first.r().to_owned());
    }
    if first.conditioning < ILL_CONDITIONED {
        return None;
    }
    let mut q = normal.to_owned();
    first.orthonormalise(q.as_mut());
    let along = s.transpose() * &q;
    mul_add(&mut q, -1.0, s, &along);
    let second =
        CholeskyQr::new(q.as_ref()).filter(|second| second.conditioning >= WELL_CONDITIONED)?;
    second.orthonormalise(q.as_mut());
    normal.copy_from(&q);
    Some(second.r() * first.r())
}
