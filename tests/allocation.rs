//! Sampling allocates per block of work, not per parameter. This test has its own binary, since the allocator counts
//! all threads.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use common::*;
use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use stiefel_rs::cubic::{SplittingOptions, integrate_cubic, integrate_embedded};
use stiefel_rs::rotation::{PoseEnds, PoseSpline, ReferenceFrame, RotationEnds, RotationSpline};
use stiefel_rs::{Curve, GeometricCubic, Interrupt, Quantity, QuasiGeodesic};

struct Counting;

static BLOCKS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is forwarded to the system allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        BLOCKS.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn blocks_for(curve: &impl Curve, points: usize, nu: usize) -> usize {
    let t: Vec<f64> = (0..points).map(|i| i as f64 / points as f64).collect();
    let before = BLOCKS.load(Ordering::Relaxed);
    let samples = curve
        .sample(&t, Quantity::Derivative(nu), Interrupt::NEVER)
        .unwrap();
    let after = BLOCKS.load(Ordering::Relaxed);
    assert_eq!(samples.len(), points);
    after - before
}

fn random_curves(n: usize, k: usize, rng: &mut Rng) -> (GeometricCubic, QuasiGeodesic) {
    let s0 = random_point(n, k, rng);
    let v = random_tangent(&s0, 1.0, rng);
    let leg = QuasiGeodesic::from_velocity(s0.as_ref(), v.as_ref()).unwrap();
    let s1 = leg.point(1.0).unwrap();
    let w = random_tangent(&s1, 1.0, rng);
    (
        GeometricCubic::from_boundary(s0.as_ref(), v.as_ref(), s1.as_ref(), w.as_ref()).unwrap(),
        leg,
    )
}

/// Allocations for a trajectory, by the splitting or in the embedding.
fn blocks_for_steps(n: usize, k: usize, steps: usize, embedded: bool) -> usize {
    let mut rng = Rng::new(2);
    let s = random_point(n, k, &mut rng);
    let [v, a, j] = [(); 3].map(|()| random_tangent(&s, 1.0, &mut rng));
    let before = BLOCKS.load(Ordering::Relaxed);
    let [s, v, a, j] = [&s, &v, &a, &j].map(|m| m.as_ref());
    let trajectory = if embedded {
        integrate_embedded(s, v, a, j, steps, 1.0, Interrupt::NEVER)
    } else {
        integrate_cubic(
            s,
            v,
            a,
            j,
            steps,
            &SplittingOptions::default(),
            Interrupt::NEVER,
        )
    }
    .unwrap();
    let after = BLOCKS.load(Ordering::Relaxed);
    assert_eq!(trajectory.steps(), steps);
    after - before
}

/// Keyframes at 20 times.
fn keyframes() -> (Vec<f64>, Vec<UnitQuaternion<f64>>) {
    let t: Vec<f64> = (0..20).map(f64::from).collect();
    let turn = |t: &f64| UnitQuaternion::from_euler_angles(0.3 * t, t.sin(), 0.2 * t * t.cos());
    let keyframes = t.iter().map(turn).collect();
    (t, keyframes)
}

/// Times from the first to the last keyframe, which are among them.
fn times() -> Vec<f64> {
    (0..=950).map(|i| f64::from(i) / 50.0).collect()
}

/// Adds the number of blocks of one evaluation per time.
fn count_each(name: &'static str, counts: &mut Vec<(&'static str, usize)>, value: impl Fn(f64)) {
    let times = times();
    let before = BLOCKS.load(Ordering::Relaxed);
    for t in times {
        value(std::hint::black_box(t));
    }
    let after = BLOCKS.load(Ordering::Relaxed);
    counts.push((name, after - before));
}

/// Allocations of a spline of rotations after the first value: at many times in one call, and at single times.
fn blocks_for_rotations() -> Vec<(&'static str, usize)> {
    let (t, keyframes) = keyframes();
    let natural = RotationEnds::Natural;
    let spline = RotationSpline::new(
        &t,
        &keyframes,
        &natural,
        &Default::default(),
        Interrupt::NEVER,
    )
    .unwrap();
    spline.rotation(0.5).unwrap();
    let (times, mut counts) = (times(), Vec::new());
    let (mut quaternions, mut rates) = (vec![[0.0; 4]; times.len()], vec![[0.0; 3]; times.len()]);
    let before = BLOCKS.load(Ordering::Relaxed);
    spline.quaternions_into(&times, &mut quaternions).unwrap();
    let after = BLOCKS.load(Ordering::Relaxed);
    counts.push(("quaternions_into", after - before));
    for (order, name) in ["rates_into, order 0", "order 1", "order 2"]
        .into_iter()
        .enumerate()
    {
        let before = BLOCKS.load(Ordering::Relaxed);
        spline.rates_into(&times, order, &mut rates).unwrap();
        let after = BLOCKS.load(Ordering::Relaxed);
        counts.push((name, after - before));
    }
    count_each("rotation", &mut counts, |t| {
        spline.rotation(t).unwrap();
    });
    for frame in [ReferenceFrame::Body, ReferenceFrame::World] {
        count_each("angular_velocity", &mut counts, |t| {
            spline.angular_velocity(t, frame).unwrap();
        });
        count_each("angular_acceleration", &mut counts, |t| {
            spline.angular_acceleration(t, frame).unwrap();
        });
        count_each("angular_jerk", &mut counts, |t| {
            spline.angular_jerk(t, frame).unwrap();
        });
    }
    counts
}

