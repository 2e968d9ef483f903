//! Trajectories of the explicit splitting from random data, and their states.
#![allow(dead_code)] // each binary uses a part

use faer::Mat;
use stiefel_rs::cubic::{CubicTrajectory, SplittingOptions, SplittingOrder, integrate_cubic};
use stiefel_rs::{Error, Interrupt};

use crate::common::*;

pub const ORDERS: [SplittingOrder; 4] = [
    SplittingOrder::Two,
    SplittingOrder::Four,
    SplittingOrder::Six,
    SplittingOrder::Eight,
];

/// Point, velocity, acceleration, jerk.
pub type Data = [Mat<f64>; 4];

pub fn options(order: SplittingOrder, t_end: f64) -> SplittingOptions {
    SplittingOptions {
        t_end,
        order,
        ..SplittingOptions::default()
    }
}

pub fn try_integrate(
    data: &Data,
    steps: usize,
    order: SplittingOrder,
    t_end: f64,
) -> Result<CubicTrajectory, Error> {
    let [s, v, a, j] = data.each_ref().map(Mat::as_ref);
    integrate_cubic(s, v, a, j, steps, &options(order, t_end), Interrupt::NEVER)
}

pub fn integrate(data: &Data, steps: usize, order: SplittingOrder, t_end: f64) -> CubicTrajectory {
    try_integrate(data, steps, order, t_end)
        .unwrap_or_else(|e| panic!("{:?}: {e}", data[0].shape()))
}

/// The state of a trajectory at one step.
pub fn state(trajectory: &CubicTrajectory, i: usize) -> Data {
    [
        trajectory.points(),
        trajectory.velocities(),
        trajectory.accelerations(),
        trajectory.jerks(),
    ]
    .map(|samples| samples.unwrap().get(i).to_owned())
}

pub fn end(data: &Data, steps: usize, order: SplittingOrder, t_end: f64) -> Data {
    state(&integrate(data, steps, order, t_end), steps)
}

pub fn random_data((n, k): (usize, usize), speed: f64, seed: u64) -> Data {
    let mut rng = Rng::new(seed);
    let s = random_point(n, k, &mut rng);
    let mut tangent = || random_tangent(&s, speed, &mut rng);
    let (v, a, j) = (tangent(), tangent(), tangent());
    [s, v, a, j]
}

pub fn difference(a: &Data, b: &Data) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| distance(a, b).powi(2));
    squares.sum::<f64>().sqrt()
}

pub fn size(data: &Data) -> f64 {
    data.iter().map(|m| frobenius(m.as_ref())).sum()
}
