//! The numbers of a trajectory across charts, as columns of a table.

use super::{AtlasState, Chart};
use crate::error::{Error, Result};

/// The numbers of a trajectory, state by state.
#[derive(Default)]
pub(crate) struct Rows {
    /// Point, velocity, acceleration, jerk, energy, momentum, state, rotation.
    pub(crate) columns: [Vec<f64>; 8],
    pub(crate) turns: Vec<usize>,
}

impl Rows {
    pub(crate) fn new<C: Chart<X, Z>, const X: usize, const Z: usize>(
        chart: &C,
        states: &[AtlasState<Z>],
    ) -> Result<Self> {
        let mut out = Rows::default();
        for state in states {
            let data = state.covariant(chart)?;
            let parts = [&data.point, &data.velocity, &data.acceleration, &data.jerk];
            for (column, part) in out.columns.iter_mut().zip(parts) {
                column.extend(part.row_iter().flat_map(|row| row.iter()));
            }
            let (energy, momentum) = (chart.hamiltonian(&state.z), data.spatial_momentum());
            if !momentum.iter().chain([&energy]).all(|x| x.is_finite()) {
                let quantity = "energy or momentum";
                return Err(Error::Overflow { quantity });
            }
            // The transpose in column-major order is the matrix in row-major order.
            let rotation = state.rotation().transpose();
            let parts = [
                &[energy],
                &momentum[..],
                state.z.as_slice(),
                rotation.as_slice(),
            ];
            for (column, part) in out.columns[4..].iter_mut().zip(parts) {
                column.extend_from_slice(part);
            }
            out.turns.push(state.turns);
        }
        Ok(out)
    }
}
