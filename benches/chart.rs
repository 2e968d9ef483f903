//! The paper's methods on the paper's problems: one curve by each method, and the de Casteljau curve for comparison.

#[path = "../tests/common/paper.rs"]
mod paper;

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use nalgebra::SVector;
use stiefel_rs::chart::{
    Chart, Composition, DiscretizationMap, Frame, LinearMap, RetractionMap, ShootingOptions,
    SpaceRetraction, Sphere, integrate, integrate_composed, integrate_with_tangent, reference,
    shoot,
};
use stiefel_rs::{Curve, GeometricCubic, Interrupt, Quantity};

const STEPS: usize = 100;
const MAPS: [(&str, LinearMap); 2] = [
    ("initial_point", LinearMap::INITIAL_POINT),
    ("midpoint", LinearMap::MIDPOINT),
];

/// One curve of `STEPS` steps by every method.
fn one_curve<const X: usize, const Z: usize>(
    c: &mut Criterion,
    name: &str,
    chart: &impl Chart<X, Z>,
    z0: &SVector<f64, Z>,
) {
    let mut group = c.benchmark_group(format!("one_curve_{name}"));
    let t: Vec<f64> = (0..=STEPS).map(|i| i as f64 / STEPS as f64).collect();
    let end = reference(chart, z0, &[1.0], Interrupt::NEVER).unwrap()[0];
    let (x0, x1) = (
        z0.fixed_rows::<X>(0).into_owned(),
        end.fixed_rows::<X>(0).into_owned(),
    );
    let split = |x: &SVector<f64, X>| {
        let (q, qdot) = x.as_slice().split_at(X / 2);
        (
            chart.embed(q).unwrap(),
            chart.embed_velocity(q, qdot).unwrap(),
        )
    };
    let ((s0, v0), (s1, v1)) = (split(&x0), split(&x1));
    group.bench_function("gcp", |b| {
        b.iter(|| {
            let curve =
                GeometricCubic::from_boundary(s0.as_ref(), v0.as_ref(), s1.as_ref(), v1.as_ref())
                    .unwrap();
            curve.sample(black_box(&t), Quantity::Derivative(0), Interrupt::NEVER)
        });
    });
    group.bench_function("reference", |b| {
        b.iter(|| reference(chart, black_box(z0), &t, Interrupt::NEVER))
    });
    for (method, map) in MAPS {
        group.bench_function(BenchmarkId::new("ivp", method), |b| {
            b.iter(|| integrate(chart, &map, black_box(z0), STEPS, 1.0, Interrupt::NEVER));
        });
        let options = ShootingOptions::default();
        assert!(
            shoot(chart, &map, &x0, &x1, STEPS, &options, Interrupt::NEVER)
                .unwrap()
                .report
                .converged
        );
        group.bench_function(BenchmarkId::new("bvp", method), |b| {
            b.iter(|| {
                shoot(
                    chart,
                    &map,
                    black_box(&x0),
                    &x1,
                    STEPS,
                    &options,
                    Interrupt::NEVER,
                )
            });
        });
    }
    group.finish();
}

/// The cost of one step, and of its exact derivative.
fn one_step<const X: usize, const Z: usize>(
    c: &mut Criterion,
    name: &str,
    chart: &impl Chart<X, Z>,
    z0: &SVector<f64, Z>,
) {
    let mut group = c.benchmark_group(format!("one_step_{name}"));
    group.bench_function("gradient", |b| b.iter(|| chart.gradient(black_box(z0))));
    group.bench_function("hessian", |b| b.iter(|| chart.hessian(black_box(z0))));
    for (method, map) in MAPS {
        group.bench_function(BenchmarkId::new("step", method), |b| {
            b.iter(|| integrate(chart, &map, black_box(z0), 1, 0.01, Interrupt::NEVER));
        });
        group.bench_function(BenchmarkId::new("step_and_tangent", method), |b| {
            b.iter(|| {
                integrate_with_tangent(chart, &map, black_box(z0), 1, 0.01, Interrupt::NEVER)
            });
        });
    }
    group.finish();
}

/// The cost of a step with a retraction map instead of a map that is linear in coordinates, and with composition.
fn other_steps<const X: usize, const Z: usize>(
    c: &mut Criterion,
    name: &str,
    chart: &impl Chart<X, Z>,
    z0: &SVector<f64, Z>,
) where
    RetractionMap: DiscretizationMap<X>,
{
    let mut group = c.benchmark_group(format!("step_by_map_{name}"));
    let linear = LinearMap::MIDPOINT;
    group.bench_function("midpoint", |b| {
        b.iter(|| integrate(chart, &linear, black_box(z0), 1, 0.01, Interrupt::NEVER));
    });
    for order in [4, 6, 8] {
        let composition = Composition::new(2, order).unwrap();
        group.bench_function(BenchmarkId::new("midpoint_order", order), |b| {
            b.iter(|| {
                let never = Interrupt::NEVER;
                integrate_composed(chart, &linear, &composition, black_box(z0), 1, 0.01, never)
            });
        });
    }
    for (retraction, method) in [
        (SpaceRetraction::Exponential, "exponential_midpoint"),
        (SpaceRetraction::Cayley, "cayley_midpoint"),
        (SpaceRetraction::QuasiGeodesic, "quasi_geodesic_midpoint"),
    ] {
        let map = RetractionMap::midpoint(retraction);
        group.bench_function(method, |b| {
            b.iter(|| integrate(chart, &map, black_box(z0), 1, 0.01, Interrupt::NEVER));
        });
    }
    group.finish();
}

fn sphere(c: &mut Criterion) {
    one_curve(c, "sphere", &Sphere, &paper::sphere());
    one_step(c, "sphere", &Sphere, &paper::sphere());
    other_steps(c, "sphere", &Sphere, &paper::sphere());
}

fn frame(c: &mut Criterion) {
    one_curve(c, "stiefel_3_2", &Frame, &paper::frame());
    one_step(c, "stiefel_3_2", &Frame, &paper::frame());
    other_steps(c, "stiefel_3_2", &Frame, &paper::frame());
}

criterion_group!(benches, sphere, frame);
criterion_main!(benches);
