//! Logarithms of unitary matrices.

use std::f64::consts::PI;

use faer::{Mat, MatRef, Scale, c64, mat};
use stiefel_rs::linalg::UnitaryLog;
use stiefel_rs::{Error, skew_exp, unitary_log};

use crate::common::{self, EPS, Rng, Worst, gaussian, random_rotation};
use crate::*;

/// `|e^L - U|_2 / (m 1e-15)`; checks that the result is exactly skew-Hermitian, with angles in `(-pi, pi]`.
fn backward(u: &Mat<c64>) -> f64 {
    let m = u.nrows();
    let log = unitary_log(u.as_ref()).unwrap();
    for j in 0..m {
        for i in 0..m {
            assert_eq!(
                log[(i, j)],
                -log[(j, i)].conj(),
                "m = {m}: not skew-Hermitian"
            );
        }
    }
    assert!(
        spectral(&log) <= PI * (1.0 + (4.0 + m as f64) * EPS),
        "m = {m}: {}",
        spectral(&log)
    );
    distance(&skew_exp(log.as_ref()).unwrap(), u) / (m as f64 * 1e-15)
}

#[track_caller]
fn check_log(name: &str, mut angles: impl FnMut(usize, &mut Rng) -> Vec<f64>) {
    let mut rng = Rng::new(11);
    let mut worst = Worst::new(&format!("log backward error / (m 1e-15), {name}"));
    for m in SIZES {
        for _ in 0..3 {
            let b = random_unitary(m, &mut rng);
            let u = unitary_with_angles(&b, &angles(m, &mut rng));
            worst.see(backward(&u), || format!("m = {m}"));
            // Also with its eigenvectors along the axes.
            let diagonal: Vec<c64> = angles(m, &mut rng).into_iter().map(phase).collect();
            worst.see(backward(&super::diagonal(&diagonal)), || {
                format!("diagonal, m = {m}")
            });
        }
    }
    // U is unitary only to a few eps, and the exponential used for comparison is as accurate.
    worst.assert_at_most(2.0);
}

#[test]
fn log_of_random_unitary_matrices() {
    let mut rng = Rng::new(12);
    let mut worst = Worst::new("log backward error / (m 1e-15), random");
    for m in (1..=40).chain([64, 80, 130]) {
        worst.see(backward(&random_unitary(m, &mut rng)), || {
            format!("m = {m}")
        });
    }
    worst.assert_at_most(2.0);
}

#[test]
fn log_of_random_angles() {
    check_log("random angles", |m, rng| {
        (0..m).map(|_| rng.between(-PI, PI)).collect()
    });
}

#[test]
fn log_of_repeated_angles() {
    for angle in [
        0.0,
        1e-3,
        0.7,
        0.7 + 0.5 * PI,
        0.7 - PI,
        2.0,
        -3.0,
        PI,
        PI - 1e-9,
        1e-9 - PI,
    ] {
        check_log(&format!("all {angle}"), |m, _| vec![angle; m]);
        check_log(&format!("half {angle}"), |m, _| {
            (0..m)
                .map(|j| if j % 2 == 0 { angle } else { -angle })
                .collect()
        });
    }
}

/// Angles for which the first Hermitian matrix has repeated eigenvalues: symmetric about the direction of the
/// combination.
#[test]
fn log_of_angles_that_share_a_cosine() {
    for off in [0.0, 1e-12, 1e-9, 1e-8, 1e-7, 2e-7, 1e-6, 1e-4] {
        check_log(&format!("mirrored, off by {off}"), |m, rng| {
            let angles: Vec<f64> = (0..m.div_ceil(2)).map(|_| rng.between(0.0, 3.0)).collect();
            (0..m)
                .map(|j| {
                    0.7 + angles[j / 2] * if j % 2 == 0 { 1.0 } else { -1.0 } + off * (j % 2) as f64
                })
                .collect()
        });
    }
}

#[test]
fn log_of_clustered_angles() {
    for centre in [
        0.0,
        0.7,
        0.7 + 0.5 * PI,
        0.7 - 0.5 * PI,
        0.7 - PI,
        2.0,
        PI,
        -1.3,
    ] {
        for gap in [1e-15, 1e-13, 1e-11, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4] {
            check_log(&format!("around {centre} by {gap:e}"), |m, rng| {
                (0..m)
                    .map(|_| centre + gap * rng.between(-1.0, 1.0))
                    .collect()
            });
        }
    }
}

