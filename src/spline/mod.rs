//! Splines: curves through many points.
//!
//! * [`Piecewise`] Riemannian cubics with continuous covariant acceleration: [`cubic_spline`];
//! * the balance of closeness to data and cost: [`smoothing_spline`];
//! * once differentiable curves through points with given velocities: [`cubic_hermite`], [`geometric_hermite`].

mod ambient;
mod chain;
mod continuation;
mod ends;
mod fit;
mod framed;
mod hermite;
mod interpolation;
mod iteration;
mod joints;
mod knots;
mod mixing;
pub mod piecewise;
mod riemannian;
mod smoothing;
mod solve;
#[cfg(any(feature = "python", feature = "serde"))]
mod stored;
mod tridiagonal;
mod validation;

pub use ends::{EndCondition, EndConditions};
pub use hermite::{cubic_hermite, geometric_hermite};
pub use piecewise::{Outside, Piecewise};
pub use riemannian::{SplineOptions, cubic_spline};
pub use smoothing::{SmoothingOptions, SmoothingSpline, smoothing_spline};
