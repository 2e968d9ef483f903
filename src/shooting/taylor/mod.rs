//! A leg of a chain as a Taylor series about its middle: the series, its residuals, and their derivatives.

pub(crate) mod brackets;
pub(crate) mod condensed_leg;
pub(crate) mod durations;
pub(crate) mod leg;
pub(crate) mod leg_equations;
pub(crate) mod orders;
pub(crate) mod room;
pub(crate) mod rotation_series;
#[cfg(test)]
mod rotation_tests;
pub(crate) mod series;
pub(crate) mod variation;
