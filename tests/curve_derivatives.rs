//! Derivatives of geometric cubics, covariant quantities, and the cost.

mod common;

use std::f64::consts::PI;

use common::*;
use faer::{Mat, Scale, mat};
use stiefel_rs::linalg::jet::MatrixJet;
use stiefel_rs::manifold::covariant::{acceleration, christoffel, jerk};
use stiefel_rs::{
    Curve, GeometricCubic, GeometricPolynomial, Interrupt, Quantity, QuasiGeodesic, Stiefel,
};

const TIMES: [f64; 6] = [0.0, 0.1, 0.37, 0.5, 0.8, 1.0];

/// First derivative by the central difference of order 8 with step `h`.
fn difference(f: impl Fn(f64) -> Mat<f64>, t: f64, h: f64) -> Mat<f64> {
    let weights = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
    let mut sum = f(t) * Scale(0.0);
    for (i, w) in weights.into_iter().enumerate() {
        let step = h * (i + 1) as f64;
        sum += (f(t + step) - f(t - step)) * Scale(w / h);
    }
    sum
}

/// Each derivative compared with a difference of the previous one, relative to `1 + |derivative|`; the best of three
/// steps, since the balance of truncation and round-off depends on the speed of the curve.
fn derivative_error(curve: &impl Curve, t: f64, nu: usize) -> f64 {
    let exact = curve.derivative(t, nu).unwrap();
    difference_error(|t| curve.derivative(t, nu - 1).unwrap(), t, &exact)
}

fn difference_error(f: impl Fn(f64) -> Mat<f64>, t: f64, exact: &Mat<f64>) -> f64 {
    let error = [1e-3, 4e-3, 1e-2].map(|h| distance(&difference(&f, t, h), exact));
    error.into_iter().fold(f64::INFINITY, f64::min) / (1.0 + frobenius(exact.as_ref()))
}

/// Round-off `1e-15 / h` with `h` about 1e-2, over derivatives of size 10 to 1000 one order below.
const DERIVATIVE_BOUND: f64 = 1e-11;

#[test]
fn derivatives_are_those_of_the_position() {
    let mut rng = Rng::new(11);
    for nu in 1..=3 {
        let mut worst = Worst::new(&format!("derivative {nu} against differences"));
        for size in SIZES.into_iter().filter(|(_, k)| *k <= 7) {
            let curve = Boundary::random(size, 1.0, 1.0, &mut rng).curve();
            for t in TIMES {
                worst.see(derivative_error(&curve, t, nu), || {
                    format!("{size:?}, t = {t}")
                });
            }
        }
        worst.assert_at_most(DERIVATIVE_BOUND);
    }
}

/// Control points whose first leg has the given principal angles: at `t = 0` they also occur in the last stage.
fn curve_at_angles(n: usize, angles: &[f64], rng: &mut Rng) -> GeometricCubic {
    let s0 = random_point(n, angles.len(), rng);
    let s1 = partner_at_angles(&s0, angles, rng);
    let s2 = retract(&s1, &random_tangent(&s1, 0.3, rng));
    let s3 = retract(&s2, &random_tangent(&s2, 0.3, rng));
    through(&[s0, s1, s2, s3])
}

#[test]
fn derivatives_where_principal_angles_repeat_or_vanish() {
    let mut rng = Rng::new(12);
    let lists: [&[f64]; 8] = [
        &[0.4, 0.4, 0.4],
        &[0.4, 0.4 + 1e-9, 1.0],
        &[0.0, 0.0, 0.0],
        &[0.0, 0.5, 0.5],
        &[1e-8, 2e-8, 0.3],
        &[1e-5, 1e-4, 1e-3],
        &[0.3],
        &[0.6, 0.6],
    ];
    for nu in 1..=3 {
        let mut worst = Worst::new(&format!("derivative {nu}, degenerate angles"));
        for angles in lists {
            let curve = curve_at_angles(7, angles, &mut rng);
            for t in [0.0, 1e-7, 0.5] {
                worst.see(derivative_error(&curve, t, nu), || {
                    format!("angles {angles:?}, t = {t}")
                });
            }
        }
        worst.assert_at_most(DERIVATIVE_BOUND);
    }
}

