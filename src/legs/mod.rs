//! Legs in a row between knots: what every solver of a chain of Riemannian cubics takes and gives.

mod dense;
mod knots;
mod options;

pub(crate) use dense::{Curves, Dense, Polynomials};
pub(crate) use knots::{End, Ends, Knots};
pub(crate) use options::{Options, Progress, ThirdDerivative};
