//! Velocities from points: formulas of flat space on the circle, exact cases, symmetries, orders, bad input.

mod common;
#[path = "common/knots.rs"]
mod knots;

use common::{Rng, assert_within, distance, random_point, random_rotation, random_tangent};
use faer::{Mat, Scale, mat};
use knots::{views, walk};
use stiefel_rs::spline::{
    VelocityEstimate, estimate_closed_velocities, estimate_velocities, geometric_hermite,
};
use stiefel_rs::{Curve, Error, QuasiGeodesic, Quotient, Stiefel};

const ESTIMATES: [VelocityEstimate; 3] = [
    VelocityEstimate::CatmullRom,
    VelocityEstimate::Akima,
    VelocityEstimate::Natural,
];

const SHAPES: [(usize, usize); 9] = [
    (1, 1),
    (2, 1),
    (3, 1),
    (3, 2),
    (3, 3),
    (4, 2),
    (6, 3),
    (4, 4),
    (40, 2),
];

/// Angles of size 4 and slopes of size 10, tens of operations.
const ROUND_OFF: f64 = 400.0 * f64::EPSILON;

fn on_circle(angle: f64) -> Mat<f64> {
    mat![[angle.cos()], [angle.sin()]]
}

/// Angular velocities from angles.
fn on_the_circle(t: &[f64], angles: &[f64], estimate: VelocityEstimate) -> Vec<f64> {
    let points: Vec<Mat<f64>> = angles.iter().map(|angle| on_circle(*angle)).collect();
    let velocities = estimate_velocities(t, &views(&points), estimate, Quotient::Frames).unwrap();
    let angular = |(v, s): (&Mat<f64>, &Mat<f64>)| v[(1, 0)] * s[(0, 0)] - v[(0, 0)] * s[(1, 0)];
    velocities.iter().zip(&points).map(angular).collect()
}

#[track_caller]
fn assert_same(found: &[f64], expected: &[f64], name: &str) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert_within((found - expected).abs(), ROUND_OFF, name);
    }
}

/// `Akima1DInterpolator(x, y, method="makima")`, SciPy's formulas for numbers.
fn makima(t: &[f64], y: &[f64]) -> Vec<f64> {
    let legs = t.len() - 1;
    let mut m = vec![0.0; legs + 4];
    for leg in 0..legs {
        m[leg + 2] = (y[leg + 1] - y[leg]) / (t[leg + 1] - t[leg]);
    }
    m[1] = 2.0 * m[2] - m[3];
    m[0] = 2.0 * m[1] - m[2];
    m[legs + 2] = 2.0 * m[legs + 1] - m[legs];
    m[legs + 3] = 2.0 * m[legs + 2] - m[legs + 1];
    let weight = |i: usize| (m[i + 1] - m[i]).abs() + 0.5 * (m[i + 1] + m[i]).abs();
    (0..=legs)
        .map(|i| {
            let (f1, f2) = (weight(i + 2), weight(i));
            if f1 + f2 > 0.0 {
                (f1 * m[i + 1] + f2 * m[i + 2]) / (f1 + f2)
            } else {
                0.5 * (m[i] + m[i + 3])
            }
        })
        .collect()
}

#[test]
fn on_the_circle_akima_is_makima_of_the_angle() {
    let t = [0.0, 0.4, 1.5, 2.1, 3.0, 3.3, 4.4];
    let y = [0.1, 0.9, 1.2, 0.3, -1.3, -2.2, -3.9];
    for count in [3, 4, 5, 7] {
        let found = on_the_circle(&t[..count], &y[..count], VelocityEstimate::Akima);
        let expected = makima(&t[..count], &y[..count]);
        assert_same(&found, &expected, &format!("{count}"));
    }
    // Two points: the slope between them.
    let found = on_the_circle(&t[..2], &y[..2], VelocityEstimate::Akima);
    assert_same(&found, &[2.0, 2.0], "two");
    // First at rest, then in motion: no overshoot.
    let found = on_the_circle(
        &[0.0, 1.0, 2.0, 3.0, 4.0],
        &[0.3, 0.3, 0.3, 0.8, 1.3],
        VelocityEstimate::Akima,
    );
    let expected = makima(&[0.0, 1.0, 2.0, 3.0, 4.0], &[0.3, 0.3, 0.3, 0.8, 1.3]);
    assert_same(&found, &expected, "at rest");
    // Nothing moves: zero velocity, without dividing zero by zero.
    let still = on_the_circle(&[0.0, 1.0, 2.0, 3.0], &[0.3; 4], VelocityEstimate::Akima);
    assert_same(&still, &[0.0; 4], "still");
}

