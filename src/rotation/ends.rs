//! End conditions of splines of rotations and poses.

use std::f64::consts::FRAC_1_SQRT_2;

use faer::Mat;
use nalgebra::{UnitQuaternion, Vector3};

use crate::error::{Error, Result};
use crate::legs::{End, Ends};
use crate::manifold::stiefel::POINT_TOLERANCE;
use crate::spline::{EndCondition, EndConditions};

/// The ends of a spline of rotations.
///
/// # Examples
/// ```
/// use nalgebra::{UnitQuaternion, Vector3};
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::rotation::{ReferenceFrame, RotationEnd, RotationEnds, RotationSpline};
/// // Keyframes at the angles t^3 about an axis: from rest, with the right acceleration at the end, it is that cubic.
/// let axis = Vector3::new(0.6, 0.0, 0.8);
/// let keyframes = [0.0, 0.125, 1.0].map(|a| UnitQuaternion::from_scaled_axis(axis * a));
/// let ends = RotationEnds::Each([RotationEnd::Rate(Vector3::zeros()), RotationEnd::Acceleration(axis * 6.0)]);
/// let spline = RotationSpline::new(&[0.0, 0.5, 1.0], &keyframes, &ends, &Default::default(), Interrupt::NEVER)?;
/// assert!((spline.angular_velocity(0.8, ReferenceFrame::Body)? - axis * 1.92).norm() < 1e-11);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub enum RotationEnds {
    /// Zero angular acceleration at both ends: the curve of least cost through the rotations.
    Natural,
    /// One condition at each end, in the body frame.
    Each([RotationEnd; 2]),
    /// The last rotation equals the first one; the rate and the angular acceleration agree there, in both frames.
    Periodic,
}

/// The condition at one end of a spline of rotations, in the body frame.
///
/// # Examples
/// ```
/// use nalgebra::{UnitQuaternion, Vector3};
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::rotation::{RotationEnd, RotationEnds, RotationSpline};
/// // From rest to rest: the angle is 3 t^2 - 2 t^3.
/// let keyframes = [0.0, 1.0].map(|a| UnitQuaternion::from_scaled_axis(Vector3::y() * a));
/// let rest = RotationEnd::Rate(Vector3::zeros());
/// let ends = RotationEnds::Each([rest; 2]);
/// let spline = RotationSpline::new(&[0.0, 1.0], &keyframes, &ends, &Default::default(), Interrupt::NEVER)?;
/// assert!((spline.rotation(0.25)?.angle() - 0.15625).abs() < 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub enum RotationEnd {
    /// The angular velocity `w` in the body frame, in radians per unit of time (rad/s).
    Rate(Vector3<f64>),
    /// Its derivative `w'`, the angular acceleration in the body frame, in radians per unit of time squared (rad/s^2).
    Acceleration(Vector3<f64>),
}

/// The ends of a spline of poses.
///
/// # Examples
/// ```
/// use nalgebra::{Isometry3, Vector3};
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::rotation::{PoseEnds, PoseSpline};
/// // Back to where it began, with the same velocity and acceleration.
/// let poses = [0.0, 1.0, 0.5, 0.0].map(|x| Isometry3::new(Vector3::x() * x, Vector3::z() * x));
/// let spline =
///     PoseSpline::new(&[0.0, 1.0, 2.0, 3.0], &poses, &PoseEnds::Periodic, &Default::default(), Interrupt::NEVER)?;
/// let [first, last] = [0.0, 3.0].map(|t| spline.linear_velocity(t));
/// assert!((first? - last?).norm() < 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub enum PoseEnds {
    /// Zero angular and linear acceleration at both ends.
    Natural,
    /// One condition at each end: angular vectors in the body frame, linear ones in the world frame.
    Each([PoseEnd; 2]),
    /// The last pose equals the first one; velocities and accelerations agree there.
    Periodic,
}

/// The condition at one end of a spline of poses: angular vectors in the body frame, linear ones in the world frame.
///
/// # Examples
/// ```
/// use nalgebra::{Isometry3, Vector3};
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::rotation::{PoseEnd, PoseEnds, PoseSpline};
/// let poses = [0.0, 1.0].map(|x| Isometry3::new(Vector3::x() * x, Vector3::z() * x));
/// let rest = PoseEnd::Velocity { angular: Vector3::zeros(), linear: Vector3::zeros() };
/// let spline =
///     PoseSpline::new(&[0.0, 1.0], &poses, &PoseEnds::Each([rest; 2]), &Default::default(), Interrupt::NEVER)?;
/// assert!((spline.position(0.25)?.x - 0.15625).abs() < 1e-15);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub enum PoseEnd {
    /// Velocities, per unit of time.
    Velocity {
        /// Angular velocity `w` in the body frame, in radians per unit of time (rad/s).
        angular: Vector3<f64>,
        /// Velocity `p'` of the position in the world frame, in units of length per unit of time (m/s).
        linear: Vector3<f64>,
    },
    /// Accelerations, per unit of time squared.
    Acceleration {
        /// Angular acceleration `w'` in the body frame, in radians per unit of time squared (rad/s^2).
        angular: Vector3<f64>,
        /// Acceleration `p''` of the position in the world frame, in units of length per unit of time squared (m/s^2).
        linear: Vector3<f64>,
    },
}

