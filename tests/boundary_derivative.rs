//! Derivatives of boundary problems, compared with exactly known families of solutions.

mod common;

use common::{
    Rng, assert_within, cubic_from, distance, frobenius, gaussian, identity, random_tangent,
};
use faer::{Mat, MatRef, Scale, mat};
use stiefel_rs::cubic::{BoundaryVariation, InitialVariation, IntegrationOptions};
use stiefel_rs::{Curve, Error, Interrupt, Result, RiemannianCubic};

const EPS: f64 = f64::EPSILON;

/// Sizes with and without rows outside the span, with 2 to 258 unknowns.
const SHAPES: [(usize, usize); 8] = [
    (2, 1),
    (7, 1),
    (3, 2),
    (3, 3),
    (5, 3),
    (12, 2),
    (30, 5),
    (24, 6),
];

fn random_cubic((n, k): (usize, usize), speed: f64) -> RiemannianCubic {
    let mut rng = Rng::new(31);
    let s = common::random_point(n, k, &mut rng);
    let [v, a, j] = [speed; 3].map(|size| random_tangent(&s, size, &mut rng));
    let options = IntegrationOptions::default();
    cubic_from([&s, &v, &a, &j], &options)
}

/// Derivative of the initial data with respect to `S0, V0, S1, V1`.
fn initial(curve: &RiemannianCubic, rates: &[Mat<f64>; 4]) -> Result<InitialVariation> {
    let [s0, v0, s1, v1] = rates.each_ref().map(|x| -> MatRef<'_, f64> { x.as_ref() });
    let derivative = curve.boundary_derivative(Interrupt::NEVER)?;
    derivative.initial(&BoundaryVariation { s0, v0, s1, v1 }, Interrupt::NEVER)
}

/// Derivative of the point at a time.
fn point(curve: &RiemannianCubic, rates: &[Mat<f64>; 4], t: f64) -> Result<Mat<f64>> {
    let [s0, v0, s1, v1] = rates.each_ref().map(|x| -> MatRef<'_, f64> { x.as_ref() });
    let variation = BoundaryVariation { s0, v0, s1, v1 };
    let derivative = curve.boundary_derivative(Interrupt::NEVER)?;
    let mut points = derivative.points(curve, &variation, &[t], Interrupt::NEVER)?;
    Ok(points.remove(0))
}

fn assert_derivatives(found: &InitialVariation, expected: [&Mat<f64>; 2], bound: f64, what: &str) {
    for (name, found, expected) in [
        ("A", &found.acceleration, expected[0]),
        ("J", &found.jerk, expected[1]),
    ] {
        let error = distance(found, expected) / (1.0 + frobenius(expected.as_ref()));
        println!("{what} {name}: {error:.1e}");
        assert_within(error, bound, &format!("{what} {name}"));
    }
}

/// Round-off of `n k` entries, times the condition number of the equations: about 30 for the worst of these curves.
fn bound((n, k): (usize, usize)) -> f64 {
    30.0 * (n * k) as f64 * EPS
}

#[test]
fn rotations_about_the_start_turn_the_initial_data() {
    for shape in SHAPES {
        for length in [1.0, 7.0, 0.01] {
            let curve = random_cubic(shape, 1.0)
                .reparametrised(0.0, length)
                .unwrap();
            let [s, v, a, j] = curve.initial().unwrap();
            let off = identity(shape.0) - &s * s.transpose();
            let g = gaussian(shape.0, shape.0, &mut Rng::new(32));
            let turn = &off * (&g - g.transpose()) * &off;
            let end = [0, 1].map(|order| &turn * curve.derivative(length, order).unwrap());
            let [s1, v1] = end;
            let rates = [Mat::zeros(shape.0, shape.1), &turn * v, s1, v1];
            for t in [0.3 * length, length] {
                let found = point(&curve, &rates, t).unwrap();
                let expected = &turn * curve.point(t).unwrap();
                let error = distance(&found, &expected) / (1.0 + frobenius(expected.as_ref()));
                assert_within(error, bound(shape), &format!("{shape:?} at {t}"));
            }
            let found = initial(&curve, &rates).unwrap();
            let size = (length * length).recip();
            let found = InitialVariation {
                acceleration: found.acceleration * Scale(size.recip()),
                jerk: found.jerk * Scale(size.recip() * length),
                ..found
            };
            let expected = [
                &turn * a * Scale(size.recip()),
                &turn * j * Scale(size.recip() * length),
            ];
            let what = format!("{shape:?} in {length}");
            assert_derivatives(&found, expected.each_ref(), bound(shape), &what);
        }
    }
}

#[test]
fn faster_runs_along_the_curve_scale_the_initial_data() {
    for shape in SHAPES {
        let curve = random_cubic(shape, 1.0);
        let [s, v, a, j] = curve.initial().unwrap();
        let [v1, w1] = [1, 2].map(|order| curve.derivative(1.0, order).unwrap());
        let rates = [Mat::zeros(s.nrows(), s.ncols()), v, v1.clone(), v1 + w1];
        let found = initial(&curve, &rates).unwrap();
        let expected = [a * Scale(2.0), j * Scale(3.0)];
        let what = format!("{shape:?}");
        assert_derivatives(&found, expected.each_ref(), bound(shape), &what);
    }
}

/// The cubic at rest at both ends of an arc `theta = pi - gap` on the sphere, a great circle with the angle `theta (3
/// t^2 - 2 t^3)`, and the variation that moves its end sideways.
fn nearly_antipodal(gap: f64) -> (RiemannianCubic, [Mat<f64>; 4]) {
    let rest = Mat::zeros(3, 1);
    let (start, aside) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [0.0], [1.0]]);
    let angle = std::f64::consts::PI - gap;
    let [a, j] = [6.0, -12.0].map(|factor| mat![[0.0], [factor * angle], [0.0]]);
    let curve = cubic_from([&start, &rest, &a, &j], &IntegrationOptions::default());
    (curve, [rest.clone(), rest.clone(), aside, rest])
}

