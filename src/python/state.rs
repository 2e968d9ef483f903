//! Chart states as rows of numbers, for the charts and for shooting.

use nalgebra::SVector;

use crate::error::{Error, Result};

/// Which chart.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    Sphere,
    Frame,
}

impl Kind {
    /// Dimension of the manifold.
    pub fn dimension(self) -> usize {
        match self {
            Kind::Sphere => 2,
            Kind::Frame => 3,
        }
    }

    /// Entries of a state.
    pub fn width(self) -> usize {
        4 * self.dimension()
    }

    /// Columns of a point.
    pub fn columns(self) -> usize {
        self.dimension() - 1
    }

    /// The name of what makes its chart.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Sphere => "sphere",
            Kind::Frame => "frame",
        }
    }
}

/// A state from its numbers.
pub fn state<const N: usize>(row: &[f64]) -> SVector<f64, N> {
    SVector::from_column_slice(row)
}

/// Error `NonFinite` where a number is NaN or infinite.
pub fn check_finite(name: &'static str, row: &[f64]) -> Result<()> {
    match row.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(Error::NonFinite { name, index }),
        None => Ok(()),
    }
}

/// Writes states one after another.
pub fn write_states<const Z: usize>(states: &[SVector<f64, Z>], out: &mut [f64]) {
    for (state, target) in states.iter().zip(out.chunks_mut(Z)) {
        target.copy_from_slice(state.as_slice());
    }
}

/// Evaluate an expression, generic in the chart, for the chart of a [`Kind`]: `on_chart!(kind, chart => expression)`.
macro_rules! on_chart {
    ($kind:expr, $chart:ident => $value:expr) => {
        match $kind {
            Kind::Sphere => {
                let $chart = &crate::chart::Sphere;
                $value
            }
            Kind::Frame => {
                let $chart = &crate::chart::Frame;
                $value
            }
        }
    };
}
pub(super) use on_chart;
