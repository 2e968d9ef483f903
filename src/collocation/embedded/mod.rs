//! Chains of legs in the embedding.

pub(crate) mod chain;
pub(crate) mod clamped;
pub(crate) mod clamped_leg;
pub(crate) mod embedded_equation;
pub(crate) mod embedded_products;
pub(crate) mod leg_polynomials;
pub(crate) mod solved_chain;
