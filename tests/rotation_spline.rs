//! Splines of rotations in quaternions: compared with the curve of matrices, closed forms, symmetries, rates compared
//! with differences.

mod common;

use std::f64::consts::PI;

use common::*;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use stiefel_rs::rotation::{
    PoseEnd, PoseEnds, PoseSpline, ReferenceFrame, RotationEnd, RotationEnds, RotationSpline,
};
use stiefel_rs::spline::{SmoothingOptions, SplineOptions};
use stiefel_rs::{Curve, Error, Interrupt};

fn vector(rng: &mut Rng, length: f64) -> Vector3<f64> {
    let v = Vector3::from_fn(|_, _| rng.between(-1.0, 1.0));
    v * (length / v.norm().max(1e-3))
}

fn turn(v: Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(v)
}

/// Keyframes at the given angular distance, at uneven times.
fn walk(count: usize, angle: f64, seed: u64) -> (Vec<f64>, Vec<UnitQuaternion<f64>>) {
    let mut rng = Rng::new(seed);
    let (mut t, mut q) = (
        vec![rng.between(-3.0, 3.0)],
        vec![turn(vector(&mut rng, 2.0))],
    );
    for i in 1..count {
        t.push(t[i - 1] + rng.between(0.3, 1.7));
        let step = angle * rng.between(0.1, 1.0);
        q.push(q[i - 1] * turn(vector(&mut rng, step)));
    }
    (t, q)
}

/// Poses with the given rotations, at random positions at distance 3 from the origin.
fn at_random_positions(q: &[UnitQuaternion<f64>], seed: u64) -> Vec<Isometry3<f64>> {
    let mut rng = Rng::new(seed);
    let mut pose = |q| Isometry3::from_parts(vector(&mut rng, 3.0).into(), q);
    q.iter().map(|q| pose(*q)).collect()
}

fn at_rest() -> PoseEnd {
    PoseEnd::Velocity {
        angular: Vector3::zeros(),
        linear: Vector3::zeros(),
    }
}

fn spline(t: &[f64], q: &[UnitQuaternion<f64>], ends: &RotationEnds) -> RotationSpline {
    RotationSpline::new(t, q, ends, &SplineOptions::default(), Interrupt::NEVER).unwrap()
}

fn poses_spline(t: &[f64], poses: &[Isometry3<f64>], ends: &PoseEnds) -> Result<PoseSpline, Error> {
    PoseSpline::new(t, poses, ends, &SplineOptions::default(), Interrupt::NEVER)
}

fn between(t: &[f64], count: usize) -> impl Iterator<Item = f64> {
    let (first, last) = (t[0], t[t.len() - 1]);
    (0..count).map(move |i| first + (last - first) * i as f64 / (count - 1) as f64)
}

fn all_ends() -> [RotationEnds; 3] {
    let rate = RotationEnd::Rate(Vector3::new(0.4, -0.9, 0.3));
    let acceleration = RotationEnd::Acceleration(Vector3::new(-0.5, 0.2, 0.7));
    [
        RotationEnds::Natural,
        RotationEnds::Each([rate, acceleration]),
        RotationEnds::Each([acceleration, rate]),
    ]
}

#[test]
fn the_curve_is_that_of_the_matrices() {
    // Short legs, and legs so long that they are integrated in steps.
    for (count, angle) in [
        (2, 0.7),
        (3, 1.5),
        (9, 0.4),
        (30, 1.2),
        (200, 1.2),
        (8, 2.9),
    ] {
        let (t, q) = walk(count, angle, count as u64);
        for ends in all_ends() {
            let spline = spline(&t, &q, &ends);
            let mut before: Option<UnitQuaternion<f64>> = None;
            for time in between(&t, 257) {
                let (found, matrix) = (spline.rotation(time).unwrap(), spline.curve().point(time));
                let (found_matrix, matrix) = (found.to_rotation_matrix(), matrix.unwrap());
                let mut error = 0.0_f64;
                for (i, j) in (0..9).map(|i| (i / 3, i % 3)) {
                    error = error.max((found_matrix[(i, j)] - matrix[(i, j)]).abs());
                }
                assert!(error < 1e-12, "{count} knots {angle} apart: {error:e}");
                let defect = (found.coords.norm() - 1.0).abs();
                assert!(defect <= 2.0 * EPS, "length off by {defect:e}");
                if let Some(before) = before {
                    // The sign does not jump.
                    assert!(count < 100 || before.coords.dot(&found.coords) > 0.0);
                }
                before = Some(found);
            }
            for (time, q) in t.iter().zip(&q) {
                let miss = spline.rotation(*time).unwrap().angle_to(q);
                assert!(miss < 1e-13 * 8.0, "misses its keyframe by {miss:e}");
            }
        }
    }
}

