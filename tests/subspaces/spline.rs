//! Splines, compared with reflections.

use faer::{Mat, MatRef, Scale};
use stiefel_rs::spline::{
    EndCondition, EndConditions, Piecewise, SmoothingOptions, SplineOptions, cubic_spline,
    smoothing_spline,
};
use stiefel_rs::{Curve, Error, Interrupt, Quotient, RiemannianCubic};

use crate::common::{Rng, assert_close, assert_within, gaussian, random_orthogonal, random_point};
use crate::{SHAPES, horizontal, reflected, reflection, view};

/// Bases at the given distance from one another, each randomly rotated.
pub(crate) fn bases(
    (n, k): (usize, usize),
    count: usize,
    far: f64,
    rng: &mut Rng,
) -> Vec<Mat<f64>> {
    let mut points = vec![random_point(n, k, rng)];
    for i in 1..count {
        let y = &points[i - 1];
        let v = horizontal(view(y), gaussian(n, k, rng).as_ref());
        let v = &v * Scale(far / v.norm_l2());
        let moved = stiefel_rs::Stiefel::new(n, k)
            .unwrap()
            .exp(view(y), view(&v));
        points.push(moved.unwrap() * random_orthogonal(k, rng));
    }
    points
}

pub(crate) fn views(points: &[Mat<f64>]) -> Vec<MatRef<'_, f64>> {
    points.iter().map(view).collect()
}

fn spline(
    t: &[f64],
    points: &[Mat<f64>],
    ends: &EndConditions,
    quotient: Quotient,
    tension: f64,
) -> Piecewise<RiemannianCubic> {
    let options = SplineOptions {
        quotient,
        tension,
        ..SplineOptions::default()
    };
    cubic_spline(t, &views(points), ends, &options, Interrupt::NEVER)
        .unwrap()
        .0
}

fn each(first: EndCondition, last: EndCondition) -> EndConditions {
    EndConditions::Each(Box::new([first, last]))
}

#[test]
fn splines_are_those_of_reflections() {
    let mut rng = Rng::new(11);
    let t = [0.0, 1.0, 1.8, 3.0, 4.1];
    for shape in SHAPES {
        let (n, k) = shape;
        let mut points = bases(shape, t.len(), 0.7, &mut rng);
        let reflections: Vec<Mat<f64>> = points.iter().map(|y| reflection(view(y))).collect();
        let ends = [0, 4].map(|knot: usize| {
            let v = horizontal(view(&points[knot]), gaussian(n, k, &mut rng).as_ref());
            v * Scale(0.4)
        });
        let low = ends.clone();
        let high = [0, 4]
            .map(|knot: usize| reflected(view(&points[knot]), view(&ends[usize::from(knot > 0)])));
        let velocity = |[a, b]: &[Mat<f64>; 2]| {
            each(
                EndCondition::Velocity(a.clone()),
                EndCondition::Velocity(b.clone()),
            )
        };
        let mixed = |[a, b]: &[Mat<f64>; 2]| {
            each(
                EndCondition::Acceleration(a.clone()),
                EndCondition::Velocity(b.clone()),
            )
        };
        let cases = [
            (EndConditions::Natural, EndConditions::Natural, 0.0),
            (EndConditions::Natural, EndConditions::Natural, 2.0),
            (velocity(&low), velocity(&high), 0.0),
            (mixed(&low), mixed(&high), 0.5),
        ];
        for (case, (below, above, tension)) in cases.into_iter().enumerate() {
            let curve = spline(&t, &points, &below, Quotient::Subspaces, tension);
            let oracle = spline(&t, &reflections, &above, Quotient::Frames, tension);
            check(&curve, &oracle, &format!("{shape:?}, case {case}"));
            assert_close(
                &curve.point(0.0).unwrap(),
                &points[0],
                1e-13,
                "the first basis",
            );
        }
        points[4] = &points[0] * random_orthogonal(k, &mut rng);
        let mut closed = reflections;
        closed[4] = closed[0].clone();
        let ends = EndConditions::Periodic;
        let curve = spline(&t, &points, &ends, Quotient::Subspaces, 0.0);
        let oracle = spline(&t, &closed, &ends, Quotient::Frames, 0.0);
        check(&curve, &oracle, &format!("{shape:?}, closed"));
    }
}

/// Checks that a spline on `[0, 4.1]` agrees with reflections, and that its bases do not rotate within the subspaces.
pub fn check(curve: &impl Curve, oracle: &impl Curve, what: &str) {
    let mut before: Option<Mat<f64>> = None;
    for i in 0..=82 {
        let t = (0.05 * f64::from(i)).min(4.1);
        let y = curve.point(t).unwrap();
        assert_close(
            &reflection(view(&y)),
            &oracle.point(t).unwrap(),
            1e-10,
            what,
        );
        let a = reflected(view(&y), view(&curve.acceleration(t).unwrap()));
        assert_close(&a, &oracle.acceleration(t).unwrap(), 1e-9, what);
        let turned = y.transpose() * curve.derivative(t, 1).unwrap();
        assert_within(turned.norm_l2(), 1e-11, what);
        if let Some(before) = before {
            let step = (&y - &before).norm_l2();
            assert!(step < 0.2, "{what}: bases jump by {step} at {t}");
        }
        before = Some(y);
    }
    assert_within(
        (4.0 * curve.cost(Interrupt::NEVER).unwrap() / oracle.cost(Interrupt::NEVER).unwrap()
            - 1.0)
            .abs(),
        1e-10,
        what,
    );
}

