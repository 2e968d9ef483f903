//! Geometric splines: smoothness at knots, end conditions, the circle, symmetries, closed curves, distant data, bad
//! input.

mod common;
#[path = "common/knots.rs"]
mod knots;

use common::{Rng, assert_within, distance, random_point, random_rotation, random_tangent};
use faer::{Mat, Scale, mat};
use knots::{views, walk};
use stiefel_rs::spline::{
    EndCondition, EndConditions, Piecewise, SplineOptions, cubic_spline, geometric_spline,
};
use stiefel_rs::{Curve, Error, GeometricCubic, Interrupt, Quantity, SolverReport};

const SHAPES: [(usize, usize); 11] = [
    (1, 1),
    (2, 1),
    (3, 1),
    (5, 1),
    (3, 2),
    (3, 3),
    (4, 2),
    (6, 3),
    (4, 4),
    (20, 2),
    (9, 4),
];

/// Points and velocities at the knots agree by construction, up to the round-off of the pieces, `1e-14`, divided by
/// short legs.
const MET: f64 = 1e-12;

/// Accelerations agree to `1e-12 / h^2`, for legs of at least 1/2; the round-off of a piece's second derivative is
/// `1e-13 / h^2`.
const SMOOTH: f64 = 1e-11;

fn spline(
    t: &[f64],
    points: &[Mat<f64>],
    ends: &EndConditions,
) -> (Piecewise<GeometricCubic>, SolverReport) {
    geometric_spline(
        t,
        &views(points),
        ends,
        &SplineOptions::default(),
        Interrupt::NEVER,
    )
    .unwrap()
}

/// The largest difference of a quantity between the pieces on both sides of a knot, in the time of the curve.
fn jump(curve: &Piecewise<GeometricCubic>, quantity: Quantity, order: i32) -> f64 {
    let knots = curve.knots();
    let value = |piece: usize, u: f64| {
        let h = knots[piece + 1] - knots[piece];
        let found = curve.pieces()[piece].sample(&[u], quantity, Interrupt::NEVER);
        found.unwrap().get(0).to_owned() * Scale(h.powi(-order))
    };
    (1..curve.pieces().len())
        .map(|i| distance(&value(i - 1, 1.0), &value(i, 0.0)))
        .fold(0.0, f64::max)
}

fn assert_smooth(curve: &Piecewise<GeometricCubic>, t: &[f64], points: &[Mat<f64>], name: &str) {
    for (t, point) in t.iter().zip(points) {
        assert_within(distance(&curve.point(*t).unwrap(), point), MET, name);
    }
    assert_within(jump(curve, Quantity::Derivative(1), 1), MET, name);
    assert_within(jump(curve, Quantity::Derivative(2), 2), SMOOTH, name);
    assert_within(jump(curve, Quantity::Acceleration, 2), SMOOTH, name);
}

#[test]
fn natural_splines_interpolate_and_are_smooth() {
    for shape in SHAPES {
        for count in [2, 3, 7, 20] {
            let (t, points) = walk(shape, count, 0.7, 1);
            let (curve, report) = spline(&t, &points, &EndConditions::Natural);
            let name = format!("{shape:?} {count}: {report}");
            assert_smooth(&curve, &t, &points, &name);
            for t in [t[0], t[count - 1]] {
                assert_within(curve.acceleration(t).unwrap().norm_l2(), SMOOTH, &name);
            }
            assert!(report.iterations <= 16, "{name}");
        }
    }
}

#[test]
fn ends_have_the_velocity_or_the_acceleration_that_is_asked_for() {
    for shape in SHAPES {
        let (t, points) = walk(shape, 6, 0.6, 2);
        let mut rng = Rng::new(3);
        let at = [0, 5].map(|knot: usize| random_tangent(&points[knot], 0.8, &mut rng));
        let ends = [
            EndCondition::Velocity(at[0].clone()),
            EndCondition::Acceleration(at[1].clone()),
        ];
        let (curve, report) = spline(&t, &points, &EndConditions::Each(Box::new(ends)));
        let name = format!("{shape:?}: {report}");
        assert_smooth(&curve, &t, &points, &name);
        let first = curve.derivative(t[0], 1).unwrap();
        assert_within(distance(&first, &at[0]), MET, &name);
        let last = curve.acceleration(t[5]).unwrap();
        assert_within(distance(&last, &at[1]), SMOOTH, &name);
    }
}

