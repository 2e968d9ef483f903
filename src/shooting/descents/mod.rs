//! Descents of a chain with free knots to a local minimum of the cost, or to a stationary chain near it.

pub(crate) mod chain_knots;
pub(crate) mod descent;
pub(crate) mod descent_state;
#[cfg(test)]
mod descent_tests;
pub(crate) mod free_chain;
pub(crate) mod layout;
pub(crate) mod second_derivative;
pub(crate) mod settling;
pub(crate) mod stiffness;
pub(crate) mod valley;
