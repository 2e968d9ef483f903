//! Riemannian cubics to round-off: initial value problems, points of the dense output, boundary value problems.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::*;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use faer::Mat;
use stiefel_rs::cubic::{BoundaryOptions, IntegrationOptions};
use stiefel_rs::{Curve, Interrupt, Quantity, RiemannianCubic};

const SHAPES: [(usize, usize); 5] = [(3, 1), (3, 2), (10, 3), (50, 5), (1000, 5)];

/// Points per call: the time per element is the time per point.
const POINTS: usize = 1000;

/// Distance of the ends, and both end speeds.
const LENGTH: f64 = 1.5;

fn id((n, k): (usize, usize)) -> BenchmarkId {
    BenchmarkId::from_parameter(format!("{n}_{k}"))
}

/// Position, velocity, covariant acceleration and jerk of lengths 1, 1, 2, 3.
fn random_state((n, k): (usize, usize)) -> [Mat<f64>; 4] {
    let mut rng = Rng::new(1);
    let s = random_point(n, k, &mut rng);
    let [v, a, j] = [1.0, 2.0, 3.0].map(|norm| random_tangent(&s, norm, &mut rng));
    [s, v, a, j]
}

fn from_initial(state: &[Mat<f64>; 4]) -> RiemannianCubic {
    let [s, v, a, j] = state.each_ref().map(Mat::as_ref);
    RiemannianCubic::from_initial(s, v, a, j, &IntegrationOptions::default(), Interrupt::NEVER)
        .unwrap()
}

fn from_boundary(b: &Boundary) -> RiemannianCubic {
    let [s0, v0, s1, v1] = [&b.s0, &b.v0, &b.s1, &b.v1].map(Mat::as_ref);
    RiemannianCubic::from_boundary(
        s0,
        v0,
        s1,
        v1,
        &BoundaryOptions::default(),
        Interrupt::NEVER,
    )
    .unwrap()
}

fn paper(name: &str) -> serde_json::Value {
    let entries: Vec<serde_json::Value> =
        serde_json::from_str(include_str!("../tests/data/cubics.json")).unwrap();
    entries.into_iter().find(|e| e["name"] == name).unwrap()
}

fn matrix(rows: &serde_json::Value) -> Mat<f64> {
    let rows = rows.as_array().unwrap();
    Mat::from_fn(rows.len(), rows[0].as_array().unwrap().len(), |i, j| {
        rows[i][j].as_f64().unwrap()
    })
}

fn initial(c: &mut Criterion) {
    let mut group = c.benchmark_group("cubic_initial");
    let entry = paper("paper-sphere");
    let state = ["point", "velocity", "acceleration", "jerk"].map(|x| matrix(&entry["initial"][x]));
    let end = matrix(&entry["at"]["1.0"]["point"]);
    assert!(distance(&from_initial(&state).point(1.0).unwrap(), &end) < 10.0 * EPS);
    group.bench_function("paper_sphere", |b| {
        b.iter(|| from_initial(black_box(&state)))
    });
    for shape in SHAPES {
        let state = random_state(shape);
        let [again, ..] = from_initial(&state).initial().unwrap();
        assert!(distance(&again, &state[0]) < 10.0 * shape.0 as f64 * EPS);
        group.bench_function(id(shape), |b| b.iter(|| from_initial(black_box(&state))));
    }
    group.finish();
}

fn points(c: &mut Criterion) {
    let mut group = c.benchmark_group("cubic_points");
    group.throughput(Throughput::Elements(POINTS as u64));
    let single = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let t: Vec<f64> = (0..POINTS)
        .map(|i| i as f64 / (POINTS - 1) as f64)
        .collect();
    for shape in SHAPES {
        let curve = from_initial(&random_state(shape));
        group.bench_function(id(shape), |b| {
            b.iter(|| {
                single
                    .install(|| {
                        curve.sample(black_box(&t), Quantity::Derivative(0), Interrupt::NEVER)
                    })
                    .unwrap()
            })
        });
    }
    group.finish();
}

fn boundary(c: &mut Criterion) {
    let mut group = c.benchmark_group("cubic_boundary");
    let papers = ["paper-sphere", "paper-stiefel-3-2"].map(|name| {
        let entry = paper(name);
        let [start, end] = [&entry["initial"], &entry["at"]["1.0"]];
        let b = Boundary {
            s0: matrix(&start["point"]),
            v0: matrix(&start["velocity"]),
            s1: matrix(&end["point"]),
            v1: matrix(&end["velocity"]),
        };
        (BenchmarkId::from_parameter(name), b)
    });
    let random = SHAPES[2..].iter().map(|&shape| {
        let b = Boundary::random(shape, LENGTH, LENGTH, &mut Rng::new(1));
        (id(shape), b)
    });
    for (id, data) in papers.into_iter().chain(random) {
        let curve = from_boundary(&data);
        // The solver's tolerance, and the round-off of this measurement.
        assert!(distance(&curve.point(1.0).unwrap(), &data.s1) < 2e-12);
        group.bench_function(id, |b| b.iter(|| from_boundary(black_box(&data))));
    }
    group.finish();
}

criterion_group!(benches, initial, points, boundary);
criterion_main!(benches);