#[test]
fn derivatives_on_the_extended_branch() {
    let mut rng = Rng::new(13);
    let lists: [&[f64]; 5] = [
        &[0.3, 0.5, 2.0],
        &[0.2, 0.2, 2.2],
        &[0.0, 1e-8, 2.5],
        &[0.4, 1.8],
        &[2.6],
    ];
    for nu in 1..=3 {
        let mut worst = Worst::new(&format!("derivative {nu}, extended branch"));
        for angles in lists {
            let curve = curve_at_angles(7, angles, &mut rng);
            let beyond = QuasiGeodesic::between(
                curve.control_points()[0].as_ref(),
                curve.control_points()[1].as_ref(),
            );
            let largest = beyond
                .unwrap()
                .angles()
                .iter()
                .fold(0.0_f64, |s, x| s.max(*x));
            assert_within(
                (largest - angles[angles.len() - 1]).abs(),
                1e-14,
                "the extended branch is in use",
            );
            for t in [0.0, 0.05] {
                worst.see(derivative_error(&curve, t, nu), || {
                    format!("angles {angles:?}, t = {t}")
                });
            }
        }
        worst.assert_at_most(DERIVATIVE_BOUND);
    }
}

#[test]
fn velocity_is_tangent() {
    let mut rng = Rng::new(14);
    for size in SIZES {
        let curve = Boundary::random(size, 1.0, 1.0, &mut rng).curve();
        for t in TIMES {
            let (s, v) = (curve.point(t).unwrap(), curve.derivative(t, 1).unwrap());
            let defect = frobenius((s.transpose() * &v + v.transpose() * &s).as_ref());
            assert_within(defect, 1e-12, &format!("S^T V + V^T S, {size:?}, t = {t}"));
        }
    }
}

// ----------------------------------------------------------- covariant quantities

#[test]
fn covariant_acceleration_and_jerk_on_the_sphere() {
    let mut rng = Rng::new(21);
    for n in [2, 3, 10] {
        let curve = Boundary::random((n, 1), 1.2, 1.5, &mut rng).curve();
        for t in TIMES {
            let [x, d1, d2, d3] = [0, 1, 2, 3].map(|nu| curve.derivative(t, nu).unwrap());
            let normal = (x.transpose() * &d2)[(0, 0)];
            let acceleration = project_off(&x, &d2);
            let jerk = project_off(&x, &d3) - &d1 * Scale(normal);
            let bound = 1e-13 * (1.0 + frobenius(d3.as_ref()));
            assert_close(
                &curve.acceleration(t).unwrap(),
                &acceleration,
                bound,
                &format!("P S'', n = {n}, t = {t}"),
            );
            assert_close(
                &curve.jerk(t).unwrap(),
                &jerk,
                bound,
                &format!("P (P S'')', n = {n}, t = {t}"),
            );
        }
    }
}

#[test]
fn covariant_quantities_follow_from_their_definition() {
    let mut rng = Rng::new(22);
    let mut worst = Worst::new("D_t W - (W' + Gamma(S', W)) with W' by differences");
    for size in SIZES.into_iter().filter(|(_, k)| *k <= 7) {
        let curve = Boundary::random(size, 1.0, 1.0, &mut rng).curve();
        let fields: [&dyn Fn(f64) -> Mat<f64>; 2] = [&|t| curve.derivative(t, 1).unwrap(), &|t| {
            curve.acceleration(t).unwrap()
        }];
        for t in TIMES {
            let found = [curve.acceleration(t).unwrap(), curve.jerk(t).unwrap()];
            for (field, found) in fields.into_iter().zip(found) {
                let (s, v, w) = (
                    curve.point(t).unwrap(),
                    curve.derivative(t, 1).unwrap(),
                    field(t),
                );
                let rate = found - christoffel(s.as_ref(), v.as_ref(), w.as_ref());
                let error = difference_error(field, t, &rate);
                worst.see(error, || format!("{size:?}, t = {t}"));
            }
        }
    }
    worst.assert_at_most(DERIVATIVE_BOUND);
}

