//! Distant knots, long chains, many dimensions.

use faer::Mat;
use stiefel_rs::spline::EndConditions;
use stiefel_rs::{Curve, Interrupt};

use crate::common::{assert_within, distance};
use crate::knots::{counted_spline, walk};
use crate::smoothness::{MET, SMOOTH, acceleration, jump, spline, velocity};

#[test]
fn knots_far_apart_are_joined() {
    // Space is far from flat along a leg: descents, or legs in the embedding in many dimensions.
    for (shape, step, count) in [
        ((3, 1), 1.6, 12),
        ((3, 1), 2.2, 4),
        ((3, 2), 2.0, 12),
        ((3, 3), 2.2, 12),
        ((4, 2), 1.8, 4),
        ((60, 2), 1.2, 8),
        ((60, 2), 1.5, 8),
    ] {
        for seed in [20, 21, 22] {
            let (t, points) = walk(shape, count, step, seed);
            let (curve, report) = spline(&t, &points, &EndConditions::Natural);
            let name = format!("{shape:?} {step} {seed}: {report}");
            for (t, point) in t.iter().zip(&points) {
                assert_within(distance(&curve.point(*t).unwrap(), point), MET, &name);
            }
            assert_within(jump(&curve, velocity), SMOOTH, &name);
            // Relative to accelerations of up to 50.
            assert_within(jump(&curve, acceleration), 10.0 * SMOOTH, &name);
        }
    }
}

#[test]
fn hard_legs_do_not_hold_up_a_long_chain() {
    // Steps from flat space do not solve the whole chain: some of its many legs are hard.
    let closed = |mut points: Vec<Mat<f64>>| {
        let last = points.len() - 1;
        points[last] = points[0].clone();
        points
    };
    for (shape, step) in [((3, 3), 1.4), ((3, 1), 1.2), ((4, 2), 1.4)] {
        let (t, points) = walk(shape, 90, step, 31);
        for (ends, points) in [
            (EndConditions::Natural, points.clone()),
            (EndConditions::Periodic, closed(points)),
        ] {
            let (curve, report) = spline(&t, &points, &ends);
            let name = format!("{shape:?} {step} {ends:?}: {report}");
            for (t, point) in t.iter().zip(&points) {
                assert_within(distance(&curve.point(*t).unwrap(), point), MET, &name);
            }
            assert_within(jump(&curve, velocity), SMOOTH, &name);
            // Relative to accelerations of up to 50.
            assert_within(jump(&curve, acceleration), 10.0 * SMOOTH, &name);
        }
    }
}

#[test]
fn many_knots_of_a_large_shape_are_within_the_limit_of_work() {
    let (t, points) = walk((20, 5), 40, 0.8, 32);
    let (curve, report) = spline(&t, &points, &EndConditions::Natural);
    for (t, point) in t.iter().zip(&points) {
        assert_within(
            distance(&curve.point(*t).unwrap(), point),
            MET,
            &report.to_string(),
        );
    }
    assert_within(
        jump(&curve, acceleration),
        10.0 * SMOOTH,
        &report.to_string(),
    );
}

#[test]
fn work_is_linear_in_the_number_of_knots() {
    let work = |shape, count| {
        let (t, points) = walk(shape, count, 0.6, 24);
        let (asked, found) = counted_spline(&t, &points);
        found.unwrap();
        asked as f64 / count as f64
    };
    for shape in [(3, 2), (30, 2)] {
        let (few, many) = (work(shape, 40), work(shape, 640));
        // With more legs, the worst one takes a few more steps of the iteration.
        assert!(many < 1.6 * few, "{shape:?}: {few} a knot, {many} a knot");
    }
}

#[test]
fn a_descent_leads_around_a_closed_curve() {
    // Three points a third of a great circle apart, and back to the first.
    let angle = |i: usize| 2.0943951023931953 * i as f64;
    let points: Vec<Mat<f64>> = (0..4)
        .map(|i| {
            Mat::from_fn(3, 1, |row, _| {
                [angle(i % 3).cos(), angle(i % 3).sin(), 0.0][row]
            })
        })
        .collect();
    let t = [0.0, 1.0, 2.0, 3.0];
    let (curve, _) = spline(&t, &points, &EndConditions::Periodic);
    // The great circle at constant speed is a cubic with zero acceleration.
    assert_within(curve.cost(Interrupt::NEVER).unwrap(), 1e-18, "cost");
}

#[test]
fn points_in_many_dimensions_need_no_exact_orthonormality() {
    for shape in [(60, 2), (40, 3)] {
        let (t, mut points) = walk(shape, 6, 0.6, 23);
        let (exact, _) = spline(&t, &points, &EndConditions::Natural);
        for point in &mut points {
            point[(0, 0)] += 1e-10;
        }
        let (near, _) = spline(&t, &points, &EndConditions::Natural);
        let middle = 0.5 * (t[2] + t[3]);
        let apart = distance(&exact.point(middle).unwrap(), &near.point(middle).unwrap());
        assert_within(apart, 1e-9, &format!("{shape:?}"));
    }
}