#[test]
fn a_closed_spline_is_smooth_where_it_closes() {
    for shape in SHAPES {
        for count in [1, 2, 3, 6] {
            let (mut t, mut points) = walk(shape, count, 0.4, 3);
            t.push(t[count - 1] + 0.8);
            points.push(points[0].clone());
            let (curve, report) = spline(&t, &points, &EndConditions::Periodic);
            let name = format!("{shape:?} {count}: {report}");
            assert_smooth(&curve, &t, &points, &name);
            let [first, last] = [t[0], t[count]];
            let ends = [first, last].map(|t| curve.derivative(t, 1).unwrap());
            assert_within(distance(&ends[0], &ends[1]), MET, &name);
            let ends = [first, last].map(|t| curve.acceleration(t).unwrap());
            assert_within(distance(&ends[0], &ends[1]), SMOOTH, &name);
        }
    }
}

/// The cubic spline of numbers: velocities from the tridiagonal (or cyclic) equations, by dense elimination.
fn flat_velocities(t: &[f64], y: &[f64], ends: [Option<f64>; 2]) -> Vec<f64> {
    let last = t.len() - 1;
    let (mut a, mut b) = (
        Mat::<f64>::zeros(last + 1, last + 1),
        Mat::zeros(last + 1, 1),
    );
    for leg in 0..last {
        let (h, dy) = (t[leg + 1] - t[leg], y[leg + 1] - y[leg]);
        for (i, j) in [(leg, leg + 1), (leg + 1, leg)] {
            a[(i, i)] += 4.0 / h;
            a[(i, j)] += 2.0 / h;
            b[(i, 0)] += 6.0 * dy / (h * h);
        }
    }
    for (knot, velocity) in [(0, ends[0]), (last, ends[1])] {
        if let Some(velocity) = velocity {
            a.row_mut(knot).fill(0.0);
            a[(knot, knot)] = 1.0;
            b[(knot, 0)] = velocity;
        }
    }
    use faer::linalg::solvers::Solve;
    let x = a.partial_piv_lu().solve(&b);
    (0..=last).map(|i| x[(i, 0)]).collect()
}

/// Angles and times of a path around the circle.
fn turns() -> ([f64; 7], [f64; 7]) {
    let t = [0.0, 0.4, 1.5, 2.1, 3.0, 3.3, 4.4];
    let angles = [0.1, 0.9, 1.2, 0.3, -1.3, -2.2, -3.9];
    (t, angles)
}

fn on_circle(angle: f64) -> Mat<f64> {
    mat![[angle.cos()], [angle.sin()]]
}

#[test]
fn on_the_circle_it_is_the_cubic_spline_of_the_angle() {
    let (t, angles) = turns();
    let points = angles.map(on_circle);
    let tangent = |angle: f64, v: f64| mat![[-v * angle.sin()], [v * angle.cos()]];
    let clamped = EndConditions::Each(Box::new([
        EndCondition::Velocity(tangent(angles[0], 1.7)),
        EndCondition::Velocity(tangent(angles[6], -0.4)),
    ]));
    let cases = [
        (EndConditions::Natural, [None, None]),
        (clamped, [Some(1.7), Some(-0.4)]),
    ];
    for (ends, flat_ends) in cases {
        let v = flat_velocities(&t, &angles, flat_ends);
        let (curve, report) = spline(&t, &points, &ends);
        assert!(report.iterations <= 1, "{report}");
        for leg in 0..6 {
            let h = t[leg + 1] - t[leg];
            for u in [0.0, 0.2, 0.5, 0.9] {
                let w: f64 = 1.0 - u;
                let angle = w * w * (1.0 + 2.0 * u) * angles[leg]
                    + u * u * (3.0 - 2.0 * u) * angles[leg + 1]
                    + h * u * w * (w * v[leg] - u * v[leg + 1]);
                let found = curve.point(t[leg] + u * h).unwrap();
                // A system of seven unknowns, angles up to four.
                let bound = 7.0 * 16.0 * f64::EPSILON;
                assert_within(distance(&found, &on_circle(angle)), bound, "circle");
            }
        }
    }
}

