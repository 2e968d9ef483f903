//! Curves of subspaces compared with curves of frames through the same matrices, whose bases are aligned.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::*;
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use faer::{Mat, MatRef, Scale};
use stiefel_rs::cubic::{IntegrationOptions, RiemannianCubic};
use stiefel_rs::spline::{EndConditions, SplineOptions, cubic_spline};
use stiefel_rs::{Grassmann, Interrupt, Quotient};

/// `(n, k)` and number of knots.
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

/// A horizontal vector of the given length.
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
            let find =
                || cubic_spline(&t, black_box(&views), &ends, &options, Interrupt::NEVER).unwrap();
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
            let integrate =
                || RiemannianCubic::from_initial(y, v, a, j, &options, Interrupt::NEVER).unwrap();
            let id = BenchmarkId::new(name, format!("{n}_{k}"));
            group.bench_function(id, |b| b.iter(|| black_box(integrate())));
        }
    }
    group.finish();
}

/// Subspaces whose mean squared angle is 0.01 or 0.6.
fn logarithms(c: &mut Criterion) {
    let mut group = c.benchmark_group("subspaces_logarithm");
    for (n, k) in [(4, 2), (50, 5), (200, 20), (1000, 50)] {
        let (mut rng, m) = (Rng::new(3), Grassmann::new(n, k).unwrap());
        let y0 = random_point(n, k, &mut rng);
        for (name, square) in [("near", 0.01), ("far", 0.6)] {
            let v = horizontal(&y0, (square * k as f64).sqrt(), &mut rng);
            let y1 = m.exp(y0.as_ref(), v.as_ref()).unwrap();
            let y1 = &y1 * random_orthogonal(k, &mut rng);
            let (y0, y1) = (y0.as_ref(), y1.as_ref());
            let id = |function: &str| BenchmarkId::new(function, format!("{n}_{k}_{name}"));
            group.bench_function(id("log"), |b| b.iter(|| m.log(black_box(y0), y1).unwrap()));
            group.bench_function(id("dist"), |b| b.iter(|| m.dist(black_box(y0), y1)));
            group.bench_function(id("principal_angles"), |b| {
                b.iter(|| m.principal_angles(black_box(y0), y1).unwrap());
            });
        }
    }
    group.finish();
}

criterion_group!(benches, splines, initial_values, logarithms);
criterion_main!(benches);
