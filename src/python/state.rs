//! Helpers for functions of charts: the kind of chart, states as rows of numbers, and steps of a named method.

use nalgebra::SVector;

use super::prelude::*;
use crate::chart::{Composition, DiscretizationMap, NamedMap};
use crate::linalg::structure;

/// The kind of chart.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub enum ChartKind {
    Sphere,
    Frame,
}

impl ChartKind {
    /// Dimension of the manifold.
    pub fn dimension(self) -> usize {
        match self {
            ChartKind::Sphere => 2,
            ChartKind::Frame => 3,
        }
    }

    /// Number of entries of a state.
    pub fn width(self) -> usize {
        4 * self.dimension()
    }

    /// Number of columns of a point.
    pub fn columns(self) -> usize {
        self.dimension() - 1
    }

    /// Name of the constructor.
    pub fn name(self) -> &'static str {
        match self {
            ChartKind::Sphere => "sphere",
            ChartKind::Frame => "frame",
        }
    }
}

/// Reads a state from its numbers.
pub fn state<const N: usize>(row: &[f64]) -> SVector<f64, N> {
    SVector::from_column_slice(row)
}

/// Error `NonFinite` if a number is NaN or infinite.
pub fn check_finite(name: &'static str, row: &[f64]) -> Result<()> {
    structure::check_finite(name, MatRef::from_column_major_slice(row, row.len(), 1))
}

/// Writes states one after another.
pub fn write_states<const Z: usize>(states: &[SVector<f64, Z>], out: &mut [f64]) {
    for (state, target) in states.iter().zip(out.chunks_mut(Z)) {
        target.copy_from_slice(state.as_slice());
    }
}

/// Evaluate an expression, generic in the chart, for the chart of a [`ChartKind`]: `on_chart!(kind, chart => expression)`.
macro_rules! on_chart {
    ($kind:expr, $chart:ident => $value:expr) => {
        match $kind {
            ChartKind::Sphere => {
                let $chart = &crate::chart::Sphere;
                $value
            }
            ChartKind::Frame => {
                let $chart = &crate::chart::Frame;
                $value
            }
        }
    };
}
pub(super) use on_chart;

/// The discretization map with a given name.
pub fn map_of(name: &str) -> PyResult<NamedMap> {
    NamedMap::from_name(name).ok_or_else(|| {
        let names: Vec<_> = NamedMap::all()
            .map(|(known, _)| format!("'{known}'"))
            .collect();
        invalid!("map: must be one of {}, found '{name}'", names.join(", "))
    })
}

/// Equal steps of the method of a map over `[0, t_end]`.
#[derive(Clone, Copy)]
pub struct Steps {
    pub map: NamedMap,
    pub composition: Composition,
    pub count: usize,
    pub t_end: f64,
}

impl Steps {
    /// `order` is the order of the method; by default the order of the map.
    pub fn read(map: &str, order: Option<i64>, steps: i64, t_end: f64) -> PyResult<Self> {
        let map = map_of(map)?;
        let base = DiscretizationMap::<4>::order(&map);
        // A negative order is as invalid as 0, and gets the same message.
        let order = order.map_or(base, |order| usize::try_from(order).unwrap_or(0));
        Ok(Steps {
            map,
            composition: Composition::new(base, order)?,
            count: count("steps", steps, 1)?,
            t_end,
        })
    }
}
