//! What splines of the binding are made from: times, points, the kind of their pieces, and options.

use pyo3::prelude::*;

use super::batch::Batch;
use super::convert::Any;
use super::error::invalid_input;
use super::knots::times;
use super::work::{EXPONENTIALS, SOLVES};
use crate::error::Error;
use crate::spline::Outside;

pub(super) const RIEMANNIAN: &str = "riemannian";
pub(super) const GEOMETRIC: &str = "geometric";

/// What a kind of spline is made of.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    Riemannian,
    Geometric,
}

impl Kind {
    pub(super) fn read(kind: &str) -> PyResult<Self> {
        match kind {
            RIEMANNIAN => Ok(Kind::Riemannian),
            GEOMETRIC => Ok(Kind::Geometric),
            _ => {
                let message =
                    format!("kind: expected '{RIEMANNIAN}' or '{GEOMETRIC}', found {kind:?}");
                Err(invalid_input(message))
            }
        }
    }
}

/// Times and points of a spline.
pub(super) struct Data {
    pub(super) t: Vec<f64>,
    pub(super) points: Batch,
}

impl Data {
    pub(super) fn read(t: &Any<'_>, points: &Any<'_>) -> PyResult<Self> {
        Ok(Data {
            t: times(t)?,
            points: Batch::read((points, "S"), "(N, n, k)")?,
        })
    }

    pub(super) fn shape(&self) -> (usize, usize) {
        (self.points.rows, self.points.cols)
    }

    /// Estimated operations to find the pieces.
    pub(super) fn operations(&self, kind: Kind) -> f64 {
        let each = match kind {
            Kind::Riemannian => SOLVES,
            Kind::Geometric => EXPONENTIALS,
        };
        each * self.points.numbers()
    }
}

/// Error where a tolerance is out of its range.
pub(super) fn check_tolerance(tol: f64) -> PyResult<()> {
    if (1e-15..=0.1).contains(&tol) {
        return Ok(());
    }
    let error = Error::InvalidArgument {
        name: "tol",
        requirement: "between 1e-15 and 0.1",
        found: tol,
    };
    Err(error.into())
}

pub(super) fn outside(extrapolate: bool) -> Outside {
    if extrapolate {
        Outside::Continued
    } else {
        Outside::Refused
    }
}
