//! Quasi-geodesics from a velocity.

use faer::{Mat, Scale};
use stiefel_rs::{Curve, Error, QuasiGeodesic, Stiefel, skew_exp};

use crate::common::{
    EPS, Rng, SIZES, Worst, assert_close, distance, frobenius, gaussian, orthonormality,
    project_off, random_point, random_skew, random_tangent,
};
use crate::ends::{TIMES, shoot};

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
pub fn normal_of_rank(s: &Mat<f64>, rank: usize, norm: f64, rng: &mut Rng) -> Mat<f64> {
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
