//! The frame in which rates are expressed.

/// The frame in which a rate, an acceleration, a jerk or a twist is expressed. The choice leaves units unchanged.
///
/// # Examples
/// ```
/// use nalgebra::{UnitQuaternion, Vector3};
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::rotation::{ReferenceFrame, RotationEnds, RotationSpline};
/// // A body that lies on its side turns about the world's vertical: about its own second axis.
/// let turned = |a: f64| {
///     UnitQuaternion::from_scaled_axis(Vector3::z() * a) * UnitQuaternion::from_scaled_axis(Vector3::x() * 1.5)
/// };
/// let keyframes = [0.0, 0.4, 0.8].map(turned);
/// let ends = RotationEnds::Natural;
/// let spline = RotationSpline::new(&[0.0, 1.0, 2.0], &keyframes, &ends, &Default::default(), Interrupt::NEVER)?;
/// let world = spline.angular_velocity(0.5, ReferenceFrame::World)?;
/// assert!((world - Vector3::z() * 0.4).norm() < 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReferenceFrame {
    /// The body frame, which the curve rotates: `R^T v` for a vector `v` of the world.
    Body,
    /// The fixed world frame.
    World,
}
