//! Splines: exactness, smoothness at knots, end conditions, symmetries, closed curves, bad input.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/knots.rs"]
mod knots;

mod bad_knots;
mod hard_chains;
mod in_embedding;
mod interpolation;
mod smoothness;
