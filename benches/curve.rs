//! Curves: evaluation compared with the formulas with `n x n` exponentials, derivatives, the endpoint problem.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::{Rng, random_point, random_tangent};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use faer::Mat;
use stiefel_rs::{
    Curve, GeodesicPolynomial, GeometricCubic, GeometricPolynomial, Interrupt, Quantity,
    QuasiGeodesic, Stiefel, skew_exp,
};

const SHAPES: [(usize, usize); 4] = [(3, 1), (3, 2), (50, 5), (300, 10)];

/// A point, and another one at a distance of a tangent vector of norm 1.
fn pair(n: usize, k: usize) -> (Mat<f64>, Mat<f64>, Mat<f64>) {
    let mut rng = Rng::new((100 * n + k) as u64);
    let s = random_point(n, k, &mut rng);
    let v = random_tangent(&s, 1.0, &mut rng);
    let end = QuasiGeodesic::from_velocity(s.as_ref(), v.as_ref())
        .unwrap()
        .point(1.0)
        .unwrap();
    (s, v, end)
}

fn cubic(n: usize, k: usize) -> GeometricCubic {
    let (s0, v0, s1) = pair(n, k);
    let v1 = random_tangent(&s1, 1.0, &mut Rng::new(7));
    GeometricCubic::from_boundary(s0.as_ref(), v0.as_ref(), s1.as_ref(), v1.as_ref()).unwrap()
}

fn quasi_geodesic(c: &mut Criterion) {
    let mut group = c.benchmark_group("quasi_geodesic");
    for (n, k) in SHAPES {
        let shape = format!("St({n},{k})");
        let (s, v, end) = pair(n, k);
        let manifold = Stiefel::new(n, k).unwrap();
        let (x, omega) = manifold.decompose(s.as_ref(), v.as_ref()).unwrap();
        let formula = || skew_exp(x.as_ref()).unwrap() * &s * skew_exp(omega.as_ref()).unwrap();
        assert!(
            (formula() - &end).norm_l2() < 1e-12,
            "thin and n x n formula agree"
        );
        group.bench_function(BenchmarkId::new("retract", &shape), |b| {
            b.iter(|| {
                QuasiGeodesic::from_velocity(black_box(s.as_ref()), v.as_ref())
                    .unwrap()
                    .point(1.0)
            });
        });
        group.bench_function(BenchmarkId::new("inverse_retract", &shape), |b| {
            b.iter(|| {
                QuasiGeodesic::between(black_box(s.as_ref()), end.as_ref())
                    .unwrap()
                    .initial_velocity()
            });
        });
        if n <= 50 {
            group.bench_function(BenchmarkId::new("n_by_n_formula", &shape), |b| {
                b.iter(|| black_box(formula()))
            });
        }
    }
    group.finish();
}

fn geometric_cubic(c: &mut Criterion) {
    let mut group = c.benchmark_group("geometric_cubic");
    let single = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let t: Vec<f64> = (0..512).map(|i| f64::from(i) / 511.0).collect();
    group.throughput(Throughput::Elements(t.len() as u64));
    for (n, k) in SHAPES {
        let (shape, curve) = (format!("St({n},{k})"), cubic(n, k));
        let quantities = [
            ("position", Quantity::Derivative(0)),
            ("velocity", Quantity::Derivative(1)),
            ("jerk", Quantity::Jerk),
        ];
        for (name, quantity) in quantities {
            if name != "position" && k > 2 {
                continue;
            }
            group.bench_function(BenchmarkId::new(name, &shape), |b| {
                b.iter(|| {
                    single.install(|| curve.sample(black_box(&t), quantity, Interrupt::NEVER))
                });
            });
        }
    }
    group.finish();
}

fn construction(c: &mut Criterion) {
    let mut group = c.benchmark_group("geometric_cubic_from_boundary");
    for (n, k) in SHAPES {
        let (s0, v0, s1) = pair(n, k);
        let v1 = random_tangent(&s1, 1.0, &mut Rng::new(7));
        group.bench_function(BenchmarkId::from_parameter(format!("St({n},{k})")), |b| {
            b.iter(|| {
                GeometricCubic::from_boundary(
                    black_box(s0.as_ref()),
                    v0.as_ref(),
                    s1.as_ref(),
                    v1.as_ref(),
                )
                .unwrap()
            });
        });
    }
    group.finish();
}

/// Other control points with the same boundary data, compared with the geometric cubic: construction, and a block of
/// points.
fn control_points(c: &mut Criterion) {
    let mut group = c.benchmark_group("control_points");
    let single = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let t: Vec<f64> = (0..512).map(|i| f64::from(i) / 511.0).collect();
    for (n, k) in [(3, 1), (3, 2), (4, 2), (6, 3), (10, 3)] {
        let shape = format!("St({n},{k})");
        let (s0, v0, s1) = pair(n, k);
        let v1 = random_tangent(&s1, 1.0, &mut Rng::new(7));
        let [s0, v0, s1, v1] = [&s0, &v0, &s1, &v1].map(|a| a.as_ref());
        let cubic = || GeometricCubic::from_boundary(black_box(s0), v0, s1, v1).unwrap();
        let search = |m| {
            GeometricPolynomial::minimal_cost(black_box(s0), v0, s1, v1, m, Interrupt::NEVER)
                .unwrap()
                .0
        };
        let curves: [(String, GeometricPolynomial); 4] = [
            ("cubic".to_owned(), cubic().into()),
            ("minimal_cost_4".to_owned(), search(4)),
            ("minimal_cost_5".to_owned(), search(5)),
            ("minimal_cost_6".to_owned(), search(6)),
        ];
        let [a0, a1] = [0.0, 1.0].map(|x| curves[3].1.acceleration(x).unwrap());
        let quintic = || {
            GeometricPolynomial::quintic(black_box(s0), v0, a0.as_ref(), s1, v1, a1.as_ref())
                .unwrap()
        };
        assert!(
            search(5).cost(Interrupt::NEVER).unwrap() < quintic().cost(Interrupt::NEVER).unwrap()
        );
        let geodesic = || GeodesicPolynomial::from_boundary(black_box(s0), v0, s1, v1).unwrap();
        let geodesic_cubic = geodesic();
        group.bench_function(BenchmarkId::new("512_points_geodesic_cubic", &shape), |b| {
            let quantity = Quantity::Derivative(0);
            b.iter(|| {
                single.install(|| geodesic_cubic.sample(black_box(&t), quantity, Interrupt::NEVER))
            });
        });
        group.bench_function(BenchmarkId::new("build_geodesic_cubic", &shape), |b| {
            b.iter(geodesic)
        });
        group.bench_function(BenchmarkId::new("build_cubic", &shape), |b| b.iter(cubic));
        group.bench_function(BenchmarkId::new("build_quintic", &shape), |b| {
            b.iter(quintic)
        });
        for m in [4, 5, 6] {
            let name = format!("build_minimal_cost_{m}");
            group.bench_function(BenchmarkId::new(name, &shape), |b| b.iter(|| search(m)));
        }
        for (name, curve) in &curves {
            let name = format!("512_points_{name}");
            group.bench_function(BenchmarkId::new(name, &shape), |b| {
                let quantity = Quantity::Derivative(0);
                b.iter(|| {
                    single.install(|| curve.sample(black_box(&t), quantity, Interrupt::NEVER))
                });
            });
        }
    }
    group.finish();
}

criterion_group!(
    benches,
    quasi_geodesic,
    geometric_cubic,
    construction,
    control_points
);
criterion_main!(benches);
