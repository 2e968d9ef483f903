//! The first and the last leg of a geometric polynomial, determined by its end velocities.

use faer::{Mat, MatRef, Scale};

use super::curve::Curve;
use crate::error::{Error, Result};

use crate::manifold::QuasiGeodesic;
use crate::manifold::stiefel::{POINT_TOLERANCE, Stiefel, TANGENT_TOLERANCE};

/// Tolerance for the velocities of two quasi-geodesics between the same points: they are equal, up to round-off times
/// the conditioning of the logarithm, or about a full turn apart.
const SAME_BRANCH: f64 = 1e-3;

/// Bounds on principal angles and on the Frobenius norm of `Omega` that keep angles safely below pi/2 and pi: the
/// largest rotation angle is at most the norm divided by the square root of two.
const SURE_ANGLE: f64 = 1.5;
const SURE_TURN: f64 = 4.2;

/// The manifold of two points with a tangent vector each, `S0, V0, S1, V1` with their names.
///
/// # Errors
/// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`.
pub(super) fn check_boundary(data: [(&'static str, MatRef<'_, f64>); 4]) -> Result<Stiefel> {
    let manifold = Stiefel::of(data[0].0, data[0].1)?;
    for [(point, s), (vector, v)] in [[data[0], data[1]], [data[2], data[3]]] {
        manifold.check_point(point, s, POINT_TOLERANCE)?;
        manifold.check_tangent(vector, s, v, TANGENT_TOLERANCE)?;
    }
    Ok(manifold)
}

/// The first leg of a polynomial that starts at `s` with velocity `v`, and its end.
///
/// # Errors
/// `InvalidArgument` if the leg is not the principal quasi-geodesic between its ends.
pub(super) fn outer_leg(
    name: &'static str,
    s: &Mat<f64>,
    v: &Mat<f64>,
    degree: usize,
) -> Result<(QuasiGeodesic, Mat<f64>)> {
    let part = v * Scale(1.0 / degree as f64);
    let leg = QuasiGeodesic::from_velocity(s.as_ref(), part.as_ref())?;
    let end = leg.point(1.0)?;
    let requirement = match degree {
        3 => "short enough that a third of it is the velocity of a principal quasi-geodesic",
        _ => "short enough that 1/degree of it is the velocity of a principal quasi-geodesic",
    };
    check_principal(&leg, &end, |size| Error::InvalidArgument {
        name,
        requirement,
        found: degree as f64 * size,
    })?;
    Ok((leg, end))
}

/// Return `refusal` of the leg's speed unless the leg, which ends at `end`, is the principal quasi-geodesic between its
/// ends.
///
/// The later stages of de Casteljau's algorithm join points by principal quasi-geodesics, so the curve would jump away
/// from any other leg.
pub(super) fn check_principal(
    leg: &QuasiGeodesic,
    end: &Mat<f64>,
    refusal: impl FnOnce(f64) -> Error,
) -> Result<()> {
    if is_surely_principal(leg) {
        return Ok(());
    }
    let principal = QuasiGeodesic::joining(leg.point(0.0)?.as_ref(), end.as_ref())?;
    let velocity = leg.initial_velocity();
    let size = velocity.norm_l2();
    let gap = (&velocity - principal.initial_velocity()).norm_l2();
    if gap <= SAME_BRANCH * size.max(1.0) {
        Ok(())
    } else {
        Err(refusal(size))
    }
}

/// Whether the angles alone show that a leg is the principal one: in `S_0^T S_1 = W cos(Sigma) W^T e^Omega`, positive
/// cosines make this the polar decomposition, and `Omega` is then the logarithm of its rotation.
fn is_surely_principal(leg: &QuasiGeodesic) -> bool {
    let largest = leg.angles().iter().fold(0.0, |a: f64, b| a.max(*b));
    // The spectral norm of a skew matrix is at most its Frobenius norm divided by the square root of two.
    largest <= SURE_ANGLE && leg.omega().norm_l2() <= SURE_TURN
}
