//! Spaces with sizes and kind known at run time, and dispatch to kernels specialised for each.

use super::quotient::Quotient;
use super::scalar_field::ScalarField;

/// The meaning of matrices with orthonormal columns (frames or subspaces), and their scalars.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Kind {
    pub(crate) quotient: Quotient,
    pub(crate) field: ScalarField,
}

impl Kind {
    pub(crate) fn real(quotient: Quotient) -> Self {
        Kind {
            quotient,
            field: ScalarField::Real,
        }
    }

    pub(crate) const REAL_FRAMES: Self = Kind {
        quotient: Quotient::Frames,
        field: ScalarField::Real,
    };
}

/// A space of matrices with orthonormal columns, by the sizes of the real matrices that represent its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Shape {
    /// Rows.
    pub(crate) r: usize,
    /// Columns.
    pub(crate) k: usize,
    pub(crate) kind: Kind,
}

/// Evaluates an expression with the [`Homogeneous`](super::Homogeneous) space of a [`Shape`]. Sizes of spheres and of
/// rotations in three dimensions are compile-time constants.
macro_rules! in_space {
    ($shape:expr, |$space:ident| $body:expr) => {{
        use $crate::space::{ComplexSpace, FixedFrames, Quotient, RealSpace, ScalarField, Shape};
        let Shape { r, k, kind } = $shape;
        let quotient = kind.quotient;
        match (kind.field, quotient, r, k) {
            (ScalarField::Complex, ..) => {
                let $space = ComplexSpace { r, k, quotient };
                $body
            }
            (_, Quotient::Frames, 3, 1) => {
                let $space = FixedFrames::<3, 1>;
                $body
            }
            (_, Quotient::Frames, 3, 2) => {
                let $space = FixedFrames::<3, 2>;
                $body
            }
            _ => {
                let $space = RealSpace { r, k, quotient };
                $body
            }
        }
    }};
}

pub(crate) use in_space;
