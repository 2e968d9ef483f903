//! Logarithms of permutations and of block diagonal rotations, their structure, and the exponential as inverse.

use std::f64::consts::PI;

use faer::Scale;
use stiefel_rs::{orthogonal_log, skew_exp};

use crate::common::{
    EPS, Rng, Worst, assert_within, backward_error, conjugated, cyclic_permutation, distance,
    identity, plane_generators, random_orthogonal, random_rotation, random_skew, scaled, spectral,
    spread_angles,
};

#[test]
fn log_of_odd_cyclic_permutations() {
    let mut worst = Worst::new("log backward error, cyclic permutations");
    for m in [1, 3, 5, 7, 9, 25, 51] {
        worst.see(backward_error(&cyclic_permutation(m)), || {
            format!("m = {m}")
        });
    }
    worst.assert_at_most(1e-13);
}

#[test]
fn log_of_block_diagonal_rotations() {
    let mut rng = Rng::new(13);
    let mut worst = Worst::new("log backward error, block diagonal");
    for blocks in [
        vec![1, 2, 3, 4],
        vec![3, 3, 3],
        vec![5, 1, 1, 5],
        vec![25, 25],
        vec![2; 20],
    ] {
        let m: usize = blocks.iter().sum();
        let (mut q, mut start) = (identity(m), 0);
        let shared = random_rotation(blocks[0], &mut rng);
        for &size in &blocks {
            // Blocks of the same size are equal, so all of their angles repeat.
            let block = if size == blocks[0] {
                shared.clone()
            } else {
                random_rotation(size, &mut rng)
            };
            q.as_mut()
                .submatrix_mut(start, start, size, size)
                .copy_from(&block);
            start += size;
        }
        worst.see(backward_error(&q), || format!("{blocks:?}"));
    }
    worst.assert_at_most(1e-13);
}

#[test]
fn log_is_exactly_skew_with_angles_below_pi() {
    let mut rng = Rng::new(14);
    for m in 1..=30 {
        let log = orthogonal_log(random_rotation(m, &mut rng).as_ref()).unwrap();
        assert_eq!(log, -log.transpose(), "m = {m}");
        assert_within(
            spectral(log.as_ref()),
            PI,
            &format!("largest angle, m = {m}"),
        );
    }
}

#[test]
fn log_inverts_exp_below_pi() {
    let mut rng = Rng::new(15);
    let mut worst = Worst::new("|log(e^A) - A|_F in units of its conditioning");
    for m in [2, 3, 4, 5, 6, 12, 25, 50] {
        for largest in [
            1e-12,
            1e-6,
            0.1,
            1.0,
            2.0,
            3.0,
            PI - 1e-2,
            PI - 1e-4,
            PI - 1e-6,
            PI - 1e-9,
        ] {
            let mut angles = scaled(&spread_angles(m, &mut rng), largest);
            angles.sort_by(|a, b| b.total_cmp(a));
            let v = random_orthogonal(m, &mut rng);
            let a = conjugated(&v, &plane_generators(&angles, m));
            let a = (&a - a.transpose()) * Scale(0.5);
            let log = orthogonal_log(skew_exp(a.as_ref()).unwrap().as_ref()).unwrap();
            // The derivative of the logarithm in the plane of two angles: x / (2 sin(x/2)), where x is their sum.
            let sum = if m == 2 {
                0.0
            } else {
                angles[0] + angles.get(1).unwrap_or(&0.0)
            };
            let conditioning = if sum < 1e-3 {
                1.0
            } else {
                0.5 * sum / (0.5 * sum).sin()
            };
            let unit = m as f64 * EPS * conditioning;
            worst.see(distance(&log, &a) / unit, || {
                format!("m = {m}, largest angle {largest}")
            });
        }
    }
    worst.assert_at_most(8.0);
}

/// On both sides of the switch to the series: both methods agree, and small rotations have high relative accuracy.
#[test]
fn small_rotations_are_right_relative_to_their_size() {
    let mut rng = Rng::new(77);
    let mut worst = Worst::new("log(exp A) against A, relative to m");
    for m in [4, 5, 6, 12, 30, 50, 100] {
        for size in [0.05, 0.033, 0.031, 0.01, 1e-4, 1e-8, 1e-12, 1e-100, 1e-300] {
            let a = random_skew(m, size, &mut rng);
            let found = orthogonal_log(skew_exp(a.as_ref()).unwrap().as_ref()).unwrap();
            let error = distance(&(found * Scale(1.0 / size)), &(&a * Scale(1.0 / size)));
            // The basis of planes (used for angles above 0.03) leaves an absolute error.
            let allowed = if size > 0.03 { 1.0 / size } else { 1.0 };
            worst.see(error / (m as f64 * allowed), || {
                format!("m = {m}, size {size}")
            });
        }
    }
    worst.assert_at_most(1e-15);
}