#[test]
fn signs_are_continuous_and_begin_with_the_given_one() {
    let (t, mut q) = walk(12, 1.2, 5);
    for (i, q) in q.iter_mut().enumerate() {
        if i % 3 == 1 || i == 0 {
            *q = UnitQuaternion::new_unchecked(-q.into_inner());
        }
    }
    let spline = spline(&t, &q, &RotationEnds::Natural);
    assert!(spline.rotation(t[0]).unwrap().coords.dot(&q[0].coords) > 0.0);
    let times: Vec<f64> = between(&t, 2001).collect();
    for pair in times.windows(2) {
        let [a, b] = [pair[0], pair[1]].map(|t| spline.rotation(t).unwrap());
        let cosine = a.coords.dot(&b.coords);
        assert!(cosine > 0.99, "from {} to {}: {cosine}", pair[0], pair[1]);
    }
    // Also beyond the ends.
    for (inside, outside) in [(t[0], t[0] - 1e-3), (t[11], t[11] + 1e-3)] {
        let [a, b] = [inside, outside].map(|t| spline.rotation(t).unwrap());
        assert!(a.coords.dot(&b.coords) > 0.99);
    }
}

#[test]
fn a_leg_that_turns_around_more_than_once_changes_the_sign_of_its_end() {
    // A fast rate at both ends, so that the leg does not take the shortest rotation.
    let axis = Vector3::new(0.0, 0.6, 0.8);
    let q = [turn(axis * 0.0), turn(axis * 0.3)];
    let fast = RotationEnd::Rate(axis * 40.0);
    let spline = spline(&[0.0, 1.0], &q, &RotationEnds::Each([fast; 2]));
    let mut before = spline.rotation(0.0).unwrap();
    for i in 1..=4000 {
        let here = spline.rotation(i as f64 / 4000.0).unwrap();
        assert!(before.coords.dot(&here.coords) > 0.9, "at {i}");
        before = here;
    }
}

#[test]
fn eq_rate_is_the_derivative_of_the_rotation() {
    let (t, q) = walk(7, 1.0, 3);
    let spline = spline(&t, &q, &RotationEnds::Natural);
    let (body, world) = (ReferenceFrame::Body, ReferenceFrame::World);
    let h = 1e-4;
    for time in between(&t, 41).skip(1).take(39) {
        if t.iter().any(|knot| (knot - time).abs() < 3.0 * h) {
            continue;
        }
        // Differences of fourth order.
        let slope = |f: &dyn Fn(f64) -> Vector3<f64>| {
            let [a, b] = [h, 2.0 * h].map(|h| f(time + h) - f(time - h));
            (a * 8.0 - b) / (12.0 * h)
        };
        let here = spline.rotation(time).unwrap();
        for frame in [body, world] {
            let moved = |t: f64| {
                let there = spline.rotation(t).unwrap();
                match frame {
                    ReferenceFrame::Body => (here.inverse() * there).scaled_axis(),
                    ReferenceFrame::World => (there * here.inverse()).scaled_axis(),
                }
            };
            let rate = spline.angular_velocity(time, frame).unwrap();
            assert!((slope(&moved) - rate).norm() < 1e-9);
            let rates = |t: f64| spline.angular_velocity(t, frame).unwrap();
            let acceleration = spline.angular_acceleration(time, frame).unwrap();
            assert!((slope(&rates) - acceleration).norm() < 1e-9);
            let accelerations = |t: f64| spline.angular_acceleration(t, frame).unwrap();
            let turning = match frame {
                ReferenceFrame::Body => Vector3::zeros(),
                ReferenceFrame::World => rate.cross(&acceleration),
            };
            let jerk = spline.angular_jerk(time, frame).unwrap();
            let error = (slope(&accelerations) - turning - jerk).norm();
            assert!(error < 1e-8, "{frame:?}: {error:e}");
        }
    }
}

#[test]
fn eq_cubic_w_third_is_w_second_times_w() {
    // w''' by a difference of w''.
    let (t, q) = walk(5, 1.2, 8);
    let spline = spline(&t, &q, &RotationEnds::Natural);
    let h = 1e-5;
    for leg in 0..4 {
        let time = 0.5 * (t[leg] + t[leg + 1]);
        let at = |t: f64, order: usize| {
            let mut out = [[0.0; 3]];
            spline.rates_into(&[t], order, &mut out).unwrap();
            Vector3::from(out[0])
        };
        let third = (at(time + h, 2) - at(time - h, 2)) / (2.0 * h);
        let cross = at(time, 2).cross(&at(time, 0));
        assert!((third - cross).norm() < 1e-8 * (1.0 + cross.norm()));
    }
}