#[test]
fn covariant_quantities_are_tangent() {
    let mut rng = Rng::new(23);
    for size in SIZES {
        let curve = Boundary::random(size, 1.0, 1.0, &mut rng).curve();
        for t in TIMES {
            let s = curve.point(t).unwrap();
            for w in [curve.acceleration(t).unwrap(), curve.jerk(t).unwrap()] {
                let manifold = Stiefel::of("S", s.as_ref()).unwrap();
                manifold
                    .check_tangent("W", s.as_ref(), w.as_ref(), 1e-11)
                    .unwrap_or_else(|e| panic!("{size:?}: {e}"));
            }
        }
    }
}

// ------------------------------------------------------------------ scalar curves

/// Data with a single angle: a great circle, or the plane rotations. The control angles are `p`.
fn scalar_data(plane: bool, p: [f64; 4], rng: &mut Rng) -> (Boundary, Mat<f64>, Mat<f64>) {
    let basis = if plane {
        random_orthogonal(2, rng)
    } else {
        random_point(5, 2, rng)
    };
    let turn = |a: f64| mat![[a.cos(), -a.sin()], [a.sin(), a.cos()]];
    let columns = if plane { 2 } else { 1 };
    let at = |a: f64| (&basis * turn(a)).subcols(0, columns).to_owned();
    let rate = |a: f64| at(a + 0.5 * PI);
    let data = Boundary {
        s0: at(p[0]),
        v0: rate(p[0]) * Scale(3.0 * (p[1] - p[0])),
        s1: at(p[3]),
        v1: rate(p[3]) * Scale(3.0 * (p[3] - p[2])),
    };
    (data, at(0.0), rate(0.0))
}

const CONTROL_ANGLES: [[f64; 4]; 4] = [
    [0.0, 0.5, 0.2, 1.0],
    [0.0, -1.0, 1.5, 2.0],
    [0.3, 1.3, 2.3, 3.3],
    [0.0, 2.0, 0.5, -1.0],
];

#[test]
fn scalar_curve_is_the_cubic_polynomial_in_the_angle() {
    let mut rng = Rng::new(31);
    for p in CONTROL_ANGLES {
        for plane in [false, true] {
            let (data, zero, quarter) = scalar_data(plane, p, &mut rng);
            let curve = data.curve();
            for t in TIMES {
                let r = 1.0 - t;
                let angle = r.powi(3) * p[0]
                    + 3.0 * r * r * t * p[1]
                    + 3.0 * r * t * t * p[2]
                    + t.powi(3) * p[3];
                let second =
                    6.0 * (r * (p[2] - 2.0 * p[1] + p[0]) + t * (p[3] - 2.0 * p[2] + p[1]));
                let place = format!("plane {plane}, p = {p:?}, t = {t}");
                let expected = &zero * Scale(angle.cos()) + &quarter * Scale(angle.sin());
                assert_close(
                    &curve.point(t).unwrap(),
                    &expected,
                    2e-14,
                    &format!("point, {place}"),
                );
                let along = &quarter * Scale(angle.cos()) - &zero * Scale(angle.sin());
                let bound = 1e-12 * (1.0 + second.abs());
                let acceleration = curve.acceleration(t).unwrap();
                assert_close(
                    &acceleration,
                    &(along * Scale(second)),
                    bound,
                    &format!("acceleration, {place}"),
                );
            }
        }
    }
}