#[test]
fn isometries_and_time_carry_splines_along() {
    for shape in [(3, 1), (3, 2), (4, 2), (3, 3), (6, 3)] {
        let (t, points) = walk(shape, 5, 0.6, 6);
        let (curve, _) = spline(&t, &points, &EndConditions::Natural);
        let mut rng = Rng::new(7);
        let (left, right) = (
            random_rotation(shape.0, &mut rng),
            random_rotation(shape.1, &mut rng),
        );
        let turned: Vec<Mat<f64>> = points.iter().map(|s| &left * s * &right).collect();
        let (other, _) = spline(&t, &turned, &EndConditions::Natural);
        let slower: Vec<f64> = t.iter().map(|t| 3e6 * t - 1.0).collect();
        let (slow, _) = spline(&slower, &points, &EndConditions::Natural);
        let backward: Vec<f64> = t.iter().rev().map(|t| -t).collect();
        let reversed: Vec<Mat<f64>> = points.iter().rev().cloned().collect();
        let (back, _) = spline(&backward, &reversed, &EndConditions::Natural);
        let name = format!("{shape:?}");
        for i in 0..=10 {
            let t = t[0] + 0.1 * f64::from(i) * (t[4] - t[0]);
            let point = curve.point(t).unwrap();
            let image = &left * &point * &right;
            assert_within(distance(&other.point(t).unwrap(), &image), MET, &name);
            let at = (3e6 * t - 1.0).clamp(slower[0], slower[4]);
            // Times of 1e7 have nine digits after the decimal point.
            assert_within(
                distance(&slow.point(at).unwrap(), &point),
                10.0 * MET,
                &name,
            );
            let at = (-t).clamp(backward[0], backward[4]);
            assert_within(distance(&back.point(at).unwrap(), &point), MET, &name);
        }
    }
}

#[test]
fn the_span_of_the_points_is_enough() {
    // Four points on St(40, 1) span four dimensions.
    let (t, points) = walk((4, 1), 4, 0.6, 8);
    let wide = |point: &Mat<f64>| {
        let entry = |i: usize, j: usize| if i % 10 == 3 { point[(i / 10, j)] } else { 0.0 };
        Mat::from_fn(40, 1, entry)
    };
    let many: Vec<Mat<f64>> = points.iter().map(wide).collect();
    let (low, _) = spline(&t, &points, &EndConditions::Natural);
    let (high, _) = spline(&t, &many, &EndConditions::Natural);
    let middle = 0.5 * (t[0] + t[3]);
    let expected = wide(&low.point(middle).unwrap());
    assert_within(
        distance(&high.point(middle).unwrap(), &expected),
        MET,
        "wide",
    );
}

#[test]
fn steps_do_not_grow_with_the_number_of_knots() {
    // Every step evaluates each leg once, so the number of steps determines the cost per knot.
    let steps: Vec<usize> = [10, 100, 1000, 5000]
        .into_iter()
        .map(|count| {
            let (t, points) = walk((3, 2), count, 0.6, 12);
            spline(&t, &points, &EndConditions::Natural).1.iterations
        })
        .collect();
    assert!(steps.iter().all(|steps| *steps <= 14), "{steps:?}");
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let (t, points) = walk((4, 2), 40, 0.6, 13);
    let solve = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| {
            let (curve, report) = spline(&t, &points, &EndConditions::Natural);
            let times: Vec<f64> = (0..40).map(|i| t[i] + 1e-3).take(39).collect();
            let all = curve.sample(&times, Quantity::Derivative(1), Interrupt::NEVER);
            (all.unwrap().into_entries(), report.residual.to_bits())
        })
    };
    let one = solve(1);
    for threads in [2, 3] {
        assert_eq!(one, solve(threads), "{threads} threads");
    }
}

