//! Splines through poses: rotations on `SO(3)`, positions in `R^3`.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::ends::{PoseEnd, PoseEnds};
use super::position_spline::{PositionEnd, PositionSpline};
use super::reference_frame::ReferenceFrame;
use super::rotation_spline::RotationSpline;
use crate::curve::sampling::check_parameter;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::manifold::stiefel::POINT_TOLERANCE;
use crate::spline::SplineOptions;

/// A curve of poses through keyframes: a [`RotationSpline`] for the rotations, and a cubic spline with the same end
/// conditions for the positions.
///
/// In the product metric of `SO(3) x R^3` the two decouple. A pose takes a point `x` of the body to `R x + p` in the
/// world. Positions and their derivatives are in the world frame. Angles are in radians; lengths and times are in any
/// unit, called m and s here. Outside the keyframes' times the first and the last piece are extrapolated.
///
/// [`PoseSpline::rotations`] gives the angular velocity, acceleration and jerk, in either frame. After the first
/// evaluation, later ones between the first and the last keyframe allocate nothing (asserted in `tests/allocation.rs`).
///
/// Only the Python class has
/// * smoothing of poses (`PoseSpline.smoothing`); in Rust, [`RotationSpline::smoothing`] smooths rotations alone;
/// * evaluation at many times in one call;
/// * linear velocities, accelerations and jerks in the body frame; in Rust, multiply by the inverse of the rotation;
/// * the choice to refuse times outside the keyframes (`extrapolate=False`);
/// * poses given and returned as matrices of shape `(4, 4)`.
///
/// # Examples
/// ```
/// use nalgebra::{Isometry3, Vector3};
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::rotation::{PoseEnds, PoseSpline, ReferenceFrame};
/// // Along a circle in the plane, with the first axis forward.
/// let poses = [0.0, 0.5, 1.0, 1.5].map(|a: f64| {
///     Isometry3::new(Vector3::new(a.sin(), 1.0 - a.cos(), 0.0), Vector3::z() * a)
/// });
/// let spline =
///     PoseSpline::new(&[0.0, 0.5, 1.0, 1.5], &poses, &PoseEnds::Natural, &Default::default(), Interrupt::NEVER)?;
/// let twist = spline.twist(0.75, ReferenceFrame::Body)?;
/// // Forward at unit speed, and turning at unit rate.
/// assert!((twist.fixed_rows::<3>(0) - Vector3::z()).norm() < 1e-12);
/// assert!((twist.fixed_rows::<3>(3) - Vector3::x()).norm() < 0.01);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug)]
pub struct PoseSpline {
    rotations: RotationSpline,
    positions: PositionSpline,
}

impl PoseSpline {
    /// The spline through poses at increasing times.
    ///
    /// `options` apply to the rotations. In particular, `tension` leaves the positions unchanged.
    ///
    /// # Errors
    /// As [`RotationSpline::new`]; `NonFinite` and, for periodic ends that do not close, `InvalidArgument`, both
    /// wrapped in `AtKnot`; `Overflow`.
    pub fn new(
        t: &[f64],
        poses: &[Isometry3<f64>],
        ends: &PoseEnds,
        options: &SplineOptions,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let turns: Vec<UnitQuaternion<f64>> = poses.iter().map(|pose| pose.rotation).collect();
        let rotations = RotationSpline::new(t, &turns, &ends.of_rotations(), options, interrupt)?;
        let mut positions: Vec<_> = poses.iter().map(|pose| pose.translation.vector).collect();
        for (knot, position) in positions.iter().enumerate() {
            if let Some(index) = position.iter().position(|x| !x.is_finite()) {
                let name = "position";
                return Err(Error::NonFinite { name, index }.at_knot(knot));
            }
        }
        let of_position = |end: PoseEnd| match end {
            PoseEnd::Velocity { linear, .. } => PositionEnd::Velocity(linear),
            PoseEnd::Acceleration { linear, .. } => PositionEnd::Acceleration(linear),
        };
        let ends = match ends {
            PoseEnds::Natural => Some([PositionEnd::Acceleration(Vector3::zeros()); 2]),
            PoseEnds::Each(ends) => Some(ends.map(of_position)),
            PoseEnds::Periodic => {
                positions = closed(positions)?;
                None
            }
        };
        let positions = PositionSpline::new(t, &positions, ends)?;
        Ok(PoseSpline {
            rotations,
            positions,
        })
    }

    /// The rotation part, from the body frame to the world frame.
    pub fn rotations(&self) -> &RotationSpline {
        &self.rotations
    }

    /// The times of the keyframes, in units of time (s).
    pub fn knots(&self) -> &[f64] {
        self.rotations.knots()
    }

