//! Splines of rotations that do not exist or are not found: errors name the place and the reason.

use std::f64::consts::PI;

use nalgebra::{UnitQuaternion, Vector3};
use stiefel_rs::rotation::{ReferenceFrame, RotationEnds, RotationSpline};
use stiefel_rs::spline::SplineOptions;
use stiefel_rs::{Error, Interrupt};

#[test]
fn rates_decide_the_direction_of_half_turns_or_an_error_names_them() {
    let axis = Vector3::new(0.6, 0.0, 0.8);
    // A quarter turn, then half a turn.
    let q = [0.0, 0.5, 1.5].map(|turns| UnitQuaternion::from_scaled_axis(axis * (PI * turns)));
    let t = [0.0, 1.0, 3.0];
    let with = |rates: [f64; 3]| {
        let rates = rates.map(|rate| axis * rate);
        RotationSpline::hermite(&t, &q, &rates, &Default::default(), Interrupt::NEVER)
    };
    for sign in [1.0, -1.0] {
        let curve = with([0.0, 0.0, 1e-9 * sign]).unwrap();
        let rate = curve.angular_velocity(2.0, ReferenceFrame::Body).unwrap();
        // At rest at both ends, it is fastest in the middle.
        assert!((rate - axis * (sign * 0.75 * PI)).norm() < 1e-6, "{rate}");
    }
    for rates in [[0.0; 3], [0.0, 1.0, -1.0], [1.0, 1e-17, 0.0]] {
        let error = with(rates).err().unwrap();
        assert!(matches!(error, Error::AtKnot { knot: 1, .. }), "{error}");
        assert!(
            matches!(error.cause(), Error::UndecidedTurn { .. }),
            "{error}"
        );
        assert!((error.angle().unwrap() - PI).abs() < 1e-14);
    }
}

#[test]
fn a_spline_that_is_not_found_names_the_long_interval() {
    let vectors = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.5], [1.0, -1.0, 2.0]];
    let q = vectors.map(|v| UnitQuaternion::from_scaled_axis(Vector3::from(v)));
    let t = [0.0, 1.0, 1001.0, 1002.0];
    let error = RotationSpline::new(
        &t,
        &q,
        &RotationEnds::Natural,
        &SplineOptions::default(),
        Interrupt::NEVER,
    )
    .err()
    .unwrap();
    let Error::AtKnot { knot: 1, source } = &error else {
        panic!("{error}");
    };
    let Error::UnevenTimes { speed, ratio, .. } = **source else {
        panic!("{error}");
    };
    assert!((ratio - 1000.0).abs() < 1e-9 && speed > 500.0, "{error}");
    assert!(error.report().is_some(), "{error}");
    // Without any iteration the reason may be another one.
    let t = [0.0, 1.0, 6.0, 7.0];
    let options = SplineOptions {
        max_iterations: 0,
        ..SplineOptions::default()
    };
    let error = RotationSpline::new(&t, &q, &RotationEnds::Natural, &options, Interrupt::NEVER)
        .err()
        .unwrap();
    assert!(matches!(error, Error::NoConvergence { .. }), "{error}");
}
