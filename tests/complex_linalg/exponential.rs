//! Exponentials of skew-Hermitian matrices.

use faer::{Mat, Scale, c64};
use stiefel_rs::linalg::SkewExp;
use stiefel_rs::{Error, skew_exp};

use crate::common::{self, EPS, Rng, Worst, random_skew};
use crate::*;

/// Norms between the switches of the algorithm, and on both sides of them.
const NORMS: [f64; 20] = [
    1e-300, 1e-160, 1e-16, 1e-8, 2.2e-4, 2.4e-4, 8e-3, 0.05, 0.17, 0.7, 1.0, 1.69, 3.3, 3.5, 13.0,
    14.0, 60.0, 1e3, 3e3, 1e8,
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
    // A is itself only accurate to a few m eps |A|.
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
        assert!(
            distance(&u, &complex(&real, &zero)) < 4.0 * m as f64 * EPS,
            "m = {m}"
        );
        let phases = skew_exp(diagonal(&vec![i_times(0.7); m]).as_ref()).unwrap();
        let expected = identity(m) * Scale(phase(0.7));
        assert!(distance(&phases, &expected) < 4.0 * EPS, "m = {m}");
        assert_eq!(
            skew_exp(Mat::<c64>::zeros(m, m).as_ref()).unwrap(),
            identity(m)
        );
    }
}

#[test]
fn exp_counts_the_skew_part_and_scales() {
    let mut rng = Rng::new(6);
    for m in [1, 2, 5] {
        let a = random_skew_hermitian(m, 2.0, &mut rng);
        let mut out = Mat::zeros(m, m);
        let mut exp = SkewExp::new(m);
        exp.exp_into(out.as_mut(), (&a + identity(m)).as_ref(), -0.5)
            .unwrap();
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
                Err(Error::NotSkewHermitian {
                    name: "A",
                    defect,
                    tolerance,
                }) => {
                    assert!((defect / (1e-6 * norm) - 1.0).abs() < 1e-3, "{defect:e}");
                    assert!(tolerance < 2e-12 * norm * (m as f64).sqrt());
                }
                other => panic!("m = {m}, norm = {norm:e}: {other:?}"),
            }
            off[(0, 0)] = i_times(f64::NAN);
            let error = skew_exp(off.as_ref()).unwrap_err();
            assert_eq!(
                error,
                Error::NonFinite {
                    name: "A",
                    index: 0
                }
            );
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
            exp.checked_into(out.as_mut().transpose_mut(), input)
                .unwrap();
            assert!(distance(&columns, &expected) < 4.0 * m as f64 * EPS);
            assert!(distance(&out.transpose().to_owned(), &expected) < 4.0 * m as f64 * EPS);
        }
    }
}
