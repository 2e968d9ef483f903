//! Quasi-geodesics between two points.

use std::f64::consts::PI;

use faer::{Mat, Scale, mat};
use stiefel_rs::{Curve, Error, QuasiGeodesic};

use crate::common::{
    EPS, Rng, SIZES, Worst, assert_close, assert_within, distance, frobenius, negate_column,
    orthonormality, partner_at_angles, random_partner, random_point, random_skew, random_tangent,
    rotation_with_angles,
};
use crate::ends::{TIMES, between, end_error, shoot};
use crate::from_velocity::normal_of_rank;

#[test]
fn between_meets_random_end_points() {
    let mut rng = Rng::new(11);
    let mut worst = Worst::new("end points of random pairs");
    for (n, k) in SIZES {
        for pair in 0..50 {
            let s0 = random_point(n, k, &mut rng);
            let s1 = random_partner(&s0, &mut rng);
            if (n, k) != (1, 1) {
                worst.see(end_error(&between(&s0, &s1), &s0, &s1), || {
                    format!("({n}, {k}), pair {pair}")
                });
            }
        }
    }
    worst.assert_at_most(3e-14);
}

/// Pairs whose rotation `U Z^T` has determinant -1, which the paper's formula does not join.
#[test]
fn between_meets_end_points_beyond_the_paper() {
    let mut rng = Rng::new(12);
    let mut worst = Worst::new("end points where det(U Z^T) = -1");
    for (n, k) in SIZES.into_iter().filter(|(n, k)| n > k) {
        let mut seen = 0;
        while seen < 25 {
            let (s0, s1) = (random_point(n, k, &mut rng), random_point(n, k, &mut rng));
            if (s0.transpose() * &s1).determinant() < 0.0 {
                seen += 1;
                let curve = between(&s0, &s1);
                worst.see(end_error(&curve, &s0, &s1), || format!("({n}, {k})"));
                let beyond = curve
                    .angles()
                    .iter()
                    .filter(|theta| **theta > 0.5 * PI)
                    .count();
                assert_eq!(beyond, 1, "one angle above pi/2: {:?}", curve.angles());
            }
        }
    }
    worst.assert_at_most(3e-14);
}

#[test]
fn between_meets_end_points_at_every_distance() {
    let mut rng = Rng::new(13);
    let mut worst =
        Worst::new("end points of close pairs, and the velocity against the one shot with");
    for (n, k) in SIZES {
        for exponent in 0..=17 {
            let s0 = random_point(n, k, &mut rng);
            let v = random_tangent(&s0, 10.0_f64.powi(-exponent), &mut rng);
            let s1 = shoot(&s0, &v).point(1.0).unwrap();
            let curve = between(&s0, &s1);
            let place = || format!("({n}, {k}), distance 1e-{exponent}");
            worst.see(end_error(&curve, &s0, &s1), place);
            worst.see(distance(&curve.initial_velocity(), &v), place);
        }
    }
    worst.assert_at_most(3e-14);
}

#[test]
fn between_meets_end_points_for_every_rank_and_distance() {
    let mut rng = Rng::new(14);
    let mut worst = Worst::new("end points and velocity, normal part of low rank");
    for (n, k) in SIZES {
        for rank in 0..=k.min(3) {
            for exponent in [0, 1, 4, 8, 12, 16] {
                let s0 = random_point(n, k, &mut rng);
                let size = 10.0_f64.powi(-exponent);
                let v =
                    normal_of_rank(&s0, rank, size, &mut rng) + &s0 * random_skew(k, 1.0, &mut rng);
                let s1 = shoot(&s0, &v).point(1.0).unwrap();
                let curve = between(&s0, &s1);
                let place = || format!("({n}, {k}), rank {rank}, |K| = {size:e}");
                worst.see(end_error(&curve, &s0, &s1), place);
                worst.see(distance(&curve.initial_velocity(), &v), place);
            }
        }
    }
    worst.assert_at_most(3e-14);
}

/// Principal angles that are equal, clustered, tiny next to large ones, or right angles.
#[test]
fn between_meets_end_points_at_degenerate_angles() {
    let mut rng = Rng::new(15);
    let mut worst = Worst::new("end points and orthonormality, degenerate principal angles");
    let lists: [&[f64]; 9] = [
        &[0.7, 0.7, 0.7],
        &[0.7, 0.7 + 1e-9, 0.7 - 1e-8],
        &[0.5 * PI, 0.5 * PI, 0.5 * PI],
        &[0.5 * PI, 0.5 * PI - 1e-9, 0.1],
        &[1e-8, 3e-8, 0.5],
        &[1e-12, 1e-8, 1e-4],
        &[0.0, 1e-5, 1.0],
        &[1e-8, 2e-8, PI - 1e-3],
        &[1e-6, 0.0, PI - 1e-6],
    ];
    for (n, k) in [(6, 3), (7, 3), (20, 3)] {
        for angles in lists {
            let s0 = random_point(n, k, &mut rng);
            let s1 = partner_at_angles(&s0, angles, &mut rng);
            let curve = between(&s0, &s1);
            worst.see(end_error(&curve, &s0, &s1), || {
                format!("({n}, {k}), angles {angles:?}")
            });
            for t in TIMES {
                let defect = orthonormality(&curve.point(t).unwrap());
                worst.see(defect, || {
                    format!("orthonormality, ({n}, {k}), angles {angles:?}, t = {t}")
                });
            }
        }
    }
    worst.assert_at_most(3e-14);
}

