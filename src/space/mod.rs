//! Homogeneous spaces, as the equations of cubics see them: the Lie algebra of the group split into `m + h`.

mod grassmann;
mod homogeneous;
mod quotient;
mod row_sums;
mod stiefel;

pub(crate) use grassmann::Subspaces;
pub(crate) use homogeneous::{Homogeneous, orthonormalise};
pub use quotient::Quotient;
pub(crate) use row_sums::{Brackets, Products, SLACK, axis, cross_products, write_row};
pub(crate) use stiefel::{FixedFrames, Frames};
