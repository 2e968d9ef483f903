//! Single cubics between given ends, in frames.

pub(crate) mod boundary_curve;
pub(crate) mod boundary_leg;
pub(crate) mod boundary_value;
pub(crate) mod lane_frames;
