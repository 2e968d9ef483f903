//! Geodesics between subspaces, whatever their bases.

use faer::{Mat, MatRef};

use super::alignment::Alignment;
use crate::error::Result;
use crate::manifold::QuasiGeodesic;
use crate::manifold::quasi_geodesic::EndpointProblem;

/// The orthogonal matrix `Q` for which `Y1 Q` is as near to `Y0` as a basis of its span can be.
///
/// # Errors
/// `Decomposition`.
pub(crate) fn alignment(y0: MatRef<'_, f64>, y1: MatRef<'_, f64>) -> Result<Mat<f64>> {
    Ok(Alignment::new(y0, y1)?.function(|_| 1.0))
}

/// The geodesic `e^{tX} Y0` from the span of one basis to that of another, and the orthogonal matrix `R` with `e^X Y0 R = Y1`.
///
/// # Errors
/// `RightAngle` where a principal angle is pi/2 to working precision; `Decomposition`.
pub(crate) fn join_spans(
    y0: MatRef<'_, f64>,
    y1: MatRef<'_, f64>,
    problem: &mut EndpointProblem,
) -> Result<(QuasiGeodesic, Mat<f64>)> {
    let (n, k) = y0.shape();
    let alignment = Alignment::new(y0, y1)?;
    alignment.check_unique()?;
    let turn = alignment.function(|_| 1.0);
    let mut curve = QuasiGeodesic::zeros(n, k);
    curve.join(y0, (y1 * &turn).as_ref(), problem)?;
    // The bases are aligned: what is left is round-off.
    curve.omega_mut().fill(0.0);
    Ok((curve, turn.transpose().to_owned()))
}
