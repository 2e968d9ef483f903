//! The linearised equations along a cubic that is known.

pub(crate) mod linear_boundary;
pub(crate) mod linear_nodes;
pub(crate) mod linear_operator;
pub(crate) mod linear_terms;
