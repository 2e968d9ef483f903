//! Geometric cubics of subspaces from boundary data, and several consecutive ones.

use std::f64::consts::FRAC_PI_2;

use faer::{Mat, Scale};
use stiefel_rs::spline::{
    EndCondition, EndConditions, SplineOptions, geometric_spline, geometric_subspace_hermite,
    geometric_subspace_spline,
};
use stiefel_rs::{Curve, Error, Interrupt, Quotient, SubspacePolynomial};

use crate::common::{
    Rng, Worst, assert_close, assert_within, distance, gaussian, random_orthogonal,
};
use crate::spline::check;
use crate::{SHAPES, horizontal, polynomial, reflected, reflection, view, walk};

#[test]
fn boundary_data_are_met() {
    let mut rng = Rng::new(35);
    let mut worst = Worst::new("boundary data");
    for shape in SHAPES.into_iter().chain([(30, 2)]) {
        for speed in [0.5, 3.0] {
            let ends = walk(shape, 1, 0.8, &mut rng);
            let [v0, v1] = [0, 1].map(|i: usize| {
                let v = horizontal(
                    view(&ends[i]),
                    gaussian(shape.0, shape.1, &mut rng).as_ref(),
                );
                &v * Scale(speed / v.norm_l2())
            });
            let [y0, y1] = [view(&ends[0]), view(&ends[1])];
            let Ok(curve) =
                SubspacePolynomial::from_boundary(y0, view(&v0), y1, view(&v1), Interrupt::NEVER)
            else {
                // Inner control points at a principal angle above pi/2.
                assert!(speed > 1.0, "{shape:?}");
                continue;
            };
            assert_eq!((curve.degree(), curve.n()), (3, shape.0));
            let q = y1.transpose() * curve.point(1.0).unwrap();
            let pairs = [
                (curve.point(0.0).unwrap(), ends[0].clone()),
                (curve.derivative(0.0, 1).unwrap(), v0.clone()),
                (curve.point(1.0).unwrap(), y1 * &q),
                (curve.derivative(1.0, 1).unwrap(), &v1 * &q),
            ];
            for (found, expected) in pairs {
                worst.see(distance(&found, &expected), || {
                    format!("{shape:?}, {speed}")
                });
            }
            let again = polynomial(&curve.control_points());
            for t in [0.2, 0.8] {
                assert_close(
                    &again.point(t).unwrap(),
                    &curve.point(t).unwrap(),
                    1e-13,
                    &format!("{shape:?}, from its control points"),
                );
            }
        }
    }
    worst.assert_at_most(4e-14);
}

/// Consecutive geometric cubics: bases are continuous, and velocities agree from both sides.
#[test]
fn pieces_through_many_subspaces() {
    let mut rng = Rng::new(41);
    let mut worst = Worst::new("knots");
    for shape in SHAPES {
        let points = walk(shape, 3, 0.8, &mut rng);
        let t = [0.0, 0.5, 2.0, 3.0];
        let velocities: Vec<_> = points
            .iter()
            .map(|y| horizontal(view(y), gaussian(shape.0, shape.1, &mut rng).as_ref()))
            .map(|v| &v * Scale(0.4 / v.norm_l2()))
            .collect();
        let [y, v] = [&points, &velocities].map(|all| all.iter().map(view).collect::<Vec<_>>());
        let curve = geometric_subspace_hermite(&t, &y, &v, Interrupt::NEVER).unwrap();
        assert_eq!(curve.quotient(), Quotient::Subspaces);
        worst.see(distance(&curve.point(0.0).unwrap(), &points[0]), || {
            "first".to_owned()
        });
        for (i, piece) in curve.pieces().iter().enumerate() {
            let h = t[i + 1] - t[i];
            for (local, knot) in [(0.0, i), (1.0, i + 1)] {
                let turn = points[knot].transpose() * piece.point(local).unwrap();
                let point = distance(&piece.point(local).unwrap(), &(&points[knot] * &turn));
                let expected = &velocities[knot] * &turn * Scale(h);
                let velocity = distance(&piece.derivative(local, 1).unwrap(), &expected);
                worst.see(point.max(velocity), || format!("{shape:?}, knot {knot}"));
            }
            if i > 0 {
                let before = curve.pieces()[i - 1].point(1.0).unwrap();
                worst.see(distance(&piece.point(0.0).unwrap(), &before), || {
                    format!("{shape:?}, bases at knot {i}")
                });
            }
        }
    }
    worst.assert_at_most(4e-14);
    // A right angle, and a velocity that is too long, each at its knot.
    let e = Mat::<f64>::identity(3, 3);
    let lines = [0, 0, 1].map(|i| e.col(i).as_mat().to_owned());
    let rest = Mat::<f64>::zeros(3, 1);
    let y = lines.each_ref().map(view);
    let make = |v: [&Mat<f64>; 3]| {
        geometric_subspace_hermite(&[0.0, 1.0, 2.0], &y, &v.map(view), Interrupt::NEVER)
    };
    let error = make([&rest; 3]).unwrap_err();
    assert!(matches!(error, Error::AtKnot { knot: 1, .. }), "{error}");
    assert_within((error.angle().unwrap() - FRAC_PI_2).abs(), 1e-15, "angle");
    let fast = &lines[2] * Scale(6.0);
    let error = make([&rest, &fast, &rest]).unwrap_err();
    assert!(matches!(error, Error::AtKnot { knot: 0, .. }), "{error}");
    let Error::InvalidArgument {
        name: "V1", found, ..
    } = *error.cause()
    else {
        panic!("{error}");
    };
    assert_within((found - 6.0).abs(), 1e-14, "speed");
}

