//! Geometric cubics of subspaces from boundary data, and many of them one after the other.

use std::f64::consts::FRAC_PI_2;

use faer::{Mat, Scale};
use stiefel_rs::spline::geometric_subspace_hermite;
use stiefel_rs::{Curve, Error, Interrupt, Quotient, SubspacePolynomial};

use crate::common::{Rng, Worst, assert_close, assert_within, distance, gaussian};
use crate::{SHAPES, horizontal, polynomial, view, walk};

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
            let Ok(curve) = SubspacePolynomial::from_boundary(y0, view(&v0), y1, view(&v1)) else {
                // Inner control points more than a right angle apart.
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

/// Geometric cubics one after the other: bases go on, velocities are met from both sides.
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
    // A right angle, and a velocity that is too long, at their knots.
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
    assert_within((error.angle().unwrap() - 2.0).abs(), 1e-15, "angle");
}
