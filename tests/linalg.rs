//! Exponentials of skew matrices and logarithms of rotations.

mod common;

use std::f64::consts::{FRAC_PI_2, PI};

use common::{Rng, *};
use faer::{Mat, Scale, mat};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use stiefel_rs::linalg::SkewSchur;
use stiefel_rs::{Error, orthogonal_log, skew_exp};

const EXP_SIZES: [usize; 8] = [1, 2, 3, 4, 5, 12, 30, 50];
const NORMS: [f64; 16] = [
    1e-300, 1e-160, 1e-16, 1e-8, 1e-3, 0.03, 0.3, 1.0, 2.5, 3.0, 6.0, 25.0, 45.0, 1e3, 1e8, 1e300,
];

/// Angles spread over `(0, 1]`, so that a factor sets their largest.
fn spread_angles(m: usize, rng: &mut Rng) -> Vec<f64> {
    (0..m / 2)
        .map(|l| if l == 0 { 1.0 } else { rng.uniform() })
        .collect()
}

fn scaled(angles: &[f64], factor: f64) -> Vec<f64> {
    angles.iter().map(|x| x * factor).collect()
}

// ---------------------------------------------------------------- exponential

#[test]
fn exp_turns_each_plane_by_its_angle() {
    let mut rng = Rng::new(1);
    let mut worst = Worst::new("exp against V blockdiag(rot) V^T, relative to m eps (1 + |A|_2)");
    for m in EXP_SIZES {
        for norm in NORMS.into_iter().filter(|x| *x <= 1e8) {
            let angles = scaled(&spread_angles(m, &mut rng), norm);
            let v = random_orthogonal(m, &mut rng);
            let a = conjugated(&v, &plane_generators(&angles, m));
            let a = (&a - a.transpose()) * Scale(0.5);
            let expected = conjugated(&v, &plane_rotations(&angles, m));
            let unit = m as f64 * EPS * (1.0 + norm);
            let error = distance(&skew_exp(a.as_ref()).unwrap(), &expected);
            worst.see(error / unit, || format!("m = {m}, norm = {norm:e}"));
        }
    }
    // A = V B V^T is itself only formed to a few m eps |A|.
    worst.assert_at_most(8.0);
}

#[test]
fn exp_is_orthogonal_at_every_norm() {
    let mut rng = Rng::new(2);
    let mut worst = Worst::new("|e^A^T e^A - I|_2 / (m 1e-15)");
    for m in EXP_SIZES {
        for norm in NORMS {
            let q = skew_exp(random_skew(m, norm, &mut rng).as_ref()).unwrap();
            worst.see(orthonormality(&q) / (m as f64 * 1e-15), || {
                format!("m = {m}, norm = {norm:e}")
            });
        }
    }
    worst.assert_at_most(1.0);
}

#[test]
fn exp_is_orthogonal_between_the_switches_of_the_algorithm() {
    let mut rng = Rng::new(3);
    let mut worst = Worst::new("|e^A^T e^A - I|_2 / (m 1e-15), fine scan");
    for m in [4, 5, 9, 16] {
        for step in 0..120 {
            let norm = 1e-2 * 1.08_f64.powi(step);
            let q = skew_exp(random_skew(m, norm, &mut rng).as_ref()).unwrap();
            worst.see(orthonormality(&q) / (m as f64 * 1e-15), || {
                format!("m = {m}, norm = {norm:e}")
            });
        }
    }
    worst.assert_at_most(1.0);
}

#[test]
fn exp_has_determinant_one() {
    let mut rng = Rng::new(4);
    for m in EXP_SIZES {
        for norm in NORMS {
            let determinant = skew_exp(random_skew(m, norm, &mut rng).as_ref())
                .unwrap()
                .determinant();
            // m columns, each orthonormal to m 1e-15, and an LU factorisation.
            let bound = 4.0 * (m * m) as f64 * EPS;
            assert_within(
                (determinant - 1.0).abs(),
                bound,
                &format!("det e^A - 1, m = {m}, norm = {norm:e}"),
            );
        }
    }
}

