//! Matrices without a logarithm, and bad input.

use std::f64::consts::PI;

use faer::{Mat, Scale};
use stiefel_rs::{Error, orthogonal_log};

use crate::common::{
    EPS, Rng, assert_within, conjugated, cyclic_permutation, identity, negate_column,
    plane_rotations, random_orthogonal, random_rotation, rotation_with_angles,
};

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
            // An angle of pi - 1e-6 in the same group may be reported instead of the one at pi.
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
