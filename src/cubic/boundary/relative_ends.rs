//! Data at both ends of a curve, relative to its start.

use faer::Mat;

use crate::cubic::taylor::initial::Horizontal;
use crate::linalg::structure::identity_columns;

/// Data at both ends of a curve on `[0, 1]`, in coordinates in which its start is the first columns of the identity.
#[derive(Clone, Copy)]
pub(crate) struct RelativeEnds<'a> {
    /// The velocity at the start.
    pub(crate) velocity: &'a Horizontal,
    /// End point and end velocity, shape `(r, k)`.
    pub(crate) end: &'a [Mat<f64>; 2],
}

impl RelativeEnds<'_> {
    /// Point and velocity at the start, shape `(r, k)`.
    pub(crate) fn initial(&self) -> [Mat<f64>; 2] {
        let (r, k) = self.end[0].shape();
        [identity_columns(r, k), self.velocity.tangent()]
    }
}
