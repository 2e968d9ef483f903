//! Splines interpolate, are smooth and have least cost; equivariance; Hermite curves.

use faer::{Mat, Scale};
use stiefel_rs::cubic::{BoundaryOptions, IntegrationOptions};
use stiefel_rs::spline::{EndCondition, EndConditions, cubic_hermite, geometric_hermite};
use stiefel_rs::{Curve, Interrupt};

use crate::common::{
    Rng, assert_within, cubic_from, distance, random_point, random_rotation, random_tangent,
};
use crate::knots::{views, walk};
use crate::smoothness::{MET, SHAPES, SMOOTH, acceleration, jump, spline, velocity};

#[test]
fn natural_splines_interpolate_and_are_smooth() {
    for shape in SHAPES {
        for count in [2, 3, 7] {
            let (t, points) = walk(shape, count, 0.7, 1);
            let (curve, report) = spline(&t, &points, &EndConditions::Natural);
            let name = format!("{shape:?} {count}: {report}");
            for (t, point) in t.iter().zip(&points) {
                assert_within(distance(&curve.point(*t).unwrap(), point), MET, &name);
            }
            assert_within(jump(&curve, velocity), SMOOTH, &name);
            assert_within(jump(&curve, acceleration), SMOOTH, &name);
            for t in [t[0], t[count - 1]] {
                assert_within(curve.acceleration(t).unwrap().norm_l2(), SMOOTH, &name);
            }
            let dimensions = shape.0 * shape.1 - shape.1 * (shape.1 + 1) / 2;
            // Newton steps below 8 dimensions, collocation sweeps from there on.
            let most = if dimensions < 8 { 20 } else { 30 };
            assert!(report.iterations <= most, "{name}");
        }
    }
}

#[test]
fn a_clamped_spline_through_a_cubic_is_that_cubic() {
    for shape in SHAPES {
        let mut rng = Rng::new(2);
        let s = random_point(shape.0, shape.1, &mut rng);
        let [v, a, j] = [1.0, 1.5, 2.0].map(|size| random_tangent(&s, size, &mut rng));
        let options = IntegrationOptions {
            t_end: 2.0,
            ..IntegrationOptions::default()
        };
        let cubic = cubic_from([&s, &v, &a, &j], &options);
        let t = [0.0, 0.3, 0.7, 1.2, 1.4, 2.0];
        let points: Vec<Mat<f64>> = t.iter().map(|t| cubic.point(*t).unwrap()).collect();
        let end = |t: f64| EndCondition::Velocity(cubic.derivative(t, 1).unwrap());
        let ends = EndConditions::Each(Box::new([end(0.0), end(2.0)]));
        let (curve, _) = spline(&t, &points, &ends);
        for i in 0..=40 {
            let t = 0.05 * f64::from(i);
            let found = curve.point(t.min(2.0)).unwrap();
            let expected = cubic.point(t.min(2.0)).unwrap();
            assert_within(
                distance(&found, &expected),
                1e-10,
                &format!("{shape:?} {t}"),
            );
        }
        assert_within(
            (curve.cost(Interrupt::NEVER).unwrap() - cubic.cost(Interrupt::NEVER).unwrap()).abs(),
            1e-9 * cubic.cost(Interrupt::NEVER).unwrap(),
            "cost",
        );
        // The same with accelerations given at both ends.
        let end = |t: f64| EndCondition::Acceleration(cubic.acceleration(t).unwrap());
        let ends = EndConditions::Each(Box::new([end(0.0), end(2.0)]));
        let (curve, _) = spline(&t, &points, &ends);
        assert_within(
            distance(&curve.point(1.0).unwrap(), &cubic.point(1.0).unwrap()),
            1e-10,
            "ends",
        );
    }
}

#[test]
fn a_closed_spline_is_smooth_where_it_closes() {
    for shape in SHAPES {
        for count in [2, 3, 6] {
            let (mut t, mut points) = walk(shape, count, 0.5, 3);
            t.push(t[count - 1] + 0.8);
            points.push(points[0].clone());
            let (curve, report) = spline(&t, &points, &EndConditions::Periodic);
            let name = format!("{shape:?} {count}: {report}");
            assert_within(jump(&curve, acceleration), SMOOTH, &name);
            let [first, last] = [t[0], t[count]];
            let ends = [first, last].map(|t| curve.derivative(t, 1).unwrap());
            assert_within(distance(&ends[0], &ends[1]), SMOOTH, &name);
            let ends = [first, last].map(|t| curve.acceleration(t).unwrap());
            assert_within(distance(&ends[0], &ends[1]), SMOOTH, &name);
        }
    }
}

