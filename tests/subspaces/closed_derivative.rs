//! Derivatives of periodic splines with respect to the data, compared with differences, and transposed.

use faer::{Mat, MatRef, Scale};
use stiefel_rs::spline::{EndConditions, Piecewise, SplineOptions, SplineVariation, cubic_spline};
use stiefel_rs::{Curve, Error, Interrupt, Quotient, RiemannianCubic};

use crate::common::{Rng, assert_close, assert_within, gaussian, random_orthogonal};
use crate::derivative::{difference, family, product, vector};
use crate::spline::{bases, views};
use crate::{horizontal, reflection, view};

const T: [f64; 5] = [0.0, 1.0, 1.8, 3.0, 3.9];

fn spline(t: &[f64], points: &[Mat<f64>], tension: f64) -> Piecewise<RiemannianCubic> {
    let options = SplineOptions {
        quotient: Quotient::Subspaces,
        tolerance: 1e-14,
        tension,
        ..SplineOptions::default()
    };
    cubic_spline(
        t,
        &views(points),
        &EndConditions::Periodic,
        &options,
        Interrupt::NEVER,
    )
    .unwrap()
    .0
}

/// A closed spline whose data are its own bases at the knots, and the rotation between the first and the last of them.
struct Closed {
    points: Vec<Mat<f64>>,
    moves: Vec<Mat<f64>>,
    times: Vec<f64>,
    holonomy: Mat<f64>,
    tension: f64,
}

impl Closed {
    fn random(shape: (usize, usize), t: &[f64], tension: f64, rng: &mut Rng) -> Self {
        let mut points = bases(shape, t.len() - 1, 0.6, rng);
        points.push(&points[0] * random_orthogonal(shape.1, rng));
        let first = spline(t, &points, tension);
        let points: Vec<Mat<f64>> = t.iter().map(|t| first.point(*t).unwrap()).collect();
        let holonomy = points[0].transpose() * &points[t.len() - 1];
        let mut moves: Vec<Mat<f64>> = points.iter().map(|y| vector(y, 0.7, rng)).collect();
        moves[t.len() - 1] = &moves[0] * &holonomy;
        let times = (0..t.len()).map(|_| rng.between(-0.2, 0.2)).collect();
        Closed {
            points,
            moves,
            times,
            holonomy,
            tension,
        }
    }

    /// The spline through the data moved by `s`.
    fn of(&self, t: &[f64], s: f64) -> Piecewise<RiemannianCubic> {
        let pairs = self.points.iter().zip(&self.moves);
        let points: Vec<Mat<f64>> = pairs.map(|(y, p)| family(y, p, &[], s).remove(0)).collect();
        let t: Vec<f64> = t
            .iter()
            .zip(&self.times)
            .map(|(t, dt)| t + s * dt)
            .collect();
        spline(&t, &points, self.tension)
    }
}

