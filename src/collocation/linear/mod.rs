//! The equations of cubics between given ends, linearised.

pub(crate) mod linear_boundary;
#[cfg(test)]
mod linear_boundary_tests;
pub(crate) mod linear_nodes;
pub(crate) mod linear_operator;
pub(crate) mod linear_row;
pub(crate) mod linear_terms;
