//! Chains of legs between knots: the data shared by all solvers of a chain of Riemannian cubics.
//!
//! The start derivatives of a leg are `x'` (the covariant acceleration) and `x''` (the third vector) at its start, in
//! the time of the leg.

mod dense;
mod knots;
mod options;

pub(crate) use dense::{Curves, Dense, Polynomials, RotationSeries};
pub(crate) use knots::{End, Ends, Knots};
pub(crate) use options::{Options, Progress};
