//! Logarithms of rotations.

mod common;

use std::f64::consts::{FRAC_PI_2, PI};

use common::{Rng, *};
use faer::{Mat, Scale};
use stiefel_rs::{Error, orthogonal_log, skew_exp};

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
fn log_of_what_is_nearly_a_rotation_is_that_of_the_nearest() {
    let mut rng = Rng::new(17);
    let mut worst = Worst::new("log of the nearest rotation");
    for m in [2, 3, 4, 5, 6, 9] {
        for angle in [1e-3, 0.5, 2.0, 3.1] {
            for _ in 0..20 {
                let angles: Vec<f64> = (0..m / 2).map(|i| angle / (1.0 + 0.3 * i as f64)).collect();
                let nearest = rotation_with_angles(&angles, m, &mut rng);
                // A symmetric positive definite factor: the first is the polar factor of the product.
                let noise = Mat::from_fn(m, m, |_, _| rng.normal());
                let stretch = (&noise + noise.transpose()) * Scale(0.5);
                let stretch = &stretch * Scale(2e-10 / frobenius(stretch.as_ref()));
                let found = orthogonal_log((&nearest + &nearest * &stretch).as_ref()).unwrap();
                let exact = orthogonal_log(nearest.as_ref()).unwrap();
                worst.see(distance(&found, &exact), || {
                    format!("m = {m}, angle {angle}")
                });
            }
        }
    }
    // The stretch is known to 1e-16; the square of the defect is 4e-20.
    worst.assert_at_most(3e-14);
}

#[test]
fn log_of_identity_is_exactly_zero() {
    for m in 1..=60 {
        let log = orthogonal_log(identity(m).as_ref()).unwrap();
        assert_eq!(log, Mat::<f64>::zeros(m, m), "m = {m}");
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

/// Sizes on both sides of the switch between the two ways to the planes; sines just apart and not.
#[test]
fn log_on_both_sides_of_its_switches() {
    let mut rng = Rng::new(16);
    let mut worst = Worst::new("log backward error / (m 1e-15), at the switches");
    for m in [79, 80, 81, 82, 83, 127, 128, 129, 160] {
        worst.see(
            backward_error(&random_rotation(m, &mut rng)) / (m as f64 * 1e-15),
            || format!("m = {m}"),
        );
    }
    for m in [4, 5, 12, 30] {
        for gap in [1e-8, 0.9e-7, 1.1e-7, 3e-7, 1e-6, 1e-4] {
            for centre in [1e-3_f64, 0.7, FRAC_PI_2 - 1e-3] {
                // One angle and the supplement of another whose sine differs by the gap.
                let other = PI - (centre.sin() + gap).min(1.0).asin();
                let mut angles = vec![0.3; m / 2];
                (angles[0], angles[1]) = (centre, other);
                for (l, angle) in angles.iter_mut().enumerate().skip(2) {
                    *angle = 0.1 + 0.08 * l as f64;
                }
                let q = rotation_with_angles(&angles, m, &mut rng);
                worst.see(backward_error(&q) / (m as f64 * 1e-15), || {
                    format!("m = {m}, sines {gap:e} apart at {centre}")
                });
            }
        }
        // Smallest sine around the gap, at 0 and at pi.
        for small in [0.5e-7, 0.99e-7, 1.01e-7, 2e-7] {
            for angle in [small, PI - small] {
                let mut angles: Vec<f64> = (0..m / 2).map(|l| 0.2 + 0.15 * l as f64).collect();
                angles[0] = angle;
                let q = rotation_with_angles(&angles, m, &mut rng);
                worst.see(backward_error(&q) / (m as f64 * 1e-15), || {
                    format!("m = {m}, angle {angle}")
                });
            }
        }
    }
    worst.assert_at_most(1.0);
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

/// Both sides of the switch to the series: the two ways agree, and small rotations are right relative to their size.
#[test]
fn small_rotations_are_right_relative_to_their_size() {
    let mut rng = Rng::new(77);
    let mut worst = Worst::new("log(exp A) against A, relative to m");
    for m in [4, 5, 6, 12, 30, 50, 100] {
        for size in [0.05, 0.033, 0.031, 0.01, 1e-4, 1e-8, 1e-12, 1e-100, 1e-300] {
            let a = random_skew(m, size, &mut rng);
            let found = orthogonal_log(skew_exp(a.as_ref()).unwrap().as_ref()).unwrap();
            let error = distance(&(found * Scale(1.0 / size)), &(&a * Scale(1.0 / size)));
            // The basis of planes (angles above 0.03) leaves an absolute error.
            let allowed = if size > 0.03 { 1.0 / size } else { 1.0 };
            worst.see(error / (m as f64 * allowed), || {
                format!("m = {m}, size {size}")
            });
        }
    }
    worst.assert_at_most(1e-15);
}
