//! The Taylor method for initial values, and the piecewise polynomial that it makes.

pub(crate) mod block_products;
pub(crate) mod blocks;
pub(crate) mod embedding;
pub(crate) mod fused;
pub(crate) mod halves;
pub(crate) mod horner;
pub(crate) mod initial;
pub(crate) mod lazy_taylor;
pub(crate) mod leg_curve;
pub(crate) mod march;
pub(crate) mod packing;
pub(crate) mod piecewise_taylor;
pub(crate) mod recurrence;
pub(crate) mod rotation;
pub(crate) mod state;
pub(crate) mod work;
