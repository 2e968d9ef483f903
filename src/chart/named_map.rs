//! Discretization maps by name.

use nalgebra::SVector as Vector;

use super::discretization::{Blocks, DiscretizationMap, Expansion, LinearMap};
use super::retraction_map::{RetractionMap, SpaceRetraction};

/// A discretization map with a name: `"initial_point"`, `"midpoint"`, or the name of a retraction map, such as
/// `"cayley"` or `"cayley_midpoint"`.
///
/// # Examples
/// ```
/// use stiefel_rs::chart::{DiscretizationMap, NamedMap};
/// let map = NamedMap::from_name("cayley_midpoint").expect("one of the names");
/// assert_eq!(DiscretizationMap::<4>::order(&map), 2);
/// assert!(NamedMap::all().any(|(name, _)| name == "midpoint"));
/// ```
#[derive(Debug, Clone, Copy)]
pub enum NamedMap {
    /// Linear in coordinates.
    Linear(LinearMap),
    /// From a retraction of space.
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
    pub fn all() -> impl Iterator<Item = (&'static str, NamedMap)> {
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

    /// The map with the given name.
    pub fn from_name(name: &str) -> Option<Self> {
        let mut all = NamedMap::all();
        all.find_map(|(known, map)| (known == name).then_some(map))
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
