//! Riemannian cubics as curves: reference data, the equation, what is conserved, symmetries, special cases.

#[path = "../common/mod.rs"]
mod common;

mod equation;
mod intervals;
mod special_cases;
mod states;
