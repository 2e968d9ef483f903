//! Geometric cubics: end conditions, agreement with the algorithm, derivatives, and sampling.

#[path = "../common/mod.rs"]
mod common;

mod algorithm;
mod bad_input;
mod end_conditions;
mod sampling;