#[test]
fn exp_of_the_opposite_is_the_inverse() {
    let mut rng = Rng::new(5);
    let mut worst = Worst::new("|e^A e^-A - I|_F / (m eps (1 + |A|))");
    for m in EXP_SIZES {
        for norm in NORMS.into_iter().filter(|x| *x <= 1e8) {
            let a = random_skew(m, norm, &mut rng);
            let product = skew_exp(a.as_ref()).unwrap() * skew_exp((-&a).as_ref()).unwrap();
            let unit = m as f64 * EPS * (1.0 + norm);
            worst.see(distance(&product, &identity(m)) / unit, || {
                format!("m = {m}, norm = {norm:e}")
            });
        }
    }
    worst.assert_at_most(4.0);
}

#[test]
fn exp_of_zero_is_exactly_the_identity() {
    for m in EXP_SIZES {
        assert_eq!(
            skew_exp(Mat::zeros(m, m).as_ref()).unwrap(),
            identity(m),
            "m = {m}"
        );
    }
}

#[test]
fn exp_of_a_tiny_matrix_is_identity_plus_matrix() {
    let mut rng = Rng::new(6);
    for m in EXP_SIZES {
        for norm in [1e-9, 1e-30, 1e-160, 1e-300, 1e-310, 2e-323] {
            let a = random_skew(m, norm, &mut rng);
            let mut rest = skew_exp(a.as_ref()).unwrap();
            for i in 0..m {
                assert_within((rest[(i, i)] - 1.0).abs(), norm, "diagonal");
                rest[(i, i)] = 0.0;
            }
            // The second-order term, and the last bits of the denormals.
            let bound = norm * norm + 4.0 * EPS * norm + 1e-323;
            assert_within(
                largest_entry((&rest - &a).as_ref()),
                bound,
                &format!("m = {m}, norm = {norm:e}"),
            );
        }
    }
}

#[test]
fn exp_drops_a_symmetric_part_at_round_off() {
    let mut rng = Rng::new(7);
    for m in EXP_SIZES {
        let a = random_skew(m, 3.0, &mut rng);
        let g = gaussian(m, m, &mut rng);
        let perturbed = &a + (&g + g.transpose()) * Scale(1e-13 / m as f64);
        let (clean, dirty) = (skew_exp(a.as_ref()).unwrap(), skew_exp(perturbed.as_ref()));
        if m == 1 {
            assert!(
                matches!(dirty, Err(Error::NotSkew { .. })),
                "a 1 x 1 matrix is skew only if zero: {dirty:?}"
            );
        } else {
            let bound = 16.0 * m as f64 * EPS;
            assert_close(
                &dirty.unwrap(),
                &clean,
                bound,
                &format!("skew part only, m = {m}"),
            );
        }
    }
}

#[test]
fn exp_refuses_bad_input() {
    let wide = skew_exp(Mat::zeros(2, 3).as_ref());
    assert!(
        matches!(wide, Err(Error::Shape { name: "A", .. })),
        "{wide:?}"
    );
    let empty = skew_exp(Mat::zeros(0, 0).as_ref());
    assert!(
        matches!(empty, Err(Error::Shape { name: "A", .. })),
        "{empty:?}"
    );
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut a = Mat::zeros(4, 4);
        a[(1, 2)] = bad;
        let error = skew_exp(a.as_ref());
        assert!(
            matches!(
                error,
                Err(Error::NonFinite {
                    name: "A",
                    index: 9
                })
            ),
            "{error:?}"
        );
    }
    let not_skew = mat![[0.0, 1.0], [1.0, 0.0]];
    match skew_exp(not_skew.as_ref()) {
        Err(Error::NotSkew { defect, .. }) => assert_within(
            (defect - 2.0_f64.sqrt()).abs(),
            4.0 * EPS,
            "reported skew defect",
        ),
        other => panic!("expected NotSkew, found {other:?}"),
    }
    let huge = mat![[0.0, 1e308], [1e308, 0.0]];
    let overflow = skew_exp(huge.as_ref());
    assert!(
        matches!(overflow, Err(Error::NotSkew { .. })),
        "{overflow:?}"
    );
}