#[test]
fn on_the_circle_parabolas_have_their_velocity() {
    // Three-point formulas are exact for parabolas, also at the ends, for any times.
    let t = [0.0, 0.4, 1.5, 2.1, 3.0, 3.3];
    let y = t.map(|t| 0.3 + 0.5 * t - 0.4 * t * t);
    let found = on_the_circle(&t, &y, VelocityEstimate::CatmullRom);
    let expected = t.map(|t| 0.5 - 0.8 * t);
    assert_same(&found, &expected, "parabola");
    let two = on_the_circle(&t[..2], &y[..2], VelocityEstimate::CatmullRom);
    assert_same(&two, &[(y[1] - y[0]) / 0.4; 2], "two");
}

#[test]
fn on_the_circle_natural_velocities_solve_the_equations_of_the_spline() {
    let t = [0.0, 0.4, 1.5, 2.1, 3.0, 3.3, 4.4];
    let y = [0.1, 0.9, 1.2, 0.3, -1.3, -2.2, -3.9];
    let v = on_the_circle(&t, &y, VelocityEstimate::Natural);
    let slope = |leg: usize| (y[leg + 1] - y[leg]) / (t[leg + 1] - t[leg]);
    let second = |leg: usize, end: f64| {
        // Second derivative of the cubic with these ends, at its start (end = 0) or end (1).
        let (h, v0, v1) = (t[leg + 1] - t[leg], v[leg], v[leg + 1]);
        (6.0 * slope(leg) * (1.0 - 2.0 * end) - (4.0 - 6.0 * end) * v0 - (2.0 - 6.0 * end) * v1) / h
    };
    // Second derivatives are ten times the slopes.
    let bound = 10.0 * ROUND_OFF;
    assert_within(second(0, 0.0).abs(), bound, "start");
    assert_within(second(5, 1.0).abs(), bound, "end");
    for knot in 1..6 {
        let gap = second(knot - 1, 1.0) - second(knot, 0.0);
        assert_within(gap.abs(), bound, "knot");
    }
}

#[test]
fn quasi_geodesics_have_their_velocity() {
    for shape in SHAPES {
        let mut rng = Rng::new(2);
        let s = random_point(shape.0, shape.1, &mut rng);
        let v = random_tangent(&s, 0.5, &mut rng);
        let curve = QuasiGeodesic::from_velocity(s.as_ref(), v.as_ref()).unwrap();
        let t = [0.0, 0.3, 1.0, 1.4, 2.0];
        let points = t.map(|t| curve.point(t).unwrap());
        for estimate in ESTIMATES {
            let found =
                estimate_velocities(&t, &views(&points), estimate, Quotient::Frames).unwrap();
            for (t, found) in t.iter().zip(&found) {
                let expected = curve.derivative(*t, 1).unwrap();
                let name = format!("{shape:?} {estimate:?} {t}");
                assert_within(distance(found, &expected), 10.0 * ROUND_OFF, &name);
            }
        }
    }
}

#[test]
fn isometries_and_time_carry_velocities_along() {
    for shape in SHAPES {
        let (t, points) = walk(shape, 6, 0.7, 3);
        let mut rng = Rng::new(4);
        let (left, right) = (
            random_rotation(shape.0, &mut rng),
            random_rotation(shape.1, &mut rng),
        );
        let turned: Vec<Mat<f64>> = points.iter().map(|s| &left * s * &right).collect();
        let backward: Vec<f64> = t.iter().rev().map(|t| -2.0 * t).collect();
        let reversed: Vec<Mat<f64>> = points.iter().rev().cloned().collect();
        for estimate in ESTIMATES {
            let name = format!("{shape:?} {estimate:?}");
            let v = estimate_velocities(&t, &views(&points), estimate, Quotient::Frames).unwrap();
            let other =
                estimate_velocities(&t, &views(&turned), estimate, Quotient::Frames).unwrap();
            let back =
                estimate_velocities(&backward, &views(&reversed), estimate, Quotient::Frames)
                    .unwrap();
            for knot in 0..6 {
                let image = &left * &v[knot] * &right;
                assert_within(distance(&other[knot], &image), 10.0 * ROUND_OFF, &name);
                let same = &back[5 - knot] * Scale(-2.0);
                assert_within(distance(&same, &v[knot]), 10.0 * ROUND_OFF, &name);
                Stiefel::new(shape.0, shape.1)
                    .unwrap()
                    .check_tangent("V", points[knot].as_ref(), v[knot].as_ref(), ROUND_OFF)
                    .unwrap();
            }
            geometric_hermite(&t, &views(&points), &views(&v)).unwrap();
        }
    }
}

