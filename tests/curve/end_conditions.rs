//! Geometric cubics satisfy their end conditions and stay on the manifold.

use std::f64::consts::PI;

use faer::Scale;
use stiefel_rs::{Curve, Error, GeometricCubic};

use crate::common::{
    Boundary, EPS, Rng, SIZES, Worst, assert_close, assert_within, distance, orthonormality,
    retract, through,
};

pub const TIMES: [f64; 6] = [0.0, 0.1, 0.37, 0.5, 0.8, 1.0];

#[test]
fn meets_end_points_and_end_velocities() {
    let mut rng = Rng::new(1);
    let mut worst = Worst::new("end points and end velocities, relative to 1 + |V|");
    for size in SIZES.into_iter().filter(|size| *size != (1, 1)) {
        for (distance_, speed) in [
            (1.0, 0.0),
            (1e-9, 1e-9),
            (0.0, 1.0),
            (1.0, 1.0),
            (2.5, 2.0),
            (1.0, 4.5),
        ] {
            let data = Boundary::random(size, distance_, speed, &mut rng);
            let curve = data.curve();
            for (t, nu, expected) in [
                (0.0, 0, &data.s0),
                (0.0, 1, &data.v0),
                (1.0, 0, &data.s1),
                (1.0, 1, &data.v1),
            ] {
                let error = distance(&curve.derivative(t, nu).unwrap(), expected) / (1.0 + speed);
                worst.see(error, || {
                    format!("{size:?}, distance {distance_}, speed {speed}, t = {t}, nu = {nu}")
                });
            }
        }
    }
    worst.assert_at_most(1e-13);
}

/// Regression: an outer leg longer than the principal quasi-geodesic between its ends gave a curve with another
/// velocity.
#[test]
fn meets_fast_end_velocities_or_refuses_them() {
    let mut rng = Rng::new(9);
    let mut worst = Worst::new("fast end velocities, relative to |V|");
    let (mut met, mut refused) = (0, 0);
    for size in SIZES.into_iter().filter(|size| *size != (1, 1)) {
        for speed in [6.0, 9.0, 10.0, 20.0, 50.0, 1e3] {
            let data = Boundary::random(size, 1.0, speed, &mut rng);
            let parts = [&data.s0, &data.v0, &data.s1, &data.v1].map(|p| p.as_ref());
            match GeometricCubic::from_boundary(parts[0], parts[1], parts[2], parts[3]) {
                Ok(curve) => {
                    met += 1;
                    for (t, expected) in [(0.0, &data.v0), (1.0, &data.v1)] {
                        let error = distance(&curve.derivative(t, 1).unwrap(), expected) / speed;
                        worst.see(error, || format!("{size:?}, speed {speed}, t = {t}"));
                    }
                }
                Err(Error::InvalidArgument {
                    name: "V0" | "V1",
                    found,
                    ..
                }) => {
                    refused += 1;
                    assert_within(
                        (found / speed - 1.0).abs(),
                        0.5,
                        "reported length (Frobenius, not canonical)",
                    );
                }
                Err(error) => panic!("{size:?}, speed {speed}: {error}"),
            }
        }
    }
    println!("{met} met, {refused} refused");
    assert!(
        met >= 13 && refused >= 13,
        "{met} met, {refused} refused: one of the two was never seen"
    );
    worst.assert_at_most(1e-12);
}

#[test]
fn meets_end_velocities_on_the_sphere_below_three_pi() {
    let mut rng = Rng::new(10);
    for (speed, meets) in [
        (9.0, true),
        (3.0 * PI - 1e-3, true),
        (3.0 * PI + 1e-3, false),
    ] {
        let data = Boundary::random((3, 1), 1.0, speed, &mut rng);
        let parts = [&data.s0, &data.v0, &data.s1, &data.v1].map(|p| p.as_ref());
        let curve = GeometricCubic::from_boundary(parts[0], parts[1], parts[2], parts[3]);
        assert_eq!(curve.is_ok(), meets, "speed {speed}: {:?}", curve.err());
    }
}

#[test]
fn control_points_are_retractions_of_a_third_of_the_velocities() {
    let mut rng = Rng::new(2);
    for size in SIZES {
        let data = Boundary::random(size, 1.0, 1.5, &mut rng);
        let curve = data.curve();
        let inner1 = retract(&data.s0, &(&data.v0 * Scale(1.0 / 3.0)));
        let inner2 = retract(&data.s1, &(&data.v1 * Scale(-1.0 / 3.0)));
        let [p0, p1, p2, p3] = &curve.control_points();
        for (found, expected) in [(p0, &data.s0), (p1, &inner1), (p2, &inner2), (p3, &data.s1)] {
            assert_close(
                found,
                expected,
                8.0 * size.0 as f64 * EPS,
                &format!("control point, {size:?}"),
            );
        }
    }
}

#[test]
fn from_control_points_is_from_boundary() {
    let mut rng = Rng::new(3);
    let mut worst = Worst::new("from_control_points - from_boundary");
    for size in SIZES {
        let curve = Boundary::random(size, 1.0, 1.5, &mut rng).curve();
        let again = through(&curve.control_points());
        for t in TIMES {
            worst.see(
                distance(&curve.point(t).unwrap(), &again.point(t).unwrap()),
                || format!("{size:?}, t = {t}"),
            );
        }
    }
    worst.assert_at_most(1e-13);
}

#[test]
fn stays_orthonormal() {
    let mut rng = Rng::new(4);
    let mut worst = Worst::new("orthonormality");
    for size in SIZES {
        let curve = Boundary::random(size, 1.5, 2.0, &mut rng).curve();
        for step in -10..=60 {
            let t = f64::from(step) / 50.0;
            worst.see(orthonormality(&curve.point(t).unwrap()), || {
                format!("{size:?}, t = {t}")
            });
        }
    }
    worst.assert_at_most(1e-13);
}
