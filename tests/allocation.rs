//! Sampling allocates per block of work, not per parameter. This test has its own binary, since the allocator counts
//! all threads.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use common::*;
use nalgebra::UnitQuaternion;
use stiefel_rs::cubic::{EmbeddedOptions, SplittingOptions, integrate_cubic, integrate_embedded};
use stiefel_rs::rotation::{RotationEnds, RotationSpline};
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
        integrate_embedded(s, v, a, j, steps, &EmbeddedOptions::default())
    } else {
        integrate_cubic(s, v, a, j, steps, &SplittingOptions::default())
    }
    .unwrap();
    let after = BLOCKS.load(Ordering::Relaxed);
    assert_eq!(trajectory.steps(), steps);
    after - before
}

/// Allocations for quaternions and rates of a spline after the first value.
fn blocks_for_rotations() -> usize {
    let t: Vec<f64> = (0..20).map(f64::from).collect();
    let turn = |t: &f64| UnitQuaternion::from_euler_angles(0.3 * t, t.sin(), 0.2 * t * t.cos());
    let keyframes: Vec<_> = t.iter().map(turn).collect();
    let natural = RotationEnds::Natural;
    let spline = RotationSpline::new(&t, &keyframes, &natural, &Default::default()).unwrap();
    spline.rotation(0.5).unwrap();
    let times: Vec<f64> = (0..1000).map(|i| 19e-3 * f64::from(i)).collect();
    let (mut quaternions, mut rates) = (vec![[0.0; 4]; 1000], vec![[0.0; 3]; 1000]);
    let before = BLOCKS.load(Ordering::Relaxed);
    spline.quaternions_into(&times, &mut quaternions).unwrap();
    spline.rates_into(&times, 2, &mut rates).unwrap();
    BLOCKS.load(Ordering::Relaxed) - before
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
    let blocks = blocks_for_rotations();
    if blocks > 0 {
        failures.push(format!("rotations: {blocks} blocks for 1000 times"));
    }
    assert!(
        failures.is_empty(),
        "more than twice the blocks for 4 or 50 times the points, or more blocks for more steps:\n{}",
        failures.join("\n")
    );
}