#[test]
fn about_one_axis_it_is_the_spline_of_the_angle() {
    let axis = Vector3::new(2.0, -1.0, 2.0) / 3.0;
    let (t, angles) = ([0.0, 1.0, 1.5, 3.0], [0.2_f64, 1.4, 0.9, 2.1]);
    let q = angles.map(|a| turn(axis * a));
    let poses = angles.map(|a| Isometry3::new(Vector3::x() * a, axis * a));
    for (ends, pose_ends) in [
        (RotationEnds::Natural, PoseEnds::Natural),
        (
            RotationEnds::Each([
                RotationEnd::Rate(axis * 0.7),
                RotationEnd::Acceleration(axis * -0.4),
            ]),
            PoseEnds::Each([
                PoseEnd::Velocity {
                    angular: axis * 0.7,
                    linear: Vector3::x() * 0.7,
                },
                PoseEnd::Acceleration {
                    angular: axis * -0.4,
                    linear: Vector3::x() * -0.4,
                },
            ]),
        ),
    ] {
        let spline = spline(&t, &q, &ends);
        let pose = poses_spline(&t, &poses, &pose_ends).unwrap();
        for time in between(&t, 61) {
            let flat = pose.position(time).unwrap().x;
            let error = spline.rotation(time).unwrap().angle_to(&turn(axis * flat));
            assert!(error < 1e-11, "at {time}: {error:e}");
            let rate = spline.angular_velocity(time, ReferenceFrame::Body).unwrap();
            let flat = pose.linear_velocity(time).unwrap().x;
            assert!((rate - axis * flat).norm() < 1e-11);
        }
    }
}

#[test]
fn rotations_of_space_and_body_move_the_curve() {
    let (t, q) = walk(10, 1.0, 21);
    let (space, body) = (
        turn(Vector3::new(0.3, 2.0, -1.0)),
        turn(Vector3::new(-1.0, 0.4, 0.9)),
    );
    let here = spline(&t, &q, &RotationEnds::Natural);
    let moved: Vec<_> = q.iter().map(|q| space * q * body).collect();
    let there = spline(&t, &moved, &RotationEnds::Natural);
    // Also in reverse.
    let backwards: Vec<f64> = t.iter().rev().map(|t| -t).collect();
    let reversed: Vec<_> = q.iter().rev().copied().collect();
    let back = spline(&backwards, &reversed, &RotationEnds::Natural);
    for time in between(&t, 101) {
        let q = here.rotation(time).unwrap();
        let gap = (space * q * body).angle_to(&there.rotation(time).unwrap());
        assert!(gap < 1e-11, "{gap:e}");
        let gap = q.angle_to(&back.rotation(-time).unwrap());
        assert!(gap < 1e-11, "{gap:e}");
        let [w, v] = [(&here, time), (&back, -time)]
            .map(|(spline, t)| spline.angular_velocity(t, ReferenceFrame::Body).unwrap());
        assert!((w + v).norm() < 1e-10);
    }
}

#[test]
fn beyond_the_ends_the_end_pieces_go_on() {
    let (t, q) = walk(4, 1.0, 2);
    let natural = spline(&t, &q, &RotationEnds::Natural);
    // The same cubic from a longer interval: through its own points beyond the end, with its own end conditions.
    let last = t[3] + 2.0;
    let times = [t[2], t[3], last];
    let rotations = times.map(|t| natural.rotation(t).unwrap());
    let rate =
        |t: f64| RotationEnd::Rate(natural.angular_velocity(t, ReferenceFrame::Body).unwrap());
    let longer = spline(
        &times,
        &rotations,
        &RotationEnds::Each([rate(t[2]), rate(last)]),
    );
    for time in between(&times, 33) {
        let gap = longer
            .rotation(time)
            .unwrap()
            .angle_to(&natural.rotation(time).unwrap());
        assert!(gap < 1e-10, "{gap:e} at {time}");
    }
    let many: Vec<f64> = (0..9000).map(|i| t[0] - 1.0 + 1e-3 * i as f64).collect();
    let mut all = vec![[0.0; 4]; many.len()];
    natural.quaternions_into(&many, &mut all).unwrap();
    for i in [0, 1, 999, 1000, 4321, 8999] {
        assert_eq!(
            natural.rotation(many[i]).unwrap().coords.as_slice().len(),
            4
        );
        let one = natural.rotation(many[i]).unwrap();
        let gap = one
            .coords
            .iter()
            .zip(all[i])
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(gap < 1e-12, "{gap:e}");
    }
}

