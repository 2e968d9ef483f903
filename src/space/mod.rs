//! Homogeneous spaces, as the equations of cubics see them: the Lie algebra of the group split into `m + h`.

mod homogeneous;
mod stiefel;

pub(crate) use homogeneous::{Homogeneous, orthonormalise};
pub(crate) use stiefel::{FixedFrames, Frames};