/// Allocations of a spline of poses after the first value, at single times.
fn blocks_for_poses() -> Vec<(&'static str, usize)> {
    let (t, keyframes) = keyframes();
    let pose = |(t, q): (&f64, &UnitQuaternion<f64>)| {
        Isometry3::from_parts(Translation3::new(t.sin(), t.cos(), 0.1 * t), *q)
    };
    let poses: Vec<_> = t.iter().zip(&keyframes).map(pose).collect();
    let spline = PoseSpline::new(
        &t,
        &poses,
        &PoseEnds::Natural,
        &Default::default(),
        Interrupt::NEVER,
    )
    .unwrap();
    spline.pose(0.5).unwrap();
    let mut counts = Vec::new();
    count_each("pose", &mut counts, |t| {
        spline.pose(t).unwrap();
    });
    count_each("position", &mut counts, |t| {
        spline.position(t).unwrap();
    });
    count_each("linear_velocity", &mut counts, |t| {
        spline.linear_velocity(t).unwrap();
    });
    count_each("linear_acceleration", &mut counts, |t| {
        spline.linear_acceleration(t).unwrap();
    });
    count_each("linear_jerk", &mut counts, |t| {
        spline.linear_jerk(t).unwrap();
    });
    for frame in [ReferenceFrame::Body, ReferenceFrame::World] {
        count_each("twist", &mut counts, |t| {
            spline.twist(t, frame).unwrap();
        });
    }
    counts
}

/// A single test, so that nothing else runs while it counts; a single thread, so that work is always split in the same
/// way.
#[test]
fn sampling_does_not_allocate_per_parameter() {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let mut rng = Rng::new(1);
    let mut failures = Vec::new();
    for (n, k) in [(3, 1), (20, 1), (4, 2), (20, 2), (5, 3), (30, 3), (8, 5)] {
        let (cubic, leg) = random_curves(n, k, &mut rng);
        for nu in [0, 1, 3] {
            let [few, many] = [2, if k < 3 { 100 } else { 8 }]
                .map(|blocks| pool.install(|| blocks_for(&cubic, 64 * blocks, nu)));
            println!("({n}, {k}), nu = {nu}: {few} blocks for 128 points, {many} for more");
            // The pool may split the longer job once more, and each part allocates its buffers once.
            if many > 2 * few + 8 {
                failures.push(format!(
                    "cubic ({n}, {k}), nu = {nu}: {few} blocks for 128 points, {many} for more"
                ));
            }
            let [few, many] =
                [2, 100].map(|blocks| pool.install(|| blocks_for(&leg, 64 * blocks, nu)));
            if many > 2 * few + 8 {
                failures.push(format!(
                    "leg ({n}, {k}), nu = {nu}: {few} blocks for 128 points, {many} for more"
                ));
            }
        }
    }
    for (n, k) in [(3, 1), (3, 2), (4, 2), (10, 3), (20, 2), (50, 5)] {
        for embedded in [false, true] {
            let [few, many] = [20, 400].map(|steps| blocks_for_steps(n, k, steps, embedded));
            println!("({n}, {k}), embedded {embedded}: {few} blocks for 20 steps, {many} for 400");
            if many > few {
                failures.push(format!(
                    "steps ({n}, {k}), embedded {embedded}: {few} blocks for 20, {many} for 400"
                ));
            }
        }
    }
    for (name, blocks) in blocks_for_rotations().into_iter().chain(blocks_for_poses()) {
        if blocks > 0 {
            failures.push(format!("{name}: {blocks} blocks for 951 times"));
        }
    }
    assert!(
        failures.is_empty(),
        "more than twice the blocks for 4 or 50 times the points, more blocks for more steps, or any for rotations and \
         poses:\n{}",
        failures.join("\n")
    );
}
