//! Refused input, and the errors for it.

use faer::Mat;
use stiefel_rs::spline::{EndConditions, SplineOptions, SplineVariation, cubic_spline};
use stiefel_rs::{Error, Interrupt};

use crate::family::{Ends, Family};
use crate::knots::views;

fn unwrapped(error: Error) -> Error {
    match error {
        Error::AtKnot { source, .. } => *source,
        other => other,
    }
}

#[test]
fn variations_that_are_none() {
    let family = Family::new((4, 2), 4, Ends::Natural, 5);
    let data = family.at(0.0);
    let curve = data.spline();
    let derivative = curve
        .data_derivative(&data.conditions, Interrupt::NEVER)
        .unwrap();
    let points = views(&family.ds);
    let good = SplineVariation {
        points: &points,
        times: &[],
        ends: [None; 2],
    };
    let refused = |variation: &SplineVariation<'_>| {
        let result = derivative.points(variation, &[1.0], Interrupt::NEVER);
        unwrapped(result.unwrap_err())
    };
    assert!(derivative.points(&good, &[1.0], Interrupt::NEVER).is_ok());
    let fewer = SplineVariation {
        points: &points[1..],
        ..good
    };
    assert!(matches!(refused(&fewer), Error::Shape { .. }));
    let times = SplineVariation {
        times: &[1.0],
        ..good
    };
    assert!(matches!(refused(&times), Error::Shape { .. }));
    let times = SplineVariation {
        times: &[1.0, f64::NAN, 0.0, 0.0],
        ..good
    };
    assert!(matches!(refused(&times), Error::NonFinite { .. }));
    let ends = SplineVariation {
        ends: [Some(points[0]), None],
        ..good
    };
    assert!(matches!(refused(&ends), Error::Shape { .. }));
    let mut off = family.ds.clone();
    off[2] += &family.points[2];
    let off = views(&off);
    let off = SplineVariation {
        points: &off,
        ..good
    };
    assert!(matches!(refused(&off), Error::NotTangent { .. }));
    let outside = derivative.points(&good, &[family.t[3] + 1.0], Interrupt::NEVER);
    assert!(matches!(outside, Err(Error::InvalidArgument { .. })));
}

#[test]
fn huge_variations_are_typed_or_finite() {
    let family = Family::new((4, 2), 4, Ends::Natural, 5);
    let data = family.at(0.0);
    let derivative = data
        .spline()
        .data_derivative(&data.conditions, Interrupt::NEVER)
        .unwrap();
    for size in [1e150, 1e300, 1e308] {
        let points: Vec<Mat<f64>> = family.ds.iter().map(|x| x * faer::Scale(size)).collect();
        let points = views(&points);
        let variation = SplineVariation {
            points: &points,
            times: &[],
            ends: [None; 2],
        };
        match derivative.points(&variation, &[1.0], Interrupt::NEVER) {
            Ok(found) => assert!(found[0].norm_max().is_finite()),
            Err(error) => assert!(matches!(
                unwrapped(error),
                Error::Overflow { .. } | Error::NotTangent { .. } | Error::NonFinite { .. }
            )),
        }
        let cotangent = Mat::from_fn(4, 2, |_, _| size);
        match derivative.pull_back(&[1.0], &[cotangent.as_ref()], Interrupt::NEVER) {
            Ok(found) => assert!(found.points[0].norm_max().is_finite()),
            Err(error) => assert!(matches!(error, Error::Overflow { .. }), "{error}"),
        }
    }
}

#[test]
fn cotangents_of_another_shape() {
    let family = Family::new((4, 2), 4, Ends::Natural, 5);
    let data = family.at(0.0);
    let derivative = data
        .spline()
        .data_derivative(&data.conditions, Interrupt::NEVER)
        .unwrap();
    let (good, wide) = (Mat::<f64>::zeros(4, 2), Mat::<f64>::zeros(4, 3));
    let refused = |t: &[f64], x: &[faer::MatRef<'_, f64>]| {
        derivative.pull_back(t, x, Interrupt::NEVER).unwrap_err()
    };
    assert!(matches!(refused(&[1.0], &[]), Error::Shape { .. }));
    assert!(matches!(
        refused(&[1.0], &[wide.as_ref()]),
        Error::Shape { .. }
    ));
    assert!(matches!(
        refused(&[f64::NAN], &[good.as_ref()]),
        Error::NonFinite { .. }
    ));
    let none = derivative.pull_back(&[], &[], Interrupt::NEVER).unwrap();
    assert!(none.points.iter().all(|x| x.norm_max() == 0.0));
}

#[test]
fn other_ends_than_those_of_the_spline() {
    let family = Family::new((3, 3), 4, Ends::Velocities, 6);
    let curve = family.at(0.0).spline();
    for ends in [EndConditions::Natural, EndConditions::Periodic] {
        let Err(error) = curve.data_derivative(&ends, Interrupt::NEVER) else {
            panic!("{ends:?}");
        };
        assert!(matches!(unwrapped(error), Error::InvalidArgument { .. }));
        let error = curve.cost_gradient(&ends, Interrupt::NEVER).unwrap_err();
        assert!(matches!(unwrapped(error), Error::InvalidArgument { .. }));
    }
}

#[test]
fn systems_that_do_not_fit_are_refused_before_they_are_made() {
    // 140 knots in 435 dimensions: matrices and factors of 5.3e8 numbers. The rotations are equal, so that the curve
    // itself is quick to compute.
    let (n, count) = (30, 140);
    let point = crate::common::random_point(n, n, &mut crate::common::Rng::new(9));
    let t: Vec<f64> = (0..count).map(f64::from).collect();
    let points = vec![point.as_ref(); t.len()];
    let ends = EndConditions::Natural;
    let (curve, _) = cubic_spline(
        &t,
        &points,
        &ends,
        &SplineOptions::default(),
        Interrupt::NEVER,
    )
    .unwrap();
    let (asked, refused) =
        crate::common::counted(|interrupt| curve.data_derivative(&ends, interrupt).err().unwrap());
    match refused {
        Error::InvalidArgument { name, found, .. } => {
            assert_eq!(
                (name, found),
                ("points", 140.0 * (20.0 * 435.0 * 435.0 + 500.0))
            );
        }
        other => panic!("{other}"),
    }
    // One poll per piece when its ends are read; no equations are set up.
    assert!(asked < t.len(), "{asked}");
}
