//! Backward errors of the logarithm for angles of every kind.

use std::f64::consts::{FRAC_PI_2, PI};

use faer::{Mat, Scale};
use stiefel_rs::orthogonal_log;

use crate::common::{
    Rng, Worst, backward_error, distance, frobenius, identity, random_rotation,
    rotation_with_angles,
};

/// Backward error of the logarithm, at the given sizes, for rotations with angles from `angles(m)`.
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

/// Sizes of four kinds: closed forms, even, odd, and the size for which the accuracy is stated.
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
                // A symmetric positive definite factor, so that the rotation is the polar factor of the product.
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
    // The stretch is accurate to 1e-16; the square of the defect is 4e-20.
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
    // Pairs whose cosines are just far enough apart to form two groups, and whose angles nearly add up to 2 pi.
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

/// Sizes on both sides of the switch between the two methods for the planes; sines just separated, and just not.
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
                // One angle, and the supplement of another, whose sines differ by the gap.
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
        // Smallest sine near the gap, at 0 and at pi.
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
