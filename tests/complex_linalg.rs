//! Exponentials of skew-Hermitian matrices and logarithms of unitary ones.

mod common;

use std::f64::consts::PI;

use common::{EPS, Rng, Worst, gaussian, random_rotation, random_skew};
use faer::{Mat, MatRef, Scale, c64, mat};
use stiefel_rs::linalg::{SkewExp, UnitaryLog};
use stiefel_rs::{Error, skew_exp, unitary_log};

const SIZES: [usize; 12] = [1, 2, 3, 4, 5, 8, 12, 23, 24, 30, 50, 81];

fn i_times(x: f64) -> c64 {
    c64::new(0.0, x)
}

fn phase(angle: f64) -> c64 {
    c64::new(angle.cos(), angle.sin())
}

fn complex(re: &Mat<f64>, im: &Mat<f64>) -> Mat<c64> {
    Mat::from_fn(re.nrows(), re.ncols(), |i, j| c64::new(re[(i, j)], im[(i, j)]))
}

fn identity(m: usize) -> Mat<c64> {
    Mat::identity(m, m)
}

fn random_unitary(m: usize, rng: &mut Rng) -> Mat<c64> {
    complex(&gaussian(m, m, rng), &gaussian(m, m, rng)).qr().compute_thin_Q()
}

fn diagonal(entries: &[c64]) -> Mat<c64> {
    Mat::from_fn(entries.len(), entries.len(), |i, j| {
        if i == j { entries[i] } else { c64::new(0.0, 0.0) }
    })
}

/// `B diag(entries) B^H`.
fn conjugated(b: &Mat<c64>, entries: impl Iterator<Item = c64>) -> Mat<c64> {
    b * diagonal(&entries.collect::<Vec<_>>()) * b.adjoint()
}

fn skew_with_angles(b: &Mat<c64>, angles: &[f64]) -> Mat<c64> {
    let a = conjugated(b, angles.iter().map(|x| i_times(*x)));
    (&a - a.adjoint()) * Scale(c64::new(0.5, 0.0))
}

fn unitary_with_angles(b: &Mat<c64>, angles: &[f64]) -> Mat<c64> {
    conjugated(b, angles.iter().map(|x| phase(*x)))
}

fn spectral(a: &Mat<c64>) -> f64 {
    a.singular_values().expect("singular values of finite input")[0]
}

fn distance(a: &Mat<c64>, b: &Mat<c64>) -> f64 {
    spectral(&(a - b))
}

fn unitarity(u: &Mat<c64>) -> f64 {
    distance(&(u.adjoint() * u), &identity(u.nrows()))
}

fn random_skew_hermitian(m: usize, norm: f64, rng: &mut Rng) -> Mat<c64> {
    let x = complex(&gaussian(m, m, rng), &gaussian(m, m, rng));
    let a = &x - x.adjoint();
    let size = spectral(&a);
    Mat::from_fn(m, m, |i, j| a[(i, j)] / size * norm)
}

fn embedded(a: &Mat<c64>) -> Mat<f64> {
    let m = a.nrows();
    Mat::from_fn(2 * m, 2 * m, |i, j| {
        let x = a[(i % m, j % m)];
        match (i < m, j < m) {
            (true, true) | (false, false) => x.re,
            (true, false) => -x.im,
            (false, true) => x.im,
        }
    })
}

// ---------------------------------------------------------------- exponential

/// Norms between and on both sides of the switches of the algorithm.
const NORMS: [f64; 20] = [
    1e-300, 1e-160, 1e-16, 1e-8, 2.2e-4, 2.4e-4, 8e-3, 0.05, 0.17, 0.7, 1.0, 1.69, 3.3, 3.5, 13.0, 14.0, 60.0, 1e3, 3e3,
    1e8,
];

#[test]
fn exp_turns_each_eigenvector_by_its_angle() {
    let mut rng = Rng::new(1);
    let mut worst = Worst::new("e^A against B diag(e^{i t}) B^H, relative to m eps (1 + |A|_2)");
    for m in SIZES {
        for norm in NORMS {
            for equal in [false, true] {
                let b = random_unitary(m, &mut rng);
                let angles: Vec<f64> = (0..m)
                    .map(|_| norm * if equal { 1.0 } else { rng.between(-1.0, 1.0) })
                    .collect();
                let found = skew_exp(skew_with_angles(&b, &angles).as_ref()).unwrap();
                let unit = m as f64 * EPS * (1.0 + norm);
                let error = distance(&found, &unitary_with_angles(&b, &angles));
                worst.see(error / unit, || format!("m = {m}, norm = {norm:e}"));
            }
        }
    }
    // A is itself only formed to a few m eps |A|.
    worst.assert_at_most(8.0);
}

