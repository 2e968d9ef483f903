//! Splines of geometric cubics compared with splines of Riemannian cubics: computing them, and evaluating them.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::*;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use faer::{Mat, MatRef};
use stiefel_rs::spline::{EndConditions, SplineOptions, cubic_spline, geometric_spline};
use stiefel_rs::{Curve, Interrupt, Quantity, Stiefel};

/// `(n, k)` and number of knots.
const PROBLEMS: [((usize, usize), usize); 7] = [
    ((3, 1), 50),
    ((3, 2), 10),
    ((3, 2), 200),
    ((3, 3), 200),
    ((5, 2), 50),
    ((10, 3), 20),
    ((20, 4), 30),
];

/// The geometric spline alone: its cost is linear in the knots and in `n`.
const LARGE: [((usize, usize), usize); 4] = [
    ((3, 2), 100),
    ((3, 2), 1000),
    ((3, 2), 10_000),
    ((1000, 5), 100),
];

/// Points per call.
const POINTS: usize = 1001;

/// Knots at unit times, `step` apart.
fn walk((n, k): (usize, usize), count: usize, step: f64) -> (Vec<f64>, Vec<Mat<f64>>) {
    let mut rng = Rng::new(1);
    let manifold = Stiefel::new(n, k).unwrap();
    let mut points = vec![random_point(n, k, &mut rng)];
    for i in 1..count {
        let v = random_tangent(&points[i - 1], step, &mut rng);
        let next = retract(&points[i - 1], &v);
        points.push(manifold.project(next.as_ref()).unwrap());
    }
    ((0..count).map(|i| i as f64).collect(), points)
}

fn id(((n, k), knots): ((usize, usize), usize)) -> String {
    format!("{n}_{k}_knots_{knots}")
}

fn find(c: &mut Criterion) {
    let mut group = c.benchmark_group("spline_find");
    group.sample_size(10);
    let (ends, options) = (EndConditions::Natural, SplineOptions::default());
    for problem in PROBLEMS {
        let (t, points) = walk(problem.0, problem.1, 0.6);
        let views: Vec<MatRef<'_, f64>> = points.iter().map(Mat::as_ref).collect();
        let geometric =
            || geometric_spline(&t, black_box(&views), &ends, &options, Interrupt::NEVER).unwrap();
        let riemannian =
            || cubic_spline(&t, black_box(&views), &ends, &options, Interrupt::NEVER).unwrap();
        println!("{}: {} | {}", id(problem), geometric().1, riemannian().1);
        group.bench_function(BenchmarkId::new("geometric", id(problem)), |b| {
            b.iter(geometric)
        });
        group.bench_function(BenchmarkId::new("riemannian", id(problem)), |b| {
            b.iter(riemannian)
        });
    }
    group.finish();
}

fn find_large(c: &mut Criterion) {
    let mut group = c.benchmark_group("spline_find_large");
    group.sample_size(10);
    let (ends, options) = (EndConditions::Natural, SplineOptions::default());
    for problem in LARGE {
        let (t, points) = walk(problem.0, problem.1, 0.6);
        let views: Vec<MatRef<'_, f64>> = points.iter().map(Mat::as_ref).collect();
        let geometric =
            || geometric_spline(&t, black_box(&views), &ends, &options, Interrupt::NEVER).unwrap();
        println!("{}: {}", id(problem), geometric().1);
        group.throughput(Throughput::Elements(problem.1 as u64));
        group.bench_function(id(problem), |b| b.iter(geometric));
    }
    group.finish();
}

fn evaluate(c: &mut Criterion) {
    let mut group = c.benchmark_group("spline_evaluate");
    group.throughput(Throughput::Elements(POINTS as u64));
    let (ends, options) = (EndConditions::Natural, SplineOptions::default());
    for problem in [((3, 2), 50), ((10, 3), 20)] {
        let (t, points) = walk(problem.0, problem.1, 0.6);
        let views: Vec<MatRef<'_, f64>> = points.iter().map(Mat::as_ref).collect();
        let (geometric, _) =
            geometric_spline(&t, &views, &ends, &options, Interrupt::NEVER).unwrap();
        let (riemannian, _) = cubic_spline(&t, &views, &ends, &options, Interrupt::NEVER).unwrap();
        let last = t[t.len() - 1];
        let times: Vec<f64> = (0..POINTS)
            .map(|i| last * i as f64 / (POINTS - 1) as f64)
            .collect();
        let quantity = Quantity::Derivative(0);
        group.bench_function(BenchmarkId::new("geometric", id(problem)), |b| {
            b.iter(|| geometric.sample(black_box(&times), quantity, Interrupt::NEVER))
        });
        group.bench_function(BenchmarkId::new("riemannian", id(problem)), |b| {
            b.iter(|| riemannian.sample(black_box(&times), quantity, Interrupt::NEVER))
        });
    }
    group.finish();
}

criterion_group!(benches, find, find_large, evaluate);
criterion_main!(benches);
