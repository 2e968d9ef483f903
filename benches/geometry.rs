//! Retractions and their inverses, parallel transport, curvature, gradients.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::{Rng, distance, gaussian, random_point, random_tangent};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use faer::Mat;
use stiefel_rs::{ParallelTransport, Retraction, Stiefel};

const SHAPES: [(usize, usize); 5] = [(3, 1), (3, 2), (50, 5), (300, 10), (1000, 50)];

/// A point and three tangent vectors of norm 1.
fn data(n: usize, k: usize) -> (Mat<f64>, [Mat<f64>; 3]) {
    let mut rng = Rng::new((100 * n + k) as u64);
    let s = random_point(n, k, &mut rng);
    let vectors = std::array::from_fn(|_| random_tangent(&s, 1.0, &mut rng));
    (s, vectors)
}

fn retraction(c: &mut Criterion) {
    let mut group = c.benchmark_group("retraction");
    for (n, k) in SHAPES {
        let shape = format!("St({n},{k})");
        let (s, [v, ..]) = data(n, k);
        for retraction in Retraction::ALL {
            let end = retraction.retract(s.as_ref(), v.as_ref()).unwrap();
            let back = retraction
                .inverse_retract(s.as_ref(), end.as_ref())
                .unwrap();
            assert!(
                distance(&back, &v) < 1e-12,
                "the inverse undoes the retraction"
            );
            let name = retraction.name();
            group.bench_function(BenchmarkId::new(name, &shape), |b| {
                b.iter(|| retraction.retract(black_box(s.as_ref()), v.as_ref()));
            });
            group.bench_function(BenchmarkId::new(format!("{name}_inverse"), &shape), |b| {
                b.iter(|| retraction.inverse_retract(black_box(s.as_ref()), end.as_ref()));
            });
        }
    }
    group.finish();
}

fn transport(c: &mut Criterion) {
    let mut group = c.benchmark_group("transport");
    for (n, k) in SHAPES {
        let shape = format!("St({n},{k})");
        let (s, [v, w, _]) = data(n, k);
        let manifold = Stiefel::new(n, k).unwrap();
        let along = ParallelTransport::new(manifold, s.as_ref(), v.as_ref()).unwrap();
        let moved = along.transport(w.as_ref()).unwrap();
        let length = manifold.norm(along.end().as_ref(), moved.as_ref()).unwrap();
        assert!((length - 1.0).abs() < 1e-13, "transport is isometric");
        group.bench_function(BenchmarkId::new("new", &shape), |b| {
            b.iter(|| ParallelTransport::new(manifold, black_box(s.as_ref()), v.as_ref()));
        });
        group.bench_function(BenchmarkId::new("transport", &shape), |b| {
            b.iter(|| along.transport(black_box(w.as_ref())));
        });
    }
    group.finish();
}

fn tensors(c: &mut Criterion) {
    let mut group = c.benchmark_group("tensors");
    for (n, k) in SHAPES {
        let shape = format!("St({n},{k})");
        let (s, [u, v, w]) = data(n, k);
        let manifold = Stiefel::new(n, k).unwrap();
        let g = gaussian(n, k, &mut Rng::new(5));
        let [s, u, v, w, g] = [&s, &u, &v, &w, &g].map(|x| x.as_ref());
        group.bench_function(BenchmarkId::new("curvature", &shape), |b| {
            b.iter(|| manifold.curvature(black_box(s), u, v, w));
        });
        if manifold.dim() >= 2 {
            group.bench_function(BenchmarkId::new("sectional_curvature", &shape), |b| {
                b.iter(|| manifold.sectional_curvature(black_box(s), u, v));
            });
        }
        group.bench_function(BenchmarkId::new("gradient", &shape), |b| {
            b.iter(|| manifold.euclidean_to_riemannian_gradient(black_box(s), g));
        });
        group.bench_function(BenchmarkId::new("hessian", &shape), |b| {
            b.iter(|| manifold.euclidean_to_riemannian_hessian(black_box(s), g, g, v));
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10).warm_up_time(std::time::Duration::from_millis(100)).measurement_time(std::time::Duration::from_millis(300));
    targets = retraction, transport, tensors
}
criterion_main!(benches);