#[test]
fn exp_is_unitary_at_every_norm() {
    let mut rng = Rng::new(2);
    let mut worst = Worst::new("|U^H U - I|_2 / (m 1e-15)");
    for m in SIZES {
        for norm in NORMS.into_iter().chain([1e300]) {
            let u = skew_exp(random_skew_hermitian(m, norm, &mut rng).as_ref()).unwrap();
            worst.see(unitarity(&u) / (m as f64 * 1e-15), || {
                format!("m = {m}, norm = {norm:e}")
            });
        }
    }
    worst.assert_at_most(1.0);
}

#[test]
fn exp_is_unitary_between_the_switches() {
    let mut rng = Rng::new(3);
    let mut worst = Worst::new("|U^H U - I|_2 / (m 1e-15), fine scan");
    for m in [2, 3, 4, 9, 70] {
        for step in 0..100 {
            let norm = 1e-2 * 1.1_f64.powi(step);
            let u = skew_exp(random_skew_hermitian(m, norm, &mut rng).as_ref()).unwrap();
            worst.see(unitarity(&u) / (m as f64 * 1e-15), || {
                format!("m = {m}, norm = {norm:e}")
            });
        }
    }
    worst.assert_at_most(1.0);
}

#[test]
fn exp_is_that_of_the_embedding_in_real_matrices() {
    let mut rng = Rng::new(4);
    let mut worst = Worst::new("e^A against the real exponential / (m eps (1 + |A|_2))");
    for m in SIZES {
        for norm in [1e-3, 0.5, 2.0, 10.0, 200.0] {
            let a = random_skew_hermitian(m, norm, &mut rng);
            let real = skew_exp(embedded(&a).as_ref()).unwrap();
            let error = common::distance(&embedded(&skew_exp(a.as_ref()).unwrap()), &real);
            let unit = m as f64 * EPS * (1.0 + norm);
            worst.see(error / unit, || format!("m = {m}, norm = {norm}"));
        }
    }
    worst.assert_at_most(8.0);
}

#[test]
fn exp_of_a_real_or_an_imaginary_matrix_keeps_its_structure() {
    let mut rng = Rng::new(5);
    for m in [2, 3, 5, 30] {
        let skew = random_skew(m, 1.5, &mut rng);
        let zero = Mat::zeros(m, m);
        let u = skew_exp(complex(&skew, &zero).as_ref()).unwrap();
        let real = skew_exp(skew.as_ref()).unwrap();
        assert!(distance(&u, &complex(&real, &zero)) < 4.0 * m as f64 * EPS, "m = {m}");
        let phases = skew_exp(diagonal(&vec![i_times(0.7); m]).as_ref()).unwrap();
        let expected = identity(m) * Scale(phase(0.7));
        assert!(distance(&phases, &expected) < 4.0 * EPS, "m = {m}");
        assert_eq!(skew_exp(Mat::<c64>::zeros(m, m).as_ref()).unwrap(), identity(m));
    }
}

#[test]
fn exp_counts_the_skew_part_and_scales() {
    let mut rng = Rng::new(6);
    for m in [1, 2, 5] {
        let a = random_skew_hermitian(m, 2.0, &mut rng);
        let mut out = Mat::zeros(m, m);
        let mut exp = SkewExp::new(m);
        exp.exp_into(out.as_mut(), (&a + identity(m)).as_ref(), -0.5).unwrap();
        let expected = skew_exp((&a * Scale(c64::new(-0.5, 0.0))).as_ref()).unwrap();
        assert!(distance(&out, &expected) < 8.0 * m as f64 * EPS, "m = {m}");
    }
}

#[test]
fn exp_refuses_what_is_not_skew_hermitian() {
    let mut rng = Rng::new(7);
    for m in [1, 2, 3, 6, 30] {
        for norm in [1e-200, 1.0, 1e200] {
            let a = random_skew_hermitian(m, norm, &mut rng);
            let mut off = a.clone();
            off[(0, 0)] += c64::new(1e-6 * norm, 0.0);
            match skew_exp(off.as_ref()) {
                Err(Error::NotSkewHermitian { name: "A", defect, tolerance }) => {
                    assert!((defect / (1e-6 * norm) - 1.0).abs() < 1e-3, "{defect:e}");
                    assert!(tolerance < 2e-12 * norm * (m as f64).sqrt());
                }
                other => panic!("m = {m}, norm = {norm:e}: {other:?}"),
            }
            off[(0, 0)] = i_times(f64::NAN);
            let error = skew_exp(off.as_ref()).unwrap_err();
            assert_eq!(error, Error::NonFinite { name: "A", index: 0 });
        }
    }
    let shape = skew_exp(Mat::<c64>::zeros(2, 3).as_ref());
    assert!(matches!(shape, Err(Error::Shape { name: "A", .. })));
    let huge = skew_exp(diagonal(&[i_times(1.5e308); 2]).as_ref());
    assert!(huge.is_ok_and(|u| unitarity(&u) < 2e-15));
}

