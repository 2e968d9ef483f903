//! Quasi-geodesics: from a velocity, between two points, and the symmetries of both.

mod common;

use std::f64::consts::PI;

use common::*;
use faer::{Mat, Scale, mat};
use stiefel_rs::{Curve, Error, QuasiGeodesic, Stiefel, skew_exp};

const TIMES: [f64; 7] = [-1.3, 0.0, 0.25, 0.5, 0.9, 1.0, 2.2];

fn between(s0: &Mat<f64>, s1: &Mat<f64>) -> QuasiGeodesic {
    QuasiGeodesic::between(s0.as_ref(), s1.as_ref())
        .unwrap_or_else(|e| panic!("{:?}: {e}", s0.shape()))
}

fn shoot(s: &Mat<f64>, v: &Mat<f64>) -> QuasiGeodesic {
    QuasiGeodesic::from_velocity(s.as_ref(), v.as_ref())
        .unwrap_or_else(|e| panic!("{:?}: {e}", s.shape()))
}

/// Largest distance of the end points of `curve` from `s0`, `s1`.
fn end_error(curve: &QuasiGeodesic, s0: &Mat<f64>, s1: &Mat<f64>) -> f64 {
    distance(&curve.point(0.0).unwrap(), s0).max(distance(&curve.point(1.0).unwrap(), s1))
}

// -------------------------------------------------------------- from a velocity

/// `e^{tX} S e^{t Omega}` and its derivatives with `n x n` exponentials.
fn naive(s: &Mat<f64>, v: &Mat<f64>, t: f64) -> [Mat<f64>; 4] {
    let (x, omega) = Stiefel::of("S", s.as_ref())
        .unwrap()
        .decompose(s.as_ref(), v.as_ref())
        .unwrap();
    let left = skew_exp((&x * Scale(t)).as_ref()).unwrap();
    let right = skew_exp((&omega * Scale(t)).as_ref()).unwrap();
    let d1 = &x * s + s * &omega;
    let d2 = &x * &d1 + &d1 * &omega;
    let d3 = &x * &d2 + &d2 * &omega;
    [s.clone(), d1, d2, d3].map(|d| &left * d * &right)
}

#[test]
fn agrees_with_the_n_by_n_formula_and_its_derivatives() {
    let mut rng = Rng::new(1);
    let mut worst =
        Worst::new("beta and derivatives against n x n, in units of n eps |V|^nu (1 + |t V|)");
    for (n, k) in SIZES {
        for norm in [1e-9, 0.1, 1.0, 5.0, 100.0] {
            let s = random_point(n, k, &mut rng);
            let v = random_tangent(&s, norm, &mut rng);
            let (curve, size) = (shoot(&s, &v), 2.0 * frobenius(v.as_ref()));
            for t in TIMES {
                for (nu, expected) in naive(&s, &v, t).iter().enumerate() {
                    let error = distance(&curve.derivative(t, nu).unwrap(), expected);
                    let unit = n as f64 * EPS * size.powi(nu as i32) * (1.0 + (t * size).abs());
                    let relative = if error == 0.0 { 0.0 } else { error / unit };
                    worst.see(relative, || {
                        format!("({n}, {k}), |V| = {norm:e}, t = {t}, nu = {nu}")
                    });
                }
            }
        }
    }
    worst.assert_at_most(4.0);
}

#[test]
fn starts_with_the_velocity_given() {
    let mut rng = Rng::new(2);
    let mut worst = Worst::new("|V - initial_velocity| / (n eps |V|)");
    for (n, k) in SIZES.into_iter().filter(|size| *size != (1, 1)) {
        for norm in [1e-300, 1e-20, 1e-3, 1.0, 1e3, 1e100] {
            let s = random_point(n, k, &mut rng);
            let v = random_tangent(&s, norm, &mut rng);
            let error = distance(
                &(shoot(&s, &v).initial_velocity() * Scale(1.0 / norm)),
                &(v * Scale(1.0 / norm)),
            );
            worst.see(error / (n as f64 * EPS), || {
                format!("({n}, {k}), |V| = {norm:e}")
            });
        }
    }
    worst.assert_at_most(4.0);
}

#[test]
fn stays_orthonormal() {
    let mut rng = Rng::new(3);
    let mut worst = Worst::new("orthonormality on |t V| <= 10");
    for (n, k) in SIZES {
        for norm in [1e-8, 0.3, 1.0, 3.0, 10.0] {
            let s = random_point(n, k, &mut rng);
            let v = random_tangent(&s, norm, &mut rng);
            for step in -20..=20 {
                let t = f64::from(step) / 20.0 * (10.0 / norm).min(10.0);
                let defect = orthonormality(&shoot(&s, &v).point(t).unwrap());
                worst.see(defect, || format!("({n}, {k}), |V| = {norm:e}, t = {t}"));
            }
        }
    }
    worst.assert_at_most(1e-14);
}

#[test]
fn stays_orthonormal_for_fast_velocities_and_lopsided_ones() {
    let mut rng = Rng::new(4);
    let mut worst = Worst::new("orthonormality, fast or lopsided velocities");
    for (n, k) in SIZES {
        for (rotation, translation) in [
            (1e3, 1e3),
            (1e6, 1e6),
            (1e3, 1e-12),
            (1e6, 1e-8),
            (1e-12, 1e3),
            (0.0, 1e4),
        ] {
            let s = random_point(n, k, &mut rng);
            let manifold = Stiefel::of("S", s.as_ref()).unwrap();
            let w = random_tangent(&s, 1.0, &mut rng);
            let (normal, omega) = manifold.split(s.as_ref(), w.as_ref()).unwrap();
            let v = normal * Scale(translation) + &s * omega * Scale(rotation);
            for t in [0.3, 1.0, 2.0] {
                let defect = orthonormality(&shoot(&s, &v).point(t).unwrap());
                worst.see(defect, || {
                    format!("({n}, {k}), Omega ~ {rotation:e}, K ~ {translation:e}, t = {t}")
                });
            }
        }
    }
    worst.assert_at_most(1e-14);
}

