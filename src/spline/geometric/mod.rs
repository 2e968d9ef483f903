//! Splines of geometric cubics, and velocities at knots from the points alone.

pub(crate) mod end_accelerations;
pub(crate) mod geometric_spline;
pub(crate) mod geometric_subspaces;
pub(crate) mod links;
pub(crate) mod velocities;