#[test]
fn it_comes_near_a_smooth_curve_with_the_fourth_power_of_the_step() {
    // Samples of a fixed analytic curve; errors in the middle of its interval, away from the natural ends.
    let shape = (5, 2);
    let mut rng = Rng::new(14);
    let s = random_point(shape.0, shape.1, &mut rng);
    let [a, b] = [1.0, 0.7].map(|size| common::random_skew(shape.0, size, &mut rng));
    let exact = |t: f64| {
        let turn = |a: &Mat<f64>, t: f64| stiefel_rs::skew_exp((a * Scale(t)).as_ref()).unwrap();
        turn(&a, t) * turn(&b, (2.0 * t).sin()) * &s
    };
    let error = |legs: u32| {
        let t: Vec<f64> = (0..=legs)
            .map(|i| f64::from(i) / f64::from(legs) * 4.0)
            .collect();
        let points: Vec<Mat<f64>> = t.iter().map(|t| exact(*t)).collect();
        let (curve, _) = spline(&t, &points, &EndConditions::Natural);
        (0..200)
            .map(|i| 1.5 + f64::from(i) / 200.0)
            .map(|t| distance(&curve.point(t).unwrap(), &exact(t)))
            .fold(0.0, f64::max)
    };
    let errors: Vec<f64> = [16, 32, 64, 128, 256].into_iter().map(error).collect();
    let slope = (errors[0] / errors[4]).log2() / 4.0;
    assert!((slope - 4.0).abs() < 0.2, "{slope} {errors:?}");
}

#[test]
fn it_is_near_the_spline_of_least_cost() {
    for shape in [(3, 1), (3, 2), (4, 2), (3, 3)] {
        let (t, points) = walk(shape, 6, 0.6, 15);
        let (curve, _) = spline(&t, &points, &EndConditions::Natural);
        let options = SplineOptions::default();
        let (least, _) = cubic_spline(
            &t,
            &views(&points),
            &EndConditions::Natural,
            &options,
            Interrupt::NEVER,
        )
        .unwrap();
        let (cost, bound) = (
            curve.cost(Interrupt::NEVER).unwrap(),
            least.cost(Interrupt::NEVER).unwrap(),
        );
        assert!(cost >= bound * (1.0 - 1e-9), "{shape:?}: {cost} {bound}");
        assert!(cost <= bound * 1.1, "{shape:?}: {cost} {bound}");
    }
}

#[test]
fn far_data_is_solved_or_refused() {
    let (mut solved, mut refused) = (0, 0);
    for shape in [(3, 1), (3, 2), (3, 3), (4, 2)] {
        for seed in 0..20 {
            let (t, points) = walk(shape, 8, 1.2 + 0.06 * seed as f64, 100 + seed);
            let options = SplineOptions::default();
            match geometric_spline(
                &t,
                &views(&points),
                &EndConditions::Natural,
                &options,
                Interrupt::NEVER,
            ) {
                Ok((curve, report)) => {
                    assert_smooth(&curve, &t, &points, &format!("{shape:?} {seed} {report}"));
                    solved += 1;
                }
                Err(Error::NoConvergence { .. } | Error::AtKnot { .. }) => refused += 1,
                Err(error) => panic!("{shape:?} {seed}: {error}"),
            }
        }
    }
    println!("far data: {solved} solved, {refused} refused");
    assert!(solved >= 40, "{solved} solved, {refused} refused");
}

