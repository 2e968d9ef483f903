//! The Riemannian logarithm: inverse of the exponential, reports, symmetry, bad input.

mod common;

use std::f64::consts::PI;

use common::*;
use faer::{Mat, Scale};
use stiefel_rs::{Metric, Stiefel};

/// Shapes of the population test.
const POPULATION: [(usize, usize); 8] = [
    (3, 1),
    (3, 2),
    (4, 2),
    (4, 3),
    (4, 4),
    (10, 3),
    (50, 5),
    (200, 20),
];

/// Distance up to which a logarithm must be found.
const REACH: f64 = 0.89 * PI;

/// Random pairs `(S0, V)` with `V` of canonical norm up to `REACH`: log must return `V`.
fn population(shape: (usize, usize), count: usize, seed: u64) -> (usize, usize, f64, f64) {
    let (n, k) = shape;
    let manifold = Stiefel::new(n, k).unwrap();
    let mut rng = Rng::new(seed);
    let (mut failures, mut most, mut sum, mut worst) = (0, 0, 0, 0.0_f64);
    for i in 0..count {
        let s0 = random_point(n, k, &mut rng);
        // A half of them at the far end, where it is hard.
        let d = if i % 2 == 0 {
            REACH
        } else {
            REACH * rng.uniform()
        };
        let v = random_tangent(&s0, d, &mut rng);
        let s1 = manifold.exp(s0.as_ref(), v.as_ref()).unwrap();
        match manifold.log_with_report(s0.as_ref(), s1.as_ref()) {
            Ok((found, report)) => {
                let error = distance(&found, &v);
                let angle = frobenius(found.as_ref());
                assert!(report.residual < 1e-11 && report.converged);
                // On SO(n) the principal logarithm is shorter than a long geodesic through a closed one.
                if error > 1e-9 {
                    println!(
                        "{shape:?} {i}: d {d:.4}, |log - V| = {error:.2e}, |V| {angle:.4}, {report:?}"
                    );
                    failures += 1;
                } else {
                    worst = worst.max(error);
                }
                most = most.max(report.iterations);
                sum += report.iterations;
            }
            Err(error) => {
                println!("{shape:?} {i}: d {d:.4}, {error}");
                failures += 1;
            }
        }
    }
    (failures, most, sum as f64 / count as f64, worst)
}

fn assert_population(count: usize, seed: u64) {
    for shape in POPULATION {
        let (failures, most, mean, worst) = population(shape, count, seed);
        println!(
            "St{shape:?}: {failures} failures of {count}, at most {most} iterations, mean {mean:.2}, \
             largest |log - V| {worst:.1e}"
        );
        assert_eq!(failures, 0, "{shape:?}");
        assert!(most <= 10, "{shape:?}: {most} iterations");
    }
}

#[test]
fn log_returns_the_velocity_of_random_pairs() {
    assert_population(300, 1);
}

#[test]
#[ignore = "ten thousand pairs per shape take minutes"]
fn log_returns_the_velocity_of_ten_thousand_pairs() {
    assert_population(10_000, 2);
}
