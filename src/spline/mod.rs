//! Splines: curves through many points.
//!
//! * [`cubic_spline`]: [`Piecewise`] Riemannian cubics with continuous covariant acceleration;
//! * [`geometric_spline`]: [`Piecewise`] geometric cubics with the same smoothness, by closed formulas at the knots;
//! * [`smoothing_spline`]: curves that balance closeness to data against cost;
//! * [`cubic_hermite`], [`geometric_hermite`]: once differentiable curves through points with given velocities;
//! * [`estimate_velocities`]: velocities when only points are known.

mod ambient;
mod ambient_solver;
mod bases;
mod chain;
mod data_variation;
mod derivative;
mod descent;
mod embedded;
mod end_accelerations;
mod ends;
mod framed;
mod framed_solver;
mod generalised_cross_validation;
mod geometric;
mod geometric_subspaces;
mod given;
mod grouped;
mod hermite;
mod interpolation;
mod iteration;
mod knot_gradient;
mod knot_states;
mod knot_system;
mod knots;
mod linearised;
mod links;
mod low_cost;
mod motion;
mod neighbours;
mod options;
pub mod piecewise;
mod reduced_knots;
mod riemannian;
mod smoothing;
mod smoothing_equations;
mod smoothing_preconditioner;
mod solution;
mod solve;
mod spline_ends;
#[cfg(any(feature = "python", feature = "serde"))]
mod stored;
#[cfg(feature = "python")]
pub(crate) mod stored_values;
mod straight;
mod subspace_batch;
mod subspace_boundary;
pub(crate) mod subspace_problem;
mod subspace_search;
mod velocities;

pub use data_variation::{SplineGradient, SplineVariation};
pub use derivative::SplineDerivative;
pub use ends::{EndCondition, EndConditions};
pub use geometric::geometric_spline;
pub use geometric_subspaces::{geometric_subspace_hermite, geometric_subspace_spline};
pub use hermite::{cubic_hermite, geometric_hermite, subspace_hermite};
pub use options::SplineOptions;
pub use piecewise::{Outside, Piecewise};
pub use riemannian::cubic_spline;
pub(crate) use riemannian::cubic_spline_of_legs;
pub use smoothing::{SmoothingOptions, SmoothingSpline, smoothing_spline};
pub use subspace_batch::solve_subspace_boundary;
pub use velocities::{VelocityEstimate, estimate_closed_velocities, estimate_velocities};
