//! The Stiefel manifold: membership, projections, metric, and the paper's parametrisation.

#[path = "../common/mod.rs"]
mod common;

mod membership;
mod metric;
mod parametrisation;
mod projections;
mod shapes;
