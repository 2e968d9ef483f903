//! Estimated work of calls: a constant times the number of entries that they read or compute.
//!
//! It decides whether a call runs on another thread and how a batch is divided; results do not depend on it.

use crate::cubic::RiemannianCubic;
use crate::curve::{Curve, GeodesicPolynomial, GeometricCubic, GeometricPolynomial, Quantity};
use crate::manifold::{Geodesic, QuasiGeodesic};
use crate::spline::Piecewise;

/// Operations per entry of products and factorisations of thin matrices.
pub const PRODUCTS: f64 = 1e3;

/// Operations per entry of exponentials, logarithms and de Casteljau's algorithm.
pub const EXPONENTIALS: f64 = 1e4;

/// Operations per entry of Newton's method for a boundary problem.
pub const SOLVES: f64 = 3e5;

/// Operations per entry of a point to evaluate a curve.
pub trait Work {
    /// For a position.
    const POINT: f64;

    /// Once in addition if a parameter is outside of `t_span`, for curves that are integrated on.
    const BEYOND: f64 = 0.0;
}

impl Work for QuasiGeodesic {
    const POINT: f64 = 100.0;
}

impl Work for Geodesic {
    const POINT: f64 = 100.0;
}

impl Work for GeometricCubic {
    const POINT: f64 = 500.0;
}

impl Work for GeometricPolynomial {
    const POINT: f64 = 500.0;
}

/// Every stage takes a logarithm.
impl Work for GeodesicPolynomial {
    const POINT: f64 = 1e4;
}

impl Work for RiemannianCubic {
    const POINT: f64 = 100.0;
    const BEYOND: f64 = 1e5;
}

impl<C: Curve + Work> Work for Piecewise<C> {
    const POINT: f64 = C::POINT;
    const BEYOND: f64 = C::BEYOND;
}

/// Time of a derivative relative to that of a position.
const DERIVATIVES: f64 = 10.0;

/// Estimated operations to evaluate a curve at parameters.
pub fn evaluation<C: Curve + Work>(curve: &C, t: &[f64], quantity: Quantity) -> f64 {
    let (start, end) = curve.t_span();
    let beyond = |t: &f64| *t < start.min(end) || *t > start.max(end);
    let each = match quantity {
        Quantity::Derivative(0) => C::POINT,
        _ => DERIVATIVES * C::POINT,
    };
    let once = if t.iter().any(beyond) { C::BEYOND } else { 0.0 };
    (t.len() as f64 * each + once) * (curve.n() * curve.k()) as f64
}
