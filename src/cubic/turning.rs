//! Variations of a point as rotations of the whole space: `dS = A S` with the skew matrix `A` of least rank.
//!
//! ```math
//! A = N S^T - S N^T + S\,\Omega\,S^T,\qquad \Omega = S^T dS,\quad N = dS - S\,\Omega
//! ```
//!
//! A tangent vector `Y` at `S` is varied by `dY = A Y + w` with `w` tangent, so `w` describes the rest of its
//! variation. Both maps and their transposes only multiply tall matrices.

use faer::{Mat, MatRef, Scale};

use crate::error::{Error, Result};
use crate::linalg::product::{columns, columns_mut, mul_add, mul_into};
use crate::linalg::structure::{check_finite, check_shape, norm};
use crate::manifold::stiefel::TANGENT_TOLERANCE;
use crate::manifold::tangent::check_vector;
use crate::space::Quotient;

/// `A Y`.
pub(crate) fn turned(s: MatRef<'_, f64>, ds: MatRef<'_, f64>, y: MatRef<'_, f64>) -> Mat<f64> {
    let inner = s.transpose() * ds;
    let omega = (&inner - inner.transpose()) * Scale(0.5);
    let normal = ds.to_owned() - s * &inner;
    let along = s.transpose() * y;
    &normal * &along - s * (normal.transpose() * y) + s * (omega * along)
}

/// The matrix `w - S S^T w / 2`, whose entrywise product with a tangent vector sums to the inner product of `w` with
/// it.
pub(crate) fn lowered(s: MatRef<'_, f64>, w: MatRef<'_, f64>) -> Mat<f64> {
    let (mut low, k) = (w.to_owned(), s.ncols());
    let mut inner = vec![0.0; k * k];
    mul_into(columns_mut(&mut inner, k), 1.0, s.transpose(), w);
    mul_add(&mut low, -0.5, s, columns(&inner, k));
    low
}

/// Gradients with respect to `dS` and `dY` of `<u, dS> + <w, dY - A Y>`, for tangent vectors `u` and `w`.
pub(crate) fn by_data(
    s: MatRef<'_, f64>,
    [u, w]: [MatRef<'_, f64>; 2],
    y: MatRef<'_, f64>,
) -> [Mat<f64>; 2] {
    let low = lowered(s, w);
    // The gradient of `<w, A Y>` for an arbitrary variation of `S`, before it is projected along the manifold.
    let along = &low * (y.transpose() * s) - y * (low.transpose() * s);
    [lowered(s, (u - along).as_ref()), low]
}

/// The tangent vector `g [x, y]_m` of the tangent vectors `g x` and `g y` at `s`.
pub(crate) fn bracket_of(
    quotient: Quotient,
    s: MatRef<'_, f64>,
    v: MatRef<'_, f64>,
    w: MatRef<'_, f64>,
) -> Mat<f64> {
    match quotient {
        Quotient::Frames => bracket(s, v, w),
        Quotient::Subspaces => Mat::zeros(s.nrows(), s.ncols()),
    }
}

/// As `bracket_of`, for frames.
pub(crate) fn bracket(s: MatRef<'_, f64>, v: MatRef<'_, f64>, w: MatRef<'_, f64>) -> Mat<f64> {
    let [(x, x_normal), (y, y_normal)] = [v, w].map(|v| {
        let omega = s.transpose() * v;
        let normal = v - s * &omega;
        (omega, normal)
    });
    let product = &x * &y - x_normal.transpose() * &y_normal;
    s * (&product - product.transpose()) + x_normal * y - y_normal * x
}

/// A name for errors, a point or tangent vector, and its variation.
type NamedVariation<'a> = (&'static str, MatRef<'a, f64>, MatRef<'a, f64>);

/// Check the variations of a point and of tangent vectors there: shapes, finite entries, and that `S^T dS` and `S^T
/// dY + dS^T Y` are skew, or zero for subspaces.
///
/// # Errors
/// `Shape`, `NonFinite`, `NotTangent`.
pub(crate) fn check_variation(
    quotient: Quotient,
    (name, s, ds): NamedVariation<'_>,
    vectors: &[NamedVariation<'_>],
) -> Result<()> {
    check_vector(quotient, name, s, ds)?;
    for &(name, y, dy) in vectors {
        check_shape(name, dy, s.nrows(), s.ncols())?;
        check_finite(name, dy)?;
        let half = s.transpose() * dy + ds.transpose() * y;
        let defect = match quotient {
            Quotient::Frames => norm((&half + half.transpose()).as_ref()) * 0.5,
            Quotient::Subspaces => norm(half.as_ref()),
        };
        let tolerance = TANGENT_TOLERANCE * (1.0 + norm(dy) + norm(ds) * norm(y));
        if defect.is_nan() || defect > tolerance {
            return Err(Error::NotTangent {
                name,
                defect,
                tolerance,
            });
        }
    }
    Ok(())
}
