//! Transposed derivatives of Riemannian cubics compared with the forward ones, and these with differences.

mod common;

use common::{Rng, assert_within, cubic_from, distance, frobenius, gaussian, random_tangent};
use faer::{Mat, MatRef, Scale};
use stiefel_rs::cubic::{BoundaryVariation, InitialVariation, IntegrationOptions};
use stiefel_rs::{Curve, Error, Interrupt, RiemannianCubic, Stiefel};

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

/// Before, in and after the interval, and at its ends; not sorted.
const TIMES: [f64; 6] = [1.0, 0.3, -0.4, 0.0, 1.5, 0.7];

/// Cubics, and curves in tension.
const TENSIONS: [f64; 2] = [0.0, 4.0];

fn random_cubic((n, k): (usize, usize), tension: f64) -> RiemannianCubic {
    let mut rng = Rng::new(31);
    let s = common::random_point(n, k, &mut rng);
    let [v, a, j] = [1.0; 3].map(|size| random_tangent(&s, size, &mut rng));
    let options = IntegrationOptions {
        tension,
        ..IntegrationOptions::default()
    };
    cubic_from([&s, &v, &a, &j], &options)
}

fn dot(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> f64 {
    let columns = a.col_iter().zip(b.col_iter());
    columns.map(|(a, b)| a.transpose() * b).sum()
}

fn cases() -> impl Iterator<Item = ((usize, usize), f64)> {
    SHAPES
        .into_iter()
        .flat_map(|shape| TENSIONS.map(|tension| (shape, tension)))
}

/// A displacement, and the derivative of a vector that is made tangent at the displaced point after adding a shift.
fn moved_vector(s: &Mat<f64>, ds: &Mat<f64>, v: &Mat<f64>, shift: &Mat<f64>) -> Mat<f64> {
    let inner = ds.transpose() * v + s.transpose() * shift;
    shift - s * (&inner + inner.transpose()) * Scale(0.5)
}

/// Difference between the products of a gradient with a variation and of cotangents with the resulting motion of the
/// points, relative to the summands.
fn mismatch(
    parts: [(&Mat<f64>, &Mat<f64>); 4],
    points: &[Mat<f64>],
    cotangents: &[Mat<f64>],
) -> f64 {
    let pairs = points.iter().zip(cotangents);
    let expected: f64 = pairs.map(|(x, w)| dot(x.as_ref(), w.as_ref())).sum();
    let product: f64 = parts.iter().map(|(g, d)| dot(g.as_ref(), d.as_ref())).sum();
    let sizes = parts
        .iter()
        .map(|(g, d)| frobenius(g.as_ref()) * frobenius(d.as_ref()));
    (product - expected).abs() / sizes.sum::<f64>()
}

fn cotangents(shape: (usize, usize)) -> Vec<Mat<f64>> {
    let mut rng = Rng::new(17);
    TIMES.map(|_| gaussian(shape.0, shape.1, &mut rng)).into()
}

#[test]
fn pulling_back_to_boundary_data_is_the_transpose() {
    for (shape, tension) in cases() {
        for length in [1.0, 0.01] {
            let curve = random_cubic(shape, tension)
                .reparametrised(2.0, 2.0 + length)
                .unwrap();
            let times = TIMES.map(|t| 2.0 + length * t);
            let mut rng = Rng::new(5);
            let [s0, s1] = [2.0, 2.0 + length].map(|t| curve.point(t).unwrap());
            let [v0, v1] = [2.0, 2.0 + length].map(|t| curve.derivative(t, 1).unwrap());
            let [ds0, ds1] = [&s0, &s1].map(|s| random_tangent(s, 1.0, &mut rng));
            let [dv0, dv1] = [(&s0, &ds0, &v0), (&s1, &ds1, &v1)].map(|(s, ds, v)| {
                moved_vector(
                    s,
                    ds,
                    v,
                    &(gaussian(shape.0, shape.1, &mut rng) * Scale(1.0 / length)),
                )
            });
            let variation = BoundaryVariation {
                s0: ds0.as_ref(),
                v0: dv0.as_ref(),
                s1: ds1.as_ref(),
                v1: dv1.as_ref(),
            };
            let derivative = curve.boundary_derivative(Interrupt::NEVER).unwrap();
            let points = derivative
                .points(&curve, &variation, &times, Interrupt::NEVER)
                .unwrap();
            let cotangents = cotangents(shape);
            let views: Vec<MatRef<'_, f64>> = cotangents.iter().map(Mat::as_ref).collect();
            let found = derivative
                .pull_back(&times, &views, Interrupt::NEVER)
                .unwrap();
            let parts = [
                (&found.s0, &ds0),
                (&found.v0, &dv0),
                (&found.s1, &ds1),
                (&found.v1, &dv1),
            ];
            let error = mismatch(parts, &points, &cotangents);
            let what = format!("{shape:?}, tension {tension}, in {length}");
            println!("{what}: {error:.1e}");
            // Round-off times the condition number, about 30; the equations are solved to 1e-15.
            assert_within(error, 1e-12, &what);
        }
    }
}

fn initial_variation(curve: &RiemannianCubic, seed: u64) -> (InitialVariation, [Mat<f64>; 3]) {
    let mut rng = Rng::new(seed);
    let [s, v, a, j] = curve.initial().unwrap();
    let (n, k) = s.shape();
    let point = random_tangent(&s, 1.0, &mut rng);
    let shifts = [(); 3].map(|()| {
        let shift = gaussian(n, k, &mut rng);
        &shift * Scale(frobenius(shift.as_ref()).recip())
    });
    let [velocity, acceleration, jerk] =
        [(&v, 0), (&a, 1), (&j, 2)].map(|(y, i)| moved_vector(&s, &point, y, &shifts[i]));
    let variation = InitialVariation {
        point,
        velocity,
        acceleration,
        jerk,
    };
    (variation, shifts)
}

#[test]
fn initial_data_move_points_as_differences_of_curves() {
    for (shape, tension) in cases() {
        let curve = random_cubic(shape, tension);
        let (variation, shifts) = initial_variation(&curve, 4);
        let [s, v, a, j] = curve.initial().unwrap();
        let manifold = Stiefel::new(shape.0, shape.1).unwrap();
        let options = IntegrationOptions {
            tension,
            ..IntegrationOptions::default()
        };
        let at = |h: f64| {
            let step = &variation.point * Scale(h);
            let point = manifold.exp(s.as_ref(), step.as_ref()).unwrap();
            let point = manifold.project(point.as_ref()).unwrap();
            let [v, a, j] = [(&v, 0), (&a, 1), (&j, 2)].map(|(y, i)| {
                let y = y + &shifts[i] * Scale(h);
                let inner = point.transpose() * &y;
                &y - &point * (&inner + inner.transpose()) * Scale(0.5)
            });
            let [s, v, a, j] = [&point, &v, &a, &j].map(|x| x.as_ref());
            let curve =
                RiemannianCubic::from_initial(s, v, a, j, &options, Interrupt::NEVER).unwrap();
            TIMES.map(|t| curve.point(t).unwrap())
        };
        let h = 1e-3;
        let [b, c, d, e] = [h, -h, 2.0 * h, -2.0 * h].map(at);
        let found = curve
            .initial_points(&variation, &TIMES, Interrupt::NEVER)
            .unwrap();
        for (i, found) in found.iter().enumerate() {
            let expected =
                ((&b[i] - &c[i]) * Scale(8.0) - (&d[i] - &e[i])) * Scale(1.0 / (12.0 * h));
            let error = distance(found, &expected) / (1.0 + frobenius(expected.as_ref()));
            // Round-off of the points divided by the step, here at most 7e-12, and the fifth derivative times h^4 / 30.
            let what = format!("{shape:?}, tension {tension}, at {}", TIMES[i]);
            assert_within(error, 1e-10, &what);
        }
    }
}

#[test]
fn pulling_back_to_initial_data_is_the_transpose() {
    for (shape, tension) in cases() {
        let curve = random_cubic(shape, tension);
        let (variation, _) = initial_variation(&curve, 6);
        let points = curve
            .initial_points(&variation, &TIMES, Interrupt::NEVER)
            .unwrap();
        let cotangents = cotangents(shape);
        let views: Vec<MatRef<'_, f64>> = cotangents.iter().map(Mat::as_ref).collect();
        let found = curve
            .initial_pull_back(&TIMES, &views, Interrupt::NEVER)
            .unwrap();
        let parts = [
            (&found.point, &variation.point),
            (&found.velocity, &variation.velocity),
            (&found.acceleration, &variation.acceleration),
            (&found.jerk, &variation.jerk),
        ];
        let error = mismatch(parts, &points, &cotangents);
        let what = format!("{shape:?}, tension {tension}");
        println!("{what}: {error:.1e}");
        // Round-off of two evaluations of the curve, which grows with time.
        assert_within(error, 1e-13, &what);
    }
}

#[test]
fn bad_cotangents_are_refused() {
    let curve = random_cubic((4, 2), 0.0);
    let derivative = curve.boundary_derivative(Interrupt::NEVER).unwrap();
    let (good, wide) = (Mat::<f64>::zeros(4, 2), Mat::<f64>::zeros(4, 3));
    let mut bad = good.clone();
    bad[(1, 1)] = f64::NAN;
    let refused = |t: &[f64], x: &[MatRef<'_, f64>]| {
        let one = derivative.pull_back(t, x, Interrupt::NEVER).unwrap_err();
        let other = curve.initial_pull_back(t, x, Interrupt::NEVER).unwrap_err();
        assert_eq!(one, other);
        one
    };
    assert!(matches!(refused(&[0.5], &[]), Error::Shape { .. }));
    assert!(matches!(
        refused(&[0.5], &[wide.as_ref()]),
        Error::Shape { .. }
    ));
    assert!(matches!(
        refused(&[0.5], &[bad.as_ref()]),
        Error::NonFinite { .. }
    ));
    assert!(matches!(
        refused(&[f64::NAN], &[good.as_ref()]),
        Error::NonFinite { .. }
    ));
    let none = derivative.pull_back(&[], &[], Interrupt::NEVER).unwrap();
    assert_eq!(none.s0.norm_max() + none.v0.norm_max(), 0.0);
}
