//! The steps of a method that is named by its discretization map.

use super::prelude::*;
use crate::chart::{Composition, DiscretizationMap, NamedMap};

/// The discretization map of a name.
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
    /// `order` is that of the method: by default that of the map.
    pub fn read(map: &str, order: Option<i64>, steps: i64, t_end: f64) -> PyResult<Self> {
        let map = map_of(map)?;
        let base = DiscretizationMap::<4>::order(&map);
        // No composition has a negative order either; the message is that of order 0.
        let order = order.map_or(base, |order| usize::try_from(order).unwrap_or(0));
        Ok(Steps {
            map,
            composition: Composition::new(base, order)?,
            count: count("steps", steps, 1)?,
            t_end,
        })
    }
}
