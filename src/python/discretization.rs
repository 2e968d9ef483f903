//! The discretization maps by name, and the order of a composition.

use nalgebra::SVector as Vector;

use super::prelude::*;
use crate::chart::discretization::{Blocks, Expansion};
use crate::chart::{Composition, DiscretizationMap, LinearMap, RetractionMap, SpaceRetraction};

/// A discretization map that has a name.
#[derive(Debug, Clone, Copy)]
pub enum NamedMap {
    Linear(LinearMap),
    Retraction(RetractionMap),
}

/// Evaluate an expression for the map of a [`NamedMap`]: `on_map!(named, map => expression)`.
macro_rules! on_map {
    ($named:expr, $map:ident => $value:expr) => {
        match $named {
            NamedMap::Linear($map) => $value,
            NamedMap::Retraction($map) => $value,
        }
    };
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
        let linear = linear.map(|(name, map)| (name, NamedMap::Linear(map)));
        let lifted = lifted.map(|(name, map)| (name, NamedMap::Retraction(map)));
        linear.into_iter().chain(lifted)
    }

    /// The map of a name.
    pub fn read(name: &str) -> PyResult<Self> {
        if let Some((_, map)) = NamedMap::all().find(|(known, _)| *known == name) {
            return Ok(map);
        }
        let names: Vec<_> = NamedMap::all()
            .map(|(known, _)| format!("'{known}'"))
            .collect();
        Err(invalid!(
            "map: must be one of {}, found '{name}'",
            names.join(", ")
        ))
    }

    /// The composition that raises this map's method to the order; its own for `None`.
    fn composition(self, order: Option<i64>) -> PyResult<Composition> {
        let base = DiscretizationMap::<4>::order(&self);
        // No composition has a negative order either; the message is that of order 0.
        let order = order.map_or(base, |order| usize::try_from(order).unwrap_or(0));
        Ok(Composition::new(base, order)?)
    }
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
    pub fn read(map: &str, order: Option<i64>, steps: i64, t_end: f64) -> PyResult<Self> {
        let map = NamedMap::read(map)?;
        Ok(Steps {
            map,
            composition: map.composition(order)?,
            count: count("steps", steps, 1)?,
            t_end,
        })
    }
}

impl<const X: usize> DiscretizationMap<X> for NamedMap
where
    RetractionMap: DiscretizationMap<X>,
{
    fn map(&self, x: &Vector<f64, X>, v: &Vector<f64, X>) -> [Vector<f64, X>; 2] {
        on_map!(self, map => map.map(x, v))
    }

    fn jacobian(&self, x: &Vector<f64, X>, v: &Vector<f64, X>) -> Blocks<X> {
        on_map!(self, map => map.jacobian(x, v))
    }

    fn second_derivative(
        &self,
        x: &Vector<f64, X>,
        v: &Vector<f64, X>,
        lambda: &[Vector<f64, X>; 2],
    ) -> Blocks<X> {
        on_map!(self, map => map.second_derivative(x, v, lambda))
    }

    fn expansion(
        &self,
        x: &Vector<f64, X>,
        v: &Vector<f64, X>,
        lambda: &[Vector<f64, X>; 2],
    ) -> Expansion<X> {
        on_map!(self, map => map.expansion(x, v, lambda))
    }

    fn order(&self) -> usize {
        on_map!(self, map => DiscretizationMap::<X>::order(map))
    }
}