#[test]
fn the_natural_spline_costs_least() {
    // Compared with the splines with other velocities at one knot: the cost is stationary, and minimal nearby.
    for shape in [(3, 1), (3, 2), (4, 2)] {
        let (t, points) = walk(shape, 4, 0.6, 4);
        let (curve, _) = spline(&t, &points, &EndConditions::Natural);
        let velocities: Vec<Mat<f64>> =
            t.iter().map(|t| curve.derivative(*t, 1).unwrap()).collect();
        let cost = curve.cost(Interrupt::NEVER).unwrap();
        let mut rng = Rng::new(5);
        for _ in 0..6 {
            let change = random_tangent(&points[1], 1e-2, &mut rng);
            let cost_at = |share: f64| {
                let mut velocities = velocities.clone();
                velocities[1] += &change * Scale(share);
                let other = cubic_hermite(
                    &t,
                    &views(&points),
                    &views(&velocities),
                    &BoundaryOptions::default(),
                    Interrupt::NEVER,
                );
                other.unwrap().cost(Interrupt::NEVER).unwrap()
            };
            let (plus, minus) = (cost_at(1.0), cost_at(-1.0));
            assert!(
                plus > cost && minus > cost,
                "{shape:?}: {plus} {minus} {cost}"
            );
            // Of second order: 1e-4 for the squared change, times the curvature of the cost.
            assert_within(
                (plus - minus).abs(),
                0.1 * (plus + minus - 2.0 * cost),
                &format!("{shape:?}"),
            );
        }
    }
}

#[test]
fn isometries_and_time_carry_splines_along() {
    for shape in [(3, 1), (3, 2), (4, 2), (3, 3)] {
        let (t, points) = walk(shape, 5, 0.6, 6);
        let (curve, _) = spline(&t, &points, &EndConditions::Natural);
        let mut rng = Rng::new(7);
        let (left, right) = (
            random_rotation(shape.0, &mut rng),
            random_rotation(shape.1, &mut rng),
        );
        let turned: Vec<Mat<f64>> = points.iter().map(|s| &left * s * &right).collect();
        let (other, _) = spline(&t, &turned, &EndConditions::Natural);
        let slower: Vec<f64> = t.iter().map(|t| 3.0 * t - 1.0).collect();
        let (slow, _) = spline(&slower, &points, &EndConditions::Natural);
        let backward: Vec<f64> = t.iter().rev().map(|t| -t).collect();
        let reversed: Vec<Mat<f64>> = points.iter().rev().cloned().collect();
        let (back, _) = spline(&backward, &reversed, &EndConditions::Natural);
        for i in 0..=10 {
            let t = t[0] + 0.1 * f64::from(i) * (t[4] - t[0]);
            let point = curve.point(t).unwrap();
            let image = &left * &point * &right;
            assert_within(
                distance(&other.point(t).unwrap(), &image),
                MET,
                &format!("{shape:?}"),
            );
            let at = (3.0 * t - 1.0).clamp(slower[0], slower[4]);
            assert_within(
                distance(&slow.point(at).unwrap(), &point),
                MET,
                &format!("{shape:?}"),
            );
            let at = (-t).clamp(backward[0], backward[4]);
            assert_within(
                distance(&back.point(at).unwrap(), &point),
                MET,
                &format!("{shape:?}"),
            );
        }
    }
}

#[test]
fn the_span_of_the_points_is_enough() {
    // Four points on St(40, 1) span four dimensions.
    let (t, points) = walk((4, 1), 4, 0.6, 8);
    let wide = |point: &Mat<f64>| {
        Mat::from_fn(
            40,
            1,
            |i, j| if i % 10 == 3 { point[(i / 10, j)] } else { 0.0 },
        )
    };
    let many: Vec<Mat<f64>> = points.iter().map(wide).collect();
    let (low, _) = spline(&t, &points, &EndConditions::Natural);
    let (high, _) = spline(&t, &many, &EndConditions::Natural);
    let middle = 0.5 * (t[0] + t[3]);
    assert_within(
        distance(
            &high.point(middle).unwrap(),
            &wide(&low.point(middle).unwrap()),
        ),
        MET,
        "wide",
    );
}

#[test]
fn hermite_curves_have_their_velocities() {
    for shape in [(3, 1), (4, 2), (3, 3), (20, 2)] {
        let (t, points) = walk(shape, 5, 0.5, 9);
        let mut rng = Rng::new(10);
        let velocities: Vec<Mat<f64>> = points
            .iter()
            .map(|s| random_tangent(s, 0.8, &mut rng))
            .collect();
        let exact = cubic_hermite(
            &t,
            &views(&points),
            &views(&velocities),
            &BoundaryOptions::default(),
            Interrupt::NEVER,
        )
        .unwrap();
        let quick = geometric_hermite(&t, &views(&points), &views(&velocities)).unwrap();
        for i in 0..5 {
            // On both sides of a knot.
            for t in [t[i], (t[i] - 1e-13).max(t[0])] {
                for (point, rate) in [
                    (exact.point(t).unwrap(), exact.derivative(t, 1).unwrap()),
                    (quick.point(t).unwrap(), quick.derivative(t, 1).unwrap()),
                ] {
                    assert_within(distance(&point, &points[i]), 1e-11, &format!("{shape:?}"));
                    assert_within(
                        distance(&rate, &velocities[i]),
                        1e-11,
                        &format!("{shape:?}"),
                    );
                }
            }
        }
        assert!(
            exact.cost(Interrupt::NEVER).unwrap()
                <= quick.cost(Interrupt::NEVER).unwrap() * (1.0 + 1e-10)
        );
    }
}
