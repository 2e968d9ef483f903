//! Cubics that are known, linearised.

pub(crate) mod linear_curve;
pub(crate) mod linear_leg;
pub(crate) mod linear_legs;
pub(crate) mod linear_middle;
pub(crate) mod linearise;