impl RotationEnds {
    /// The same conditions for points of `St(3, 3)`; `rotations` are the first and the last one.
    pub(super) fn on_frames(&self, rotations: [&UnitQuaternion<f64>; 2]) -> EndConditions {
        let on_frame = |rotation: &UnitQuaternion<f64>, end: &RotationEnd| match end {
            RotationEnd::Rate(w) => EndCondition::Velocity(tangent(rotation, w)),
            RotationEnd::Acceleration(a) => EndCondition::Acceleration(tangent(rotation, a)),
        };
        match self {
            RotationEnds::Natural => EndConditions::Natural,
            RotationEnds::Periodic => EndConditions::Periodic,
            RotationEnds::Each([first, last]) => EndConditions::Each(Box::new([
                on_frame(rotations[0], first),
                on_frame(rotations[1], last),
            ])),
        }
    }
}

impl PoseEnds {
    /// The conditions on the rotations alone.
    pub(super) fn of_rotations(&self) -> RotationEnds {
        match self {
            PoseEnds::Natural => RotationEnds::Natural,
            PoseEnds::Periodic => RotationEnds::Periodic,
            PoseEnds::Each(ends) => RotationEnds::Each(ends.map(|end| match end {
                PoseEnd::Velocity { angular, .. } => RotationEnd::Rate(angular),
                PoseEnd::Acceleration { angular, .. } => RotationEnd::Acceleration(angular),
            })),
        }
    }
}

/// Check that the last rotation of a periodic spline is the first one.
///
/// # Errors
/// `InvalidArgument`, with the angle, in `AtKnot`.
pub(super) fn check_closed(rotations: &[UnitQuaternion<f64>], ends: &EndConditions) -> Result<()> {
    let (EndConditions::Periodic, [first, .., last]) = (ends, rotations) else {
        return Ok(());
    };
    let found = first.angle_to(last);
    // Two matrices are `sqrt(2)` times their small angle apart.
    // Rotations that are not finite are refused later.
    if found <= FRAC_1_SQRT_2 * POINT_TOLERANCE || found.is_nan() {
        return Ok(());
    }
    let error = Error::InvalidArgument {
        name: "rotations",
        requirement: "at angle 0 from the first rotation (periodic ends)",
        found,
    };
    Err(error.at_knot(rotations.len() - 1))
}

/// The conditions on a curve of matrices, in the body frame; `None` without rotations.
pub(super) fn in_body(ends: &EndConditions, rotations: &[UnitQuaternion<f64>]) -> Option<Ends> {
    let [first, .., last] = rotations else {
        return None;
    };
    let zero = || End::Acceleration(vec![0.0; 3]);
    let end = |rotation, end: &EndCondition| match end {
        EndCondition::Velocity(v) => End::Velocity(rate(rotation, v)),
        EndCondition::Acceleration(a) => End::Acceleration(rate(rotation, a)),
    };
    Some(match ends {
        EndConditions::Natural => Ends::Open([zero(), zero()]),
        EndConditions::Periodic => Ends::Periodic,
        EndConditions::Each(each) => Ends::Open([end(first, &each[0]), end(last, &each[1])]),
    })
}

/// `w` of the tangent vector `R hat(w)`.
fn rate(rotation: &UnitQuaternion<f64>, tangent: &Mat<f64>) -> Vec<f64> {
    let matrix = rotation.to_rotation_matrix();
    let entry =
        |i: usize, j: usize| -> f64 { (0..3).map(|l| matrix[(l, i)] * tangent[(l, j)]).sum() };
    vec![entry(2, 1), entry(0, 2), entry(1, 0)]
}

/// `R hat(w)`, the tangent vector of `St(3, 3)` with the body rate `w`.
pub(crate) fn tangent(rotation: &UnitQuaternion<f64>, w: &Vector3<f64>) -> Mat<f64> {
    let product = rotation.to_rotation_matrix().into_inner() * w.cross_matrix();
    Mat::from_fn(3, 3, |i, j| product[(i, j)])
}

/// The matrix of a rotation, a point of `St(3, 3)`.
pub(crate) fn frame(rotation: &UnitQuaternion<f64>) -> Mat<f64> {
    let matrix = rotation.to_rotation_matrix();
    Mat::from_fn(3, 3, |i, j| matrix[(i, j)])
}
