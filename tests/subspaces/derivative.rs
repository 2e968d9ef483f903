//! Derivatives with respect to the data, compared with differences, and transposed.

use faer::{Mat, MatRef, Scale};
use stiefel_rs::cubic::{
    BoundaryOptions, BoundaryVariation, InitialVariation, IntegrationOptions, RiemannianCubic,
};
use stiefel_rs::spline::{
    EndCondition, EndConditions, Piecewise, SplineOptions, SplineVariation, cubic_spline,
};
use stiefel_rs::{Curve, Interrupt, Quotient, skew_exp};

use crate::common::{Rng, assert_close, assert_within, cubic_from, gaussian, random_point};
use crate::{boundary_options, horizontal, view};

const SHAPES: [(usize, usize); 5] = [(3, 1), (4, 2), (3, 2), (7, 3), (20, 2)];

/// Step of differences: errors of fourth-order differences and round-off are both at most about 1e-11.
const STEP: f64 = 1e-3;

pub(crate) fn vector(y: &Mat<f64>, size: f64, rng: &mut Rng) -> Mat<f64> {
    let (n, k) = y.shape();
    let v = horizontal(view(y), gaussian(n, k, rng).as_ref());
    let norm = v.norm_l2();
    v * Scale(size / norm)
}

/// The rotation of least rank that moves `y` by `p`.
fn generator(y: &Mat<f64>, p: &Mat<f64>) -> Mat<f64> {
    p * y.transpose() - y * p.transpose()
}

/// A basis and vectors at it along a family, and their derivatives.
pub(crate) fn family(
    y: &Mat<f64>,
    p: &Mat<f64>,
    vectors: &[(&Mat<f64>, &Mat<f64>)],
    s: f64,
) -> Vec<Mat<f64>> {
    let turn = skew_exp((generator(y, p) * Scale(s)).as_ref()).unwrap();
    let moved = vectors.iter().map(|(v, w)| &turn * (*v + *w * Scale(s)));
    std::iter::once(&turn * y).chain(moved).collect()
}

/// `A v + w`.
fn slope(y: &Mat<f64>, p: &Mat<f64>, v: &Mat<f64>, w: &Mat<f64>) -> Mat<f64> {
    generator(y, p) * v + w
}

/// The derivative at 0, to fourth order.
pub(crate) fn difference(f: impl Fn(f64) -> Mat<f64>) -> Mat<f64> {
    let pair = |s: f64| f(s) - f(-s);
    (pair(STEP) * Scale(8.0) - pair(2.0 * STEP)) * Scale(1.0 / (12.0 * STEP))
}

pub(crate) fn product(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    let (rows, cols) = a.shape();
    (0..cols)
        .flat_map(|j| (0..rows).map(move |i| (i, j)))
        .map(|at| a[at] * b[at])
        .sum()
}

#[test]
fn by_initial_data() {
    let mut rng = Rng::new(31);
    for (n, k) in SHAPES {
        for tension in [0.0, 2.0] {
            let y = random_point(n, k, &mut rng);
            let [p, v, a, j, dv, da, dj] =
                [0.9, 1.1, 1.5, 3.0, 0.8, 1.3, 1.7].map(|size| vector(&y, size, &mut rng));
            let options = IntegrationOptions {
                quotient: Quotient::Subspaces,
                tension,
                ..IntegrationOptions::default()
            };
            let of = |s: f64| {
                let data = family(&y, &p, &[(&v, &dv), (&a, &da), (&j, &dj)], s);
                cubic_from([&data[0], &data[1], &data[2], &data[3]], &options)
            };
            let (curve, times) = (of(0.0), [0.4, 1.0, 1.3]);
            let variation = InitialVariation {
                point: p.clone(),
                velocity: slope(&y, &p, &v, &dv),
                acceleration: slope(&y, &p, &a, &da),
                jerk: slope(&y, &p, &j, &dj),
            };
            let found = curve
                .initial_points(&variation, &times, Interrupt::NEVER)
                .unwrap();
            let mut sum = 0.0;
            let cotangents = times.map(|_| gaussian(n, k, &mut rng));
            for ((t, found), w) in times.iter().zip(&found).zip(&cotangents) {
                let here = curve.point(*t).unwrap();
                let expected = difference(|s| of(s).point(*t).unwrap());
                let expected = horizontal(view(&here), view(&expected));
                assert_close(
                    found,
                    &expected,
                    1e-8,
                    &format!("({n}, {k}), tension {tension}, at {t}"),
                );
                sum += product(w, found);
            }
            let views = cotangents.each_ref().map(view);
            let gradient = curve
                .initial_pull_back(&times, &views, Interrupt::NEVER)
                .unwrap();
            let total = product(&gradient.point, &variation.point)
                + product(&gradient.velocity, &variation.velocity)
                + product(&gradient.acceleration, &variation.acceleration)
                + product(&gradient.jerk, &variation.jerk);
            assert_within((total - sum).abs() / (1.0 + sum.abs()), 1e-10, "transposed");
        }
    }
}

