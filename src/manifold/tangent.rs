//! Tangent vectors of frames and of subspaces.
//!
//! Those at a basis `Y` of a subspace are horizontal, `Y^T V = 0`: what is left of them are changes of the span.

use faer::{Mat, MatRef, Scale};

use super::stiefel::{Stiefel, TANGENT_TOLERANCE};
use crate::error::{Error, Result};
use crate::linalg::structure::{check_finite, check_shape, norm};
use crate::space::Quotient;

/// Checks shape, finiteness, and that `S^T V` is skew, or zero, to [`TANGENT_TOLERANCE`].
///
/// # Errors
/// `Shape`, `NonFinite`, `NotTangent`.
pub(crate) fn check_vector(
    quotient: Quotient,
    name: &'static str,
    s: MatRef<'_, f64>,
    v: MatRef<'_, f64>,
) -> Result<()> {
    let manifold = Stiefel::of("S", s)?;
    match quotient {
        Quotient::Frames => manifold.check_tangent(name, s, v, TANGENT_TOLERANCE),
        Quotient::Subspaces => {
            check_shape(name, v, s.nrows(), s.ncols())?;
            check_finite(name, v)?;
            let tolerance = TANGENT_TOLERANCE * norm(v).max(1.0);
            let defect = norm((s.transpose() * v).as_ref());
            match defect <= tolerance {
                true => Ok(()),
                false => Err(Error::NotTangent {
                    name,
                    defect,
                    tolerance,
                }),
            }
        }
    }
}

/// The tangential part of a matrix at a point: `A - S sym(S^T A)`, or `A - S S^T A`.
pub(crate) fn tangent_part(quotient: Quotient, s: MatRef<'_, f64>, a: MatRef<'_, f64>) -> Mat<f64> {
    let inner = s.transpose() * a;
    match quotient {
        Quotient::Frames => a - s * (&inner + inner.transpose()) * Scale(0.5),
        Quotient::Subspaces => a - s * inner,
    }
}