#[test]
fn between_equal_points_is_constant() {
    for (n, k) in SIZES {
        let s = random_point(n, k, &mut Rng::new(16));
        let curve = between(&s, &s);
        let bound = 8.0 * n as f64 * EPS;
        assert_within(
            frobenius(curve.initial_velocity().as_ref()),
            bound,
            &format!("velocity, ({n}, {k})"),
        );
        assert_close(
            &curve.point(0.4).unwrap(),
            &s,
            bound,
            &format!("point, ({n}, {k})"),
        );
    }
}

#[test]
fn between_on_the_sphere_is_the_great_circle() {
    let mut rng = Rng::new(17);
    let mut worst = Worst::new("great circle");
    for n in [2, 3, 10] {
        for theta in [1e-15, 1e-8, 0.1, 0.5 * PI, 2.0, 3.0] {
            let basis = random_point(n, 2, &mut rng);
            let at = |a: f64| &basis * mat![[a.cos()], [a.sin()]];
            let curve = between(&at(0.0), &at(theta));
            for t in TIMES {
                let error = distance(&curve.point(t).unwrap(), &at(t * theta));
                worst.see(error, || format!("n = {n}, theta = {theta}, t = {t}"));
            }
        }
    }
    worst.assert_at_most(5e-15);
}

#[test]
fn between_works_up_to_antipodal_points() {
    let mut rng = Rng::new(18);
    let mut worst = Worst::new("angle, end points and orthonormality near the antipode");
    for n in [2, 3, 10] {
        for j in 1..=13 {
            let basis = random_point(n, 2, &mut rng);
            let theta = PI - 10.0_f64.powi(-j);
            let at = |a: f64| &basis * mat![[a.cos()], [a.sin()]];
            let (s0, s1) = (at(0.0), at(theta));
            let curve = between(&s0, &s1);
            let place = || format!("n = {n}, pi - 1e-{j}");
            worst.see((curve.angles()[0] - theta).abs(), place);
            worst.see(end_error(&curve, &s0, &s1), place);
            worst.see(orthonormality(&curve.point(0.5).unwrap()), place);
        }
    }
    worst.assert_at_most(5e-15);
}

#[test]
fn between_refuses_antipodal_points() {
    let mut rng = Rng::new(19);
    for n in [2, 3, 10] {
        let s = random_point(n, 1, &mut rng);
        match QuasiGeodesic::between(s.as_ref(), (-&s).as_ref()) {
            Err(Error::NoJoiningCurve { angle }) => {
                assert_within((angle - PI).abs(), 1e-14, "reported angle")
            }
            other => panic!("n = {n}: expected NoJoiningCurve, found {other:?}"),
        }
    }
    let s = random_point(5, 2, &mut rng);
    let mut opposite = s.clone();
    negate_column(&mut opposite, 1);
    let error = QuasiGeodesic::between(s.as_ref(), opposite.as_ref()).err();
    assert!(
        matches!(
            error.as_ref().map(Error::cause),
            Some(Error::NoJoiningCurve { .. })
        ),
        "{error:?}"
    );
}

#[test]
fn between_refuses_a_rotation_with_eigenvalue_minus_one() {
    let mut rng = Rng::new(20);
    for (n, k) in [(5, 2), (4, 2), (6, 3), (4, 4), (20, 4)] {
        let s0 = random_point(n, k, &mut rng);
        let s1 = &s0 * rotation_with_angles(&[PI], k, &mut rng);
        let error = QuasiGeodesic::between(s0.as_ref(), s1.as_ref()).err();
        assert!(
            matches!(
                error.as_ref().map(Error::cause),
                Some(Error::OutsideLogDomain { .. })
            ),
            "({n}, {k}): {error:?}"
        );
    }
}

#[test]
fn between_refuses_different_components() {
    for n in [1, 2, 3, 6] {
        let s0 = random_point(n, n, &mut Rng::new(21));
        let mut s1 = s0.clone();
        negate_column(&mut s1, 0);
        let error = QuasiGeodesic::between(s0.as_ref(), s1.as_ref()).err();
        assert_eq!(error, Some(Error::DifferentComponents { n }));
    }
}

#[test]
fn between_refuses_bad_input() {
    let s = random_point(4, 2, &mut Rng::new(22));
    let error =
        |s0: &Mat<f64>, s1: &Mat<f64>| QuasiGeodesic::between(s0.as_ref(), s1.as_ref()).err();
    assert!(matches!(
        error(&s, &Mat::zeros(5, 2)),
        Some(Error::Shape { name: "S1", .. })
    ));
    assert!(matches!(
        error(&Mat::zeros(1, 2), &s),
        Some(Error::Shape { name: "S0", .. })
    ));
    assert!(matches!(
        error(&s, &(&s * Scale(2.0))),
        Some(Error::NotOrthonormal { name: "S1", .. })
    ));
    assert!(matches!(
        error(&s, &(&s * Scale(f64::NAN))),
        Some(Error::NonFinite {
            name: "S1",
            index: 0
        })
    ));
    assert!(matches!(
        error(&(&s * Scale(f64::INFINITY)), &s),
        Some(Error::NonFinite { name: "S0", .. })
    ));
}
