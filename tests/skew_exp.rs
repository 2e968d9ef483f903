//! Exponentials of skew matrices.

mod common;

use common::{Rng, *};
use faer::{Mat, Scale, mat};
use stiefel_rs::linalg::SkewExp;
use stiefel_rs::{Error, skew_exp};

const EXP_SIZES: [usize; 8] = [1, 2, 3, 4, 5, 12, 30, 50];
const NORMS: [f64; 16] = [
    1e-300, 1e-160, 1e-16, 1e-8, 1e-3, 0.03, 0.3, 1.0, 2.5, 3.0, 6.0, 25.0, 45.0, 1e3, 1e8, 1e300,
];

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
    // A = V B V^T is itself only accurate to a few m eps |A|.
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

/// Sizes near the switches between product algorithms, and norms near the limits of every polynomial.
#[test]
fn exp_is_right_on_both_sides_of_every_switch() {
    let limits = [
        0.000227, 0.008261, 0.05388, 0.1741, 0.7189, 1.684, 3.368, 53.888, 431.104,
    ];
    let mut rng = Rng::new(8);
    let mut orthogonal = Worst::new("|e^A^T e^A - I|_2 / (m 1e-15), at the switches");
    let mut exact =
        Worst::new("e^A against V blockdiag(rot) V^T / (m eps (1 + |A|_2)), at the switches");
    for m in [4, 5, 8, 9, 63, 64, 79, 80, 81, 101] {
        for limit in limits {
            for norm in [limit * 0.999, limit * 1.001] {
                // The bound by the Frobenius norm of powers is worst if all angles are equal, and sharp for a single
                // angle.
                for equal in [true, false] {
                    let mut angles = vec![if equal { norm } else { 0.0 }; m / 2];
                    angles[0] = norm;
                    let v = random_orthogonal(m, &mut rng);
                    let a = conjugated(&v, &plane_generators(&angles, m));
                    let a = (&a - a.transpose()) * Scale(0.5);
                    let expected = conjugated(&v, &plane_rotations(&angles, m));
                    let q = skew_exp(a.as_ref()).unwrap();
                    let place = || format!("m = {m}, norm = {norm:e}, equal = {equal}");
                    orthogonal.see(orthonormality(&q) / (m as f64 * 1e-15), place);
                    let unit = m as f64 * EPS * (1.0 + norm);
                    exact.see(spectral((&q - &expected).as_ref()) / unit, place);
                }
            }
        }
    }
    orthogonal.assert_at_most(1.0);
    exact.assert_at_most(8.0);
}

#[test]
fn exp_does_not_depend_on_layout_or_on_what_the_buffers_held() {
    let mut rng = Rng::new(9);
    for m in [4, 7, 30, 81] {
        let mut work = SkewExp::new(m);
        for norm in [1.0, 1e3, 1e-4, 5.0, 0.1, 1e-200] {
            let a = random_skew(m, norm, &mut rng);
            let fresh = skew_exp(a.as_ref()).unwrap();
            let mut again = Mat::zeros(m, m);
            work.checked_into(again.as_mut(), a.as_ref()).unwrap();
            assert_eq!(
                fresh, again,
                "buffers used before, m = {m}, norm = {norm:e}"
            );
            let rows = a.transpose().to_owned();
            let mut out = Mat::zeros(m, m);
            work.exp_into(out.as_mut().transpose_mut(), rows.transpose(), 1.0)
                .unwrap();
            let bound = 4.0 * m as f64 * EPS * (1.0 + norm);
            assert_close(&out.transpose().to_owned(), &fresh, bound, "row by row");
        }
    }
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
            skew_exp(Mat::<f64>::zeros(m, m).as_ref()).unwrap(),
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
            // The second-order term, and the last bits of subnormal numbers.
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
    let wide = skew_exp(Mat::<f64>::zeros(2, 3).as_ref());
    assert!(
        matches!(wide, Err(Error::Shape { name: "A", .. })),
        "{wide:?}"
    );
    let empty = skew_exp(Mat::<f64>::zeros(0, 0).as_ref());
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
