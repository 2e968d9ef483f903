//! Times outside a spline, and bad knots.

use faer::{Mat, Scale};
use stiefel_rs::spline::{EndCondition, EndConditions, Outside, SplineOptions, cubic_spline};
use stiefel_rs::{Curve, Error, Interrupt};

use crate::common::{assert_within, distance};
use crate::knots::{views, walk};
use crate::smoothness::{MET, spline};

#[test]
fn samples_are_points_and_times_outside_are_refused() {
    let (t, points) = walk((4, 2), 5, 0.6, 11);
    let (curve, _) = spline(&t, &points, &EndConditions::Natural);
    let times: Vec<f64> = (0..300)
        .map(|i| t[0] + (t[4] - t[0]) * f64::from(i * 37 % 300) / 300.0)
        .collect();
    let all = curve
        .sample(
            &times,
            stiefel_rs::Quantity::Derivative(1),
            stiefel_rs::Interrupt::NEVER,
        )
        .unwrap();
    for (i, t) in times.iter().enumerate() {
        let one = curve.derivative(*t, 1).unwrap();
        assert_eq!(one.as_ref(), all.get(i));
    }
    for outside in [t[0] - 0.1, t[4] + 0.1] {
        assert!(matches!(
            curve.point(outside),
            Err(Error::InvalidArgument { name: "t", found, .. }) if found == outside
        ));
    }
    let longer = curve.clone().with_outside(Outside::Continued);
    let before = longer.point(t[0] - 0.1).unwrap();
    assert_within(
        distance(
            &before,
            &curve.pieces()[0].point(-0.1 / (t[1] - t[0])).unwrap(),
        ),
        MET,
        "before",
    );
    assert!(matches!(
        longer.point(f64::NAN),
        Err(Error::NonFinite { .. })
    ));
}

#[test]
fn bad_knots_are_named() {
    let (t, points) = walk((3, 2), 4, 0.5, 12);
    let solve = |t: &[f64], points: &[Mat<f64>], ends: &EndConditions| {
        cubic_spline(
            t,
            &views(points),
            ends,
            &SplineOptions::default(),
            Interrupt::NEVER,
        )
        .map(|_| ())
    };
    let natural = EndConditions::Natural;
    assert!(matches!(
        solve(&t[..1], &points[..1], &natural),
        Err(Error::Shape { .. })
    ));
    assert!(matches!(
        solve(&t[..3], &points, &natural),
        Err(Error::Shape { .. })
    ));
    let mut wrong = t.clone();
    wrong[2] = f64::NAN;
    assert!(matches!(
        solve(&wrong, &points, &natural),
        Err(Error::AtKnot { knot: 2, source }) if *source == Error::NonFinite { name: "t", index: 2 }
    ));
    for time in [t[1], t[1] - 0.1, t[0]] {
        let mut wrong = t.clone();
        wrong[2] = time;
        assert!(matches!(
            solve(&wrong, &points, &natural),
            Err(Error::AtKnot { knot: 2, .. })
        ));
    }
    let mut wrong = points.clone();
    wrong[3][(0, 0)] += 0.1;
    assert!(matches!(
        solve(&t, &wrong, &natural),
        Err(Error::AtKnot { knot: 3, source }) if matches!(*source, Error::NotOrthonormal { .. })
    ));
    // Opposite points of the sphere.
    let (t, mut points) = walk((3, 1), 4, 0.5, 13);
    points[2] = &points[1] * Scale(-1.0);
    assert!(matches!(
        solve(&t, &points, &natural),
        Err(Error::AtKnot { knot: 1, source }) if matches!(*source, Error::NoJoiningCurve { .. })
    ));
    let said = solve(&t, &points, &natural).unwrap_err().to_string();
    assert!(said.starts_with("knots 1 and 2: "), "{said}");
    // Different components of O(n).
    let (t, mut points) = walk((3, 3), 4, 0.5, 14);
    points[3] = &points[3] * Scale(-1.0);
    assert!(matches!(
        solve(&t, &points, &natural),
        Err(Error::AtKnot { knot: 2, source }) if matches!(*source, Error::DifferentComponents { n: 3 })
    ));
    // A tolerance that cannot be met.
    for tolerance in [0.0, 1e-16, 1.0, f64::NAN] {
        let options = SplineOptions {
            tolerance,
            ..SplineOptions::default()
        };
        assert!(matches!(
            cubic_spline(
                &t[..2],
                &views(&points[..2]),
                &natural,
                &options,
                Interrupt::NEVER
            ),
            Err(Error::InvalidArgument {
                name: "tolerance",
                ..
            })
        ));
    }
    // Ends that do not close, ends that are not tangent.
    assert!(matches!(
        solve(&t[..3], &points[..3], &EndConditions::Periodic),
        Err(Error::AtKnot { knot: 2, .. })
    ));
    let ends = EndConditions::Each(Box::new([
        EndCondition::Velocity(Mat::zeros(3, 3)),
        EndCondition::Velocity(points[2].clone()),
    ]));
    assert!(matches!(
        solve(&t[..3], &points[..3], &ends),
        Err(Error::AtKnot { knot: 2, source }) if matches!(*source, Error::NotTangent { .. })
    ));
}