// ------------------------------------------------------------------ logarithm

fn backward_error(q: &Mat<f64>) -> f64 {
    let log = orthogonal_log(q.as_ref()).unwrap_or_else(|e| panic!("m = {}: {e}", q.nrows()));
    distance(&skew_exp(log.as_ref()).unwrap(), q)
}

/// Backward error of the logarithm at the sizes given for rotations with angles made by `angles(m)`.
#[track_caller]
fn check_log(name: &str, sizes: &[usize], mut angles: impl FnMut(usize, &mut Rng) -> Vec<f64>) {
    let mut rng = Rng::new(11);
    let mut worst = Worst::new(&format!("log backward error, {name}"));
    for &m in sizes {
        for _ in 0..3 {
            let q = rotation_with_angles(&angles(m, &mut rng), m, &mut rng);
            worst.see(backward_error(&q), || format!("m = {m}"));
        }
    }
    worst.assert_at_most(1e-13);
}

/// Four of each kind: closed forms, even and odd, and the size that the accuracy is stated for.
const LOG_SIZES: [usize; 14] = [1, 2, 3, 4, 5, 6, 7, 12, 25, 40, 49, 50, 59, 60];

fn all(theta: f64) -> impl FnMut(usize, &mut Rng) -> Vec<f64> {
    move |m, _| vec![theta; m / 2]
}

#[test]
fn log_of_random_rotations() {
    let mut rng = Rng::new(12);
    let mut worst = Worst::new("log backward error, random rotations");
    for m in 1..=60 {
        worst.see(backward_error(&random_rotation(m, &mut rng)), || {
            format!("m = {m}")
        });
    }
    worst.assert_at_most(1e-13);
}

#[test]
fn log_of_random_angles() {
    check_log("random angles", &LOG_SIZES, |m, rng| {
        (0..m / 2).map(|_| rng.between(0.0, 3.1)).collect()
    });
}

#[test]
fn log_of_identity_is_exactly_zero() {
    for m in 1..=60 {
        let log = orthogonal_log(identity(m).as_ref()).unwrap();
        assert_eq!(log, Mat::zeros(m, m), "m = {m}");
    }
}

#[test]
fn log_of_small_angles() {
    for largest in [1e-3, 1e-5, 1e-8, 1e-12, 1e-16] {
        check_log(
            &format!("angles below {largest:e}"),
            &LOG_SIZES,
            |m, rng| (0..m / 2).map(|_| rng.between(0.0, largest)).collect(),
        );
    }
}

#[test]
fn log_of_equal_angles() {
    for theta in [0.0, 1e-9, 1e-4, 0.3, 1.0, FRAC_PI_2, 2.5, 3.0] {
        check_log(&format!("all angles {theta}"), &LOG_SIZES, all(theta));
    }
    check_log("20 angles equal, others random", &[50, 51], |_, rng| {
        (0..25)
            .map(|l| if l < 20 { 1.1 } else { rng.between(0.0, 3.0) })
            .collect()
    });
}

#[test]
fn log_of_clustered_angles() {
    for centre in [1e-3, 0.02, 1.0, FRAC_PI_2, 2.0, 3.0, PI - 1e-3] {
        for spread in [1e-10, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4] {
            check_log(
                &format!("20 angles {spread:e} apart at {centre}"),
                &[50, 51],
                |_, rng| {
                    let cluster = |l: usize| centre + spread * (l as f64 - 10.0);
                    (0..25)
                        .map(|l| {
                            if l < 20 {
                                cluster(l).min(PI - 1e-9)
                            } else {
                                rng.between(0.0, 3.0)
                            }
                        })
                        .collect()
                },
            );
        }
    }
}

