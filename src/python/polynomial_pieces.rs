//! What de Casteljau curves of the binding are made of: quasi-geodesics or geodesics.

use std::sync::Arc;

use super::curve::AnyCurve;
use super::prelude::*;
use crate::curve::{GeodesicPolynomial, GeometricCubic, GeometricPolynomial};

/// What a polynomial is made of.
pub(super) enum Pieces {
    QuasiGeodesic(Arc<GeometricPolynomial>),
    Geodesic(Arc<GeodesicPolynomial>),
}

/// Evaluate an expression for the curve of [`Pieces`]: `on_pieces!(pieces, curve => expression)`.
macro_rules! on_pieces {
    ($pieces:expr, $curve:ident => $value:expr) => {
        match $pieces {
            Pieces::QuasiGeodesic($curve) => $value,
            Pieces::Geodesic($curve) => $value,
        }
    };
}

impl From<GeometricPolynomial> for Pieces {
    fn from(curve: GeometricPolynomial) -> Self {
        Pieces::QuasiGeodesic(Arc::new(curve))
    }
}

impl From<GeometricCubic> for Pieces {
    fn from(curve: GeometricCubic) -> Self {
        GeometricPolynomial::from(curve).into()
    }
}

impl From<GeodesicPolynomial> for Pieces {
    fn from(curve: GeodesicPolynomial) -> Self {
        Pieces::Geodesic(Arc::new(curve))
    }
}

impl Pieces {
    pub(super) fn name(&self) -> &'static str {
        match self {
            Pieces::QuasiGeodesic(_) => QUASI_GEODESIC,
            Pieces::Geodesic(_) => GEODESIC,
        }
    }

    pub(super) fn curve(&self) -> Arc<dyn AnyCurve> {
        on_pieces!(self, curve => Arc::clone(curve) as _)
    }

    pub(super) fn control_points(&self) -> Vec<Mat<f64>> {
        on_pieces!(self, curve => curve.control_points())
    }

    pub(super) fn degree(&self) -> usize {
        on_pieces!(self, curve => curve.degree())
    }
}

pub(super) const QUASI_GEODESIC: &str = "quasi_geodesic";
const GEODESIC: &str = "geodesic";

/// Whether a word says that pieces are geodesics.
pub(super) fn is_geodesic(pieces: &str) -> PyResult<bool> {
    match pieces {
        QUASI_GEODESIC => Ok(false),
        GEODESIC => Ok(true),
        _ => Err(invalid!(
            "pieces: expected '{QUASI_GEODESIC}' or '{GEODESIC}', found {pieces:?}"
        )),
    }
}

/// The curve with control points `P`, shape (degree + 1, n, k).
pub(super) fn polynomial(P: &Any, pieces: &str) -> PyResult<Pieces> {
    let geodesic = is_geodesic(pieces)?;
    let batch = Batch::read(P, "P", "(degree + 1, n, k)")?;
    run(P.py(), batch.numbers(), move |_| {
        Ok(match geodesic {
            true => GeodesicPolynomial::new(&batch.views())?.into(),
            false => GeometricPolynomial::new(&batch.views())?.into(),
        })
    })
}
