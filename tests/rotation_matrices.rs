//! Splines of near rotations, which are solved from quaternions, beside the splines of their matrices.

mod common;

use common::Rng;
use faer::Mat;
use nalgebra::{UnitQuaternion, Vector3};
use stiefel_rs::rotation::{ReferenceFrame, RotationEnd, RotationEnds, RotationSpline};
use stiefel_rs::spline::{EndCondition, EndConditions, SplineOptions, cubic_spline};
use stiefel_rs::{Curve, Interrupt};

fn matrix(q: &UnitQuaternion<f64>) -> Mat<f64> {
    let rotation = q.to_rotation_matrix();
    Mat::from_fn(3, 3, |i, j| rotation[(i, j)])
}

/// The tangent vector with a body rate.
fn tangent(q: &UnitQuaternion<f64>, w: Vector3<f64>) -> Mat<f64> {
    let product = q.to_rotation_matrix().into_inner() * w.cross_matrix();
    Mat::from_fn(3, 3, |i, j| product[(i, j)])
}

/// Rotations up to 1.3 rad apart at uneven times; closed if that is wanted.
fn keyframes(count: usize, is_closed: bool, rng: &mut Rng) -> (Vec<f64>, Vec<UnitQuaternion<f64>>) {
    let (mut t, mut q) = (
        vec![-2.0],
        vec![UnitQuaternion::from_euler_angles(0.3, -1.0, 2.0)],
    );
    for i in 1..count {
        t.push(t[i - 1] + rng.between(0.5, 1.5));
        let v = Vector3::from_fn(|_, _| rng.between(-1.0, 1.0));
        q.push(q[i - 1] * UnitQuaternion::from_scaled_axis(v.normalize() * rng.between(0.0, 1.3)));
    }
    if is_closed {
        // Back the way it came, ending in the other quaternion of the first rotation.
        for i in (0..count - 1).rev() {
            t.push(t[t.len() - 1] + rng.between(0.5, 1.5));
            q.push(q[i]);
        }
        let last = q.len() - 1;
        q[last] = UnitQuaternion::new_unchecked(-q[0].into_inner());
    }
    (t, q)
}

#[test]
fn near_rotations_have_the_spline_of_their_matrices() {
    let mut rng = Rng::new(3);
    let (w, a) = (Vector3::new(0.4, -0.9, 0.3), Vector3::new(-0.5, 0.2, 0.7));
    for count in [2, 3, 9, 30, 100] {
        for case in 0..4 {
            let (t, q) = keyframes(count, case == 3, &mut rng);
            let [first, last] = [&q[0], &q[q.len() - 1]];
            let (ends, of_matrices) = match case {
                0 => (RotationEnds::Natural, EndConditions::Natural),
                1 => (
                    RotationEnds::Each([RotationEnd::Rate(w), RotationEnd::Acceleration(a)]),
                    EndConditions::Each(Box::new([
                        EndCondition::Velocity(tangent(first, w)),
                        EndCondition::Acceleration(tangent(last, a)),
                    ])),
                ),
                2 => (
                    RotationEnds::Each([RotationEnd::Acceleration(a), RotationEnd::Rate(w)]),
                    EndConditions::Each(Box::new([
                        EndCondition::Acceleration(tangent(first, a)),
                        EndCondition::Velocity(tangent(last, w)),
                    ])),
                ),
                _ => (RotationEnds::Periodic, EndConditions::Periodic),
            };
            for tension in [0.0, 2.0] {
                let options = SplineOptions {
                    tension,
                    ..SplineOptions::default()
                };
                let spline =
                    RotationSpline::new(&t, &q, &ends, &options, Interrupt::NEVER).unwrap();
                let matrices: Vec<_> = q.iter().map(matrix).collect();
                let views: Vec<_> = matrices.iter().map(|matrix| matrix.as_ref()).collect();
                let (curve, _) =
                    cubic_spline(&t, &views, &of_matrices, &options, Interrupt::NEVER).unwrap();
                let (start, span) = (t[0], t[t.len() - 1] - t[0]);
                for i in 0..=100 {
                    let time = start + span * f64::from(i) / 100.0;
                    let found = spline.rotation(time).unwrap();
                    let gap = (matrix(&found) - curve.point(time).unwrap()).norm_max();
                    assert!(
                        gap < 1e-12,
                        "{count} knots, case {case}, {tension}: {gap:e}"
                    );
                    let rate = spline.angular_velocity(time, ReferenceFrame::Body).unwrap();
                    let velocity = curve.derivative(time, 1).unwrap();
                    let gap = (tangent(&found, rate) - velocity).norm_max();
                    assert!(
                        gap < 1e-11,
                        "{count} knots, case {case}, {tension}: {gap:e}"
                    );
                }
                let [cost, expected] = [
                    spline.cost(Interrupt::NEVER).unwrap(),
                    curve.cost(Interrupt::NEVER).unwrap(),
                ];
                assert!(
                    (cost - expected).abs() < 1e-11 * (1.0 + expected),
                    "{cost} {expected}"
                );
                let lazy = spline.curve().point(start + 0.4 * span).unwrap();
                let gap = lazy - curve.point(start + 0.4 * span).unwrap();
                assert!(gap.norm_max() < 1e-12);
            }
        }
    }
}
