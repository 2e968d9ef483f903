//! Quasi-geodesics: from a velocity, between two points, and the symmetries of both.

#[path = "../common/mod.rs"]
mod common;

mod between_points;
mod ends;
mod from_velocity;
mod symmetries;
