//! Knots of splines.
#![allow(dead_code)] // each binary uses a part

use faer::{Mat, MatRef};
use stiefel_rs::spline::{EndConditions, Piecewise, SplineOptions, cubic_spline};
use stiefel_rs::{Result, RiemannianCubic, SolverReport, Stiefel};

use crate::common::{Rng, counted, random_point, random_tangent};

/// A random walk of points with steps of the given length, at unequal times.
pub fn walk(
    shape: (usize, usize),
    count: usize,
    step: f64,
    seed: u64,
) -> (Vec<f64>, Vec<Mat<f64>>) {
    let mut rng = Rng::new(seed);
    let manifold = Stiefel::new(shape.0, shape.1).unwrap();
    let mut points = vec![random_point(shape.0, shape.1, &mut rng)];
    let mut t = vec![0.5];
    for i in 1..count {
        let v = random_tangent(&points[i - 1], step, &mut rng);
        let next = manifold.exp(points[i - 1].as_ref(), v.as_ref()).unwrap();
        // Removes the round-off of many steps.
        points.push(manifold.project(next.as_ref()).unwrap());
        t.push(t[i - 1] + rng.between(0.5, 1.5));
    }
    (t, points)
}

pub fn views(points: &[Mat<f64>]) -> Vec<MatRef<'_, f64>> {
    points.iter().map(Mat::as_ref).collect()
}

/// The natural spline, and how often it polled the interrupt.
pub fn counted_spline(
    t: &[f64],
    points: &[Mat<f64>],
) -> (usize, Result<(Piecewise<RiemannianCubic>, SolverReport)>) {
    counted(|interrupt| {
        let (ends, options) = (EndConditions::Natural, SplineOptions::default());
        cubic_spline(t, &views(points), &ends, &options, interrupt)
    })
}