#[test]
fn closed_curves_have_one_velocity_where_they_close() {
    for shape in SHAPES {
        for count in [2, 3, 6] {
            let (mut t, mut points) = walk(shape, count, 0.5, 5);
            t.push(t[count - 1] + 0.8);
            points.push(points[0].clone());
            // The same curve from its second knot on.
            let mut later: Vec<Mat<f64>> = points[1..].to_vec();
            later.push(points[1].clone());
            let mut times: Vec<f64> = t[1..].to_vec();
            times.push(t[count] + t[1] - t[0]);
            for estimate in ESTIMATES {
                let name = format!("{shape:?} {estimate:?} {count}");
                let v = estimate_closed_velocities(&t, &views(&points), estimate, Quotient::Frames)
                    .unwrap();
                assert_eq!(v.len(), count + 1);
                assert_within(distance(&v[0], &v[count]), ROUND_OFF, &name);
                let w =
                    estimate_closed_velocities(&times, &views(&later), estimate, Quotient::Frames)
                        .unwrap();
                for knot in 0..count {
                    assert_within(distance(&w[knot], &v[knot + 1]), 10.0 * ROUND_OFF, &name);
                }
            }
        }
    }
}

/// Slope of the errors at interior samples of a fixed smooth curve, for 16 to 256 legs of unequal length.
fn order(shape: (usize, usize), estimate: VelocityEstimate) -> f64 {
    let mut rng = Rng::new(6);
    let s = random_point(shape.0, shape.1, &mut rng);
    let [a, b] = [1.0, 0.7].map(|size| common::random_skew(shape.0, size, &mut rng));
    let exact = |t: f64| {
        let turn = |a: &Mat<f64>, t: f64| stiefel_rs::skew_exp((a * Scale(t)).as_ref()).unwrap();
        turn(&a, t) * turn(&b, (2.0 * t).sin()) * &s
    };
    let velocity = |t: f64| {
        // A central difference of order eight: round-off and truncation are below 1e-11.
        let (h, weights) = (0.02, [0.8, -0.2, 4.0 / 105.0, -1.0 / 280.0]);
        let mut sum = Mat::zeros(shape.0, shape.1);
        for (i, w) in weights.iter().enumerate() {
            let d = h * (i + 1) as f64;
            sum += (exact(t + d) - exact(t - d)) * Scale(w / h);
        }
        sum
    };
    let error = |legs: usize| {
        let odd = |i: usize| (i % 2) as f64;
        let time = |i: usize| (4.0 * i as f64 + odd(i)) / legs as f64;
        let t: Vec<f64> = (0..=legs).map(time).collect();
        let points: Vec<Mat<f64>> = t.iter().map(|t| exact(*t)).collect();
        let v = estimate_velocities(&t, &views(&points), estimate, Quotient::Frames).unwrap();
        let inside = (legs / 4..3 * legs / 4).map(|i| distance(&v[i], &velocity(t[i])));
        inside.fold(0.0, f64::max)
    };
    let errors: Vec<f64> = [16, 32, 64, 128, 256].into_iter().map(error).collect();
    println!("{shape:?} {estimate:?}: {errors:?}");
    (errors[0] / errors[4]).log2() / 4.0
}

#[test]
fn orders_of_the_estimates() {
    for (shape, estimate, expected) in [
        ((4, 1), VelocityEstimate::CatmullRom, 2.0),
        ((5, 2), VelocityEstimate::CatmullRom, 2.0),
        ((4, 1), VelocityEstimate::Natural, 3.0),
        // Quasi-geodesics are not geodesics: carried vectors are rotated relative to parallel ones, to second order.
        ((5, 2), VelocityEstimate::Natural, 2.0),
    ] {
        let slope = order(shape, estimate);
        assert!(
            (slope - expected).abs() < 0.2,
            "{shape:?} {estimate:?}: {slope}"
        );
    }
}

#[test]
fn bad_input_is_refused() {
    let (t, points) = walk((3, 2), 4, 0.5, 7);
    for estimate in ESTIMATES {
        let solve = |t: &[f64], points: &[Mat<f64>]| {
            estimate_velocities(t, &views(points), estimate, Quotient::Frames).map(|_| ())
        };
        let one = solve(&t[..1], &points[..1]);
        assert!(matches!(one, Err(Error::Shape { .. })));
        assert!(matches!(solve(&t[..3], &points), Err(Error::Shape { .. })));
        let mut wrong = t.clone();
        wrong[2] = t[1];
        let repeated = solve(&wrong, &points);
        assert!(matches!(repeated, Err(Error::AtKnot { knot: 2, .. })));
        let mut wrong = points.clone();
        wrong[1][(0, 0)] = f64::NAN;
        let nan = solve(&t, &wrong);
        assert!(matches!(nan, Err(Error::AtKnot { knot: 1, .. })));
        let (t, mut points) = walk((3, 1), 4, 0.5, 8);
        points[3] = &points[2] * Scale(-1.0);
        assert!(matches!(
            solve(&t, &points),
            Err(Error::AtKnot { knot: 2, source }) if matches!(*source, Error::NoJoiningCurve { .. })
        ));
        let open =
            estimate_closed_velocities(&t[..3], &views(&points[..3]), estimate, Quotient::Frames);
        assert!(matches!(open, Err(Error::AtKnot { knot: 2, .. })));
    }
}
