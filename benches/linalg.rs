//! Exponential and logarithm of rotations, each compared with its alternative.
//!
//! * `exp`: ours compared with the generic scaling and squaring of nalgebra, and one matrix product as the unit.
//! * `exp_complex`, `log_complex`: skew-Hermitian and unitary matrices, compared with the real functions of the same
//!   size.
//! * `log`: ours for difficult spectra (random, clustered, repeated, near pi), and one product as the unit.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::{Rng, random_rotation, random_skew, rotation_with_angles, spectral};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par, c64};
use nalgebra::DMatrix;
use stiefel_rs::linalg::{OrthogonalLog, SkewExp, UnitaryLog};

fn exponential(c: &mut Criterion) {
    let mut group = c.benchmark_group("exp");
    for m in [2, 3, 6, 12, 30, 100, 300] {
        let mut rng = Rng::new(m as u64);
        let a = random_skew(m, 1.0, &mut rng);
        let generic = DMatrix::from_fn(m, m, |i, j| a[(i, j)]);
        let (mut out, mut work) = (Mat::zeros(m, m), SkewExp::new(m));
        work.exp_into(out.as_mut(), a.as_ref(), 1.0).unwrap();
        let expected = generic.exp();
        let difference = Mat::from_fn(m, m, |i, j| out[(i, j)] - expected[(i, j)]);
        assert!(
            spectral(difference.as_ref()) < 1e-13,
            "both compute the same exponential"
        );
        group.bench_function(BenchmarkId::new("skew_exp", m), |b| {
            b.iter(|| work.exp_into(out.as_mut(), black_box(a.as_ref()), 1.0));
        });
        group.bench_function(BenchmarkId::new("nalgebra", m), |b| {
            b.iter(|| black_box(&generic).exp())
        });
        group.bench_function(BenchmarkId::new("one_product", m), |b| {
            b.iter(|| {
                matmul(
                    out.as_mut(),
                    Accum::Replace,
                    black_box(&a),
                    &a,
                    1.0,
                    Par::Seq,
                )
            });
        });
    }
    group.finish();
}

/// A name and the angles of a difficult spectrum for `m x m`.
fn spectra(m: usize) -> Vec<(&'static str, Option<Vec<f64>>)> {
    let planes = m / 2;
    let near_pi = std::f64::consts::PI - 1e-10;
    vec![
        ("random", None),
        ("equal", Some(vec![1.0; planes])),
        (
            "clustered",
            Some((0..planes).map(|i| 1.0 + 1e-8 * i as f64).collect()),
        ),
        (
            "near_pi",
            Some(
                (0..planes)
                    .map(|i| {
                        if i == 0 {
                            near_pi
                        } else {
                            0.1 * i as f64 % 3.0
                        }
                    })
                    .collect(),
            ),
        ),
    ]
}

fn logarithm(c: &mut Criterion) {
    let mut group = c.benchmark_group("log");
    for m in [2, 3, 6, 12, 30, 100, 300] {
        for (name, angles) in spectra(m) {
            let mut rng = Rng::new(m as u64);
            let q = match angles {
                Some(angles) => rotation_with_angles(&angles, m, &mut rng),
                None => random_rotation(m, &mut rng),
            };
            let (mut log, mut back) = (Mat::zeros(m, m), Mat::zeros(m, m));
            let mut work = OrthogonalLog::new(m);
            work.log_into(log.as_mut(), q.as_ref()).unwrap();
            SkewExp::new(m)
                .exp_into(back.as_mut(), log.as_ref(), 1.0)
                .unwrap();
            assert!(
                (&back - &q).norm_l2() < 1e-12,
                "exp log Q = Q for {name}, m = {m}"
            );
            group.bench_function(BenchmarkId::new(name, m), |b| {
                b.iter(|| work.log_into(log.as_mut(), black_box(q.as_ref())));
            });
        }
        let a = random_rotation(m, &mut Rng::new(m as u64));
        let mut out = Mat::zeros(m, m);
        group.bench_function(BenchmarkId::new("one_product", m), |b| {
            b.iter(|| {
                matmul(
                    out.as_mut(),
                    Accum::Replace,
                    black_box(&a),
                    &a,
                    1.0,
                    Par::Seq,
                )
            });
        });
    }
    group.finish();
}

fn complex(c: &mut Criterion) {
    for m in [4, 16, 64, 256] {
        let mut rng = Rng::new(m as u64);
        let (skew, other) = (random_skew(m, 2.0, &mut rng), random_skew(m, 1.0, &mut rng));
        // A skew matrix plus i times the symmetric -X^2: norm between 1 and 3.
        let symmetric = &other * &other;
        let a = Mat::from_fn(m, m, |i, j| c64::new(skew[(i, j)], -symmetric[(i, j)]));
        let (mut exp, mut real_exp) = (SkewExp::new(m), SkewExp::new(m));
        let (mut u, mut q) = (Mat::<c64>::zeros(m, m), Mat::<f64>::zeros(m, m));
        exp.checked_into(u.as_mut(), a.as_ref()).unwrap();
        real_exp.checked_into(q.as_mut(), skew.as_ref()).unwrap();
        let (mut out, mut real) = (Mat::zeros(m, m), Mat::zeros(m, m));
        let mut group = c.benchmark_group("exp_complex");
        group.bench_function(BenchmarkId::new("complex", m), |b| {
            b.iter(|| exp.checked_into(out.as_mut(), black_box(a.as_ref())));
        });
        group.bench_function(BenchmarkId::new("real", m), |b| {
            b.iter(|| real_exp.checked_into(real.as_mut(), black_box(skew.as_ref())));
        });
        group.finish();
        let (mut log, mut real_log) = (UnitaryLog::new(m), OrthogonalLog::new(m));
        log.checked_into(out.as_mut(), u.as_ref()).unwrap();
        assert!((&out - &a).norm_l2() < 1e-11, "log exp A = A, m = {m}");
        let mut group = c.benchmark_group("log_complex");
        group.bench_function(BenchmarkId::new("complex", m), |b| {
            b.iter(|| log.checked_into(out.as_mut(), black_box(u.as_ref())));
        });
        group.bench_function(BenchmarkId::new("real", m), |b| {
            b.iter(|| real_log.checked_into(real.as_mut(), black_box(q.as_ref())));
        });
        group.finish();
    }
}

criterion_group!(benches, exponential, logarithm, complex);
criterion_main!(benches);
