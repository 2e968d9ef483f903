//! The paper's charts: Riemannian cubics as Hamiltonian systems in coordinates of `St(3,1)` and `St(3,2)`.
//!
//! A state is `z = (q, qdot, p_q, p_qdot)`, four groups of `d` numbers. The Hamiltonian of both charts is a sum of
//! monomials in the state whose coefficients depend on the polar angle `theta` alone, so a chart is given by a table of
//! terms ([`Term`]); value, exact gradient and Hessian, momenta and Taylor series all follow from the table.
//!
//! # Source
//! arXiv 2404.19407, sections on `St(3,1)` and `St(3,2)`; Crouch, Silva Leite (1995) for the equations.

pub mod atlas;
#[expect(clippy::module_inception, reason = "the trait")]
mod chart;
pub mod composition;
pub mod covariant;
pub mod discretization;
mod elimination;
mod frame;
pub mod integrator;
pub mod jet;
mod named_map;
pub mod reference;
mod retraction_map;
pub mod rotation;
#[cfg(feature = "python")]
pub(crate) mod rows;
pub mod series;
pub mod shooting;
mod sphere;
mod tangent_lift;
mod term;

pub use atlas::{AtlasState, integrate_across};
pub use chart::Chart;
pub use composition::Composition;
pub use covariant::{CovariantData, covariant_from_state, state_from_covariant};
pub use discretization::{DiscretizationMap, LinearMap};
pub use frame::Frame;
pub use integrator::{
    integrate, integrate_composed, integrate_composed_with_tangent, integrate_with_tangent,
};
pub use named_map::NamedMap;
pub use reference::{reference, reference_across};
pub use retraction_map::{RetractionMap, SpaceRetraction};
pub use shooting::{Shooting, ShootingOptions, shoot};
pub use sphere::Sphere;
pub use term::Term;