#[test]
fn conjugate_ends_are_errors() {
    let (curve, rates) = nearly_antipodal(0.0);
    let error = initial(&curve, &rates).unwrap_err();
    let Error::ConjugateEnds { smallest, largest } = error else {
        panic!("{error}");
    };
    assert!(smallest < 1e-11 * largest && largest < 10.0, "{error}");
    // The first variation of the cost needs no linear solve.
    let gradient = curve.cost_gradient().unwrap();
    assert!(frobenius(gradient.s1.as_ref()).is_finite());
    assert_within(
        frobenius((gradient.s1.transpose() * &rates[2]).as_ref()),
        1e-9,
        "the cost does not change to first order where the end turns about the start",
    );
}

#[test]
fn derivatives_near_conjugate_ends_are_as_good_as_their_condition() {
    // A rotation about the start rotates the curve, and moves its end by the sine of the gap.
    for gap in [1e-1, 1e-2, 1e-4, 1e-6, 1e-8] {
        let (curve, rates) = nearly_antipodal(gap);
        let [_, _, a, j] = curve.initial().unwrap();
        // `e1 x` of the data, for an end that moves by `sin(gap) e3`.
        let turned = |x: &Mat<f64>| mat![[0.0], [-x[(2, 0)]], [x[(1, 0)]]];
        let expected = [turned(&a), turned(&j)].map(|x| x * Scale(gap.sin().recip()));
        let found = initial(&curve, &rates).unwrap();
        // The end is accurate to a few units of round-off, relative to the gap.
        assert_derivatives(
            &found,
            expected.each_ref(),
            1e-11 / gap,
            &format!("gap {gap:e}"),
        );
    }
}

#[test]
fn the_gradient_of_the_cost_is_that_of_the_derivative() {
    for shape in SHAPES {
        let curve = random_cubic(shape, 2.0);
        let found = curve.cost_gradient().unwrap();
        let [s, v, ..] = curve.initial().unwrap();
        let [s1, v1, w1] = [0, 1, 2].map(|order| curve.derivative(1.0, order).unwrap());
        assert!(s1.nrows() == s.nrows());
        // Faster by the factor `1 + h` on the same curve: the cost of `[0, 1 + h]` in unit time is `(1 + h)^3` times
        // that of the longer piece, whose additional cost is the square of the last acceleration.
        let product = |a: &Mat<f64>, b: &Mat<f64>| {
            let columns = a.col_iter().zip(b.col_iter());
            columns.map(|(a, b)| a.transpose() * b).sum::<f64>()
        };
        let rate =
            product(&found.v0, &v) + product(&found.s1, &v1) + product(&found.v1, &(&v1 + w1));
        let manifold = stiefel_rs::Stiefel::new(shape.0, shape.1).unwrap();
        let last = curve.acceleration(1.0).unwrap();
        let square = manifold
            .inner(s1.as_ref(), last.as_ref(), last.as_ref())
            .unwrap();
        let expected = 3.0 * curve.cost(Interrupt::NEVER).unwrap() + square;
        let bound = 100.0 * (shape.0 * shape.1) as f64 * EPS * (1.0 + expected);
        assert_within((rate - expected).abs(), bound, &format!("{shape:?}"));
    }
}
