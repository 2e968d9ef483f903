//! What a spline does at its ends.

use faer::{Mat, MatRef};

use crate::error::{Error, Result};
use crate::linalg::structure::distance;
use crate::manifold::Stiefel;
use crate::manifold::stiefel::{POINT_TOLERANCE, TANGENT_TOLERANCE};

/// End conditions of a spline.
#[derive(Debug, Clone)]
pub enum EndConditions {
    /// No covariant acceleration at both ends: the curve of least cost through the points.
    Natural,
    /// One condition at each end.
    Each(Box<[EndCondition; 2]>),
    /// The last point is the first one; velocity and covariant acceleration agree there.
    Periodic,
}

/// The condition at one end: a tangent vector at the end point, shape `(n, k)`.
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

/// The same in coordinates of the end knots.
pub(super) enum Ends {
    Open([End; 2]),
    Periodic,
}

/// What is given at an end, in coordinates.
#[derive(Clone)]
pub(super) enum End {
    Velocity(Vec<f64>),
    Acceleration(Vec<f64>),
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

/// Checks that end vectors are tangent, and that a closed spline closes.
///
/// # Errors
/// `Shape`, `NonFinite`, `NotTangent`, `InvalidArgument`, in `AtKnot`.
pub(super) fn check_ends(
    manifold: &Stiefel,
    points: &[MatRef<'_, f64>],
    ends: &EndConditions,
) -> Result<()> {
    let last = points.len() - 1;
    match ends {
        EndConditions::Natural => Ok(()),
        EndConditions::Periodic => {
            let gap = distance(points[0], points[last]);
            if gap <= POINT_TOLERANCE {
                return Ok(());
            }
            let error = Error::InvalidArgument {
                name: "S",
                requirement: "the first point again (the ends are periodic), this far from it",
                found: gap,
            };
            Err(error.at_knot(last))
        }
        EndConditions::Each(each) => {
            for (knot, end) in [(0, &each[0]), (last, &each[1])] {
                manifold
                    .check_tangent(
                        "bc_type",
                        points[knot],
                        end.vector().as_ref(),
                        TANGENT_TOLERANCE,
                    )
                    .map_err(|error| error.at_knot(knot))?;
            }
            Ok(())
        }
    }
}
