//! Splines whose legs are solved in the embedding: many dimensions, and matrices taller than the span of a leg.

use faer::Mat;
use stiefel_rs::spline::{EndCondition, EndConditions, Piecewise};
use stiefel_rs::{Curve, RiemannianCubic};

use crate::common::{
    Rng, assert_within, distance, integrated_from_start, random_rotation, random_tangent,
};
use crate::knots::walk;
use crate::smoothness::{MET, SMOOTH, acceleration, jump, spline, velocity};

/// Many dimensions, with `k = n` and `k = n - 1`; and frames with more than `4k` rows.
const SHAPES: [(usize, usize); 11] = [
    (12, 1),
    (10, 2),
    (12, 2),
    (11, 11),
    (10, 9),
    (12, 4),
    (12, 11),
    (40, 1),
    (40, 2),
    (60, 3),
    (30, 7),
];

/// The largest distance of the pieces from the cubics that are integrated from their data at the start.
fn far_from_cubics(curve: &Piecewise<RiemannianCubic>) -> f64 {
    let far = |piece: &RiemannianCubic| {
        let cubic = integrated_from_start(piece);
        let apart = [0.3, 0.8, 1.0].map(|u| {
            let points = [piece, &cubic].map(|curve| curve.point(u).unwrap());
            let velocities = [piece, &cubic].map(|curve| curve.derivative(u, 1).unwrap());
            distance(&points[0], &points[1]).max(distance(&velocities[0], &velocities[1]))
        });
        apart.into_iter().fold(0.0, f64::max)
    };
    curve.pieces().iter().map(far).fold(0.0, f64::max)
}

#[test]
fn pieces_are_cubics_that_join_for_all_ends() {
    for shape in SHAPES {
        let mut rng = Rng::new(5);
        let (mut t, mut points) = walk(shape, 6, 0.7, 8);
        let mut tangent = |knot: usize, size: f64| random_tangent(&points[knot], size, &mut rng);
        let ends = [
            EndConditions::Natural,
            EndConditions::Each(Box::new([
                EndCondition::Velocity(tangent(0, 0.8)),
                EndCondition::Acceleration(tangent(5, 0.6)),
            ])),
            EndConditions::Periodic,
        ];
        for ends in ends {
            let is_closed = matches!(ends, EndConditions::Periodic);
            if is_closed {
                // Two steps of a walk and back.
                (t, points) = (t[..4].to_vec(), points[..3].to_vec());
                points.push(points[0].clone());
            }
            let (curve, report) = spline(&t, &points, &ends);
            let name = format!("{shape:?} {ends:?}: {report}");
            let name = &name[..name.len().min(200)];
            for (t, point) in t.iter().zip(&points) {
                assert_within(distance(&curve.point(*t).unwrap(), point), MET, name);
            }
            assert_within(jump(&curve, velocity), SMOOTH, name);
            assert_within(jump(&curve, acceleration), SMOOTH, name);
            assert_within(far_from_cubics(&curve), MET, name);
            let [first, last] = [t[0], t[t.len() - 1]];
            if is_closed {
                let ends = [first, last].map(|t| curve.acceleration(t).unwrap());
                assert_within(distance(&ends[0], &ends[1]), SMOOTH, name);
            }
            if let EndConditions::Each(ends) = &ends {
                let found = [curve.derivative(first, 1), curve.acceleration(last)];
                for (found, end) in found.into_iter().zip(ends.iter()) {
                    let (EndCondition::Velocity(x) | EndCondition::Acceleration(x)) = end;
                    assert_within(distance(&found.unwrap(), x), SMOOTH, name);
                }
            }
            assert!(report.iterations <= 30, "{name}");
        }
    }
}

#[test]
fn rows_of_zeros_do_not_change_a_spline() {
    // St(8, 3) is solved by series, the others in the embedding: St(10, 3) in coordinates of the points, St(12, 1) and
    // St(12, 2) in those of the ends of legs.
    for (n, k) in [(8, 3), (10, 3), (12, 1), (12, 2)] {
        let (t, points) = walk((n, k), 9, 0.9, 4);
        let rotation = random_rotation(40, &mut Rng::new(3));
        let up = |point: &Mat<f64>| rotation.as_ref().subcols(0, n) * point;
        let tall: Vec<Mat<f64>> = points.iter().map(up).collect();
        let (curve, _) = spline(&t, &points, &EndConditions::Natural);
        let (other, _) = spline(&t, &tall, &EndConditions::Natural);
        for i in 0..=30 {
            let t = t[0] + (t[8] - t[0]) * f64::from(i) / 30.0;
            let error = distance(&other.point(t).unwrap(), &up(&curve.point(t).unwrap()));
            assert_within(error, MET, &format!("({n}, {k}) at {t}"));
        }
    }
}

/// Descents leave starts near a solution, which legs in coordinates of their ends take by their velocities alone.
#[test]
fn splines_through_distant_points_join() {
    for shape in [(12, 1), (10, 2), (12, 2), (10, 9)] {
        let (t, points) = walk(shape, 8, 2.4, 8);
        let (curve, report) = spline(&t, &points, &EndConditions::Natural);
        let name = format!("{shape:?}: {report}");
        for (t, point) in t.iter().zip(&points) {
            assert_within(distance(&curve.point(*t).unwrap(), point), MET, &name);
        }
        assert_within(jump(&curve, acceleration), SMOOTH, &name);
        assert_within(far_from_cubics(&curve), MET, &name);
    }
}

#[test]
fn a_closed_loop_of_coordinate_frames_is_smooth() {
    // Zeros, repeated angles and knots that differ by permutations: each step turns two columns by a right angle.
    let points: Vec<Mat<f64>> = [[0, 1, 2], [3, 1, 2], [3, 4, 2], [0, 4, 2], [0, 1, 2]]
        .iter()
        .map(|rows| Mat::from_fn(14, 3, |i, j| f64::from(u8::from(rows[j] == i))))
        .collect();
    let t = [0.0, 1.0, 2.0, 3.0, 4.0];
    let (curve, report) = spline(&t, &points, &EndConditions::Periodic);
    let name = report.to_string();
    assert_within(jump(&curve, velocity), SMOOTH, &name);
    assert_within(jump(&curve, acceleration), SMOOTH, &name);
    assert_within(far_from_cubics(&curve), MET, &name);
}
