//! Logarithms of rotations.

#[path = "../common/mod.rs"]
mod common;

mod backward_error;
mod refusals;
mod structure;