#[test]
fn splines_are_those_of_reflections() {
    let mut rng = Rng::new(43);
    let t = [0.0, 1.0, 1.8, 3.0, 4.1];
    for shape in SHAPES {
        let (n, k) = shape;
        let mut points = walk(shape, 4, 0.6, &mut rng);
        let mut reflections: Vec<Mat<f64>> = points.iter().map(|y| reflection(view(y))).collect();
        let given = [0, 4].map(|knot: usize| {
            let v = horizontal(view(&points[knot]), gaussian(n, k, &mut rng).as_ref());
            &v * Scale(0.4 / v.norm_l2())
        });
        let high = [0, 1].map(|i: usize| reflected(view(&points[4 * i]), view(&given[i])));
        let velocity = |v: &Mat<f64>| EndCondition::Velocity(v.clone());
        let acceleration = |a: &Mat<f64>| EndCondition::Acceleration(a.clone());
        let mixed =
            |[a, b]: &[Mat<f64>; 2]| EndConditions::Each(Box::new([velocity(a), acceleration(b)]));
        let cases = [
            (EndConditions::Natural, EndConditions::Natural),
            (mixed(&given), mixed(&high)),
            (EndConditions::Periodic, EndConditions::Periodic),
        ];
        for (case, (below, above)) in cases.into_iter().enumerate() {
            if case == 2 {
                points[4] = &points[0] * random_orthogonal(k, &mut rng);
                reflections[4] = reflections[0].clone();
            }
            let [y, r] =
                [&points, &reflections].map(|all| all.iter().map(view).collect::<Vec<_>>());
            let options = SplineOptions::default();
            let (curve, report) =
                geometric_subspace_spline(&t, &y, &below, &options, Interrupt::NEVER).unwrap();
            let (oracle, expected) =
                geometric_spline(&t, &r, &above, &options, Interrupt::NEVER).unwrap();
            let what = format!("geometric, {shape:?}, case {case}");
            check(&curve, &oracle, &what);
            assert!(
                report.converged && report.iterations <= expected.iterations + 2,
                "{what}"
            );
            assert_close(&curve.point(0.0).unwrap(), &points[0], 1e-13, &what);
            // Accelerations of both pieces at a knot.
            for i in 1..4 {
                let [before, after] = [(i - 1, 1.0), (i, 0.0)].map(|(piece, local)| {
                    let h: f64 = t[piece + 1] - t[piece];
                    curve.pieces()[piece].acceleration(local).unwrap() * Scale(h.powi(-2))
                });
                assert_close(&before, &after, 1e-10, &what);
            }
        }
    }
}

#[test]
fn perpendicular_neighbours_are_refused() {
    let e = Mat::<f64>::identity(4, 4);
    let planes = [[0, 1], [1, 2], [2, 3]].map(|c| Mat::from_fn(4, 2, |i, j| e[(i, c[j])]));
    let tilted = Mat::from_fn(4, 2, |i, j| match (i, j) {
        (0, 0) | (2, 0) => 0.5_f64.sqrt(),
        (1, 1) => 1.0,
        _ => 0.0,
    });
    let y = [&planes[0], &tilted, &planes[2]].map(view);
    let error = geometric_subspace_spline(
        &[0.0, 1.0, 2.0],
        &y,
        &EndConditions::Natural,
        &SplineOptions::default(),
        Interrupt::NEVER,
    )
    .unwrap_err();
    assert!(matches!(error, Error::AtKnot { knot: 1, .. }), "{error}");
    assert_within((error.angle().unwrap() - FRAC_PI_2).abs(), 1e-14, "angle");
}