#[test]
fn of_zero_velocity_is_constant() {
    for (n, k) in SIZES {
        let s = random_point(n, k, &mut Rng::new(5));
        let curve = shoot(&s, &Mat::zeros(n, k));
        for t in TIMES {
            assert_close(
                &curve.point(t).unwrap(),
                &s,
                4.0 * k as f64 * EPS,
                &format!("({n}, {k}), t = {t}"),
            );
            for nu in 1..=3 {
                assert_eq!(
                    curve.derivative(t, nu).unwrap(),
                    Mat::<f64>::zeros(n, k),
                    "({n}, {k}), t = {t}, nu = {nu}"
                );
            }
        }
    }
}

#[test]
fn reversed_runs_backwards() {
    let mut rng = Rng::new(6);
    let mut worst = Worst::new("reversed(t) - beta(1 - t)");
    for (n, k) in SIZES {
        for rank in [0, 1, k] {
            let s = random_point(n, k, &mut rng);
            let v = normal_of_rank(&s, rank, 1.0, &mut rng) + &s * random_skew(k, 1.0, &mut rng);
            let (curve, reversed) = (shoot(&s, &v), shoot(&s, &v).reversed().unwrap());
            for t in TIMES {
                let error = distance(&reversed.point(t).unwrap(), &curve.point(1.0 - t).unwrap());
                worst.see(error, || format!("({n}, {k}), rank {rank}, t = {t}"));
            }
        }
    }
    worst.assert_at_most(2e-14);
}

/// `K` with `S^T K = 0` of the given rank and norm.
fn normal_of_rank(s: &Mat<f64>, rank: usize, norm: f64, rng: &mut Rng) -> Mat<f64> {
    let (n, k) = s.shape();
    if n == k || rank == 0 {
        return Mat::zeros(n, k);
    }
    let g = gaussian(n, rank, rng) * gaussian(rank, k, rng);
    let normal = project_off(s, &project_off(s, &g));
    &normal * Scale(norm / frobenius(normal.as_ref()))
}

#[test]
fn from_velocity_refuses_bad_input() {
    let s = random_point(4, 2, &mut Rng::new(7));
    let v = random_tangent(&s, 1.0, &mut Rng::new(8));
    let error =
        |s: &Mat<f64>, v: &Mat<f64>| QuasiGeodesic::from_velocity(s.as_ref(), v.as_ref()).err();
    assert!(matches!(
        error(&(&s * Scale(1.1)), &v),
        Some(Error::NotOrthonormal { name: "S", .. })
    ));
    assert!(matches!(
        error(&s, &s),
        Some(Error::NotTangent { name: "V", .. })
    ));
    assert!(matches!(
        error(&s, &Mat::zeros(4, 3)),
        Some(Error::Shape { name: "V", .. })
    ));
    assert!(matches!(
        error(&Mat::zeros(2, 3), &v),
        Some(Error::Shape { name: "S", .. })
    ));
    assert!(matches!(
        error(&s, &(&v * Scale(f64::NAN))),
        Some(Error::NonFinite {
            name: "V",
            index: 0
        })
    ));
    assert!(matches!(
        error(&(&s * Scale(f64::INFINITY)), &v),
        Some(Error::NonFinite { name: "S", .. })
    ));
}

// ------------------------------------------------------------ between two points

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

/// Pairs whose rotation `U Z^T` has determinant -1: the paper's formula does not join them.
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

/// Principal angles that are equal, clustered, tiny beside large, or right angles.
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
        matches!(error, Some(Error::NoJoiningCurve { .. })),
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
            matches!(error, Some(Error::OutsideLogDomain { .. })),
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

// --------------------------------------------------------------------- symmetries

#[test]
fn is_equivariant_under_both_orthogonal_actions() {
    let mut rng = Rng::new(31);
    let mut worst = Worst::new("A beta(S0, S1) B - beta(A S0 B, A S1 B)");
    for (n, k) in SIZES {
        let s0 = random_point(n, k, &mut rng);
        let s1 = shoot(&s0, &random_tangent(&s0, 1.0, &mut rng))
            .point(1.0)
            .unwrap();
        let (a, b) = (
            random_orthogonal(n, &mut rng),
            random_orthogonal(k, &mut rng),
        );
        let (here, there) = (
            between(&s0, &s1),
            between(&(&a * &s0 * &b), &(&a * &s1 * &b)),
        );
        for t in TIMES {
            let error = distance(
                &(&a * here.point(t).unwrap() * &b),
                &there.point(t).unwrap(),
            );
            worst.see(error, || format!("({n}, {k}), t = {t}"));
        }
    }
    worst.assert_at_most(5e-14);
}

#[test]
fn between_exchanged_points_runs_backwards() {
    let mut rng = Rng::new(32);
    let mut worst = Worst::new("beta(S0, S1; t) - beta(S1, S0; 1 - t)");
    for (n, k) in SIZES {
        let s0 = random_point(n, k, &mut rng);
        let s1 = shoot(&s0, &random_tangent(&s0, 1.5, &mut rng))
            .point(1.0)
            .unwrap();
        let (there, back) = (between(&s0, &s1), between(&s1, &s0));
        for t in TIMES {
            let error = distance(&there.point(t).unwrap(), &back.point(1.0 - t).unwrap());
            worst.see(error, || format!("({n}, {k}), t = {t}"));
        }
    }
    worst.assert_at_most(5e-14);
}
