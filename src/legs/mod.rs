//! Chains of legs between knots: the data shared by all solvers of a chain of Riemannian cubics.

mod dense;
mod knots;
mod options;

pub(crate) use dense::{Curves, Dense, Polynomials};
pub(crate) use knots::{End, Ends, Knots};
#[cfg(test)]
pub(crate) use options::ThirdDerivative;
pub(crate) use options::{Options, Progress};
