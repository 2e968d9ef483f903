//! Splines of rotations in quaternions, and of poses: computing them, and evaluating them.

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::Rng;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use stiefel_rs::Interrupt;
use stiefel_rs::rotation::{PoseEnds, PoseSpline, ReferenceFrame, RotationEnds, RotationSpline};
use stiefel_rs::spline::SplineOptions;

/// Times per call.
const TIMES: usize = 1001;

/// Poses of a spline of poses; one of the numbers of rotations, for comparison.
const POSES: usize = 200;

/// Keyframes 0.3 to 1.2 rad apart, at times 0.5 to 1.5 apart.
fn walk(count: usize) -> (Vec<f64>, Vec<UnitQuaternion<f64>>) {
    let mut rng = Rng::new(1);
    let (mut t, mut q) = (vec![0.0], vec![UnitQuaternion::identity()]);
    for i in 1..count {
        t.push(t[i - 1] + rng.between(0.5, 1.5));
        let v = Vector3::from_fn(|_, _| rng.between(-1.0, 1.0));
        let step = v.normalize() * rng.between(0.3, 1.2);
        q.push(q[i - 1] * UnitQuaternion::from_scaled_axis(step));
    }
    (t, q)
}

/// The keyframes of [`walk`], with positions within a cube of side 2.
fn pose_walk() -> (Vec<f64>, Vec<Isometry3<f64>>) {
    let (t, q) = walk(POSES);
    let mut rng = Rng::new(2);
    let pose = |q: &UnitQuaternion<f64>| {
        let position = Vector3::from_fn(|_, _| rng.between(-1.0, 1.0));
        Isometry3::from_parts(position.into(), *q)
    };
    let poses = q.iter().map(pose).collect();
    (t, poses)
}

/// Evenly spaced times from the first to the last keyframe.
fn evaluation_times(t: &[f64]) -> Vec<f64> {
    let step = (t[t.len() - 1] - t[0]) / (TIMES - 1) as f64;
    (0..TIMES).map(|i| t[0] + step * i as f64).collect()
}

fn construction(c: &mut Criterion) {
    let mut group = c.benchmark_group("rotation_spline_construction");
    for count in [10, 50, 200, 2000] {
        let (t, q) = walk(count);
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::from_parameter(count), |b| {
            b.iter(|| {
                let options = SplineOptions::default();
                RotationSpline::new(
                    black_box(&t),
                    &q,
                    &RotationEnds::Natural,
                    &options,
                    Interrupt::NEVER,
                )
                .unwrap()
            });
        });
    }
    group.finish();
}

fn evaluation(c: &mut Criterion) {
    let mut group = c.benchmark_group("rotation_spline_evaluation");
    group.throughput(Throughput::Elements(TIMES as u64));
    let (t, q) = walk(200);
    let spline = RotationSpline::new(
        &t,
        &q,
        &RotationEnds::Natural,
        &Default::default(),
        Interrupt::NEVER,
    )
    .unwrap();
    let times = evaluation_times(&t);
    let mut quaternions = vec![[0.0; 4]; TIMES];
    spline.quaternions_into(&times, &mut quaternions).unwrap();
    assert!(spline.rotation(t[7]).unwrap().angle_to(&q[7]) < 1e-12);
    group.bench_function("quaternions", |b| {
        b.iter(|| {
            spline
                .quaternions_into(black_box(&times), &mut quaternions)
                .unwrap()
        });
    });
    let mut rates = vec![[0.0; 3]; TIMES];
    for (order, name) in ["rates", "accelerations", "jerks"].into_iter().enumerate() {
        group.bench_function(name, |b| {
            b.iter(|| {
                spline
                    .rates_into(black_box(&times), order, &mut rates)
                    .unwrap()
            });
        });
    }
    group.finish();
}

fn pose_construction(c: &mut Criterion) {
    let mut group = c.benchmark_group("pose_spline_construction");
    let (t, poses) = pose_walk();
    group.throughput(Throughput::Elements(POSES as u64));
    group.bench_function(BenchmarkId::from_parameter(POSES), |b| {
        b.iter(|| {
            let options = SplineOptions::default();
            PoseSpline::new(
                black_box(&t),
                &poses,
                &PoseEnds::Natural,
                &options,
                Interrupt::NEVER,
            )
            .unwrap()
        });
    });
    group.finish();
}

/// Single times, one call each.
fn pose_evaluation(c: &mut Criterion) {
    let mut group = c.benchmark_group("pose_spline_evaluation");
    group.throughput(Throughput::Elements(TIMES as u64));
    let (t, poses) = pose_walk();
    let spline = PoseSpline::new(
        &t,
        &poses,
        &PoseEnds::Natural,
        &Default::default(),
        Interrupt::NEVER,
    )
    .unwrap();
    let times = evaluation_times(&t);
    let found = spline.pose(t[7]).unwrap();
    assert!(found.rotation.angle_to(&poses[7].rotation) < 1e-12);
    assert!((found.translation.vector - poses[7].translation.vector).norm() < 1e-12);
    group.bench_function("pose", |b| {
        b.iter(|| {
            for t in black_box(&times) {
                black_box(spline.pose(*t).unwrap());
            }
        });
    });
    group.bench_function("position", |b| {
        b.iter(|| {
            for t in black_box(&times) {
                black_box(spline.position(*t).unwrap());
            }
        });
    });
    for (frame, name) in [
        (ReferenceFrame::Body, "body twist"),
        (ReferenceFrame::World, "world twist"),
    ] {
        group.bench_function(name, |b| {
            b.iter(|| {
                for t in black_box(&times) {
                    black_box(spline.twist(*t, frame).unwrap());
                }
            });
        });
    }
    group.finish();
}

criterion_group!(
    benches,
    construction,
    evaluation,
    pose_construction,
    pose_evaluation
);
criterion_main!(benches);
