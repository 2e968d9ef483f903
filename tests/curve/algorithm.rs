//! Geometric cubics agree with de Casteljau's algorithm with n x n exponentials, and have its symmetries.

use faer::{Mat, Scale};
use stiefel_rs::{Curve, orthogonal_log, skew_exp};

use crate::common::{
    Actions, Boundary, Rng, SIZES, Worst, assert_close, assert_equivariant, distance, frobenius,
    project_off, random_point,
};
use crate::end_conditions::TIMES;

/// The pair `(X, Omega)` that moves `S0` to `S1`, with `X` as an `n x n` matrix, from a singular value decomposition.
fn joining_pair(s0: &Mat<f64>, s1: &Mat<f64>) -> (Mat<f64>, Mat<f64>) {
    let k = s0.ncols();
    let svd = (s0.transpose() * s1).svd().unwrap();
    let (u, z) = (svd.U(), svd.V());
    let mut directions = project_off(s0, &(s1 * z));
    for i in 0..k {
        let sine = frobenius(directions.as_ref().subcols(i, 1));
        let theta = sine.atan2(svd.S()[i]);
        for row in 0..s0.nrows() {
            directions[(row, i)] *= if sine > 0.0 { theta / sine } else { 1.0 };
        }
    }
    let normal = directions * u.transpose();
    let x = &normal * s0.transpose() - s0 * normal.transpose();
    (x, orthogonal_log((u * z.transpose()).as_ref()).unwrap())
}

fn quasi_geodesic_step(s: &Mat<f64>, (x, omega): &(Mat<f64>, Mat<f64>), t: f64) -> Mat<f64> {
    // X of the paper's formula is skew only to round-off, whereas SKEW_TOLERANCE is relative to its norm, which may be
    // small.
    let exp = |a: &Mat<f64>| skew_exp(((a - a.transpose()) * Scale(0.5 * t)).as_ref()).unwrap();
    exp(x) * s * exp(omega)
}

/// `X_0 .. X_5`, `Omega_0 .. Omega_5` with explicit exponentials.
fn de_casteljau(points: &[Mat<f64>; 4], t: f64) -> Mat<f64> {
    let [s0, s1, s2, s3] = points;
    let b01 = quasi_geodesic_step(s0, &joining_pair(s0, s1), t);
    let b12 = quasi_geodesic_step(s1, &joining_pair(s1, s2), t);
    let b23 = quasi_geodesic_step(s2, &joining_pair(s2, s3), t);
    let b012 = quasi_geodesic_step(&b01, &joining_pair(&b01, &b12), t);
    let b123 = quasi_geodesic_step(&b12, &joining_pair(&b12, &b23), t);
    quasi_geodesic_step(&b012, &joining_pair(&b012, &b123), t)
}

#[test]
fn equals_de_casteljau_with_n_by_n_exponentials() {
    let mut rng = Rng::new(5);
    let mut worst = Worst::new("curve - de Casteljau");
    for size in SIZES {
        for (distance_, speed) in [(0.1, 0.1), (0.5, 0.5), (0.8, 0.8)] {
            let curve = Boundary::random(size, distance_, speed, &mut rng).curve();
            for t in TIMES {
                let error = distance(
                    &curve.point(t).unwrap(),
                    &de_casteljau(&curve.control_points(), t),
                );
                worst.see(error, || format!("{size:?}, distance {distance_}, t = {t}"));
            }
        }
    }
    worst.assert_at_most(1e-13);
}

#[test]
fn lives_in_the_span_of_its_data() {
    let mut rng = Rng::new(6);
    for order in [0, 1, 2, 3] {
        let low = Boundary::random((8, 2), 1.2, 1.5, &mut rng);
        let basis = random_point(20, 8, &mut rng);
        let high = low.mapped(|a| &basis * a).curve();
        let low = low.curve();
        assert!(
            low.frame().is_none() && high.frame().is_some(),
            "(20, 2) is reduced, (8, 2) is not"
        );
        for t in TIMES {
            let expected = &basis * low.derivative(t, order).unwrap();
            let bound = 2e-13 * 10.0_f64.powi(order as i32).min(100.0);
            let found = high.derivative(t, order).unwrap();
            assert_close(
                &found,
                &expected,
                bound,
                &format!("St(20, 2) - E St(8, 2), t = {t}, nu = {order}"),
            );
        }
    }
}

#[test]
fn is_equivariant_under_both_orthogonal_actions() {
    let mut rng = Rng::new(7);
    for size in SIZES {
        let data = Boundary::random(size, 1.0, 1.0, &mut rng);
        let points = |a: &[Mat<f64>]| {
            TIMES
                .map(|t| Boundary::of(a).curve().point(t).unwrap())
                .to_vec()
        };
        let what = format!("{size:?}");
        assert_equivariant(Actions::Both, &data.all(), points, 1e-13, &what, &mut rng);
    }
}

/// So does each stage: `between` of exchanged points is the reversed curve.
#[test]
fn runs_backwards_with_reversed_data() {
    let mut rng = Rng::new(8);
    let mut worst = Worst::new("curve(t) - reversed data(1 - t)");
    for size in SIZES {
        let data = Boundary::random(size, 1.0, 1.0, &mut rng);
        let minus = |v: &Mat<f64>| v * Scale(-1.0);
        let back = Boundary {
            s0: data.s1.clone(),
            v0: minus(&data.v1),
            s1: data.s0.clone(),
            v1: minus(&data.v0),
        };
        let (curve, back) = (data.curve(), back.curve());
        for t in TIMES {
            let error = distance(&curve.point(t).unwrap(), &back.point(1.0 - t).unwrap());
            worst.see(error, || format!("{size:?}, t = {t}"));
        }
    }
    worst.assert_at_most(1e-13);
}
