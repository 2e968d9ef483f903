//! Trajectories of the method in the embedding, and the exact cubics for comparison.
#![allow(dead_code)] // each binary uses a part

use faer::Mat;
use stiefel_rs::cubic::{CubicTrajectory, IntegrationOptions, RiemannianCubic, integrate_embedded};
use stiefel_rs::{Curve, Error, Interrupt};

use crate::trajectories::{Data, state};

/// The circle, the sphere, `n = k`, `n < 2k`, `n = 4k`, and tall shapes that are computed in fewer dimensions.
pub const SHAPES: [(usize, usize); 11] = [
    (1, 1),
    (2, 1),
    (3, 1),
    (3, 2),
    (3, 3),
    (5, 2),
    (5, 3),
    (4, 4),
    (8, 2),
    (20, 2),
    (20, 4),
];

pub fn try_embedded(data: &Data, steps: usize, t_end: f64) -> Result<CubicTrajectory, Error> {
    let [s, v, a, j] = data.each_ref().map(Mat::as_ref);
    integrate_embedded(s, v, a, j, steps, t_end, Interrupt::NEVER)
}

pub fn embedded(data: &Data, steps: usize, t_end: f64) -> CubicTrajectory {
    try_embedded(data, steps, t_end).unwrap_or_else(|e| panic!("{:?}: {e}", data[0].shape()))
}

pub fn embedded_end(data: &Data, steps: usize, t_end: f64) -> Data {
    state(&embedded(data, steps, t_end), steps)
}

/// The exact cubic and its covariant derivatives.
pub fn exact(data: &Data, t: f64) -> Data {
    let [s, v, a, j] = data.each_ref().map(Mat::as_ref);
    let options = IntegrationOptions {
        t_end: t,
        ..IntegrationOptions::default()
    };
    let curve = RiemannianCubic::from_initial(s, v, a, j, &options, Interrupt::NEVER).unwrap();
    [
        curve.point(t).unwrap(),
        curve.derivative(t, 1).unwrap(),
        curve.acceleration(t).unwrap(),
        curve.jerk(t).unwrap(),
    ]
}
