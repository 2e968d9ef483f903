//! The shortest geodesic between two subspaces, for any bases of them.

use std::f64::consts::FRAC_PI_2;

use faer::{Mat, MatRef};

use super::QuasiGeodesic;
use super::quasi_geodesic::EndpointProblem;
use crate::error::{Error, Result};
use crate::linalg::decomp::Svd;

/// A largest angle within this of pi/2 is that to working precision.
const PERPENDICULAR: f64 = 32.0 * f64::EPSILON;

/// The orthogonal matrix `Q` for which `Y1 Q` is as near to `Y0` as a basis of its span can be: the polar factor of `Y1^T Y0`.
///
/// # Errors
/// `Decomposition`.
pub(crate) fn alignment(y0: MatRef<'_, f64>, y1: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let k = y0.ncols();
    let mut svd = Svd::new(k, k);
    svd.compute((y1.transpose() * y0).as_ref())?;
    Ok(svd.u() * svd.v().transpose())
}

/// The geodesic `e^{tX} Y0` from the span of one basis to that of another, and the orthogonal matrix `R` with `e^X Y0 R = Y1`.
///
/// # Errors
/// `NoJoiningCurve` where a principal angle is pi/2 to working precision; `Decomposition`.
pub(crate) fn join_spans(
    y0: MatRef<'_, f64>,
    y1: MatRef<'_, f64>,
    problem: &mut EndpointProblem,
) -> Result<(QuasiGeodesic, Mat<f64>)> {
    let (n, k) = y0.shape();
    let turn = alignment(y0, y1)?;
    let mut curve = QuasiGeodesic::zeros(n, k);
    curve.join(y0, (y1 * &turn).as_ref(), problem)?;
    // The bases are aligned: what is left is round-off.
    curve.omega.as_mut().fill(0.0);
    let angle = curve.angles().iter().fold(0.0_f64, |most, x| most.max(*x));
    match angle < FRAC_PI_2 - PERPENDICULAR {
        true => Ok((curve, turn.transpose().to_owned())),
        false => Err(Error::NoJoiningCurve { angle }),
    }
}

/// The initial velocity of that geodesic: the logarithm.
///
/// # Errors
/// As [`join_spans`].
pub(crate) fn log_spans(y0: MatRef<'_, f64>, y1: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let (n, k) = y0.shape();
    let (curve, _) = join_spans(y0, y1, &mut EndpointProblem::new(n, k))?;
    Ok(curve.initial_velocity())
}