#[test]
fn periodic_splines_by_their_data() {
    let mut rng = Rng::new(41);
    let cases = [
        ((3, 1), 0.0),
        ((2, 1), 0.0),
        ((4, 2), 0.0),
        ((3, 2), 1.0),
        ((7, 3), 0.0),
        ((20, 2), 0.0),
        ((30, 2), 0.5),
    ];
    for ((n, k), tension) in cases {
        for legs in [2, 4] {
            let (what, t) = (format!("({n}, {k}), {legs} legs"), &T[..=legs]);
            let data = Closed::random((n, k), t, tension, &mut rng);
            let ends = EndConditions::Periodic;
            let curve = data.of(t, 0.0);
            let derivative = curve.data_derivative(&ends, Interrupt::NEVER).unwrap();
            let moves: Vec<MatRef<'_, f64>> = data.moves.iter().map(view).collect();
            let variation = SplineVariation {
                points: &moves,
                times: &data.times,
                ends: [None, None],
            };
            let times = [0.4, 1.4, t[legs] - 0.1];
            let found = derivative
                .points(&variation, &times, Interrupt::NEVER)
                .unwrap();
            let cotangents = times.map(|_| gaussian(n, k, &mut rng));
            let mut sum = 0.0;
            for ((time, found), w) in times.iter().zip(&found).zip(&cotangents) {
                let here = curve.point(*time).unwrap();
                let expected = difference(|s| data.of(t, s).point(*time).unwrap());
                let expected = horizontal(view(&here), view(&expected));
                assert_close(found, &expected, 1e-7, &format!("{what} at {time}"));
                sum += product(w, found);
            }
            let views = cotangents.each_ref().map(view);
            let gradient = derivative
                .pull_back(&times, &views, Interrupt::NEVER)
                .unwrap();
            let total = |gradient: &stiefel_rs::spline::SplineGradient| {
                let points = gradient.points.iter().zip(&data.moves);
                let times = gradient.times.iter().zip(&data.times);
                points.map(|(g, p)| product(g, p)).sum::<f64>()
                    + times.map(|(g, t)| g * t).sum::<f64>()
            };
            let off = total(&gradient) - sum;
            assert_within(off.abs() / (1.0 + sum.abs()), 1e-9, &what);
            let cost =
                |s: f64| Mat::from_fn(1, 1, |_, _| data.of(t, s).cost(Interrupt::NEVER).unwrap());
            let expected = difference(cost)[(0, 0)];
            let gradient = curve.cost_gradient(&ends, Interrupt::NEVER).unwrap();
            let off = total(&gradient) - expected;
            assert_within(off.abs() / (1.0 + expected.abs()), 1e-8, &what);
        }
    }
}

#[test]
fn the_closing_condition_knows_the_turn_of_the_basis() {
    let mut rng = Rng::new(44);
    let data = Closed::random((4, 2), &T, 0.0, &mut rng);
    let still = (&data.holonomy - Mat::<f64>::identity(2, 2)).norm_l2();
    assert!(still > 0.05, "the loop turns the basis by {still} only");
    let curve = data.of(&T, 0.0);
    let derivative = curve
        .data_derivative(&EndConditions::Periodic, Interrupt::NEVER)
        .unwrap();
    // Without the rotation, the last subspace would differ from the first one.
    let mut moves = data.moves.clone();
    moves[4] = moves[0].clone();
    let moves: Vec<MatRef<'_, f64>> = moves.iter().map(view).collect();
    let variation = SplineVariation {
        points: &moves,
        times: &[],
        ends: [None, None],
    };
    let error = derivative
        .points(&variation, &[0.5], Interrupt::NEVER)
        .unwrap_err();
    assert!(matches!(error, Error::AtKnot { knot: 4, .. }), "{error}");
}

/// Rotations move the curve along; coordinate planes are symmetric data, and a loop of lines ends with the opposite
/// basis.
#[test]
fn rotations_of_everything_at_coordinate_planes_and_lines() {
    let rotation = |n: usize| {
        let mut a = Mat::zeros(n, n);
        for i in 1..n {
            a[(i, i - 1)] = 1.0;
            a[(i - 1, i)] = -1.0;
        }
        a
    };
    let e = Mat::<f64>::identity(4, 4);
    let tilted = |i: usize, j: usize| {
        let mut y = e.as_ref().subcols(0, 2).to_owned();
        let (sin, cos) = 0.6_f64.sin_cos();
        let column = e.as_ref().col(i) * Scale(cos) + e.as_ref().col(j) * Scale(sin);
        y.as_mut().col_mut(i).copy_from(&column);
        y
    };
    let planes = [
        e.as_ref().subcols(0, 2).to_owned(),
        tilted(0, 2),
        tilted(1, 3),
        tilted(1, 2),
        Mat::from_fn(4, 2, |i, j| e[(i, 1 - j)]),
    ];
    let pi = std::f64::consts::PI;
    let lines = [0.0, 0.8, 1.5, 2.4, pi].map(|a: f64| faer::mat![[a.cos()], [a.sin()]]);
    for points in [&planes[..], &lines[..]] {
        let a = rotation(points[0].nrows());
        let curve = spline(&T, points, 0.0);
        let knots = T.map(|t| curve.point(t).unwrap());
        let moves = knots
            .each_ref()
            .map(|y| horizontal(view(y), (&a * y).as_ref()));
        let moves = moves.each_ref().map(view);
        let variation = SplineVariation {
            points: &moves,
            times: &[],
            ends: [None, None],
        };
        let ends = EndConditions::Periodic;
        let derivative = curve.data_derivative(&ends, Interrupt::NEVER).unwrap();
        let times = [0.3, 2.0, 3.7];
        let found = derivative
            .points(&variation, &times, Interrupt::NEVER)
            .unwrap();
        for (t, found) in times.iter().zip(&found) {
            let y = curve.point(*t).unwrap();
            let expected = horizontal(view(&y), (&a * &y).as_ref());
            assert_close(found, &expected, 1e-10, "rotated");
        }
        let gradient = curve.cost_gradient(&ends, Interrupt::NEVER).unwrap();
        let pairs = gradient.points.iter().zip(&moves);
        let change: f64 = pairs.map(|(g, p)| product(g, &p.to_owned())).sum();
        assert_within(change.abs(), 1e-9, "the cost stays");
    }
}