#[test]
fn log_of_roots_of_unity_and_permutations() {
    let mut worst = Worst::new("log backward error / (m 1e-15), permutations");
    let mut rng = Rng::new(13);
    for m in 1..=30 {
        let zero = Mat::zeros(m, m);
        let cycle = common::cyclic_permutation(m);
        worst.see(backward(&complex(&cycle, &zero)), || {
            format!("cycle of {m}")
        });
        let turned = complex(&cycle, &zero) * Scale(phase(rng.between(-PI, PI)));
        worst.see(backward(&turned), || format!("turned cycle of {m}"));
        let rotation = random_rotation(m, &mut rng);
        worst.see(backward(&complex(&rotation, &zero)), || {
            format!("rotation, m = {m}")
        });
        let reflection = complex(&rotation, &zero) * Scale(c64::new(-1.0, 0.0));
        worst.see(backward(&reflection), || {
            format!("minus a rotation, m = {m}")
        });
    }
    worst.assert_at_most(2.0);
}

#[test]
fn log_of_minus_one_has_the_angle_pi() {
    let mut rng = Rng::new(14);
    for m in SIZES {
        let minus = identity(m) * Scale(c64::new(-1.0, 0.0));
        let log = unitary_log(minus.as_ref()).unwrap();
        let expected = identity(m) * Scale(i_times(PI));
        assert!(distance(&log, &expected) < 4.0 * EPS * PI, "m = {m}");
        // On half of the space, in a random basis: both signs of the angle are equal to round-off, and pi is chosen.
        let half: Vec<f64> = (0..m).map(|j| if j % 2 == 0 { PI } else { 0.3 }).collect();
        let b = random_unitary(m, &mut rng);
        let log = unitary_log(unitary_with_angles(&b, &half).as_ref()).unwrap();
        let error = distance(&log, &skew_with_angles(&b, &half));
        assert!(error < 20.0 * m as f64 * EPS, "m = {m}: {error:e}");
    }
    let exchange = mat![[0.0, 1.0], [1.0, 0.0]];
    let log = unitary_log(complex(&exchange, &Mat::zeros(2, 2)).as_ref()).unwrap();
    assert!(
        (log[(0, 0)] - i_times(0.5 * PI)).norm() < EPS && (log[(0, 1)] + log[(0, 0)]).norm() < EPS
    );
}

#[test]
fn log_of_small_angles_is_relatively_exact() {
    let mut rng = Rng::new(15);
    let mut worst = Worst::new("|log - L| / (m eps |L|), small angles");
    for m in SIZES {
        for size in [1e-300, 1e-160, 1e-9, 1e-3, 0.01] {
            let l = random_skew_hermitian(m, size, &mut rng);
            // e^L computed directly if it is I + L: the exponential is not under test.
            let u = if size < 1e-8 {
                identity(m) + &l
            } else {
                skew_exp(l.as_ref()).unwrap()
            };
            let log = unitary_log(u.as_ref()).unwrap();
            let scaled = |a: &Mat<c64>| Mat::from_fn(m, m, |i, j| a[(i, j)] / size);
            // The rounding of U is an error of eps; L^3 / 6 is neglected.
            let unit = m as f64 * EPS * (1.0 + if size >= 1e-8 { 1.0 / size } else { 0.0 });
            worst.see(distance(&scaled(&log), &scaled(&l)) / unit, || {
                format!("m = {m}, |L| = {size:e}")
            });
        }
    }
    worst.assert_at_most(4.0);
}

#[test]
fn log_is_that_of_the_nearest_unitary_matrix() {
    let mut rng = Rng::new(16);
    let mut worst = Worst::new("log of the nearest unitary matrix");
    for m in [1, 2, 3, 4, 6, 30] {
        for angle in [1e-3, 1.0, 3.1] {
            let b = random_unitary(m, &mut rng);
            let angles: Vec<f64> = (0..m).map(|j| angle / (1.0 + 0.3 * j as f64)).collect();
            let u = unitary_with_angles(&b, &angles);
            let noise = complex(&gaussian(m, m, &mut rng), &gaussian(m, m, &mut rng));
            let hermitian = &noise + noise.adjoint();
            let size = hermitian.norm_l2();
            let off = &u + &u * hermitian * Scale(c64::new(2e-10 / size, 0.0));
            let log = unitary_log(off.as_ref()).unwrap();
            let error = distance(&log, &unitary_log(u.as_ref()).unwrap());
            worst.see(error / (m as f64 * EPS), || {
                format!("m = {m}, angle = {angle}")
            });
        }
    }
    // For angles of 3.1 the logarithm has condition number 1: it is singular only at differences of 2 pi.
    worst.assert_at_most(30.0);
}