#[test]
fn other_bases_make_the_same_spline() {
    let mut rng = Rng::new(12);
    let t = [0.0, 1.0, 2.0, 3.0];
    for (n, k) in [(4, 2), (6, 3), (60, 3), (30, 7)] {
        let points = bases((n, k), t.len(), 0.9, &mut rng);
        let turned: Vec<Mat<f64>> = points
            .iter()
            .map(|y| y * random_orthogonal(k, &mut rng))
            .collect();
        let ends = EndConditions::Natural;
        let [one, other] =
            [&points, &turned].map(|points| spline(&t, points, &ends, Quotient::Subspaces, 0.0));
        for i in 0..=12 {
            let t = 0.25 * f64::from(i);
            let [p, q] = [&one, &other].map(|curve| reflection(view(&curve.point(t).unwrap())));
            assert_close(&p, &q, 1e-11, &format!("({n}, {k}) at {t}"));
        }
        for t in [1.0, 2.0] {
            let jump = |nu: fn(&RiemannianCubic, f64) -> stiefel_rs::Result<Mat<f64>>| {
                let pieces = one.pieces();
                let i = t as usize;
                (nu(&pieces[i - 1], 1.0).unwrap() - nu(&pieces[i], 0.0).unwrap()).norm_l2()
            };
            assert_within(jump(|piece, t| piece.point(t)), 1e-11, "joint");
            assert_within(jump(|piece, t| piece.derivative(t, 1)), 1e-11, "joint");
            assert_within(jump(|piece, t| piece.acceleration(t)), 1e-11, "joint");
        }
    }
}

#[test]
fn smoothing_is_that_of_reflections() {
    let mut rng = Rng::new(13);
    let t = [0.0, 1.0, 1.8, 3.0, 4.1];
    for shape in [(3, 1), (4, 2), (5, 2), (3, 2)] {
        let points = bases(shape, t.len(), 0.6, &mut rng);
        let reflections: Vec<Mat<f64>> = points.iter().map(|y| reflection(view(y))).collect();
        let options = SmoothingOptions {
            lambda: Some(0.05),
            quotient: Quotient::Subspaces,
            ..SmoothingOptions::default()
        };
        let frames = SmoothingOptions {
            quotient: Quotient::Frames,
            ..options
        };
        let found =
            smoothing_spline(&t, &views(&points), None, &options, Interrupt::NEVER).unwrap();
        let oracle =
            smoothing_spline(&t, &views(&reflections), None, &frames, Interrupt::NEVER).unwrap();
        assert_within(
            (4.0 * found.misfit / oracle.misfit - 1.0).abs(),
            1e-8,
            "misfit",
        );
        for i in 0..=20 {
            let t = 4.1 / 20.0 * f64::from(i);
            let y = found.curve.point(t).unwrap();
            let expected = oracle.curve.point(t).unwrap();
            assert_close(
                &reflection(view(&y)),
                &expected,
                1e-8,
                &format!("{shape:?} at {t}"),
            );
        }
    }
}

#[test]
fn perpendicular_neighbours_are_refused_with_their_angle() {
    let e = Mat::<f64>::identity(4, 4);
    let points = [
        e.as_ref().subcols(0, 2).to_owned(),
        e.as_ref().subcols(2, 2).to_owned(),
    ];
    let options = SplineOptions {
        quotient: Quotient::Subspaces,
        ..SplineOptions::default()
    };
    let error = cubic_spline(
        &[0.0, 1.0],
        &views(&points),
        &EndConditions::Natural,
        &options,
        Interrupt::NEVER,
    );
    let error = error.unwrap_err();
    assert!(matches!(error, Error::AtKnot { knot: 0, .. }), "{error}");
    assert!(
        (error.angle().unwrap() - std::f64::consts::FRAC_PI_2).abs() < 1e-14,
        "{error}"
    );
}

/// Loops in which a line turns half around, so that bases carried along them come back with one direction reversed.
#[test]
fn closed_splines_that_reverse_a_direction_do_not_depend_on_their_first_knot() {
    for ((n, k), count) in [((40, 1), 12), ((40, 2), 12), ((12, 4), 8), ((13, 3), 8)] {
        let mut rng = Rng::new(19);
        let turn = random_orthogonal(n, &mut rng);
        let last = 1.1;
        let mut points: Vec<Mat<f64>> = (0..count)
            .map(|i| {
                let angle = (std::f64::consts::PI - last) * i as f64 / (count - 1) as f64;
                let axes = Mat::from_fn(n, k, |row, col| match (row, col) {
                    (0, 0) => angle.cos(),
                    (1, 0) => angle.sin(),
                    _ => f64::from(u8::from(col > 0 && row == col + 1)),
                });
                let near = axes + gaussian(n, k, &mut rng) * Scale(0.02);
                let manifold = stiefel_rs::Stiefel::new(n, k).unwrap();
                manifold.project((&turn * near).as_ref()).unwrap()
            })
            .collect();
        points.push(points[0].clone());
        let half = count / 2;
        let others: Vec<Mat<f64>> = (0..=count)
            .map(|i| points[(i + half) % count].clone())
            .collect();
        let t: Vec<f64> = (0..=count).map(|i| i as f64).collect();
        let costs = [&points, &others].map(|points| {
            let ends = EndConditions::Periodic;
            spline(&t, points, &ends, Quotient::Subspaces, 0.0)
                .cost(Interrupt::NEVER)
                .unwrap()
        });
        let off = (costs[0] / costs[1] - 1.0).abs();
        assert_within(off, 1e-9, &format!("({n}, {k}): {costs:?}"));
    }
}
