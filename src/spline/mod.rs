//! Splines: curves through many points.
//!
//! * [`Piecewise`] Riemannian cubics with continuous covariant acceleration: [`cubic_spline`];
//! * once differentiable curves through points with given velocities: [`cubic_hermite`], [`geometric_hermite`].

mod ends;
mod hermite;
mod joints;
mod knots;
pub mod piecewise;
mod riemannian;
mod start;
#[cfg(any(feature = "python", feature = "serde"))]
mod stored;

pub use ends::{EndCondition, EndConditions};
pub use hermite::{cubic_hermite, geometric_hermite};
pub use piecewise::{Outside, Piecewise};
pub use riemannian::{SplineOptions, cubic_spline};
