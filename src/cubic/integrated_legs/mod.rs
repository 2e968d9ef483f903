//! Legs of splines, integrated by the Taylor method.

pub(crate) mod leg;
pub(crate) mod leg_of_blocks;
pub(crate) mod marches;
