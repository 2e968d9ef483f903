//! The explicit splitting of Riemannian cubics: one step for each order and shape, compared with a step in the
//! embedding and a step of the chart integrator.

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/common/paper.rs"]
mod paper;

use std::hint::black_box;

use common::*;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use faer::Mat;
use stiefel_rs::Interrupt;
use stiefel_rs::chart::{Frame, LinearMap, Sphere, integrate};
use stiefel_rs::cubic::{SplittingOptions, SplittingOrder, integrate_cubic, integrate_embedded};

const ORDERS: [SplittingOrder; 4] = [
    SplittingOrder::Two,
    SplittingOrder::Four,
    SplittingOrder::Six,
    SplittingOrder::Eight,
];

/// Steps per call: the time per element is that of a step with its state, energy and defects of the invariants.
const STEPS: usize = 100;

fn steps(c: &mut Criterion) {
    for shape in [(3, 1), (3, 2), (4, 2), (10, 3), (50, 5), (300, 10)] {
        let mut group = c.benchmark_group(format!("cubic_step_{}_{}", shape.0, shape.1));
        group.throughput(Throughput::Elements(STEPS as u64));
        let mut rng = Rng::new(1);
        let s = random_point(shape.0, shape.1, &mut rng);
        let [v, a, j]: [Mat<f64>; 3] = std::array::from_fn(|_| random_tangent(&s, 1.0, &mut rng));
        for order in ORDERS {
            let options = SplittingOptions {
                order,
                ..SplittingOptions::default()
            };
            let run = || {
                let data = black_box([&s, &v, &a, &j]).map(Mat::as_ref);
                integrate_cubic(
                    data[0],
                    data[1],
                    data[2],
                    data[3],
                    STEPS,
                    &options,
                    Interrupt::NEVER,
                )
                .unwrap()
            };
            assert!(run().momentum_drift() < 1e-12);
            group.bench_function(BenchmarkId::new("order", order.number()), |b| b.iter(run));
        }
        group.bench_function("embedded", |b| {
            b.iter(|| {
                let data = black_box([&s, &v, &a, &j]).map(Mat::as_ref);
                integrate_embedded(
                    data[0],
                    data[1],
                    data[2],
                    data[3],
                    STEPS,
                    1.0,
                    Interrupt::NEVER,
                )
                .unwrap()
            });
        });
        chart_steps(&mut group, shape);
        group.finish();
    }
}

/// The paper's integrator, if there is a chart.
fn chart_steps(
    group: &mut criterion::BenchmarkGroup<'_, criterion::measurement::WallTime>,
    shape: (usize, usize),
) {
    let map = LinearMap::MIDPOINT;
    match shape {
        (3, 1) => group.bench_function("chart_midpoint", |b| {
            let z = paper::sphere();
            b.iter(|| integrate(&Sphere, &map, black_box(&z), STEPS, 1.0, Interrupt::NEVER))
        }),
        (3, 2) => group.bench_function("chart_midpoint", |b| {
            let z = paper::frame();
            b.iter(|| integrate(&Frame, &map, black_box(&z), STEPS, 1.0, Interrupt::NEVER))
        }),
        _ => group,
    };
}

criterion_group!(benches, steps);
criterion_main!(benches);
