//! Splines: exactness, smoothness at knots, end conditions, symmetries, closed curves, bad input.

mod common;
#[path = "common/knots.rs"]
mod knots;

use common::{Rng, assert_within, distance, random_point, random_rotation, random_tangent};
use faer::{Mat, Scale};
use knots::{counted_spline, views, walk};
use stiefel_rs::cubic::{BoundaryOptions, IntegrationOptions};
use stiefel_rs::spline::{
    EndCondition, EndConditions, Outside, Piecewise, SplineOptions, cubic_hermite, cubic_spline,
    geometric_hermite,
};
use stiefel_rs::{Curve, Error, RiemannianCubic, SolverReport};

const SHAPES: [(usize, usize); 9] = [
    (1, 1),
    (2, 1),
    (3, 1),
    (5, 1),
    (3, 2),
    (3, 3),
    (4, 2),
    (6, 3),
    (4, 4),
];

/// Legs that miss their knot or jump by at most 1e-12, and evaluation.
const MET: f64 = 1e-11;

/// Covariant acceleration at the knots of unequal legs, `1e-12 / h^2`.
const SMOOTH: f64 = 1e-10;

fn spline(
    t: &[f64],
    points: &[Mat<f64>],
    ends: &EndConditions,
) -> (Piecewise<RiemannianCubic>, SolverReport) {
    let found = cubic_spline(t, &views(points), ends, &SplineOptions::default());
    found.unwrap_or_else(|error| panic!("{:?}: {error}", points[0].shape()))
}

fn jump(
    curve: &Piecewise<RiemannianCubic>,
    quantity: impl Fn(&RiemannianCubic, f64, f64) -> Mat<f64>,
) -> f64 {
    let knots = curve.knots();
    let lengths: Vec<f64> = knots.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let pieces = curve.pieces();
    (1..pieces.len())
        .map(|i| {
            let before = quantity(&pieces[i - 1], 1.0, lengths[i - 1]);
            distance(&before, &quantity(&pieces[i], 0.0, lengths[i]))
        })
        .fold(0.0, f64::max)
}

fn velocity(piece: &RiemannianCubic, u: f64, h: f64) -> Mat<f64> {
    piece.derivative(u, 1).unwrap() * Scale(1.0 / h)
}

fn acceleration(piece: &RiemannianCubic, u: f64, h: f64) -> Mat<f64> {
    piece.acceleration(u).unwrap() * Scale(1.0 / (h * h))
}

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
            // Steps of Newton's method below 8 dimensions, sweeps of collocation from there on.
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
        let cubic =
            RiemannianCubic::from_initial(s.as_ref(), v.as_ref(), a.as_ref(), j.as_ref(), &options)
                .unwrap();
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
            (curve.cost().unwrap() - cubic.cost().unwrap()).abs(),
            1e-9 * cubic.cost().unwrap(),
            "cost",
        );
        // The same with the accelerations of both ends.
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
    // Against the splines with other velocities at one knot: the cost is stationary, and least nearby.
    for shape in [(3, 1), (3, 2), (4, 2)] {
        let (t, points) = walk(shape, 4, 0.6, 4);
        let (curve, _) = spline(&t, &points, &EndConditions::Natural);
        let velocities: Vec<Mat<f64>> =
            t.iter().map(|t| curve.derivative(*t, 1).unwrap()).collect();
        let cost = curve.cost().unwrap();
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
                );
                other.unwrap().cost().unwrap()
            };
            let (plus, minus) = (cost_at(1.0), cost_at(-1.0));
            assert!(
                plus > cost && minus > cost,
                "{shape:?}: {plus} {minus} {cost}"
            );
            // Of second order: 1e-4 in the square of the change, times curvature of the cost.
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
        )
        .unwrap();
        let quick = geometric_hermite(&t, &views(&points), &views(&velocities)).unwrap();
        for i in 0..5 {
            // Both sides of a knot.
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
        assert!(exact.cost().unwrap() <= quick.cost().unwrap() * (1.0 + 1e-10));
    }
}

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
        cubic_spline(t, &views(points), ends, &SplineOptions::default()).map(|_| ())
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
    // Components of O(n).
    let (t, mut points) = walk((3, 3), 4, 0.5, 14);
    points[3] = &points[3] * Scale(-1.0);
    assert!(matches!(
        solve(&t, &points, &natural),
        Err(Error::AtKnot { knot: 2, source }) if matches!(*source, Error::DifferentComponents { n: 3 })
    ));
    // A tolerance that nothing meets.
    for tolerance in [0.0, 1e-16, 1.0, f64::NAN] {
        let options = SplineOptions {
            tolerance,
            ..SplineOptions::default()
        };
        assert!(matches!(
            cubic_spline(&t[..2], &views(&points[..2]), &natural, &options),
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

#[test]
fn knots_far_apart_are_joined() {
    // Where space is far from flat along a leg: relaxed chains, families of shorter legs, Newton by GMRES in many dimensions.
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
            // Of accelerations of up to 50.
            assert_within(jump(&curve, acceleration), 10.0 * SMOOTH, &name);
        }
    }
}

#[test]
fn hard_legs_do_not_hold_up_a_long_chain() {
    // Steps from flat space do not reach the whole: some legs of many are hard. Solved in parts, closed chains too.
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
            // Of accelerations of up to 50.
            assert_within(jump(&curve, acceleration), 10.0 * SMOOTH, &name);
        }
    }
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
        // The worst of more legs takes a few more steps of the iteration.
        assert!(many < 1.6 * few, "{shape:?}: {few} a knot, {many} a knot");
    }
}

#[test]
fn a_family_of_shorter_legs_leads_around_a_closed_curve() {
    // Three points a third of a great circle apart, and back: no chain is relaxed where the ends meet.
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
    // The great circle at constant speed is a cubic without acceleration.
    assert_within(curve.cost().unwrap(), 1e-18, "cost");
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