#[test]
fn half_turns_are_refused_with_the_pair_and_the_angle() {
    let q = [
        Vector3::zeros(),
        Vector3::x() * 0.5,
        Vector3::x() * (0.5 + PI),
    ]
    .map(turn);
    let error = RotationSpline::new(
        &[0.0, 1.0, 2.0],
        &q,
        &RotationEnds::Natural,
        &Default::default(),
        Interrupt::NEVER,
    )
    .unwrap_err();
    let Error::AtKnot { knot, source } = error else {
        panic!("{error}");
    };
    assert_eq!(knot, 1);
    assert!(matches!(*source, Error::OutsideLogDomain { angle } if (angle - PI).abs() < 1e-9));
}

#[test]
fn hermite_curves_have_the_given_rates_and_smoothing_nears_the_data() {
    let (t, q) = walk(6, 0.9, 13);
    let natural = spline(&t, &q, &RotationEnds::Natural);
    let rates: Vec<_> = t
        .iter()
        .map(|t| natural.angular_velocity(*t, ReferenceFrame::Body).unwrap())
        .collect();
    // With the rates of the spline, the Hermite curve is the spline.
    let hermite =
        RotationSpline::hermite(&t, &q, &rates, &Default::default(), Interrupt::NEVER).unwrap();
    let options = SmoothingOptions {
        lambda: Some(1e-9),
        ..SmoothingOptions::default()
    };
    let smooth = RotationSpline::smoothing(&t, &q, None, &options, Interrupt::NEVER).unwrap();
    for time in between(&t, 77) {
        let here = natural.rotation(time).unwrap();
        let gap = here.angle_to(&hermite.rotation(time).unwrap());
        assert!(gap < 1e-10, "{gap:e}");
        let gap = here.angle_to(&smooth.rotation(time).unwrap());
        assert!(gap < 1e-6, "{gap:e}");
    }
    assert!(natural.report().unwrap().converged && hermite.report().is_none());
    assert!(
        RotationSpline::hermite(&t, &q, &rates[1..], &Default::default(), Interrupt::NEVER)
            .is_err()
    );
}

#[test]
fn poses_have_the_twist_of_their_matrices() {
    let (t, q) = walk(6, 1.1, 34);
    let poses = at_random_positions(&q, 4);
    let spline = poses_spline(&t, &poses, &PoseEnds::Natural).unwrap();
    for (time, pose) in t.iter().zip(&poses) {
        let found = spline.pose(*time).unwrap();
        assert!((found.translation.vector - pose.translation.vector).norm() < 1e-14);
    }
    let h = 1e-5;
    for time in between(&t, 21).skip(1).take(19) {
        let matrix = |t: f64| spline.pose(t).unwrap().to_homogeneous();
        let slope = (matrix(time + h) - matrix(time - h)) / (2.0 * h);
        let inverse = spline.pose(time).unwrap().inverse().to_homogeneous();
        for (frame, product) in [
            (ReferenceFrame::Body, inverse * slope),
            (ReferenceFrame::World, slope * inverse),
        ] {
            let twist = spline.twist(time, frame).unwrap();
            let expected = [
                product[(2, 1)],
                product[(0, 2)],
                product[(1, 0)],
                product[(0, 3)],
                product[(1, 3)],
                product[(2, 3)],
            ];
            for (found, expected) in twist.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-8, "{frame:?} at {time}");
            }
        }
        let acceleration = spline.linear_acceleration(time).unwrap();
        let [before, after] = [time - h, time + h].map(|t| spline.linear_velocity(t).unwrap());
        assert!(
            t.iter().any(|knot| (knot - time).abs() < 2.0 * h) || {
                ((after - before) / (2.0 * h) - acceleration).norm() < 1e-8
            }
        );
    }
}

