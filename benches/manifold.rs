//! Riemannian exponential and logarithm, compared with the retraction and its inverse.

use std::f64::consts::PI;
use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use faer::Mat;
use stiefel_rs::{Metric, QuasiGeodesic, Stiefel};

#[path = "../tests/common/mod.rs"]
mod common;
use common::*;

const SHAPES: [(usize, usize); 4] = [(4, 2), (50, 5), (200, 20), (1000, 50)];

struct Pair {
    manifold: Stiefel,
    s0: Mat<f64>,
    v: Mat<f64>,
    s1: Mat<f64>,
}

fn pair((n, k): (usize, usize), distance: f64, metric: Metric) -> Pair {
    let manifold = Stiefel::new(n, k).unwrap().with_metric(metric);
    let mut rng = Rng::new(7);
    let s0 = random_point(n, k, &mut rng);
    let v = random_tangent(&s0, distance, &mut rng);
    let s1 = manifold.exp(s0.as_ref(), v.as_ref()).unwrap();
    let found = manifold.log(s0.as_ref(), s1.as_ref()).unwrap();
    assert_close(&found, &v, 1e-10, "the logarithm inverts the exponential");
    Pair {
        manifold,
        s0,
        v,
        s1,
    }
}

/// One pair of points per call, at a short and at a long distance.
fn logarithm(c: &mut Criterion) {
    for (name, metric) in [
        ("canonical", Metric::CANONICAL),
        ("euclidean", Metric::EUCLIDEAN),
    ] {
        let mut group = c.benchmark_group(format!("log/{name}"));
        for (n, k) in SHAPES {
            for (label, distance) in [("0.5", 0.5), ("0.89 pi", 0.89 * PI)] {
                // The Euclidean length is up to sqrt(2) times the canonical one.
                let shrink = (0.5 / metric.weight()).sqrt();
                let p = pair((n, k), shrink * distance, metric);
                let id = BenchmarkId::new(format!("St({n},{k})"), label);
                group.bench_function(id, |b| {
                    b.iter(|| {
                        p.manifold
                            .log(black_box(p.s0.as_ref()), p.s1.as_ref())
                            .unwrap()
                    });
                });
            }
        }
        group.finish();
    }
}

fn exponential(c: &mut Criterion) {
    let mut group = c.benchmark_group("exp");
    for (n, k) in SHAPES {
        let p = pair((n, k), 0.5, Metric::CANONICAL);
        group.bench_function(BenchmarkId::from_parameter(format!("St({n},{k})")), |b| {
            b.iter(|| {
                p.manifold
                    .exp(black_box(p.s0.as_ref()), p.v.as_ref())
                    .unwrap()
            });
        });
    }
    group.finish();
}

/// The cost of the quasi-geodesic through the same points.
fn quasi_geodesic(c: &mut Criterion) {
    let mut group = c.benchmark_group("inverse retraction");
    for (n, k) in SHAPES {
        let p = pair((n, k), 0.5, Metric::CANONICAL);
        group.bench_function(BenchmarkId::from_parameter(format!("St({n},{k})")), |b| {
            b.iter(|| QuasiGeodesic::between(black_box(p.s0.as_ref()), p.s1.as_ref()).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, logarithm, exponential, quasi_geodesic);
criterion_main!(benches);