#[test]
fn exp_reads_and_writes_rows_and_columns() {
    let mut rng = Rng::new(8);
    for m in [2, 3, 9, 30] {
        let a = random_skew_hermitian(m, 2.0, &mut rng);
        let expected = skew_exp(a.as_ref()).unwrap();
        let rows = a.transpose().to_owned();
        for input in [a.as_ref(), rows.transpose()] {
            let (mut columns, mut out) = (Mat::zeros(m, m), Mat::zeros(m, m));
            let mut exp = SkewExp::new(m);
            exp.checked_into(columns.as_mut(), input).unwrap();
            exp.checked_into(out.as_mut().transpose_mut(), input).unwrap();
            assert!(distance(&columns, &expected) < 4.0 * m as f64 * EPS);
            assert!(distance(&out.transpose().to_owned(), &expected) < 4.0 * m as f64 * EPS);
        }
    }
}

// ------------------------------------------------------------------ logarithm

/// `|e^L - U|_2 / (m 1e-15)`; exactly skew-Hermitian, angles in `(-pi, pi]`.
fn backward(u: &Mat<c64>) -> f64 {
    let m = u.nrows();
    let log = unitary_log(u.as_ref()).unwrap();
    for j in 0..m {
        for i in 0..m {
            assert_eq!(log[(i, j)], -log[(j, i)].conj(), "m = {m}: not skew-Hermitian");
        }
    }
    assert!(spectral(&log) <= PI * (1.0 + 8.0 * EPS), "m = {m}: {}", spectral(&log));
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
            // With its eigenvectors on the axes too.
            let diagonal: Vec<c64> = angles(m, &mut rng).into_iter().map(phase).collect();
            worst.see(backward(&self::diagonal(&diagonal)), || format!("diagonal, m = {m}"));
        }
    }
    // U itself is unitary to a few eps, and the exponential that it is compared with is exact to as much.
    worst.assert_at_most(if name == "one size" { 1.0 } else { 2.0 });
}

#[test]
fn log_of_random_unitary_matrices() {
    let mut rng = Rng::new(12);
    let mut worst = Worst::new("log backward error / (m 1e-15), random");
    for m in (1..=40).chain([64, 80, 130]) {
        worst.see(backward(&random_unitary(m, &mut rng)), || format!("m = {m}"));
    }
    worst.assert_at_most(2.0);
}

#[test]
fn log_of_random_angles() {
    check_log("random angles", |m, rng| (0..m).map(|_| rng.between(-PI, PI)).collect());
}

#[test]
fn log_of_repeated_angles() {
    for angle in [0.0, 1e-3, 0.7, 0.7 + 0.5 * PI, 0.7 - PI, 2.0, -3.0, PI, PI - 1e-9, 1e-9 - PI] {
        check_log(&format!("all {angle}"), |m, _| vec![angle; m]);
        check_log(&format!("half {angle}"), |m, _| {
            (0..m).map(|j| if j % 2 == 0 { angle } else { -angle }).collect()
        });
    }
}

/// Angles whose first Hermitian matrix has repeated eigenvalues: mirrored at the direction of the combination.
#[test]
fn log_of_angles_that_share_a_cosine() {
    for off in [0.0, 1e-12, 1e-9, 1e-8, 1e-7, 2e-7, 1e-6, 1e-4] {
        check_log(&format!("mirrored, off by {off}"), |m, rng| {
            let angles: Vec<f64> = (0..m.div_ceil(2)).map(|_| rng.between(0.0, 3.0)).collect();
            (0..m)
                .map(|j| 0.7 + angles[j / 2] * if j % 2 == 0 { 1.0 } else { -1.0 } + off * (j % 2) as f64)
                .collect()
        });
    }
}

