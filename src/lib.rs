//! Smooth curves on Stiefel manifolds.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod chart;
pub mod curve;
pub mod error;
pub mod interrupt;
pub mod linalg;
pub mod manifold;
pub mod newton;
#[cfg(feature = "python")]
mod python;
pub mod report;

pub use curve::{Curve, GeometricCubic, Quantity};
pub use error::{Error, Result};
pub use interrupt::Interrupt;
pub use linalg::{orthogonal_log, skew_exp};
pub use manifold::{QuasiGeodesic, Stiefel};
pub use report::{SolverReport, StopReason};
