//! Smoothing splines: curves near data.

pub(crate) mod flat_smoothing;
pub(crate) mod generalised_cross_validation;
pub(crate) mod grouped;
pub(crate) mod interpolating;
pub(crate) mod smoothing_equations;
pub(crate) mod smoothing_options;
pub(crate) mod smoothing_spline;
pub(crate) mod solve;
pub(crate) mod straight;