#[test]
fn cost_of_a_scalar_curve_has_a_closed_form() {
    let mut rng = Rng::new(32);
    for p in CONTROL_ANGLES {
        for plane in [false, true] {
            let (data, ..) = scalar_data(plane, p, &mut rng);
            let (a, b) = (p[2] - 2.0 * p[1] + p[0], p[3] - 2.0 * p[2] + p[1]);
            let expected = 12.0 * (a * a + a * b + b * b);
            let found = data
                .curve()
                .cost(Interrupt::NEVER)
                .unwrap_or_else(|e| panic!("plane {plane}, p = {p:?}: {e}"));
            let bound = 1e-12 * (1.0 + expected);
            assert_within(
                (found - expected).abs(),
                bound,
                &format!("J - {expected}, plane {plane}, p = {p:?}"),
            );
        }
    }
}

#[test]
fn cost_of_a_geodesic_is_zero() {
    let mut rng = Rng::new(33);
    for size in [(3, 1), (10, 1), (2, 2), (4, 4), (1, 1)] {
        let s = random_point(size.0, size.1, &mut rng);
        let curve =
            QuasiGeodesic::from_velocity(s.as_ref(), random_tangent(&s, 1.3, &mut rng).as_ref())
                .unwrap();
        let cost = curve
            .cost(Interrupt::NEVER)
            .unwrap_or_else(|e| panic!("{size:?}: {e}"));
        assert_within(cost, 1e-24, &format!("J, {size:?}"));
    }
}

#[test]
fn cost_of_a_nearly_geodesic_curve_converges() {
    let mut rng = Rng::new(34);
    for bend in [1e-3, 1e-6, 1e-9, 1e-12] {
        let (data, ..) = scalar_data(false, [0.0, 0.4 + bend, 0.8, 1.2], &mut rng);
        let expected = 12.0 * 3.0 * bend * bend;
        let found = data
            .curve()
            .cost(Interrupt::NEVER)
            .unwrap_or_else(|e| panic!("bend {bend}: {e}"));
        // The acceleration is accurate to the round-off of the second derivative.
        let bound = 1e-12 * expected + 1e-13 * expected.sqrt() + 1e-26;
        assert_within(
            (found - expected).abs(),
            bound,
            &format!("J - {expected:e}, bend {bend:e}"),
        );
    }
}

/// Control points of curves on which formulas for small, repeated or vanishing angles matter.
fn special_control_points(n: usize, k: usize, rng: &mut Rng) -> Vec<[Mat<f64>; 4]> {
    let start = random_point(n, k, rng);
    let coordinates = Mat::from_fn(n, k, |i, j| f64::from(u8::from(i == j)));
    let near = |s: &Mat<f64>, size: f64, rng: &mut Rng| retract(s, &random_tangent(s, size, rng));
    let turned = {
        // The first two coordinates are rotated, all others stay.
        let (sin, cos) = 0.8_f64.sin_cos();
        let mut turned = coordinates.clone();
        for j in 0..k {
            let (x, y) = (coordinates[(0, j)], coordinates[(1, j)]);
            (turned[(0, j)], turned[(1, j)]) = (cos * x - sin * y, sin * x + cos * y);
        }
        turned
    };
    let mut all = Vec::new();
    for size in [1e-9, 0.3, 1.0, 1.9, 2.7] {
        let second = near(&start, size, rng);
        let third = near(&second, size, rng);
        let last = near(&third, size, rng);
        all.push([start.clone(), second, third, last]);
    }
    all.push([start.clone(), start.clone(), start.clone(), start.clone()]);
    let moved = near(&coordinates, 0.7, rng);
    all.push([coordinates.clone(), turned.clone(), coordinates, moved]);
    all
}

