//! Bad parameters, boundary data and control points.

use faer::{Mat, Scale};
use stiefel_rs::{Curve, Error, GeometricCubic, Interrupt, Quantity};

use crate::common::{Boundary, Rng, random_point};

#[test]
fn bad_parameters_are_refused() {
    let curve = Boundary::random((4, 2), 1.0, 1.0, &mut Rng::new(51)).curve();
    let sample = |t: &[f64], quantity| curve.sample(t, quantity, Interrupt::NEVER).err();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = sample(&[0.0, 0.5, bad], Quantity::Derivative(0));
        assert_eq!(
            error,
            Some(Error::NonFinite {
                name: "t",
                index: 2
            })
        );
        assert_eq!(
            curve.point(bad).err(),
            Some(Error::NonFinite {
                name: "t",
                index: 0
            })
        );
    }
    for t in [&[0.5][..], &[]] {
        let error = sample(t, Quantity::Derivative(4));
        assert!(
            matches!(
                error,
                Some(Error::InvalidArgument {
                    name: "nu",
                    found: 4.0,
                    ..
                })
            ),
            "{error:?}"
        );
    }
    let stopped = curve
        .sample(&[0.5], Quantity::Derivative(0), Interrupt::new(&|| true))
        .err();
    assert!(
        matches!(stopped, Some(Error::Interrupted { .. })),
        "{stopped:?}"
    );
}

#[test]
fn bad_boundary_data_are_refused() {
    let data = Boundary::random((4, 2), 1.0, 1.0, &mut Rng::new(52));
    let parts = [&data.s0, &data.v0, &data.s1, &data.v1];
    let with = |at: usize, replacement: Mat<f64>| {
        let mut parts = parts.map(|p| p.clone());
        parts[at] = replacement;
        let [s0, v0, s1, v1] = parts.each_ref().map(|p| p.as_ref());
        GeometricCubic::from_boundary(s0, v0, s1, v1).err()
    };
    for (at, expected) in ["S0", "V0", "S1", "V1"].into_iter().enumerate() {
        for bad in [f64::NAN, f64::INFINITY] {
            let error = with(at, parts[at] * Scale(bad));
            assert!(
                matches!(error, Some(Error::NonFinite { name, .. }) if name == expected),
                "{expected}: {error:?}"
            );
        }
        if at > 0 {
            let error = with(at, Mat::zeros(5, 2));
            assert!(
                matches!(error, Some(Error::Shape { name, .. }) if name == expected),
                "{expected}: {error:?}"
            );
        }
    }
    let error = with(0, Mat::zeros(2, 4));
    assert!(
        matches!(error, Some(Error::Shape { name: "S0", .. })),
        "{error:?}"
    );
    for (at, expected) in [(0, "S0"), (2, "S1")] {
        let error = with(at, parts[at] * Scale(1.0 + 1e-6));
        assert!(
            matches!(error, Some(Error::NotOrthonormal { name, .. }) if name == expected),
            "{error:?}"
        );
    }
    for (at, point, expected) in [(1, &data.s0, "V0"), (3, &data.s1, "V1")] {
        let error = with(at, parts[at] + point * Scale(1e-6));
        assert!(
            matches!(error, Some(Error::NotTangent { name, .. }) if name == expected),
            "{error:?}"
        );
    }
}

#[test]
fn bad_control_points_are_refused() {
    let points = Boundary::random((4, 2), 1.0, 1.0, &mut Rng::new(53))
        .curve()
        .control_points();
    let with = |replacement: Mat<f64>| {
        let [a, b, _, d] = points.each_ref().map(|p| p.as_ref());
        GeometricCubic::from_control_points([a, b, replacement.as_ref(), d]).err()
    };
    assert!(matches!(
        with(&points[2] * Scale(f64::NAN)),
        Some(Error::NonFinite {
            name: "control points",
            ..
        })
    ));
    assert!(matches!(
        with(&points[2] * Scale(1.5)),
        Some(Error::NotOrthonormal {
            name: "control points",
            ..
        })
    ));
    assert!(matches!(
        with(Mat::zeros(4, 3)),
        Some(Error::Shape {
            name: "control points",
            ..
        })
    ));
    let three = GeometricCubic::try_from(&points[..3]).err();
    assert!(
        matches!(
            three,
            Some(Error::Shape {
                name: "control points",
                ..
            })
        ),
        "{three:?}"
    );
    let sphere = random_point(3, 1, &mut Rng::new(54));
    let opposite = -&sphere;
    let error = GeometricCubic::from_control_points(
        [&sphere, &opposite, &sphere, &sphere].map(|p| p.as_ref()),
    )
    .err();
    assert!(
        matches!(error, Some(Error::NoJoiningCurve { .. })),
        "{error:?}"
    );
}
