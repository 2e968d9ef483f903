//! Geometric cubics: end conditions, agreement with the paper's algorithm, derivatives, and sampling.

#[path = "../common/mod.rs"]
mod common;

mod bad_input;
mod end_conditions;
mod paper_algorithm;
mod sampling;
