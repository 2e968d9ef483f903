//! Geodesics as curves: the geodesic equation, ends, symmetry.

mod common;

use common::*;
use faer::{Mat, Scale};
use stiefel_rs::{Curve, Geodesic, Interrupt, Metric, Quantity, Stiefel};

fn at(curve: &Geodesic, t: f64, quantity: Quantity) -> Mat<f64> {
    curve
        .sample(&[t], quantity, Default::default())
        .unwrap()
        .get(0)
        .to_owned()
}

#[test]
fn covariant_acceleration_and_jerk_vanish() {
    let mut rng = Rng::new(21);
    let mut worst = Worst::new("covariant acceleration of canonical geodesics");
    for (n, k) in SIZES {
        let s = random_point(n, k, &mut rng);
        let v = random_tangent(&s, 2.0, &mut rng);
        let curve = Geodesic::from_velocity(s.as_ref(), v.as_ref()).unwrap();
        for t in [-1.0, 0.0, 0.3, 1.0, 4.0] {
            for quantity in [Quantity::Acceleration, Quantity::Jerk] {
                let defect = frobenius(at(&curve, t, quantity).as_ref());
                worst.see(defect, || format!("St({n},{k}), t {t}, {quantity:?}"));
            }
        }
        assert_within(curve.cost(Interrupt::NEVER).unwrap(), 1e-25, "cost");
    }
    worst.assert_at_most(2e-13);
}

#[test]
fn geodesics_of_other_metrics_accelerate_in_the_canonical_one() {
    let mut rng = Rng::new(22);
    let manifold = Stiefel::new(5, 3).unwrap().with_metric(Metric::EUCLIDEAN);
    let s = random_point(5, 3, &mut rng);
    let v = random_tangent(&s, 1.0, &mut rng);
    let curve = manifold.geodesic(s.as_ref(), v.as_ref()).unwrap();
    assert_eq!(curve.metric(), Metric::EUCLIDEAN);
    let size = frobenius(at(&curve, 0.5, Quantity::Acceleration).as_ref());
    assert!(size > 1e-2, "{size}");
}

#[test]
fn derivatives_are_those_of_the_curve() {
    let mut rng = Rng::new(23);
    let h = 1e-4;
    for (n, k) in [(3, 1), (4, 2), (5, 3), (6, 6), (20, 4)] {
        for metric in [Metric::CANONICAL, Metric::EUCLIDEAN] {
            let manifold = Stiefel::new(n, k).unwrap().with_metric(metric);
            let s = random_point(n, k, &mut rng);
            let v = random_tangent(&s, 1.0, &mut rng);
            let curve = manifold.geodesic(s.as_ref(), v.as_ref()).unwrap();
            assert_close(
                &at(&curve, 0.0, Quantity::Derivative(1)),
                &v,
                1e-14,
                "initial velocity",
            );
            for order in 1..=3 {
                let lower = Quantity::Derivative(order - 1);
                let difference =
                    (at(&curve, 0.6 + h, lower) - at(&curve, 0.6 - h, lower)) * Scale(0.5 / h);
                let exact = at(&curve, 0.6, Quantity::Derivative(order));
                assert_close(
                    &difference,
                    &exact,
                    1e-7,
                    &format!("St({n},{k}), order {order}"),
                );
            }
        }
    }
}

#[test]
fn geodesics_between_points_meet_them_and_run_backwards() {
    let mut rng = Rng::new(24);
    for (n, k) in SIZES {
        let s0 = random_point(n, k, &mut rng);
        let v = random_tangent(&s0, 1.2, &mut rng);
        let s1 = Stiefel::new(n, k)
            .unwrap()
            .exp(s0.as_ref(), v.as_ref())
            .unwrap();
        let there = Geodesic::between(s0.as_ref(), s1.as_ref()).unwrap();
        let back = Geodesic::between(s1.as_ref(), s0.as_ref()).unwrap();
        assert_close(&there.initial_velocity(), &v, 1e-12, "velocity");
        for t in [0.0, 0.25, 1.0] {
            assert_close(
                &there.point(t).unwrap(),
                &back.point(1.0 - t).unwrap(),
                1e-12,
                "reversal",
            );
        }
        assert_close(&there.point(0.0).unwrap(), &s0, 1e-14, "start");
        assert_close(&there.point(1.0).unwrap(), &s1, 1e-12, "end");
    }
}

#[test]
fn the_exponential_is_a_flow() {
    let mut rng = Rng::new(25);
    for (n, k) in SIZES {
        let s = random_point(n, k, &mut rng);
        let v = random_tangent(&s, 1.0, &mut rng);
        let curve = Geodesic::from_velocity(s.as_ref(), v.as_ref()).unwrap();
        let (p, w) = (
            curve.point(0.7).unwrap(),
            at(&curve, 0.7, Quantity::Derivative(1)),
        );
        let on = Geodesic::from_velocity(p.as_ref(), w.as_ref()).unwrap();
        assert_close(
            &on.point(0.9).unwrap(),
            &curve.point(1.6).unwrap(),
            1e-13,
            "flow",
        );
    }
}
