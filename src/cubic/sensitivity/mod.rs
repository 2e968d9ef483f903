//! Derivatives of cubics with respect to their data, forward and transposed.

pub(crate) mod collocated;
pub(crate) mod derivative;
pub(crate) mod initial_derivative;
pub(crate) mod linear_cubic;
pub(crate) mod linear_flow;
pub(crate) mod linear_layout;
pub(crate) mod linear_piece;
#[cfg(test)]
mod linear_piece_tests;
pub(crate) mod linear_start;
pub(crate) mod linear_velocities;
pub(crate) mod variation;
