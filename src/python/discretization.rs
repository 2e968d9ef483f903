//! The discretization maps by name, and the order of a composition.

use nalgebra::SVector;
use pyo3::prelude::*;

use super::error::{invalid_input, to_exception};
use crate::chart::discretization::{Blocks, Expansion};
use crate::chart::{Composition, DiscretizationMap, LinearMap, RetractionMap, SpaceRetraction};

/// A discretization map that has a name.
#[derive(Debug, Clone, Copy)]
pub enum NamedMap {
    Linear(LinearMap),
    Retraction(RetractionMap),
}

const RETRACTIONS: [(&str, &str, SpaceRetraction); 3] = [
    (
        "exponential",
        "exponential_midpoint",
        SpaceRetraction::Exponential,
    ),
    ("cayley", "cayley_midpoint", SpaceRetraction::Cayley),
    (
        "quasi_geodesic",
        "quasi_geodesic_midpoint",
        SpaceRetraction::QuasiGeodesic,
    ),
];

impl NamedMap {
    /// All maps with their names.
    fn all() -> impl Iterator<Item = (&'static str, NamedMap)> {
        let linear = [
            ("initial_point", LinearMap::INITIAL_POINT),
            ("midpoint", LinearMap::MIDPOINT),
        ];
        let lifted = RETRACTIONS
            .into_iter()
            .flat_map(|(first, second, retraction)| {
                [
                    (first, RetractionMap::initial_point(retraction)),
                    (second, RetractionMap::midpoint(retraction)),
                ]
            });
        linear
            .into_iter()
            .map(|(name, map)| (name, NamedMap::Linear(map)))
            .chain(lifted.map(|(name, map)| (name, NamedMap::Retraction(map))))
    }

    /// The map of a name.
    pub fn read(py: Python<'_>, name: &str) -> PyResult<Self> {
        if let Some((_, map)) = NamedMap::all().find(|(known, _)| *known == name) {
            return Ok(map);
        }
        let names: Vec<String> = NamedMap::all()
            .map(|(known, _)| format!("'{known}'"))
            .collect();
        let names = names.join(", ");
        let message = format!("map: must be one of {names}, found '{name}'");
        Err(invalid_input(py, message))
    }

    /// The composition that raises this map's method to the order; its own for `None`.
    pub fn composition(self, py: Python<'_>, order: Option<i64>) -> PyResult<Composition> {
        let base = match self {
            NamedMap::Linear(map) => DiscretizationMap::<4>::order(&map),
            NamedMap::Retraction(map) => DiscretizationMap::<4>::order(&map),
        };
        let order = match order.map(usize::try_from) {
            None => base,
            Some(Ok(order)) => order,
            // No composition either; the message of order 0.
            Some(Err(_)) => 0,
        };
        Composition::new(base, order).map_err(|error| to_exception(py, &error, ""))
    }
}

impl<const X: usize> DiscretizationMap<X> for NamedMap
where
    RetractionMap: DiscretizationMap<X>,
{
    fn map(&self, x: &SVector<f64, X>, v: &SVector<f64, X>) -> [SVector<f64, X>; 2] {
        match self {
            NamedMap::Linear(map) => map.map(x, v),
            NamedMap::Retraction(map) => map.map(x, v),
        }
    }

    fn jacobian(&self, x: &SVector<f64, X>, v: &SVector<f64, X>) -> Blocks<X> {
        match self {
            NamedMap::Linear(map) => map.jacobian(x, v),
            NamedMap::Retraction(map) => map.jacobian(x, v),
        }
    }

    fn second_derivative(
        &self,
        x: &SVector<f64, X>,
        v: &SVector<f64, X>,
        lambda: &[SVector<f64, X>; 2],
    ) -> Blocks<X> {
        match self {
            NamedMap::Linear(map) => map.second_derivative(x, v, lambda),
            NamedMap::Retraction(map) => map.second_derivative(x, v, lambda),
        }
    }

    fn expansion(
        &self,
        x: &SVector<f64, X>,
        v: &SVector<f64, X>,
        lambda: &[SVector<f64, X>; 2],
    ) -> Expansion<X> {
        match self {
            NamedMap::Linear(map) => map.expansion(x, v, lambda),
            NamedMap::Retraction(map) => map.expansion(x, v, lambda),
        }
    }

    fn order(&self) -> usize {
        match self {
            NamedMap::Linear(map) => DiscretizationMap::<X>::order(map),
            NamedMap::Retraction(map) => DiscretizationMap::<X>::order(map),
        }
    }
}
