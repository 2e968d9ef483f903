//! Derivatives of splines with respect to their data, forward and transposed.

pub(crate) mod data_variation;
pub(crate) mod derivative;
pub(crate) mod given;
pub(crate) mod knot_gradient;
pub(crate) mod knot_states;
pub(crate) mod knot_system;
pub(crate) mod spline_ends;
