//! Retractions: their equations, their orders compared with the geodesic, their inverses and the domains of these.

#[path = "../common/mod.rs"]
mod common;

mod bad_input;
mod equations;
mod inverses;
mod orders;
mod vectors;
