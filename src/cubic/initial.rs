//! Initial data of a Riemannian cubic, in the coordinates of a frame of their span.

use faer::{Mat, MatRef, Scale};

use crate::curve::span::Span;
use crate::error::Result;
use crate::linalg::product::mul_into;
use crate::linalg::structure::norm;
use crate::manifold::stiefel::{POINT_TOLERANCE, Stiefel, TANGENT_TOLERANCE};

/// A vector of `m`: `[[omega, -normal^T], [normal, 0]]` with `omega` skew, shape `(k, k)`, and `normal`, of shape
/// `(r - k, k)`.
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
        check(s, [v, a, j])?;
        Ok(Self::of_checked([s, v, a, j]))
    }

    /// The same data per unit of their natural time, and how many of these units a unit of time has.
    ///
    /// The rate is a power of two near `max(|V|, |A|^(1/2), |J|^(1/3))`, so nothing is rounded, and nothing but what is
    /// negligible beside the rest underflows.
    ///
    /// # Errors
    /// As [`InitialData::new`].
    pub(crate) fn in_natural_time(
        s: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
        a: MatRef<'_, f64>,
        j: MatRef<'_, f64>,
    ) -> Result<(Self, f64)> {
        check(s, [v, a, j])?;
        let rate = norm(v).max(norm(a).sqrt()).max(norm(j).cbrt());
        let rate = match rate {
            0.0 => 1.0,
            _ => rate
                .log2()
                .round()
                .clamp(-LARGEST_POWER, LARGEST_POWER)
                .exp2(),
        };
        let unit = 1.0 / rate;
        let slower = |a: &Mat<f64>| a * Scale(unit);
        let velocity = slower(&v.to_owned());
        let acceleration = slower(&slower(&a.to_owned()));
        let jerk = slower(&slower(&slower(&j.to_owned())));
        let data = [s, velocity.as_ref(), acceleration.as_ref(), jerk.as_ref()];
        Ok((Self::of_checked(data), rate))
    }

    fn of_checked(data: [MatRef<'_, f64>; 4]) -> Self {
        let [s, v, a, j] = data;
        let span = Span::of(&data);
        let g = complete(span.down(s).as_ref());
        let horizontal = |vector| Horizontal::of_tangent(g.as_ref(), span.down(vector).as_ref());
        let (velocity, acceleration, jerk) = (horizontal(v), horizontal(a), horizontal(j));
        InitialData {
            frame: span.into_basis(),
            g,
            velocity,
            acceleration,
            jerk,
        }
    }
}

/// The rate of natural time and its inverse stay normal numbers.
const LARGEST_POWER: f64 = 1022.0;

fn check(s: MatRef<'_, f64>, vectors: [MatRef<'_, f64>; 3]) -> Result<()> {
    let manifold = Stiefel::of("S", s)?;
    manifold.check_point("S", s, POINT_TOLERANCE)?;
    for (name, vector) in ["V", "A", "J"].into_iter().zip(vectors) {
        manifold.check_tangent(name, s, vector, TANGENT_TOLERANCE)?;
    }
    Ok(())
}

/// An orthogonal matrix whose first columns are those of `s`, shape `(r, k)`, orthonormalised where they are not.
///
/// By Householder reflections, written out: `r` is at most `4k`, and often three.
pub(crate) fn complete(s: MatRef<'_, f64>) -> Mat<f64> {
    let (r, k) = s.shape();
    let mut rest = s.to_owned();
    let mut g = Mat::<f64>::identity(r, r);
    let mut reflections = Mat::<f64>::zeros(r, k);
    let mut signs = vec![1.0; k];
    for j in 0..k {
        let length = (j..r).map(|i| rest[(i, j)].powi(2)).sum::<f64>().sqrt();
        // Away from cancellation; the column becomes `-sign length` times a unit vector.
        let sign = if rest[(j, j)] < 0.0 { -1.0 } else { 1.0 };
        signs[j] = -sign;
        for i in j..r {
            reflections[(i, j)] = rest[(i, j)];
        }
        reflections[(j, j)] += sign * length;
        for col in j..k {
            reflect(&reflections, j, &mut rest, col);
        }
    }
    for j in (0..k).rev() {
        for col in j..r {
            reflect(&reflections, j, &mut g, col);
        }
    }
    for j in 0..k {
        for i in 0..r {
            g[(i, j)] *= signs[j];
        }
    }
    g
}

/// Reflects a column of `a` at the hyperplane orthogonal to column `j` of `reflections`, which is zero above the diagonal.
fn reflect(reflections: &Mat<f64>, j: usize, a: &mut Mat<f64>, col: usize) {
    let r = a.nrows();
    let (mut product, mut square) = (0.0, 0.0);
    for i in j..r {
        product += reflections[(i, j)] * a[(i, col)];
        square += reflections[(i, j)].powi(2);
    }
    let factor = if square > 0.0 {
        2.0 * product / square
    } else {
        0.0
    };
    for i in j..r {
        a[(i, col)] -= factor * reflections[(i, j)];
    }
}
