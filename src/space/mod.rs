//! Homogeneous spaces as needed for the equation of cubics: the Lie algebra of the group, split into `m + h`.

mod complex;
mod homogeneous;
mod quotient;
mod real;
mod row_order;
mod row_sums;
mod scalar_field;
mod shape;
#[cfg(test)]
mod test_matrices;

pub(crate) use complex::ComplexSpace;
pub(crate) use homogeneous::{Homogeneous, orthonormalise};
pub use quotient::Quotient;
pub(crate) use real::{FixedFrames, RealSpace};
pub(crate) use row_order::RowOrder;
pub(crate) use row_sums::{Brackets, RowProducts, SLACK, axis, skew, write_row};
pub use scalar_field::ScalarField;
pub(crate) use shape::{Kind, Shape, in_space};
