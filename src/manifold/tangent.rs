//! Tangent vectors of frames and of subspaces.
//!
//! Tangent vectors at a basis `Y` of a subspace are horizontal, `Y^T V = 0`: they describe changes of the span only.

use faer::{Mat, MatRef, Scale};

use super::Grassmann;
use super::stiefel::{Stiefel, TANGENT_TOLERANCE};
use crate::error::Result;
use crate::space::Quotient;

/// Checks shape, finiteness, and that `S^T V` is skew, or zero, to [`TANGENT_TOLERANCE`].
///
/// # Errors
/// `Shape`, `NonFinite`, `NotTangent`, `NotHorizontal`.
pub(crate) fn check_vector(
    quotient: Quotient,
    name: &'static str,
    s: MatRef<'_, f64>,
    v: MatRef<'_, f64>,
) -> Result<()> {
    check_vector_to(TANGENT_TOLERANCE, quotient, name, s, v)
}

/// As [`check_vector`] with another tolerance, relative to the length of `v` if it exceeds 1.
///
/// # Errors
/// `Shape`, `NonFinite`, `NotTangent`, `NotHorizontal`.
pub(crate) fn check_vector_to(
    tolerance: f64,
    quotient: Quotient,
    name: &'static str,
    s: MatRef<'_, f64>,
    v: MatRef<'_, f64>,
) -> Result<()> {
    match quotient {
        Quotient::Frames => Stiefel::of("S", s)?.check_tangent(name, s, v, tolerance),
        Quotient::Subspaces => Grassmann::of("S", s)?.check_tangent(name, s, v, tolerance),
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