    /// The pose at a time, from the body frame to the world frame: a rotation, dimensionless, and a position, in units
    /// of length (m).
    ///
    /// # Errors
    /// As [`RotationSpline::rotation`]; `Overflow`.
    pub fn pose(&self, t: f64) -> Result<Isometry3<f64>> {
        let translation = Translation3::from(self.position(t)?);
        Ok(Isometry3::from_parts(
            translation,
            self.rotations.rotation(t)?,
        ))
    }

    /// The position `p` at a time, in the world frame, in units of length (m).
    ///
    /// # Errors
    /// `NonFinite`, `Overflow`.
    pub fn position(&self, t: f64) -> Result<Vector3<f64>> {
        self.derivative(t, 0)
    }

    /// The velocity of the position `p'`, in the world frame, in units of length per unit of time (m/s).
    ///
    /// # Errors
    /// `NonFinite`, `Overflow`.
    pub fn linear_velocity(&self, t: f64) -> Result<Vector3<f64>> {
        self.derivative(t, 1)
    }

    /// The acceleration of the position `p''`, in the world frame, in units of length per unit of time squared (m/s^2).
    ///
    /// # Errors
    /// `NonFinite`, `Overflow`.
    pub fn linear_acceleration(&self, t: f64) -> Result<Vector3<f64>> {
        self.derivative(t, 2)
    }

    /// The jerk of the position `p'''`, in the world frame, in units of length per unit of time cubed (m/s^3).
    ///
    /// It is constant on each piece. At a knot, where it jumps, it is the value of the following piece.
    ///
    /// # Errors
    /// `NonFinite`, `Overflow`.
    pub fn linear_jerk(&self, t: f64) -> Result<Vector3<f64>> {
        self.derivative(t, 3)
    }

    /// The twist of the pose `T(t)`, angular part first: `T^{-1} T'` in the body frame, `T' T^{-1}` in the world frame:
    ///
    /// ```math
    /// (w,\; R^T p'),\qquad (R w,\; p' - R w \times p)
    /// ```
    ///
    /// The angular part is in radians per unit of time (rad/s), the linear part in units of length per unit of time
    /// (m/s). In the world frame, the linear part is the velocity of the body's point at the world's origin.
    ///
    /// # Errors
    /// As [`RotationSpline::rotation`]; `Overflow`.
    /// # Source
    /// Lynch, Park (2017), "Modern Robotics", sec. 3.3.2.
    pub fn twist(&self, t: f64, frame: ReferenceFrame) -> Result<nalgebra::Vector6<f64>> {
        let (angular, velocity) = (
            self.rotations.angular_velocity(t, frame)?,
            self.linear_velocity(t)?,
        );
        let linear = match frame {
            ReferenceFrame::Body => self.rotations.rotation(t)?.inverse() * velocity,
            ReferenceFrame::World => velocity - angular.cross(&self.position(t)?),
        };
        let mut twist = nalgebra::Vector6::zeros();
        twist.fixed_rows_mut::<3>(0).copy_from(&angular);
        twist.fixed_rows_mut::<3>(3).copy_from(&linear);
        Ok(twist)
    }

    fn derivative(&self, t: f64, order: usize) -> Result<Vector3<f64>> {
        check_parameter(t)?;
        let knots = self.knots();
        let leg = knots
            .partition_point(|knot| *knot <= t)
            .clamp(1, knots.len() - 1)
            - 1;
        let h = knots[leg + 1] - knots[leg];
        let value = self
            .positions
            .derivative(leg, (t - knots[leg]) / h, h, order);
        if value.iter().all(|x| x.is_finite()) {
            return Ok(value);
        }
        Err(Error::Overflow {
            quantity: "derivative of a spline of positions",
        })
    }
}

/// Positions of a closed curve, with the last set to the first: they may differ by round-off of their numbers, or by
/// the tolerance of points relative to their extent.
///
/// # Errors
/// `InvalidArgument`, with the gap, in `AtKnot`.
fn closed(mut positions: Vec<Vector3<f64>>) -> Result<Vec<Vector3<f64>>> {
    let last = positions.len() - 1;
    let gap = (positions[last] - positions[0]).amax();
    let (mut least, mut most) = (positions[0], positions[0]);
    for position in &positions {
        (least, most) = (least.inf(position), most.sup(position));
    }
    let round_off = 4.0 * f64::EPSILON * least.amax().max(most.amax());
    if gap > round_off.max(POINT_TOLERANCE * (most - least).amax()) {
        let error = Error::InvalidArgument {
            name: "position",
            requirement: "at distance 0 from the first position (periodic ends)",
            found: gap,
        };
        return Err(error.at_knot(last));
    }
    positions[last] = positions[0];
    Ok(positions)
}
