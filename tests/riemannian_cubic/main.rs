//! Riemannian cubics as curves: reference data, the equation, conserved quantities, symmetries, special cases.

#[path = "../common/mod.rs"]
mod common;

mod equation;
mod intervals;
mod special_cases;
mod states;