#[test]
fn log_of_angles_near_pi() {
    for distance in [1e-4, 1e-10] {
        check_log(
            &format!("one angle pi - {distance:e}"),
            &LOG_SIZES,
            |m, rng| {
                (0..m / 2)
                    .map(|l| {
                        if l == 0 {
                            PI - distance
                        } else {
                            rng.between(0.0, 3.0)
                        }
                    })
                    .collect()
            },
        );
        check_log(
            &format!("every third angle pi - {distance:e}"),
            &LOG_SIZES,
            |m, rng| {
                (0..m / 2)
                    .map(|l| {
                        if l % 3 == 0 {
                            PI - distance
                        } else {
                            rng.between(0.0, 3.0)
                        }
                    })
                    .collect()
            },
        );
        check_log(
            &format!("all angles pi - {distance:e}"),
            &LOG_SIZES,
            all(PI - distance),
        );
    }
    for j in 1..=12 {
        let distance = 10.0_f64.powi(-j);
        check_log(&format!("one angle pi - 1e-{j}"), &LOG_SIZES, |m, rng| {
            (0..m / 2)
                .map(|l| {
                    if l == 0 {
                        PI - distance
                    } else {
                        rng.between(0.0, 3.0)
                    }
                })
                .collect()
        });
    }
    // Pairs whose cosines are just far enough apart to be two groups, and whose angles nearly add up to 2 pi.
    check_log("angles pi - 4e-4 and pi - 6.1e-4", &LOG_SIZES, |m, _| {
        (0..m / 2)
            .map(|l| PI - if l % 2 == 0 { 4e-4 } else { 6.1e-4 })
            .collect()
    });
    check_log("angles pi - 1e-j, j = 1..=12", &[24, 25, 50], |m, _| {
        (0..m / 2)
            .map(|l| PI - 10.0_f64.powi(-(l as i32 % 12 + 1)))
            .collect()
    });
    for largest in [1e-1, 1e-2, 2e-3, 1e-3, 1e-4, 1e-6] {
        check_log(
            &format!("all angles within {largest:e} of pi"),
            &LOG_SIZES,
            |m, rng| {
                (0..m / 2)
                    .map(|_| PI - largest * rng.between(0.01, 1.0))
                    .collect()
            },
        );
    }
}

#[test]
fn log_of_supplementary_angles() {
    check_log("pairs theta, pi - theta", &LOG_SIZES, |m, rng| {
        let thetas: Vec<f64> = (0..m.div_ceil(4))
            .map(|_| rng.between(0.01, FRAC_PI_2))
            .collect();
        (0..m / 2)
            .map(|l| {
                if l % 2 == 0 {
                    thetas[l / 2]
                } else {
                    PI - thetas[l / 2]
                }
            })
            .collect()
    });
}

#[test]
fn log_with_a_null_space() {
    check_log("half of the planes at rest", &LOG_SIZES, |m, rng| {
        (0..m / 2)
            .map(|l| {
                if l % 2 == 0 {
                    0.0
                } else {
                    rng.between(0.0, 3.1)
                }
            })
            .collect()
    });
}

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
            // Blocks of one size are equal, so all of their angles repeat.
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
            // The derivative of the logarithm in the plane of two angles: x / (2 sin(x/2)), x their sum.
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

#[test]
fn log_refuses_determinant_minus_one() {
    let mut rng = Rng::new(16);
    for m in (1..=20).chain([33, 50, 51]) {
        for angle in [0.0, 1e-9, 1.0, PI - 1e-6] {
            let mut q = identity(m);
            if m > 2 {
                q = plane_rotations(&vec![angle; (m - 1) / 2], m);
            }
            q[(m - 1, m - 1)] = -1.0;
            let q = conjugated(&random_orthogonal(m, &mut rng), &q);
            let error = orthogonal_log(q.as_ref());
            // An angle of pi - 1e-6 in the same group may be mistaken for the one at pi.
            let found = error.as_ref().err().and_then(Error::angle);
            assert!(
                matches!(error, Err(Error::OutsideLogDomain { .. })),
                "m = {m}, angle = {angle}: {error:?}"
            );
            assert_within(
                (found.unwrap() - PI).abs(),
                1e-12,
                &format!("reported angle, m = {m}"),
            );
        }
    }
}