#[test]
fn by_boundary_data() {
    let mut rng = Rng::new(32);
    for (n, k) in SHAPES {
        let y = random_point(n, k, &mut rng);
        let [v, a, j, p0, w0] = [0.7, 0.9, 1.4, 0.8, 0.9].map(|size| vector(&y, size, &mut rng));
        let options = IntegrationOptions {
            quotient: Quotient::Subspaces,
            ..IntegrationOptions::default()
        };
        let known = cubic_from([&y, &v, &a, &j], &options);
        let [y1, v1] = [known.point(1.0), known.derivative(1.0, 1)].map(|x| x.unwrap());
        let v1 = horizontal(view(&y1), view(&v1));
        let [p1, w1] = [0.6, 0.7].map(|size| vector(&y1, size, &mut rng));
        let of = |s: f64| {
            let (start, end) = (
                family(&y, &p0, &[(&v, &w0)], s),
                family(&y1, &p1, &[(&v1, &w1)], s),
            );
            RiemannianCubic::from_boundary(
                view(&start[0]),
                view(&start[1]),
                view(&end[0]),
                view(&end[1]),
                &BoundaryOptions {
                    tolerance: 1e-14,
                    ..boundary_options()
                },
                Interrupt::NEVER,
            )
            .unwrap()
        };
        let curve = of(0.0);
        let derivative = curve.boundary_derivative(Interrupt::NEVER).unwrap();
        let [dv0, dv1] = [slope(&y, &p0, &v, &w0), slope(&y1, &p1, &v1, &w1)];
        let variation = BoundaryVariation {
            s0: view(&p0),
            v0: view(&dv0),
            s1: view(&p1),
            v1: view(&dv1),
        };
        let what = format!("({n}, {k})");
        let initial = derivative.initial(&variation, Interrupt::NEVER).unwrap();
        let expected = difference(|s| of(s).initial().unwrap()[2].clone());
        assert_close(&initial.acceleration, &expected, 1e-7, &what);
        let expected = difference(|s| of(s).initial().unwrap()[3].clone());
        assert_close(&initial.jerk, &expected, 1e-6, &what);
        let times = [0.3, 0.8];
        let found = derivative
            .points(&curve, &variation, &times, Interrupt::NEVER)
            .unwrap();
        let cotangents = times.map(|_| gaussian(n, k, &mut rng));
        let mut sum = 0.0;
        for ((t, found), w) in times.iter().zip(&found).zip(&cotangents) {
            let here = curve.point(*t).unwrap();
            let expected = difference(|s| of(s).point(*t).unwrap());
            assert_close(
                found,
                &horizontal(view(&here), view(&expected)),
                1e-8,
                &what,
            );
            sum += product(w, found);
        }
        let views = cotangents.each_ref().map(view);
        let gradient = derivative
            .pull_back(&times, &views, Interrupt::NEVER)
            .unwrap();
        let total = product(&gradient.s0, &p0)
            + product(&gradient.v0, &dv0)
            + product(&gradient.s1, &p1)
            + product(&gradient.v1, &dv1);
        assert_within((total - sum).abs() / (1.0 + sum.abs()), 1e-9, &what);
        let cost = |s: f64| Mat::from_fn(1, 1, |_, _| of(s).cost(Interrupt::NEVER).unwrap());
        let expected = difference(cost)[(0, 0)];
        let found = derivative.cost(&variation).unwrap();
        assert_within(
            (found - expected).abs() / (1.0 + expected.abs()),
            1e-8,
            &what,
        );
    }
}

