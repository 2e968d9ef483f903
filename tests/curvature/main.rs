//! Curvature: against brackets of full size, Gauss's equation, spheres, rotations, holonomy, and its symmetries.

#[path = "../common/mod.rs"]
mod common;

mod holonomy;
mod metrics;
mod quotient;
mod sectional;
mod tensor;