#[test]
fn log_gives_the_skew_matrix_back() {
    let mut rng = Rng::new(17);
    let mut worst = Worst::new("|log(e^A) - A| / (m eps)");
    for m in SIZES {
        for norm in [0.02, 0.5, 1.5, 2.5] {
            let a = random_skew_hermitian(m, norm, &mut rng);
            let log = unitary_log(skew_exp(a.as_ref()).unwrap().as_ref()).unwrap();
            worst.see(distance(&log, &a) / (m as f64 * EPS), || {
                format!("m = {m}, norm = {norm}")
            });
        }
    }
    worst.assert_at_most(40.0);
}

#[test]
fn log_is_that_of_the_embedding_in_real_matrices() {
    let mut rng = Rng::new(18);
    for m in [1, 2, 3, 5, 12, 40] {
        let u = skew_exp(random_skew_hermitian(m, 2.5, &mut rng).as_ref()).unwrap();
        let real = stiefel_rs::orthogonal_log(embedded(&u).as_ref()).unwrap();
        let found = embedded(&unitary_log(u.as_ref()).unwrap());
        let error = common::distance(&found, &real);
        assert!(error < 40.0 * m as f64 * EPS, "m = {m}: {error:e}");
    }
}

#[test]
fn log_refuses_what_is_not_unitary() {
    let mut rng = Rng::new(19);
    for m in [1, 2, 3, 30] {
        let u = random_unitary(m, &mut rng);
        let off = &u * Scale(c64::new(1.0 + 1e-6, 0.0));
        match unitary_log(off.as_ref()) {
            Err(Error::NotUnitary {
                name: "Q", defect, ..
            }) => {
                let expected = 2e-6 * (m as f64).sqrt();
                assert!(
                    (defect / expected - 1.0).abs() < 1e-5,
                    "m = {m}: {defect:e}"
                );
            }
            other => panic!("m = {m}: {other:?}"),
        }
        for bad in [f64::NAN, f64::INFINITY] {
            let mut off = u.clone();
            off[(m - 1, 0)] = c64::new(0.0, bad);
            let error = unitary_log(off.as_ref()).unwrap_err();
            assert_eq!(
                error,
                Error::NonFinite {
                    name: "Q",
                    index: m - 1
                }
            );
        }
        let huge = unitary_log((&u * Scale(c64::new(1e200, 0.0))).as_ref());
        assert!(matches!(huge, Err(Error::NotUnitary { .. })), "{huge:?}");
        let zero = unitary_log(Mat::<c64>::zeros(m, m).as_ref());
        assert!(matches!(zero, Err(Error::NotUnitary { .. })), "{zero:?}");
    }
    let shape = |a: MatRef<'_, c64>| matches!(unitary_log(a), Err(Error::Shape { name: "Q", .. }));
    assert!(shape(Mat::zeros(2, 3).as_ref()) && shape(Mat::zeros(0, 0).as_ref()));
}

#[test]
fn log_buffers_serve_many_matrices_in_rows_and_columns() {
    let mut rng = Rng::new(20);
    for m in [2, 3, 8, 30, 90] {
        let mut log = UnitaryLog::new(m);
        for round in 0..4 {
            let angles: Vec<f64> = (0..m)
                .map(|j| {
                    if round % 2 == 0 {
                        rng.between(-3.0, 3.0)
                    } else {
                        (j % 3) as f64
                    }
                })
                .collect();
            let u = unitary_with_angles(&random_unitary(m, &mut rng), &angles);
            let expected = unitary_log(u.as_ref()).unwrap();
            let (mut columns, mut rows) = (Mat::zeros(m, m), Mat::zeros(m, m));
            log.checked_into(columns.as_mut(), u.as_ref()).unwrap();
            assert_eq!(columns, expected, "m = {m}: the buffers remember");
            log.checked_into(rows.as_mut().transpose_mut(), u.as_ref())
                .unwrap();
            let error = distance(&rows.transpose().to_owned(), &expected);
            assert!(error < 400.0 * m as f64 * EPS, "m = {m}: {error:e}");
        }
    }
}
