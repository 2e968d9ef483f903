//! A cubic on `[0, 1]`, linearised: the response to displacements `u` and changes `w` of the velocities at its ends.
//!
//! The second derivative of half the cost is the matrix of four by four blocks
//!
//! ```math
//! \tfrac12 J:\qquad \text{gradient}\ (x''_0,\,-x'_0,\,-x''_1,\,x'_1)\ \text{by}\ (u_0, w_0, u_1, w_1)
//! ```
//!
//! It is symmetric except for the blocks of two displacements of the same end, which do not commute, and, in tension, for
//! the blocks of `x''` by `w` at the same end: the gradient contains `x'' - tau x` there.

use std::sync::Arc;

use crate::curve::barycentric::Barycentric;

/// The response of a cubic. Frames are relative to the one at the start; matrices in row-major order.
#[derive(Debug, Default)]
pub(crate) struct LinearCurve {
    /// The frame at the end.
    pub(crate) frame: Vec<f64>,
    /// The second derivative of half the cost, shape `(4 d, 4 d)`.
    pub(crate) stiffness: Vec<f64>,
    /// Empty if points cannot move, or if their displacements are not wanted.
    pub(crate) parts: Vec<CurvePart>,
}

/// The points of a part of the curve, through which frames and displacements are interpolated.
#[derive(Debug)]
pub(crate) struct CurvePart {
    pub(crate) start: f64,
    pub(crate) length: f64,
    pub(crate) through: Arc<Barycentric>,
    /// Frames at the points, shape `(r, r)` each.
    pub(crate) frames: Vec<f64>,
    /// Displacements of the points, shape `(d, 4 d)` each.
    pub(crate) displacements: Vec<f64>,
}

/// Solver named in errors.
pub(crate) const SOLVER: &str = "linearised cubic";
