//! Riemannian cubics from boundary data: success rates, symmetries, bad data, several solutions.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/boundary.rs"]
mod data;

mod at_nodes;
mod bad_data;
mod batch;
mod known_solutions;
mod random_data;
mod several_solutions;
mod special_data;