/// Reflections are an isometric embedding up to scale, with four times the cost.
#[test]
fn the_gradient_of_the_cost_is_that_of_reflections() {
    let mut rng = Rng::new(43);
    for (n, k) in [(3, 1), (4, 2), (5, 2), (3, 2)] {
        let mut points = bases((n, k), 4, 0.6, &mut rng);
        points.push(&points[0] * random_orthogonal(k, &mut rng));
        let curve = spline(&T, &points, 0.0);
        let ends = EndConditions::Periodic;
        let gradient = curve.cost_gradient(&ends, Interrupt::NEVER).unwrap();
        let reflections: Vec<Mat<f64>> = points.iter().map(|y| reflection(view(y))).collect();
        let options = SplineOptions {
            tolerance: 1e-14,
            ..SplineOptions::default()
        };
        let (oracle, _) =
            cubic_spline(&T, &views(&reflections), &ends, &options, Interrupt::NEVER).unwrap();
        let expected = oracle.cost_gradient(&ends, Interrupt::NEVER).unwrap();
        let what = format!("({n}, {k})");
        for (found, expected) in gradient.times.iter().zip(&expected.times) {
            let off = (4.0 * found - expected).abs() / (1.0 + expected.abs());
            assert_within(off, 1e-9, &what);
        }
        for knot in 0..5 {
            let y = curve.point(T[knot]).unwrap();
            let p = vector(&y, 1.0, &mut rng);
            let found = product(&gradient.points[knot], &p);
            let reflected = crate::reflected(view(&y), view(&p));
            let wanted = product(&expected.points[knot], &reflected);
            let off = (4.0 * found - wanted).abs() / (1.0 + wanted.abs());
            assert_within(off, 1e-9, &what);
        }
    }
}

/// The manifold is a single point: nothing moves, and times are irrelevant.
#[test]
fn derivatives_in_the_whole_space_are_zero() {
    let mut rng = Rng::new(45);
    let points: Vec<Mat<f64>> = T.iter().map(|_| random_orthogonal(3, &mut rng)).collect();
    let curve = spline(&T, &points, 0.0);
    let ends = EndConditions::Periodic;
    let derivative = curve.data_derivative(&ends, Interrupt::NEVER).unwrap();
    let still = Mat::zeros(3, 3);
    let moves = [still.as_ref(); 5];
    let variation = SplineVariation {
        points: &moves,
        times: &[0.1, 0.0, -0.1, 0.2, 0.0],
        ends: [None, None],
    };
    let found = derivative.points(&variation, &[0.5], Interrupt::NEVER);
    assert_eq!(found.unwrap()[0].norm_l2(), 0.0);
    let gradient = curve.cost_gradient(&ends, Interrupt::NEVER).unwrap();
    assert!(gradient.times.iter().all(|x| *x == 0.0));
    assert!(gradient.points.iter().all(|x| x.norm_l2() == 0.0));
}
