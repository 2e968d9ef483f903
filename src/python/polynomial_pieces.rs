//! What de Casteljau curves of the binding are made of: quasi-geodesics or geodesics.

use std::sync::Arc;

use faer::Mat;
use pyo3::prelude::*;

use super::batch::Batch;
use super::call::run;
use super::convert::Any;
use super::curve::AnyCurve;
use super::error::invalid_input;
use super::work::EXPONENTIALS;
use crate::curve::{GeodesicPolynomial, GeometricPolynomial};

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
pub(super) fn is_geodesic(pieces: &str) -> PyResult<bool> {
    match pieces {
        QUASI_GEODESIC => Ok(false),
        GEODESIC => Ok(true),
        _ => {
            let message =
                format!("pieces: expected '{QUASI_GEODESIC}' or '{GEODESIC}', found {pieces:?}");
            Err(invalid_input(message))
        }
    }
}

/// The curve with control points `P`, shape (degree + 1, n, k).
#[allow(non_snake_case)]
pub(super) fn polynomial(P: &Any<'_>, pieces: &str) -> PyResult<Pieces> {
    let geodesic = is_geodesic(pieces)?;
    let batch = Batch::read((P, "P"), "(degree + 1, n, k)")?;
    run(P.py(), EXPONENTIALS * batch.numbers(), move |_| {
        let points = batch.views();
        Ok(if geodesic {
            Pieces::Geodesic(Arc::new(GeodesicPolynomial::new(&points)?))
        } else {
            Pieces::QuasiGeodesic(Arc::new(GeometricPolynomial::new(&points)?))
        })
    })
}