#[test]
fn log_of_clustered_angles() {
    for centre in [0.0, 0.7, 0.7 + 0.5 * PI, 0.7 - 0.5 * PI, 0.7 - PI, 2.0, PI, -1.3] {
        for gap in [1e-15, 1e-13, 1e-11, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4] {
            check_log(&format!("around {centre} by {gap:e}"), |m, rng| {
                (0..m).map(|_| centre + gap * rng.between(-1.0, 1.0)).collect()
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
        worst.see(backward(&complex(&cycle, &zero)), || format!("cycle of {m}"));
        let turned = complex(&cycle, &zero) * Scale(phase(rng.between(-PI, PI)));
        worst.see(backward(&turned), || format!("turned cycle of {m}"));
        let rotation = random_rotation(m, &mut rng);
        worst.see(backward(&complex(&rotation, &zero)), || format!("rotation, m = {m}"));
        let reflection = complex(&rotation, &zero) * Scale(c64::new(-1.0, 0.0));
        worst.see(backward(&reflection), || format!("minus a rotation, m = {m}"));
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
        // On a half of the space, in a random basis: both signs of the angle are the same to round-off, and pi is taken.
        let half: Vec<f64> = (0..m).map(|j| if j % 2 == 0 { PI } else { 0.3 }).collect();
        let b = random_unitary(m, &mut rng);
        let log = unitary_log(unitary_with_angles(&b, &half).as_ref()).unwrap();
        let error = distance(&log, &skew_with_angles(&b, &half));
        assert!(error < 20.0 * m as f64 * EPS, "m = {m}: {error:e}");
    }
    let exchange = mat![[0.0, 1.0], [1.0, 0.0]];
    let log = unitary_log(complex(&exchange, &Mat::zeros(2, 2)).as_ref()).unwrap();
    assert!((log[(0, 0)] - i_times(0.5 * PI)).norm() < EPS && (log[(0, 1)] + log[(0, 0)]).norm() < EPS);
}

#[test]
fn log_of_small_angles_is_relatively_exact() {
    let mut rng = Rng::new(15);
    let mut worst = Worst::new("|log - L| / (m eps |L|), small angles");
    for m in SIZES {
        for size in [1e-300, 1e-160, 1e-9, 1e-3, 0.01] {
            let l = random_skew_hermitian(m, size, &mut rng);
            // e^L by hand where it is I + L: the exponential is not what is tested.
            let u = if size < 1e-8 {
                identity(m) + &l
            } else {
                skew_exp(l.as_ref()).unwrap()
            };
            let log = unitary_log(u.as_ref()).unwrap();
            let scaled = |a: &Mat<c64>| Mat::from_fn(m, m, |i, j| a[(i, j)] / size);
            // What U is rounded to is an error of eps; L^3 / 6 is left out.
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
            worst.see(error / (m as f64 * EPS), || format!("m = {m}, angle = {angle}"));
        }
    }
    // Angles of 3.1 condition the logarithm by 1 only: what it is singular at are differences of 2 pi.
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
            worst.see(distance(&log, &a) / (m as f64 * EPS), || format!("m = {m}, norm = {norm}"));
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
            Err(Error::NotUnitary { name: "U", defect, .. }) => {
                let expected = 2e-6 * (m as f64).sqrt();
                assert!((defect / expected - 1.0).abs() < 1e-5, "m = {m}: {defect:e}");
            }
            other => panic!("m = {m}: {other:?}"),
        }
        for bad in [f64::NAN, f64::INFINITY] {
            let mut off = u.clone();
            off[(m - 1, 0)] = c64::new(0.0, bad);
            let error = unitary_log(off.as_ref()).unwrap_err();
            assert_eq!(error, Error::NonFinite { name: "U", index: m - 1 });
        }
        let huge = unitary_log((&u * Scale(c64::new(1e200, 0.0))).as_ref());
        assert!(matches!(huge, Err(Error::NotUnitary { .. })), "{huge:?}");
        let zero = unitary_log(Mat::<c64>::zeros(m, m).as_ref());
        assert!(matches!(zero, Err(Error::NotUnitary { .. })), "{zero:?}");
    }
    let shape = |a: MatRef<'_, c64>| matches!(unitary_log(a), Err(Error::Shape { name: "U", .. }));
    assert!(shape(Mat::zeros(2, 3).as_ref()) && shape(Mat::zeros(0, 0).as_ref()));
}

#[test]
fn log_buffers_serve_many_matrices_in_rows_and_columns() {
    let mut rng = Rng::new(20);
    for m in [2, 3, 8, 30, 90] {
        let mut log = UnitaryLog::new(m);
        for round in 0..4 {
            let angles: Vec<f64> = (0..m)
                .map(|j| if round % 2 == 0 { rng.between(-3.0, 3.0) } else { (j % 3) as f64 })
                .collect();
            let u = unitary_with_angles(&random_unitary(m, &mut rng), &angles);
            let expected = unitary_log(u.as_ref()).unwrap();
            let (mut columns, mut rows) = (Mat::zeros(m, m), Mat::zeros(m, m));
            log.checked_into(columns.as_mut(), u.as_ref()).unwrap();
            assert_eq!(columns, expected, "m = {m}: the buffers remember");
            log.checked_into(rows.as_mut().transpose_mut(), u.as_ref()).unwrap();
            let error = distance(&rows.transpose().to_owned(), &expected);
            assert!(error < 400.0 * m as f64 * EPS, "m = {m}: {error:e}");
        }
    }
}