#[test]
fn by_the_data_of_a_spline() {
    let mut rng = Rng::new(33);
    let t = [0.0, 1.0, 1.8, 3.0];
    for (n, k) in SHAPES {
        let mut points = vec![random_point(n, k, &mut rng)];
        for i in 0..3 {
            let v = vector(&points[i], 0.6, &mut rng);
            points.push(skew_exp(generator(&points[i], &v).as_ref()).unwrap() * &points[i]);
        }
        let velocity = vector(&points[0], 0.4, &mut rng);
        let still = Mat::zeros(n, k);
        let spline = |points: &[Mat<f64>], velocity: &Mat<f64>| -> Piecewise<RiemannianCubic> {
            let views: Vec<MatRef<'_, f64>> = points.iter().map(view).collect();
            let options = SplineOptions {
                quotient: Quotient::Subspaces,
                tolerance: 1e-14,
                ..SplineOptions::default()
            };
            cubic_spline(
                &t,
                &views,
                &ends(velocity, &still),
                &options,
                Interrupt::NEVER,
            )
            .unwrap()
            .0
        };
        // The data in terms of the bases of the curve.
        let first = spline(&points, &velocity);
        let points = t.map(|t| first.point(t).unwrap());
        let moves = points.each_ref().map(|y| vector(y, 0.7, &mut rng));
        let w = vector(&points[0], 0.5, &mut rng);
        let of = |s: f64| {
            let start = family(&points[0], &moves[0], &[(&velocity, &w)], s);
            let mut all = vec![start[0].clone()];
            for i in 1..4 {
                all.push(family(&points[i], &moves[i], &[], s).remove(0));
            }
            spline(&all, &start[1])
        };
        let curve = of(0.0);
        let ends = ends(&velocity, &still);
        let derivative = curve.data_derivative(&ends, Interrupt::NEVER).unwrap();
        let dv = slope(&points[0], &moves[0], &velocity, &w);
        let views = moves.each_ref().map(view);
        let zero = Mat::zeros(n, k);
        let variation = SplineVariation {
            points: &views,
            times: &[],
            ends: [Some(view(&dv)), Some(view(&zero))],
        };
        let times = [0.4, 1.4, 2.5];
        let found = derivative
            .points(&variation, &times, Interrupt::NEVER)
            .unwrap();
        let cotangents = times.map(|_| gaussian(n, k, &mut rng));
        let mut sum = 0.0;
        for ((t, found), w) in times.iter().zip(&found).zip(&cotangents) {
            let here = curve.point(*t).unwrap();
            let expected = difference(|s| of(s).point(*t).unwrap());
            let what = format!("({n}, {k}) at {t}");
            assert_close(
                found,
                &horizontal(view(&here), view(&expected)),
                1e-8,
                &what,
            );
            sum += product(w, found);
        }
        let views = cotangents.each_ref().map(view);
        let gradient = derivative
            .pull_back(&times, &views, Interrupt::NEVER)
            .unwrap();
        let mut total = product(gradient.ends[0].as_ref().unwrap(), &dv);
        for (gradient, moved) in gradient.points.iter().zip(&moves) {
            total += product(gradient, moved);
        }
        assert_within((total - sum).abs() / (1.0 + sum.abs()), 1e-9, "transposed");
    }
}

fn ends(velocity: &Mat<f64>, acceleration: &Mat<f64>) -> EndConditions {
    EndConditions::Each(Box::new([
        EndCondition::Velocity(velocity.clone()),
        EndCondition::Acceleration(acceleration.clone()),
    ]))
}
