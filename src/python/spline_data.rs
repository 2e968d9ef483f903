//! What splines of the binding are made from: times, points and the kind of their pieces.

use faer::Mat;
use pyo3::prelude::*;

use super::convert::{Batch, stack};
use super::error::invalid_input;
use super::knots::times;
use super::polynomial_pieces::construction;
use super::riemannian_cubic::shooting;

pub(super) const RIEMANNIAN: &str = "riemannian";
pub(super) const GEOMETRIC: &str = "geometric";

/// What a kind of spline is made of.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    Riemannian,
    Geometric,
}

impl Kind {
    pub(super) fn read(py: Python<'_>, kind: &str) -> PyResult<Self> {
        match kind {
            RIEMANNIAN => Ok(Kind::Riemannian),
            GEOMETRIC => Ok(Kind::Geometric),
            _ => {
                let message =
                    format!("kind: expected '{RIEMANNIAN}' or '{GEOMETRIC}', found {kind:?}");
                Err(invalid_input(py, message))
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
    pub(super) fn read(t: &Bound<'_, PyAny>, points: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Data {
            t: times(t)?,
            points: stack(points, "S", "(N, n, k)")?,
        })
    }

    pub(super) fn shape(&self) -> (usize, usize) {
        (self.points.rows, self.points.cols)
    }

    /// Rough operations of a boundary value problem for every leg, with vectors like these as velocities.
    pub(super) fn legs(&self, kind: Kind, vectors: &Batch) -> f64 {
        let one = match kind {
            Kind::Riemannian => {
                let [s, v] = [&self.points, vectors].map(|batch| match batch.len() {
                    0 => Mat::zeros(1, 1),
                    _ => batch.get(0).to_owned(),
                });
                shooting([&s, &v, &s, &v])
            }
            Kind::Geometric => construction(self.shape(), 3),
        };
        one * self.points.len() as f64
    }

    /// Rough operations of a spline: as many for every leg, after a factorisation that reduces the dimension.
    pub(super) fn joints(&self, kind: Kind) -> f64 {
        self.legs(kind, &self.points) + self.reduction()
    }

    /// Rough operations of quasi-geodesics between all neighbours.
    pub(super) fn links(&self) -> f64 {
        let (n, k) = self.shape();
        construction((n, k), 1) * self.points.len() as f64 + self.reduction()
    }

    /// Rough operations of the factorisation that reduces the dimension.
    fn reduction(&self) -> f64 {
        let (n, columns) = (
            self.points.rows as f64,
            (self.points.len() * self.points.cols) as f64,
        );
        4.0 * n * columns * columns.min(n)
    }
}
