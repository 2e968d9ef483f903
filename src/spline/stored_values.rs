//! Checks that the points and velocities stored with a spline agree with its pieces.

use faer::{Mat, MatRef};

use crate::curve::Samples;
use crate::error::Result;
use crate::linalg::structure::{distance, norm};
use crate::manifold::stored::check_orthonormal;
use crate::manifold::tangent::tangent_part;
use crate::space::Quotient;
use crate::stored::refusal;

/// Allowed deviation from the pieces, which are solved to a tolerance.
const STORED_TOLERANCE: f64 = 1e-6;

/// Return an error unless points are orthonormal and agree with the curve at its knots to the tolerance of its solver.
pub(crate) fn check_points(
    name: &str,
    points: &[MatRef<'_, f64>],
    found: &Samples,
    quotient: Quotient,
    tolerance: f64,
) -> Result<()> {
    for (knot, (point, stored)) in found.iter().zip(points).enumerate() {
        check_orthonormal(&format!("{name}: knot {knot}"), *stored)?;
        let gap = match quotient {
            Quotient::Frames => distance(point, *stored),
            // Distance of their spans.
            Quotient::Subspaces => norm(tangent_part(quotient, point, *stored).as_ref()),
        };
        if gap > STORED_TOLERANCE.max(tolerance) {
            let problem = format!("knot {knot}: the curve is {gap:.3e} away from the point");
            return Err(refusal(problem));
        }
    }
    Ok(())
}

/// Return an error unless velocities agree with those of the curve at its knots, at times `t`; for subspaces they refer
/// to bases that `turns` maps to those of the curve.
pub(crate) fn check_velocities(
    t: &[f64],
    turns: Option<&[Mat<f64>]>,
    velocities: &[MatRef<'_, f64>],
    found: &Samples,
) -> Result<()> {
    let steps = t.windows(2).map(|pair| pair[1] - pair[0]);
    let shortest = steps.fold(f64::INFINITY, f64::min);
    for (knot, (velocity, stored)) in found.iter().zip(velocities).enumerate() {
        let gap = match turns {
            Some(turns) => distance(velocity, (*stored * &turns[knot]).as_ref()),
            None => distance(velocity, *stored),
        };
        // Pieces are solved in their own unit of time.
        let allowed = STORED_TOLERANCE * norm(*stored).max(shortest.recip());
        if gap.is_nan() || gap > allowed {
            let problem = format!("knot {knot}: the velocity of the curve is {gap:.3e} away");
            return Err(refusal(problem));
        }
    }
    Ok(())
}
