//! Continuity of splines and of their derivatives at the knots.

use faer::{Mat, Scale};
use stiefel_rs::spline::{EndConditions, Piecewise, SplineOptions, cubic_spline};
use stiefel_rs::{Curve, Interrupt, RiemannianCubic, SolverReport};

use crate::common::distance;
use crate::knots::views;

pub const SHAPES: [(usize, usize); 9] = [
    (1, 1),
    (2, 1),
    (3, 1),
    (5, 1),
    (3, 2),
    (3, 3),
    (4, 2),
    (6, 3),
    (4, 4),
];

/// Defects of the legs of at most 1e-12, and round-off of the evaluation.
pub const MET: f64 = 1e-11;

/// Covariant acceleration at the knots of unequal legs, `1e-12 / h^2`.
pub const SMOOTH: f64 = 1e-10;

pub fn spline(
    t: &[f64],
    points: &[Mat<f64>],
    ends: &EndConditions,
) -> (Piecewise<RiemannianCubic>, SolverReport) {
    let found = cubic_spline(
        t,
        &views(points),
        ends,
        &SplineOptions::default(),
        Interrupt::NEVER,
    );
    found.unwrap_or_else(|error| panic!("{:?}: {error}", points[0].shape()))
}

pub fn jump(
    curve: &Piecewise<RiemannianCubic>,
    quantity: impl Fn(&RiemannianCubic, f64, f64) -> Mat<f64>,
) -> f64 {
    let knots = curve.knots();
    let lengths: Vec<f64> = knots.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let pieces = curve.pieces();
    (1..pieces.len())
        .map(|i| {
            let before = quantity(&pieces[i - 1], 1.0, lengths[i - 1]);
            distance(&before, &quantity(&pieces[i], 0.0, lengths[i]))
        })
        .fold(0.0, f64::max)
}

pub fn velocity(piece: &RiemannianCubic, u: f64, h: f64) -> Mat<f64> {
    piece.derivative(u, 1).unwrap() * Scale(1.0 / h)
}

pub fn acceleration(piece: &RiemannianCubic, u: f64, h: f64) -> Mat<f64> {
    piece.acceleration(u).unwrap() * Scale(1.0 / (h * h))
}
