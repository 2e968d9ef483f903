//! Boundary value problems: what is solved by which method, and what several solutions are found by.

pub(crate) mod at_nodes;
pub(crate) mod batch;
pub(crate) mod continuation;
pub(crate) mod descent_start;
pub(crate) mod end_equations;
pub(crate) mod few_dimensions;
pub(crate) mod from_boundary;
pub(crate) mod guess;
pub(crate) mod homotopy;
pub(crate) mod lines;
pub(crate) mod low_cost;
pub(crate) mod problem;
pub(crate) mod random;
pub(crate) mod relative_ends;
pub(crate) mod search;
pub(crate) mod shooting;
pub(crate) mod short_legs;
pub(crate) mod solution;
pub(crate) mod solver;
