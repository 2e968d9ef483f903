//! Curvature: compared with brackets of full size, Gauss's equation, spheres, rotations and holonomy; and its
//! symmetries.

#[path = "../common/mod.rs"]
mod common;

mod holonomy;
mod metrics;
mod quotient;
mod sectional;
mod tensor;
