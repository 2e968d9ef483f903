//! The paper's two experiments as test problems.
#![allow(dead_code)] // each binary uses a part

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use nalgebra::SVector;
use stiefel_rs::chart::{Chart, Frame, Sphere};

/// Initial coordinate derivatives of orders 0 to 3 on the sphere.
pub const SPHERE: [&[f64]; 4] = [&[FRAC_PI_2, PI], &[0.1, 0.2], &[1.0, 0.5], &[0.1, 0.2]];

/// The same on St(3,2).
pub const FRAME: [&[f64]; 4] = [
    &[FRAC_PI_4, PI, PI],
    &[0.1, 0.1, 0.05],
    &[1.0, 0.3, 0.5],
    &[0.1, 0.1, 0.05],
];

/// The initial state on the sphere.
pub fn sphere() -> SVector<f64, 8> {
    initial_state(&Sphere, SPHERE)
}

/// The initial state on St(3,2).
pub fn frame() -> SVector<f64, 12> {
    initial_state(&Frame, FRAME)
}

fn initial_state<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    data: [&[f64]; 4],
) -> SVector<f64, Z> {
    let momenta = chart.momenta(data[0], data[1], data[2], data[3]).unwrap();
    SVector::from_iterator([data[0], data[1], momenta.as_slice()].concat())
}
