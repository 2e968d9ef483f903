//! Retractions: their equations, their orders against the geodesic, their inverses and the borders of these.

#[path = "../common/mod.rs"]
mod common;

mod bad_input;
mod equations;
mod inverses;
mod orders;
mod vectors;
