//! What de Casteljau curves of the binding are made of, quasi-geodesics or geodesics, and what they cost.

use std::sync::Arc;

use faer::Mat;
use pyo3::prelude::*;

use super::call::Call;
use super::convert::stack;
use super::curve::{AnyCurve, Operations, cube};
use super::error::invalid_input;
use crate::curve::{Curve, GeodesicPolynomial, GeometricCubic, GeometricPolynomial, Quantity};

impl Operations for GeometricPolynomial {
    fn operations(&self, quantity: Quantity) -> f64 {
        polynomial_operations(self.k(), self.degree(), quantity)
    }
}

fn polynomial_operations(k: usize, degree: usize, quantity: Quantity) -> f64 {
    let joins = 0.5 * (degree * degree) as f64;
    match quantity {
        Quantity::Derivative(0) => joins * (30.0 + 30.0 * cube(k)),
        _ => joins * (5e3 + 5e3 * cube(k)),
    }
}

impl Operations for GeometricCubic {
    fn operations(&self, quantity: Quantity) -> f64 {
        polynomial_operations(self.k(), 3, quantity)
    }
}

impl Operations for GeodesicPolynomial {
    fn operations(&self, quantity: Quantity) -> f64 {
        let joins = 0.5 * (self.degree() * self.degree()) as f64;
        match quantity {
            // Rotations, whose geodesics are in closed form.
            Quantity::Derivative(0) if self.n() == self.k() + 1 => {
                joins * (30.0 + 30.0 * cube(self.n()))
            }
            Quantity::Derivative(0) => joins * (2e4 + 2e3 * cube(self.k())),
            // A linear system of the dimension of the reduced manifold for each stage.
            _ => joins * (1e5 + 1e4 * cube(self.k()) * cube(self.k())),
        }
    }
}

/// What a polynomial is made of.
#[derive(Clone)]
pub(super) enum Pieces {
    QuasiGeodesic(Arc<GeometricPolynomial>),
    Geodesic(Arc<GeodesicPolynomial>),
}

impl Pieces {
    pub(super) fn curve(&self) -> Arc<dyn AnyCurve> {
        match self {
            Pieces::QuasiGeodesic(curve) => Arc::clone(curve) as Arc<dyn AnyCurve>,
            Pieces::Geodesic(curve) => Arc::clone(curve) as Arc<dyn AnyCurve>,
        }
    }

    pub(super) fn control_points(&self) -> Vec<Mat<f64>> {
        match self {
            Pieces::QuasiGeodesic(curve) => curve.control_points(),
            Pieces::Geodesic(curve) => curve.control_points(),
        }
    }

    pub(super) fn degree(&self) -> usize {
        match self {
            Pieces::QuasiGeodesic(curve) => curve.degree(),
            Pieces::Geodesic(curve) => curve.degree(),
        }
    }
}

pub(super) const QUASI_GEODESIC: &str = "quasi_geodesic";
pub(super) const GEODESIC: &str = "geodesic";

/// Whether a word says that pieces are geodesics.
pub(super) fn is_geodesic(py: Python<'_>, pieces: &str) -> PyResult<bool> {
    match pieces {
        QUASI_GEODESIC => Ok(false),
        GEODESIC => Ok(true),
        _ => {
            let message =
                format!("pieces: expected '{QUASI_GEODESIC}' or '{GEODESIC}', found {pieces:?}");
            Err(invalid_input(py, message))
        }
    }
}

/// Rough operations of a construction: the span, and the branch at some tens of parameters.
pub(super) fn construction((n, k): (usize, usize), degree: usize) -> f64 {
    let (n, k, degree) = (n as f64, k as f64, degree as f64);
    let columns = (degree + 1.0) * k;
    1e4 + 4.0 * n * columns * columns.min(n) + 1e3 * degree * degree * (1.0 + k * k * k)
}

/// Rough operations of a search for control points: derivatives by differences, and their factorisation, some times.
pub(super) fn search((n, k): (usize, usize), degree: usize) -> f64 {
    let (n, k, degree) = (n as f64, k as f64, degree as f64);
    let rows = n.min(4.0 * k);
    let unknowns = (degree - 3.0).max(0.0) * rows * k;
    let differences = 16.0 * unknowns * degree * degree * (100.0 + 50.0 * k * k * k);
    let factorisation = 64.0 * rows * k * unknowns * unknowns;
    1e4 + 4.0 * n * rows * rows + 5.0 * (differences + factorisation)
}

/// The curve with control points `P`, shape (degree + 1, n, k).
#[allow(non_snake_case)]
pub(super) fn polynomial(py: Python<'_>, P: &Bound<'_, PyAny>, pieces: &str) -> PyResult<Pieces> {
    let geodesic = is_geodesic(py, pieces)?;
    let batch = stack(P, "P", "(degree + 1, n, k)")?;
    let (shape, degree) = ((batch.rows, batch.cols), batch.len().saturating_sub(1));
    let call = Call::new(py, None, construction(shape, degree))?;
    call.run(py, move |_| {
        let points = batch.views();
        Ok(if geodesic {
            Pieces::Geodesic(Arc::new(GeodesicPolynomial::new(&points)?))
        } else {
            Pieces::QuasiGeodesic(Arc::new(GeometricPolynomial::new(&points)?))
        })
    })
}
