//! Exponential and logarithm are inverse to each other, for difficult spectra.

mod common;

use std::f64::consts::{FRAC_PI_2, PI};

use common::{Rng, *};
use faer::Scale;
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use stiefel_rs::linalg::SkewSchur;
use stiefel_rs::{orthogonal_log, skew_exp};

/// Difficult angles: zero, tiny, equal, supplementary, a right angle, near pi.
fn degenerate_angle() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.0),
        (1.0..16.0_f64).prop_map(|e| 10.0_f64.powf(-e)),
        Just(1.0),
        (6.0..12.0_f64).prop_map(|e| 1.0 + 10.0_f64.powf(-e)),
        Just(PI - 1.0),
        Just(FRAC_PI_2),
        (3.0..16.0_f64).prop_map(|e| FRAC_PI_2 + 10.0_f64.powf(-e)),
        (1.0..11.0_f64).prop_map(|e| PI - 10.0_f64.powf(-e)),
        0.0..3.1_f64,
    ]
}

fn degenerate_angles() -> impl Strategy<Value = (Vec<f64>, usize, u64)> {
    (
        prop::collection::vec(degenerate_angle(), 0..=9),
        0..2_usize,
        any::<u64>(),
    )
        .prop_map(|(angles, odd, seed)| (angles.clone(), (2 * angles.len() + odd).max(1), seed))
}

/// Failing seeds are stored next to this file.
fn config() -> ProptestConfig {
    let kept = FileFailurePersistence::Direct(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/log_properties.proptest-regressions"
    ));
    ProptestConfig {
        cases: 400,
        failure_persistence: Some(Box::new(kept)),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn exp_of_log_is_the_rotation((angles, m, seed) in degenerate_angles()) {
        let q = rotation_with_angles(&angles, m, &mut Rng::new(seed));
        let (error, bound) = (backward_error(&q), 5e-14);
        prop_assert!(error <= bound, "|exp(log Q) - Q| = {error:.3e} exceeds {bound:.3e}");
    }

    #[test]
    fn log_keeps_the_angles((angles, m, seed) in degenerate_angles()) {
        let q = rotation_with_angles(&angles, m, &mut Rng::new(seed));
        let log = orthogonal_log(q.as_ref()).unwrap();
        let mut schur = SkewSchur::new(m);
        schur.compute(log.as_ref()).unwrap();
        let mut expected = angles;
        expected.sort_by(|a, b| b.total_cmp(a));
        for (x, y) in schur.angles().iter().zip(&expected) {
            // Angles of orthogonal matrices are perfectly conditioned.
            let bound = 16.0 * m as f64 * EPS;
            prop_assert!((x - y).abs() <= bound, "angle {y}: error {:.3e} exceeds {bound:.3e}", x - y);
        }
    }

    #[test]
    fn log_inverts_exp_of_degenerate_angles((angles, m, seed) in degenerate_angles()) {
        let v = random_orthogonal(m, &mut Rng::new(seed));
        let a = conjugated(&v, &plane_generators(&angles, m));
        let a = (&a - a.transpose()) * Scale(0.5);
        let log = orthogonal_log(skew_exp(a.as_ref()).unwrap().as_ref()).unwrap();
        let mut sorted = angles;
        sorted.sort_by(|a, b| b.total_cmp(a));
        let sum = sorted.first().unwrap_or(&0.0) + sorted.get(1).unwrap_or(&0.0);
        let conditioning = if sum < 1e-3 { 1.0 } else { 0.5 * sum / (0.5 * sum).sin() };
        let (error, bound) = (distance(&log, &a), 8.0 * m as f64 * EPS * conditioning);
        prop_assert!(error <= bound, "|log(exp A) - A| = {error:.3e} exceeds {bound:.3e}");
    }
}