#[test]
fn linear_jerk_is_the_difference_quotient_of_accelerations() {
    let (t, q) = walk(7, 1.1, 55);
    let poses = at_random_positions(&q, 6);
    for ends in [PoseEnds::Natural, PoseEnds::Each([at_rest(); 2])] {
        let spline = poses_spline(&t, &poses, &ends).unwrap();
        for (leg, knots) in t.windows(2).enumerate() {
            // The acceleration is linear on a piece: a difference is exact for any step, except for round-off.
            let h = (knots[1] - knots[0]) / 4.0;
            let [a, b] =
                [h, 3.0 * h].map(|after| spline.linear_acceleration(knots[0] + after).unwrap());
            let expected = (b - a) / (2.0 * h);
            let bound = 1e3 * EPS * (expected.norm() + (a.norm() + b.norm()) / h);
            // Also at the knot where the piece begins, and for the last piece at its end and beyond.
            let quarters = [0.0, 0.5, 3.5, 4.0, 5.0];
            let count = if leg == t.len() - 2 { 5 } else { 3 };
            for time in quarters[..count].iter().map(|x| knots[0] + x * h) {
                let error = (spline.linear_jerk(time).unwrap() - expected).norm();
                assert!(error <= bound, "leg {leg}: {error:e} above {bound:e}");
            }
        }
        let error = spline.linear_jerk(f64::NAN);
        assert!(matches!(error, Err(Error::NonFinite { .. })));
    }
}

#[test]
fn closed_poses_close() {
    let poses = [0.0, 1.0, 0.5, -0.4, 0.0]
        .map(|x: f64| Isometry3::new(Vector3::new(x, x * x, 2.0), Vector3::new(0.2, x, 0.5 * x)));
    let t = [0.0, 1.0, 2.5, 3.0, 4.5];
    let closed = poses_spline(&t, &poses, &PoseEnds::Periodic).unwrap();
    let [first, last] = [0.0, 4.5].map(|t| closed.linear_acceleration(t).unwrap());
    assert!((first - last).norm() < 1e-12);
    let [first, last] = [0.0, 4.5].map(|t| {
        let frame = ReferenceFrame::World;
        closed.rotations().angular_acceleration(t, frame).unwrap()
    });
    assert!((first - last).norm() < 1e-10);
    let mut open = poses;
    open[4].translation.vector.x += 0.1;
    let error = poses_spline(&t, &open, &PoseEnds::Periodic);
    assert!(matches!(error, Err(Error::AtKnot { knot: 4, .. })));
    // Far outside, the last cubic exceeds the range of floating-point numbers.
    let error = closed.position(1e150);
    assert!(matches!(error, Err(Error::Overflow { .. })));
    assert!(closed.position(1e90).is_ok());
    open[2].translation.vector.y = f64::NAN;
    let error = poses_spline(&t, &open, &PoseEnds::Natural);
    assert!(matches!(error, Err(Error::AtKnot { knot: 2, .. })));
}

#[test]
fn bad_input_is_an_error() {
    let (t, q) = walk(4, 1.0, 1);
    let natural = spline(&t, &q, &RotationEnds::Natural);
    assert!(matches!(
        natural.rotation(f64::NAN),
        Err(Error::NonFinite { .. })
    ));
    let mut out = [[0.0; 3]; 2];
    assert!(natural.rates_into(&[t[0]], 0, &mut out).is_err());
    assert!(natural.rates_into(&t[..2], 3, &mut out).is_err());
    // A rotation in almost no time.
    let fast = spline(&[0.0, 1e-200], &q[..2], &RotationEnds::Natural);
    assert!(fast.rates_into(&[0.0, 1e-200], 0, &mut out).is_ok());
    let ends = RotationEnds::Each([RotationEnd::Rate(Vector3::zeros()); 2]);
    let fast = spline(&[0.0, 1e-200], &q[..2], &ends);
    let error = fast.rates_into(&[0.0, 1e-200], 1, &mut out);
    assert!(matches!(error, Err(Error::Overflow { .. })));
    let options = SplineOptions::default();
    let ends = RotationEnds::Natural;
    assert!(RotationSpline::new(&t[..1], &q[..1], &ends, &options, Interrupt::NEVER).is_err());
    assert!(RotationSpline::new(&t[..3], &q, &ends, &options, Interrupt::NEVER).is_err());
    let flat = [[1.0, 0.0], [0.0, 1.0]].map(|[x, y]| faer::mat![[x], [y]]);
    let views = flat.each_ref().map(|x| x.as_ref());
    let (curve, _) = stiefel_rs::spline::cubic_spline(
        &[0.0, 1.0],
        &views,
        &stiefel_rs::spline::EndConditions::Natural,
        &options,
        Interrupt::NEVER,
    )
    .unwrap();
    let error = RotationSpline::of_curve(std::sync::Arc::new(curve), None, None).unwrap_err();
    assert!(matches!(error, Error::Shape { .. }), "{error}");
}