#[test]
fn log_refuses_random_reflections() {
    let mut rng = Rng::new(17);
    for m in (1..=20).chain([50, 51]) {
        let mut q = random_rotation(m, &mut rng);
        negate_column(&mut q, 0);
        let error = orthogonal_log(q.as_ref());
        assert!(
            matches!(error, Err(Error::OutsideLogDomain { angle }) if angle == PI),
            "m = {m}: {error:?}"
        );
    }
}

#[test]
fn log_refuses_even_cyclic_permutations() {
    for m in [2, 4, 6, 10, 24, 50] {
        let error = orthogonal_log(cyclic_permutation(m).as_ref());
        assert!(
            matches!(error, Err(Error::OutsideLogDomain { .. })),
            "m = {m}: {error:?}"
        );
    }
}

#[test]
fn log_refuses_eigenvalue_minus_one() {
    for m in [2, 3, 4, 5, 10] {
        for pairs in 1..=m / 2 {
            let q = Mat::from_fn(m, m, |i, j| {
                f64::from(u8::from(i == j)) * if i < 2 * pairs { -1.0 } else { 1.0 }
            });
            match orthogonal_log(q.as_ref()) {
                Err(Error::OutsideLogDomain { angle }) => {
                    assert_eq!(angle, PI, "m = {m}, {pairs} pairs")
                }
                other => {
                    panic!("m = {m}, {pairs} pairs: expected OutsideLogDomain, found {other:?}")
                }
            }
        }
    }
}

#[test]
fn log_refuses_a_rotated_eigenvalue_minus_one() {
    let mut rng = Rng::new(18);
    for m in [2, 3, 4, 5, 10, 30, 50] {
        let q = rotation_with_angles(&[PI], m, &mut rng);
        match orthogonal_log(q.as_ref()) {
            Err(Error::OutsideLogDomain { angle }) => assert_within(
                (angle - PI).abs(),
                4.0 * m as f64 * EPS,
                &format!("reported angle, m = {m}"),
            ),
            other => panic!("m = {m}: expected OutsideLogDomain, found {other:?}"),
        }
    }
}

#[test]
fn log_refuses_bad_input() {
    let wide = orthogonal_log(Mat::zeros(2, 3).as_ref());
    assert!(
        matches!(wide, Err(Error::Shape { name: "Q", .. })),
        "{wide:?}"
    );
    let empty = orthogonal_log(Mat::zeros(0, 0).as_ref());
    assert!(
        matches!(empty, Err(Error::Shape { name: "Q", .. })),
        "{empty:?}"
    );
    let mut nan = identity(4);
    nan[(2, 1)] = f64::NAN;
    let error = orthogonal_log(nan.as_ref());
    assert!(
        matches!(
            error,
            Err(Error::NonFinite {
                name: "Q",
                index: 6
            })
        ),
        "{error:?}"
    );
    let stretched = identity(4) * Scale(1.5);
    match orthogonal_log(stretched.as_ref()) {
        Err(Error::NotOrthonormal { defect, .. }) => assert_within(
            (defect - 2.5).abs(),
            8.0 * EPS,
            "reported orthonormality defect",
        ),
        other => panic!("expected NotOrthonormal, found {other:?}"),
    }
    let huge = orthogonal_log((identity(4) * Scale(1e200)).as_ref());
    assert!(
        matches!(huge, Err(Error::NotOrthonormal { .. })),
        "{huge:?}"
    );
    let mut overflow = identity(2) * Scale(1e200);
    overflow[(0, 1)] = -1e200;
    let error = orthogonal_log(overflow.as_ref());
    assert!(
        matches!(error, Err(Error::NotOrthonormal { .. })),
        "{error:?}"
    );
}

// ------------------------------------------------------------------ properties

/// Angles that aim at trouble: zero, tiny, equal to one another, supplementary, a right angle, near pi.
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

/// Failing seeds are kept beside this file.
fn config() -> ProptestConfig {
    let kept = FileFailurePersistence::Direct(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/linalg.proptest-regressions"
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
