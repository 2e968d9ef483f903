//! Newton's method for a chain between given points.

pub(crate) mod chain;
pub(crate) mod newton;
pub(crate) mod newton_step;
pub(crate) mod solved;
