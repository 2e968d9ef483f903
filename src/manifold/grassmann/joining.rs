//! Geodesics between subspaces given by arbitrary bases.

use faer::{Mat, MatRef};

use super::alignment::unique_alignment;
use crate::error::Result;
use crate::manifold::QuasiGeodesic;
use crate::manifold::quasi_geodesic::{Departure, EndpointProblem};

/// The geodesic `e^{tX} Y0` from the span of one basis to the span of another, and the orthogonal matrix `R` with `e^X
/// Y0 R = Y1`.
///
/// # Errors
/// `RightAngle` if a principal angle is pi/2 to working precision; `Decomposition`.
pub(crate) fn join_spans(
    y0: MatRef<'_, f64>,
    y1: MatRef<'_, f64>,
    problem: &mut EndpointProblem,
) -> Result<(QuasiGeodesic, Mat<f64>)> {
    let (n, k) = y0.shape();
    let (turn, _) = unique_alignment(y0, y1)?;
    let mut curve = QuasiGeodesic::zeros(n, k);
    curve.join(y0, (y1 * &turn).as_ref(), problem)?;
    // The bases are aligned, so `Omega` is only round-off.
    curve.omega_mut().fill(0.0);
    Ok((curve, turn.transpose().to_owned()))
}

/// The geodesic `e^{tX} Y` with initial velocity `v`, whose component along `y` is dropped.
///
/// # Errors
/// `Overflow`, `Decomposition`.
pub(crate) fn leave_span(y: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<QuasiGeodesic> {
    let (n, k) = y.shape();
    let mut curve = QuasiGeodesic::zeros(n, k);
    curve.leave(y, v, &mut Departure::new(n, k))?;
    curve.omega_mut().fill(0.0);
    Ok(curve)
}
