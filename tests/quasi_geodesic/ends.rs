//! Quasi-geodesics from a velocity and between points, and how they meet their ends.

use faer::Mat;
use stiefel_rs::{Curve, QuasiGeodesic};

use crate::common::distance;

pub const TIMES: [f64; 7] = [-1.3, 0.0, 0.25, 0.5, 0.9, 1.0, 2.2];

pub fn between(s0: &Mat<f64>, s1: &Mat<f64>) -> QuasiGeodesic {
    QuasiGeodesic::between(s0.as_ref(), s1.as_ref())
        .unwrap_or_else(|e| panic!("{:?}: {e}", s0.shape()))
}

pub fn shoot(s: &Mat<f64>, v: &Mat<f64>) -> QuasiGeodesic {
    QuasiGeodesic::from_velocity(s.as_ref(), v.as_ref())
        .unwrap_or_else(|e| panic!("{:?}: {e}", s.shape()))
}

/// Largest distance of the end points of `curve` from `s0`, `s1`.
pub fn end_error(curve: &QuasiGeodesic, s0: &Mat<f64>, s1: &Mat<f64>) -> f64 {
    distance(&curve.point(0.0).unwrap(), s0).max(distance(&curve.point(1.0).unwrap(), s1))
}
