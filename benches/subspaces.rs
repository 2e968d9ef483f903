//! Curves of subspaces beside curves of frames through the same matrices: bases that were made near to one another.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::*;
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use faer::{Mat, MatRef, Scale};
use stiefel_rs::cubic::{IntegrationOptions, RiemannianCubic};
use stiefel_rs::spline::{EndConditions, SplineOptions, cubic_spline};
use stiefel_rs::{Grassmann, Quotient};

/// `(n, k)` and knots.
const PROBLEMS: [((usize, usize), usize); 5] = [
    ((3, 1), 50),
    ((4, 2), 50),
    ((8, 3), 20),
    ((50, 5), 12),
    ((2000, 6), 12),
];

const QUOTIENTS: [(&str, Quotient); 2] = [
    ("frames", Quotient::Frames),
    ("subspaces", Quotient::Subspaces),
];

/// A horizontal vector of a length.
fn horizontal(y: &Mat<f64>, length: f64, rng: &mut Rng) -> Mat<f64> {
    let (n, k) = y.shape();
    let v = project_off(y, &gaussian(n, k, rng));
    let norm = v.norm_l2();
    v * Scale(length / norm)
}

/// Bases at unit times, `step` apart.
fn walk((n, k): (usize, usize), count: usize, step: f64) -> (Vec<f64>, Vec<Mat<f64>>) {
    let mut rng = Rng::new(1);
    let manifold = Grassmann::new(n, k).unwrap();
    let mut points = vec![random_point(n, k, &mut rng)];
    for i in 1..count {
        let v = horizontal(&points[i - 1], step, &mut rng);
        points.push(manifold.exp(points[i - 1].as_ref(), v.as_ref()).unwrap());
    }
    ((0..count).map(|i| i as f64).collect(), points)
}

fn splines(c: &mut Criterion) {
    let mut group = c.benchmark_group("subspaces_spline");
    group.sample_size(10);
    for ((n, k), count) in PROBLEMS {
        let (t, points) = walk((n, k), count, 0.6);
        let views: Vec<MatRef<'_, f64>> = points.iter().map(Mat::as_ref).collect();
        for (name, quotient) in QUOTIENTS {
            let options = SplineOptions {
                quotient,
                ..SplineOptions::default()
            };
            let ends = EndConditions::Natural;
            let find = || cubic_spline(&t, black_box(&views), &ends, &options).unwrap();
            println!("({n}, {k}), {name}: {}", find().1);
            let id = BenchmarkId::new(name, format!("{n}_{k}_knots_{count}"));
            group.bench_function(id, |b| b.iter(find));
        }
    }
    group.finish();
}

fn initial_values(c: &mut Criterion) {
    let mut group = c.benchmark_group("subspaces_initial");
    for (n, k) in [(3, 1), (4, 2), (8, 3), (50, 5)] {
        let mut rng = Rng::new(2);
        let y = random_point(n, k, &mut rng);
        let [v, a, j] = [1.0, 2.0, 4.0].map(|length| horizontal(&y, length, &mut rng));
        let [y, v, a, j] = [&y, &v, &a, &j].map(Mat::as_ref);
        for (name, quotient) in QUOTIENTS {
            let options = IntegrationOptions {
                quotient,
                ..IntegrationOptions::default()
            };
            let integrate = || RiemannianCubic::from_initial(y, v, a, j, &options).unwrap();
            let id = BenchmarkId::new(name, format!("{n}_{k}"));
            group.bench_function(id, |b| b.iter(|| black_box(integrate())));
        }
    }
    group.finish();
}

criterion_group!(benches, splines, initial_values);
criterion_main!(benches);