#[test]
fn a_limit_of_steps_is_an_error_with_the_residual() {
    let (t, points) = walk((3, 2), 8, 0.8, 16);
    let options = SplineOptions {
        max_iterations: 2,
        ..SplineOptions::default()
    };
    let found = geometric_spline(
        &t,
        &views(&points),
        &EndConditions::Natural,
        &options,
        Interrupt::NEVER,
    );
    let Err(Error::NoConvergence { report, .. }) = found else {
        panic!("two steps are not enough");
    };
    assert!(report.iterations == 2 && report.residual > 1e-12 && !report.converged);
    let stop = || true;
    let (options, interrupt) = (SplineOptions::default(), Interrupt::new(&stop));
    let (ends, points) = (EndConditions::Natural, views(&points));
    let found = geometric_spline(&t, &points, &ends, &options, interrupt);
    assert!(matches!(found, Err(Error::Interrupted { .. })));
}

#[test]
fn rounded_points_are_taken() {
    // Points orthonormal to only eight digits: the curve is smooth, and passes them to that accuracy.
    let (t, points) = walk((5, 2), 6, 0.6, 17);
    let rounded: Vec<Mat<f64>> = points
        .iter()
        .map(|s| Mat::from_fn(5, 2, |i, j| (s[(i, j)] * 4e9).round() / 4e9))
        .collect();
    let (curve, report) = spline(&t, &rounded, &EndConditions::Natural);
    assert_within(
        jump(&curve, Quantity::Acceleration, 2),
        SMOOTH,
        &report.to_string(),
    );
    for (t, point) in t.iter().zip(&points) {
        assert_within(distance(&curve.point(*t).unwrap(), point), 1e-9, "rounded");
    }
}

#[test]
fn bad_knots_are_named() {
    let (t, points) = walk((3, 2), 4, 0.5, 12);
    let solve = |t: &[f64], points: &[Mat<f64>], ends: &EndConditions| {
        geometric_spline(
            t,
            &views(points),
            ends,
            &SplineOptions::default(),
            Interrupt::NEVER,
        )
        .map(|_| ())
    };
    let natural = EndConditions::Natural;
    let short = solve(&t[..1], &points[..1], &natural);
    assert!(matches!(short, Err(Error::Shape { .. })));
    let fewer = solve(&t[..3], &points, &natural);
    assert!(matches!(fewer, Err(Error::Shape { .. })));
    let mut wrong = t.clone();
    wrong[2] = f64::NAN;
    let index = solve(&wrong, &points, &natural);
    assert!(matches!(index, Err(Error::AtKnot { knot: 2, .. })));
    for time in [t[1], t[1] - 0.1, t[0]] {
        let mut wrong = t.clone();
        wrong[2] = time;
        let knot = solve(&wrong, &points, &natural);
        assert!(matches!(knot, Err(Error::AtKnot { knot: 2, .. })));
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
    // Different components of O(n).
    let (t, mut points) = walk((3, 3), 4, 0.5, 14);
    points[3] = &points[3] * Scale(-1.0);
    assert!(matches!(
        solve(&t, &points, &natural),
        Err(Error::AtKnot { knot: 2, source }) if matches!(*source, Error::DifferentComponents { n: 3 })
    ));
    // Ends that do not close, ends that are not tangent, ends that are too fast.
    let open = solve(&t[..3], &points[..3], &EndConditions::Periodic);
    assert!(matches!(open, Err(Error::AtKnot { knot: 2, .. })));
    let ends = |v: Mat<f64>| {
        let first = EndCondition::Velocity(Mat::zeros(3, 3));
        EndConditions::Each(Box::new([first, EndCondition::Velocity(v)]))
    };
    assert!(matches!(
        solve(&t[..3], &points[..3], &ends(points[2].clone())),
        Err(Error::AtKnot { knot: 2, source }) if matches!(*source, Error::NotTangent { .. })
    ));
    let fast = random_tangent(&points[2], 1e3, &mut Rng::new(1));
    assert!(solve(&t[..3], &points[..3], &ends(fast)).is_err());
}
