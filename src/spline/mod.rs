//! Splines: curves through many points.
//!
//! * [`cubic_spline`]: [`Piecewise`] Riemannian cubics with continuous covariant acceleration;
//! * [`geometric_spline`]: [`Piecewise`] geometric cubics with the same smoothness, by closed formulas at the knots;
//! * [`smoothing_spline`]: curves that balance closeness to data against cost;
//! * [`cubic_hermite`], [`geometric_hermite`]: once differentiable curves through points with given velocities;
//! * [`estimate_velocities`]: velocities when only points are known.

mod bases;
pub(crate) mod chains;
mod ends;
pub(crate) mod geometric;
mod hermite;
mod joining_curves;
mod knots;
mod near_rotations;
mod options;
pub mod piecewise;
mod reduced_knots;
mod riemannian;
pub(crate) mod sensitivity;
pub(crate) mod smoothing;
#[cfg(any(feature = "python", feature = "serde"))]
mod stored;
#[cfg(feature = "python")]
pub(crate) mod stored_values;

pub use ends::{EndCondition, EndConditions};
pub use geometric::geometric_spline::geometric_spline;
pub use geometric::geometric_subspaces::{geometric_subspace_hermite, geometric_subspace_spline};
pub use geometric::velocities::{
    VelocityEstimate, estimate_closed_velocities, estimate_velocities,
};
pub use hermite::{cubic_hermite, geometric_hermite};
pub(crate) use knots::check_times;
pub(crate) use near_rotations::{SolvedRotations, near_rotations};
pub use options::SplineOptions;
pub use piecewise::{Outside, Piecewise};
pub use riemannian::cubic_spline;
pub(crate) use riemannian::cubic_spline_of_legs;
pub use sensitivity::data_variation::{SplineGradient, SplineVariation};
pub use sensitivity::derivative::SplineDerivative;
pub use smoothing::smoothing_options::SmoothingOptions;
pub use smoothing::smoothing_spline::{SmoothingSpline, smoothing_spline};