#[test]
fn derivatives_at_many_parameters_are_those_at_one() {
    let (mut rng, mut refused) = (Rng::new(733), 0);
    for (n, k) in [
        (2, 1),
        (3, 1),
        (2, 2),
        (3, 2),
        (4, 2),
        (3, 3),
        (4, 3),
        (4, 4),
        (7, 3),
        (12, 5),
    ] {
        for points in special_control_points(n, k, &mut rng) {
            // Some of the widest ones jump.
            let Ok(curve) = GeometricPolynomial::try_from(&points[..]) else {
                refused += 1;
                continue;
            };
            // Outside on one side in the first block of eight, on the other in the last.
            let inside = (0..=20).map(|i| f64::from(i) / 20.0);
            let t: Vec<f64> = [-1.2, -0.4]
                .into_iter()
                .chain(inside)
                .chain([1.3])
                .collect();
            let rows = curve.frame().map_or(n, |frame| frame.ncols());
            for order in 1..=3 {
                let mut work = curve.workspace();
                let mut found: Vec<MatrixJet> =
                    t.iter().map(|_| MatrixJet::zeros(rows, k)).collect();
                curve.jets_into(&t, order, &mut work, &mut found).unwrap();
                let mut exact = MatrixJet::zeros(rows, k);
                for (t, found) in t.iter().zip(&found) {
                    curve
                        .coordinates_into(*t, order, &mut work, &mut exact)
                        .unwrap();
                    for j in 0..=order {
                        let error = (&found.c[j] - &exact.c[j]).norm_l2();
                        let size = exact.c.iter().fold(1.0, |m: f64, c| m.max(c.norm_l2()));
                        assert_within(
                            error,
                            1e-13 * size,
                            &format!("({n}, {k}) at {t}, order {j}"),
                        );
                    }
                }
            }
        }
    }
    assert!(refused <= 15, "{refused} refused");
}

#[test]
fn covariant_derivatives_of_many_columns_and_of_few_are_those_of_the_formulas() {
    let mut rng = Rng::new(739);
    for (n, k) in [(3, 1), (4, 2), (3, 3), (7, 3), (9, 6), (16, 7)] {
        let curve = Boundary::random((n, k), 0.9, 1.2, &mut rng).curve();
        for t in TIMES {
            let d: Vec<Mat<f64>> = (0..4).map(|nu| curve.derivative(t, nu).unwrap()).collect();
            let [s, v, a, b] = [0, 1, 2, 3].map(|nu| d[nu].as_ref());
            let size = d.iter().fold(1.0, |m: f64, x| m.max(frobenius(x.as_ref())));
            let exact = [acceleration(s, v, a), jerk(s, v, a, b)];
            let found = [curve.acceleration(t).unwrap(), curve.jerk(t).unwrap()];
            for (exact, found) in exact.iter().zip(&found) {
                let place = format!("({n}, {k}) at {t}");
                assert_close(found, exact, 1e-14 * size.powi(3), &place);
            }
            let manifold = Stiefel::new(n, k).unwrap();
            let largest = curve.derivative_bounds(Interrupt::NEVER).unwrap();
            let speed = manifold.norm(s, v).unwrap();
            assert!(
                speed <= largest.velocity * (1.0 + 1e-9),
                "({n}, {k}) at {t}"
            );
            let rate = manifold.norm(s, exact[1].as_ref()).unwrap();
            assert!(rate <= largest.jerk * (1.0 + 1e-9), "({n}, {k}) at {t}");
        }
    }
}

#[test]
fn a_point_at_rest_on_a_sphere_has_no_derivatives_at_all() {
    let mut rng = Rng::new(743);
    for n in [1, 2, 3, 10] {
        let point = random_point(n, 1, &mut rng);
        let curve = through(&[point.clone(), point.clone(), point.clone(), point]);
        for nu in 1..=3 {
            let quantity = Quantity::Derivative(nu);
            let values = curve.sample(&TIMES, quantity, Interrupt::NEVER).unwrap();
            assert!(
                values.iter().all(|value| value.norm_max() == 0.0),
                "{n}, {nu}"
            );
        }
    }
}
