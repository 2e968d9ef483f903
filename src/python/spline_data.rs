//! What splines of the binding are made from: times, points, the kind of their pieces, and options.

use super::knots::times;
use super::prelude::*;
use crate::spline::Outside;

/// What a kind of spline is made of.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    Riemannian,
    Geometric,
}

impl Kind {
    pub(super) fn name(self) -> &'static str {
        match self {
            Kind::Riemannian => "riemannian",
            Kind::Geometric => "geometric",
        }
    }

    pub(super) fn read(kind: &str) -> PyResult<Self> {
        let known = [Kind::Riemannian, Kind::Geometric];
        known
            .into_iter()
            .find(|known| known.name() == kind)
            .ok_or_else(|| invalid!("kind: expected 'riemannian' or 'geometric', found {kind:?}"))
    }
}

/// Times and points of a spline.
pub(super) struct Data {
    pub(super) t: Vec<f64>,
    pub(super) points: Batch,
}

impl Data {
    pub(super) fn read(t: &Any, points: &Any) -> PyResult<Self> {
        Ok(Data {
            t: times(t)?,
            points: Batch::read(points, "S", "(N, n, k)")?,
        })
    }

    pub(super) fn shape(&self) -> (usize, usize) {
        (self.points.rows, self.points.cols)
    }

    /// A call that finds pieces.
    pub(super) fn call<'py>(&self, py: Python<'py>, threads: Option<i64>) -> PyResult<Call<'py>> {
        Call::new(py, threads, SOLVES * self.points.numbers())
    }
}

/// Error where a tolerance is out of its range.
pub(super) fn check_tolerance(tol: f64) -> PyResult<()> {
    if (1e-15..=0.1).contains(&tol) {
        return Ok(());
    }
    let (name, requirement, found) = ("tol", "between 1e-15 and 0.1", tol);
    Err(Error::InvalidArgument {
        name,
        requirement,
        found,
    }
    .into())
}

pub(super) fn outside(extrapolate: bool) -> Outside {
    match extrapolate {
        true => Outside::Continued,
        false => Outside::Refused,
    }
}
