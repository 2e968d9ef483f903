//! Splines through rotations (unit quaternions) and poses (rigid motions), with rates in the body or world frame.
//!
//! `SO(3) = St(3, 3)`, and a curve of rotations `R(t)` has the body rate `w` with
//!
//! ```math
//! R' = R\,\hat w,\qquad q' = \tfrac12\, q \circ (w, 0),\qquad w''' = w'' \times w
//! ```
//!
//! The last equation is the equation of Riemannian cubics. `D_t R' = R \hat{w'}`, since `w x w = 0`, so the cost of a
//! curve is the integral of the squared angular acceleration.
//!
//! # Source
//! Noakes, Heinzinger, Paden (1989), "Cubic splines on curved spaces", IMA J. Math. Control Inform. 6, 465-473;
//! Noakes (2003), "Null cubics and Lie quadratics", J. Math. Phys. 44, 1436-1448.

mod ends;
mod half_turns;
mod pieces;
mod pose_spline;
mod position_spline;
mod reference_frame;
mod rotation_spline;
mod sampling;
mod series;

pub use ends::{PoseEnd, PoseEnds, RotationEnd, RotationEnds};
#[cfg(feature = "python")]
pub(crate) use ends::{frame, tangent};
pub use pose_spline::PoseSpline;
pub use reference_frame::ReferenceFrame;
pub use rotation_spline::RotationSpline;
