//! End conditions of splines.

use faer::{Mat, MatRef};

use crate::error::{Error, Result};
pub(super) use crate::legs::{End, Ends};
use crate::linalg::structure::{distance, norm};
use crate::manifold::stiefel::POINT_TOLERANCE;
use crate::manifold::tangent::{check_vector, tangent_part};
use crate::space::Quotient;

/// End conditions of a spline.
///
/// # Examples
/// ```
/// use faer::{MatRef, mat};
/// use stiefel_rs::spline::{EndConditions, SplineOptions, cubic_spline};
/// use stiefel_rs::{Curve, Interrupt};
/// // On the circle it is the spline of the angle.
/// let points = [0.0_f64, 1.0, 0.0].map(|a| mat![[a.cos()], [a.sin()]]);
/// let views: Vec<MatRef<'_, f64>> = points.iter().map(|point| point.as_ref()).collect();
/// let t = [0.0, 1.0, 2.0];
/// let (natural, _) = cubic_spline(&t, &views, &EndConditions::Natural, &SplineOptions::default(), Interrupt::NEVER)?;
/// assert!(natural.acceleration(0.0)?.norm_l2() < 1e-10);
/// let (closed, _) = cubic_spline(&t, &views, &EndConditions::Periodic, &SplineOptions::default(), Interrupt::NEVER)?;
/// assert!((closed.acceleration(0.0)? - closed.acceleration(2.0)?).norm_l2() < 1e-10);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub enum EndConditions {
    /// Zero covariant acceleration at both ends: the cost is stationary among all curves through the points.
    Natural,
    /// One condition at each end.
    Each(Box<[EndCondition; 2]>),
    /// The last point equals the first one; velocity and covariant acceleration agree there.
    Periodic,
}

impl EndConditions {
    /// The given vectors.
    pub(super) fn vectors(&self) -> Vec<MatRef<'_, f64>> {
        match self {
            EndConditions::Each(each) => each.iter().map(|end| end.vector().as_ref()).collect(),
            _ => Vec::new(),
        }
    }
}

/// The condition at one end: a tangent vector at the end point, shape `(n, k)`.
///
/// # Examples
/// ```
/// use faer::{MatRef, mat};
/// use stiefel_rs::spline::{EndCondition, EndConditions, SplineOptions, cubic_spline};
/// use stiefel_rs::{Curve, Interrupt};
/// // On the circle, points at the angles t^3: with the right ends the spline is that cubic.
/// let points = [0.0_f64, 0.125, 1.0].map(|a| mat![[a.cos()], [a.sin()]]);
/// let views: Vec<MatRef<'_, f64>> = points.iter().map(|point| point.as_ref()).collect();
/// let at_rest = EndCondition::Velocity(mat![[0.0], [0.0]]);
/// let speeding_up = EndCondition::Acceleration(mat![[-6.0 * 1.0_f64.sin()], [6.0 * 1.0_f64.cos()]]);
/// let ends = EndConditions::Each(Box::new([at_rest, speeding_up]));
/// let (curve, _) = cubic_spline(&[0.0, 0.5, 1.0], &views, &ends, &SplineOptions::default(), Interrupt::NEVER)?;
/// assert!((curve.point(0.8)?[(1, 0)] - 0.512_f64.sin()).abs() < 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub enum EndCondition {
    /// The velocity.
    Velocity(Mat<f64>),
    /// The covariant acceleration.
    Acceleration(Mat<f64>),
}

impl EndCondition {
    pub(super) fn vector(&self) -> &Mat<f64> {
        match self {
            EndCondition::Velocity(v) | EndCondition::Acceleration(v) => v,
        }
    }
}

/// Whether a velocity is given at an end.
pub(super) fn gives_velocity(ends: &Ends) -> bool {
    matches!(ends, Ends::Open(ends) if ends.iter().any(|end| end.velocity().is_some()))
}

impl End {
    pub(super) fn velocity(&self) -> Option<&[f64]> {
        match self {
            End::Velocity(v) => Some(v),
            End::Acceleration(_) => None,
        }
    }

    pub(super) fn acceleration(&self) -> Option<&[f64]> {
        match self {
            End::Acceleration(a) => Some(a),
            End::Velocity(_) => None,
        }
    }
}

/// Check that end vectors are tangent, and that a closed spline closes.
///
/// # Errors
/// `Shape`, `NonFinite`, `NotTangent`, `InvalidArgument`, wrapped in `AtKnot`.
pub(super) fn check_ends(
    quotient: Quotient,
    points: &[MatRef<'_, f64>],
    ends: &EndConditions,
) -> Result<()> {
    let last = points.len() - 1;
    match ends {
        EndConditions::Natural => Ok(()),
        EndConditions::Periodic => {
            let gap = match quotient {
                Quotient::Frames => distance(points[0], points[last]),
                Quotient::Subspaces => {
                    norm(tangent_part(quotient, points[0], points[last]).as_ref())
                }
            };
            if gap <= POINT_TOLERANCE {
                return Ok(());
            }
            let error = Error::InvalidArgument {
                name: "S",
                requirement: "at distance 0 from the first point (periodic ends)",
                found: gap,
            };
            Err(error.at_knot(last))
        }
        EndConditions::Each(each) => {
            for (knot, end) in [(0, &each[0]), (last, &each[1])] {
                check_vector(quotient, "bc_type", points[knot], end.vector().as_ref())
                    .map_err(|error| error.at_knot(knot))?;
            }
            Ok(())
        }
    }
}
