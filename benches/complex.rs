//! Complex frames compared with real ones of the same shape: matrices are embedded, unknowns of splines and cubics are
//! complex.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::*;
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use faer::{Mat, MatRef, c64};
use stiefel_rs::cubic::{BoundaryOptions, RiemannianCubic};
use stiefel_rs::linalg::complex_embedding::embed;
use stiefel_rs::linalg::decomp::unitary_q;
use stiefel_rs::manifold::Retraction;
use stiefel_rs::spline::{EndConditions, SplineOptions, cubic_spline};
use stiefel_rs::{Interrupt, ScalarField, Stiefel};

/// `(n, k)`.
const SHAPES: [(usize, usize); 4] = [(3, 1), (4, 2), (10, 3), (100, 5)];

const FIELDS: [(&str, ScalarField); 2] = [
    ("real", ScalarField::Real),
    ("complex", ScalarField::Complex),
];

/// Complex unknowns, and all entries of the embedded matrices as real unknowns.
const WAYS: [(&str, ScalarField, ScalarField); 3] = [
    ("real", ScalarField::Real, ScalarField::Real),
    ("complex", ScalarField::Complex, ScalarField::Complex),
    ("embedded", ScalarField::Complex, ScalarField::Real),
];

fn matrix(field: ScalarField, (n, k): (usize, usize), rng: &mut Rng) -> Mat<c64> {
    let re = gaussian(n, k, rng);
    let im = match field {
        ScalarField::Real => Mat::zeros(n, k),
        ScalarField::Complex => gaussian(n, k, rng),
    };
    Mat::from_fn(n, k, |i, j| c64::new(re[(i, j)], im[(i, j)]))
}

/// A matrix in the form that the library takes.
fn taken(field: ScalarField, a: &Mat<c64>) -> Mat<f64> {
    match field {
        ScalarField::Real => Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)].re),
        ScalarField::Complex => embed(a.as_ref()),
    }
}

fn point(field: ScalarField, shape: (usize, usize), rng: &mut Rng) -> Mat<f64> {
    taken(field, &unitary_q(matrix(field, shape, rng).as_ref(), false))
}

/// A tangent vector of the given length, of the real or complex matrix.
fn tangent(
    field: ScalarField,
    s: &Mat<f64>,
    shape: (usize, usize),
    length: f64,
    rng: &mut Rng,
) -> Mat<f64> {
    let a = taken(field, &matrix(field, shape, rng));
    let inner = s.transpose() * &a;
    let v = a - s * (&inner + inner.transpose()) * faer::Scale(0.5);
    let copies = match field {
        ScalarField::Real => 1.0_f64,
        ScalarField::Complex => 2.0,
    };
    let norm = v.norm_l2() / copies.sqrt();
    v * faer::Scale(length / norm)
}

fn moved(s: &Mat<f64>, v: &Mat<f64>) -> Mat<f64> {
    let along = Retraction::QuasiGeodesic;
    along.retract(s.as_ref(), v.as_ref()).unwrap()
}

fn splines(c: &mut Criterion) {
    let mut group = c.benchmark_group("complex_spline");
    group.sample_size(10);
    for shape in SHAPES {
        for (name, numbers, field) in WAYS {
            let mut rng = Rng::new(1);
            let mut points = vec![point(numbers, shape, &mut rng)];
            for i in 1..10 {
                let v = tangent(numbers, &points[i - 1], shape, 0.6, &mut rng);
                points.push(moved(&points[i - 1], &v));
            }
            let t: Vec<f64> = (0..10).map(f64::from).collect();
            let views: Vec<MatRef<'_, f64>> = points.iter().map(Mat::as_ref).collect();
            let options = SplineOptions {
                field,
                ..SplineOptions::default()
            };
            let ends = EndConditions::Natural;
            let find =
                || cubic_spline(&t, black_box(&views), &ends, &options, Interrupt::NEVER).unwrap();
            let id = BenchmarkId::new(name, format!("{}_{}", shape.0, shape.1));
            group.bench_function(id, |b| b.iter(find));
        }
    }
    group.finish();
}

fn boundary_values(c: &mut Criterion) {
    let mut group = c.benchmark_group("complex_boundary");
    group.sample_size(10);
    for shape in SHAPES {
        // Near ends, and ends that need descents.
        for (far, length) in [("near", 0.5), ("far", 2.2)] {
            for (name, numbers, field) in WAYS {
                // Distant matrices of shape (100, 5), and embedded ones of shape (20, 6), exceed the work limit for
                // some data.
                let is_large = shape.0 > 10 || name == "embedded" && shape.0 == 10;
                if far == "far" && is_large {
                    continue;
                }
                let mut rng = Rng::new(2);
                let s0 = point(numbers, shape, &mut rng);
                let v = tangent(numbers, &s0, shape, length, &mut rng);
                let s1 = moved(&s0, &v);
                let v0 = tangent(numbers, &s0, shape, 2.0 * length, &mut rng);
                let v1 = tangent(numbers, &s1, shape, 2.0 * length, &mut rng);
                let options = BoundaryOptions {
                    field,
                    ..BoundaryOptions::default()
                };
                let [s0, v0, s1, v1] = [&s0, &v0, &s1, &v1].map(|a| a.as_ref());
                let find = || {
                    RiemannianCubic::from_boundary(
                        black_box(s0),
                        v0,
                        s1,
                        v1,
                        &options,
                        Interrupt::NEVER,
                    )
                    .unwrap()
                };
                let id = BenchmarkId::new(name, format!("{}_{}_{far}", shape.0, shape.1));
                group.bench_function(id, |b| b.iter(find));
            }
        }
    }
    group.finish();
}

fn maps(c: &mut Criterion) {
    let mut group = c.benchmark_group("complex_maps");
    group.sample_size(10);
    for shape in SHAPES {
        for (name, field) in FIELDS {
            let mut rng = Rng::new(3);
            let s0 = point(field, shape, &mut rng);
            let v = tangent(field, &s0, shape, 0.8, &mut rng);
            let s1 = moved(&s0, &v);
            let manifold = Stiefel::new(s0.nrows(), s0.ncols()).unwrap();
            let id = |what: &str| {
                BenchmarkId::new(format!("{name}_{what}"), format!("{}_{}", shape.0, shape.1))
            };
            group.bench_function(id("retract"), |b| b.iter(|| moved(black_box(&s0), &v)));
            group.bench_function(id("log"), |b| {
                b.iter(|| manifold.log(black_box(s0.as_ref()), s1.as_ref()).unwrap());
            });
        }
    }
    group.finish();
}

criterion_group!(benches, splines, boundary_values, maps);
criterion_main!(benches);
