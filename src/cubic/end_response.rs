//! How the start of a curve of least cost changes with its end, in the coordinates of the end map.

use super::packing::{of_real_coordinates, to_real_coordinates};
use super::reduced::Sized;
use crate::shooting::StartResponse;
use crate::space::ScalarField;

/// The response of a chain of legs at rest.
pub(super) struct EndResponse {
    pub(super) chain: StartResponse,
    /// Of the chain.
    pub(super) blocks: Sized,
}

impl EndResponse {
    /// The change of `(x', x'')` with that of the end.
    pub(super) fn change(&self, end: &[f64]) -> Vec<f64> {
        match self.blocks.field {
            ScalarField::Real => self.chain.change(end),
            ScalarField::Complex => {
                let end = of_real_coordinates(end, self.blocks);
                to_real_coordinates(&self.chain.change(&end), self.blocks)
            }
        }
    }
}
