//! Geometric cubics: end conditions, agreement with the paper's algorithm, derivatives, and sampling.

mod common;

use std::f64::consts::PI;

use common::*;
use faer::{Mat, Scale};
use stiefel_rs::{Curve, Error, GeometricCubic, Interrupt, Quantity, orthogonal_log, skew_exp};

const TIMES: [f64; 6] = [0.0, 0.1, 0.37, 0.5, 0.8, 1.0];

// -------------------------------------------------------------- end conditions

#[test]
fn meets_end_points_and_end_velocities() {
    let mut rng = Rng::new(1);
    let mut worst = Worst::new("end points and end velocities, relative to 1 + |V|");
    for size in SIZES.into_iter().filter(|size| *size != (1, 1)) {
        for (distance_, speed) in [
            (1.0, 0.0),
            (1e-9, 1e-9),
            (0.0, 1.0),
            (1.0, 1.0),
            (2.5, 2.0),
            (1.0, 4.5),
        ] {
            let data = Boundary::random(size, distance_, speed, &mut rng);
            let curve = data.curve();
            for (t, nu, expected) in [
                (0.0, 0, &data.s0),
                (0.0, 1, &data.v0),
                (1.0, 0, &data.s1),
                (1.0, 1, &data.v1),
            ] {
                let error = distance(&curve.derivative(t, nu).unwrap(), expected) / (1.0 + speed);
                worst.see(error, || {
                    format!("{size:?}, distance {distance_}, speed {speed}, t = {t}, nu = {nu}")
                });
            }
        }
    }
    worst.assert_at_most(1e-13);
}

/// Found: an outer leg longer than the principal quasi-geodesic between its ends gave a curve of another velocity.
#[test]
fn meets_fast_end_velocities_or_refuses_them() {
    let mut rng = Rng::new(9);
    let mut worst = Worst::new("fast end velocities, relative to |V|");
    let (mut met, mut refused) = (0, 0);
    for size in SIZES.into_iter().filter(|size| *size != (1, 1)) {
        for speed in [6.0, 9.0, 10.0, 20.0, 50.0, 1e3] {
            let data = Boundary::random(size, 1.0, speed, &mut rng);
            let parts = [&data.s0, &data.v0, &data.s1, &data.v1].map(|p| p.as_ref());
            match GeometricCubic::from_boundary(parts[0], parts[1], parts[2], parts[3]) {
                Ok(curve) => {
                    met += 1;
                    for (t, expected) in [(0.0, &data.v0), (1.0, &data.v1)] {
                        let error = distance(&curve.derivative(t, 1).unwrap(), expected) / speed;
                        worst.see(error, || format!("{size:?}, speed {speed}, t = {t}"));
                    }
                }
                Err(Error::InvalidArgument {
                    name: "V0" | "V1",
                    found,
                    ..
                }) => {
                    refused += 1;
                    assert_within(
                        (found / speed - 1.0).abs(),
                        0.5,
                        "reported length (Frobenius, not canonical)",
                    );
                }
                Err(error) => panic!("{size:?}, speed {speed}: {error}"),
            }
        }
    }
    println!("{met} met, {refused} refused");
    assert!(
        met >= 13 && refused >= 13,
        "{met} met, {refused} refused: one of the two was never seen"
    );
    worst.assert_at_most(1e-12);
}

#[test]
fn meets_end_velocities_on_the_sphere_below_three_pi() {
    let mut rng = Rng::new(10);
    for (speed, meets) in [
        (9.0, true),
        (3.0 * PI - 1e-3, true),
        (3.0 * PI + 1e-3, false),
    ] {
        let data = Boundary::random((3, 1), 1.0, speed, &mut rng);
        let parts = [&data.s0, &data.v0, &data.s1, &data.v1].map(|p| p.as_ref());
        let curve = GeometricCubic::from_boundary(parts[0], parts[1], parts[2], parts[3]);
        assert_eq!(curve.is_ok(), meets, "speed {speed}: {:?}", curve.err());
    }
}

#[test]
fn control_points_are_retractions_of_a_third_of_the_velocities() {
    let mut rng = Rng::new(2);
    for size in SIZES {
        let data = Boundary::random(size, 1.0, 1.5, &mut rng);
        let curve = data.curve();
        let inner1 = retract(&data.s0, &(&data.v0 * Scale(1.0 / 3.0)));
        let inner2 = retract(&data.s1, &(&data.v1 * Scale(-1.0 / 3.0)));
        let [p0, p1, p2, p3] = &curve.control_points();
        for (found, expected) in [(p0, &data.s0), (p1, &inner1), (p2, &inner2), (p3, &data.s1)] {
            assert_close(
                found,
                expected,
                8.0 * size.0 as f64 * EPS,
                &format!("control point, {size:?}"),
            );
        }
    }
}

#[test]
fn from_control_points_is_from_boundary() {
    let mut rng = Rng::new(3);
    let mut worst = Worst::new("from_control_points - from_boundary");
    for size in SIZES {
        let curve = Boundary::random(size, 1.0, 1.5, &mut rng).curve();
        let again = through(&curve.control_points());
        for t in TIMES {
            worst.see(
                distance(&curve.point(t).unwrap(), &again.point(t).unwrap()),
                || format!("{size:?}, t = {t}"),
            );
        }
    }
    worst.assert_at_most(1e-13);
}

#[test]
fn stays_orthonormal() {
    let mut rng = Rng::new(4);
    let mut worst = Worst::new("orthonormality");
    for size in SIZES {
        let curve = Boundary::random(size, 1.5, 2.0, &mut rng).curve();
        for step in -10..=60 {
            let t = f64::from(step) / 50.0;
            worst.see(orthonormality(&curve.point(t).unwrap()), || {
                format!("{size:?}, t = {t}")
            });
        }
    }
    worst.assert_at_most(1e-13);
}

// ---------------------------------------------------------- the paper's algorithm

/// The paper's pair `(X, Omega)` that takes `S0` to `S1` (Proposition 1), with `n x n` matrices.
fn paper_pair(s0: &Mat<f64>, s1: &Mat<f64>) -> (Mat<f64>, Mat<f64>) {
    let k = s0.ncols();
    let svd = (s0.transpose() * s1).svd().unwrap();
    let (u, z) = (svd.U(), svd.V());
    let mut directions = project_off(s0, &(s1 * z));
    for i in 0..k {
        let sine = frobenius(directions.as_ref().subcols(i, 1));
        let theta = sine.atan2(svd.S()[i]);
        for row in 0..s0.nrows() {
            directions[(row, i)] *= if sine > 0.0 { theta / sine } else { 1.0 };
        }
    }
    let normal = directions * u.transpose();
    let x = &normal * s0.transpose() - s0 * normal.transpose();
    (x, orthogonal_log((u * z.transpose()).as_ref()).unwrap())
}

fn paper_step(s: &Mat<f64>, (x, omega): &(Mat<f64>, Mat<f64>), t: f64) -> Mat<f64> {
    // X of the paper's formula is skew only to round-off; SKEW_TOLERANCE is relative to its norm, which may be small.
    let exp = |a: &Mat<f64>| skew_exp(((a - a.transpose()) * Scale(0.5 * t)).as_ref()).unwrap();
    exp(x) * s * exp(omega)
}

/// `X_0 .. X_5`, `Omega_0 .. Omega_5` with explicit exponentials.
fn paper_curve(points: &[Mat<f64>; 4], t: f64) -> Mat<f64> {
    let [s0, s1, s2, s3] = points;
    let b01 = paper_step(s0, &paper_pair(s0, s1), t);
    let b12 = paper_step(s1, &paper_pair(s1, s2), t);
    let b23 = paper_step(s2, &paper_pair(s2, s3), t);
    let b012 = paper_step(&b01, &paper_pair(&b01, &b12), t);
    let b123 = paper_step(&b12, &paper_pair(&b12, &b23), t);
    paper_step(&b012, &paper_pair(&b012, &b123), t)
}

#[test]
fn equals_the_papers_algorithm_with_n_by_n_matrices() {
    let mut rng = Rng::new(5);
    let mut worst = Worst::new("curve - paper's algorithm");
    for size in SIZES {
        for (distance_, speed) in [(0.1, 0.1), (0.5, 0.5), (0.8, 0.8)] {
            let curve = Boundary::random(size, distance_, speed, &mut rng).curve();
            for t in TIMES {
                let error = distance(
                    &curve.point(t).unwrap(),
                    &paper_curve(&curve.control_points(), t),
                );
                worst.see(error, || format!("{size:?}, distance {distance_}, t = {t}"));
            }
        }
    }
    worst.assert_at_most(1e-13);
}

#[test]
fn lives_in_the_span_of_its_data() {
    let mut rng = Rng::new(6);
    for order in [0, 1, 2, 3] {
        let low = Boundary::random((8, 2), 1.2, 1.5, &mut rng);
        let basis = random_point(20, 8, &mut rng);
        let high = low.mapped(|a| &basis * a).curve();
        let low = low.curve();
        assert!(
            low.frame().is_none() && high.frame().is_some(),
            "(20, 2) is reduced, (8, 2) is not"
        );
        for t in TIMES {
            let expected = &basis * low.derivative(t, order).unwrap();
            let bound = 2e-13 * 10.0_f64.powi(order as i32).min(100.0);
            let found = high.derivative(t, order).unwrap();
            assert_close(
                &found,
                &expected,
                bound,
                &format!("St(20, 2) - E St(8, 2), t = {t}, nu = {order}"),
            );
        }
    }
}

#[test]
fn is_equivariant_under_both_orthogonal_actions() {
    let mut rng = Rng::new(7);
    let mut worst = Worst::new("A curve B - curve of A data B");
    for size in SIZES {
        let data = Boundary::random(size, 1.0, 1.0, &mut rng);
        let (a, b) = (
            random_orthogonal(size.0, &mut rng),
            random_orthogonal(size.1, &mut rng),
        );
        let moved = data.mapped(|x| &a * x * &b).curve();
        for t in TIMES {
            let error = distance(
                &(&a * data.curve().point(t).unwrap() * &b),
                &moved.point(t).unwrap(),
            );
            worst.see(error, || format!("{size:?}, t = {t}"));
        }
    }
    worst.assert_at_most(1e-13);
}

/// Each stage is: `between` of exchanged points runs backwards.
#[test]
fn runs_backwards_with_reversed_data() {
    let mut rng = Rng::new(8);
    let mut worst = Worst::new("curve(t) - reversed data(1 - t)");
    for size in SIZES {
        let data = Boundary::random(size, 1.0, 1.0, &mut rng);
        let minus = |v: &Mat<f64>| v * Scale(-1.0);
        let back = Boundary {
            s0: data.s1.clone(),
            v0: minus(&data.v1),
            s1: data.s0.clone(),
            v1: minus(&data.v0),
        };
        let (curve, back) = (data.curve(), back.curve());
        for t in TIMES {
            let error = distance(&curve.point(t).unwrap(), &back.point(1.0 - t).unwrap());
            worst.see(error, || format!("{size:?}, t = {t}"));
        }
    }
    worst.assert_at_most(1e-13);
}

// --------------------------------------------------------------------- sampling

const QUANTITIES: [Quantity; 6] = [
    Quantity::Derivative(0),
    Quantity::Derivative(1),
    Quantity::Derivative(2),
    Quantity::Derivative(3),
    Quantity::Acceleration,
    Quantity::Jerk,
];

fn many_times(count: usize) -> Vec<f64> {
    (0..count).map(|i| i as f64 / count as f64).collect()
}

#[test]
fn sampling_does_not_depend_on_the_number_of_threads() {
    let mut rng = Rng::new(41);
    let t = many_times(64 * 2 + 17);
    for size in [(3, 1), (4, 2), (20, 2), (3, 3)] {
        let curve = Boundary::random(size, 1.0, 1.0, &mut rng).curve();
        for quantity in QUANTITIES {
            let [one, many] = [1, 7].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .unwrap();
                pool.install(|| curve.sample(&t, quantity, Interrupt::NEVER))
                    .unwrap()
            });
            let bits = |x: stiefel_rs::curve::Samples| {
                x.into_entries()
                    .into_iter()
                    .map(f64::to_bits)
                    .collect::<Vec<_>>()
            };
            assert_eq!(bits(one), bits(many), "{size:?}, {quantity:?}");
        }
    }
}

#[test]
fn sampling_is_evaluation_at_each_parameter() {
    let mut rng = Rng::new(42);
    let t = many_times(80);
    for size in [(3, 1), (4, 2), (20, 2), (3, 3)] {
        let curve = Boundary::random(size, 1.0, 1.0, &mut rng).curve();
        for nu in 0..=3 {
            let samples = curve
                .sample(&t, Quantity::Derivative(nu), Interrupt::NEVER)
                .unwrap();
            assert_eq!(samples.len(), t.len());
            for (t, sample) in t.iter().zip(samples.iter()) {
                let alone = curve.derivative(*t, nu).unwrap();
                // The lift of a block may round differently from that of one point.
                let bound = if curve.frame().is_none() {
                    0.0
                } else {
                    16.0 * EPS * (1.0 + frobenius(alone.as_ref()))
                };
                assert_close(
                    &sample.to_owned(),
                    &alone,
                    bound,
                    &format!("{size:?}, t = {t}, nu = {nu}"),
                );
            }
        }
    }
}

#[test]
fn no_parameters_give_no_samples() {
    let curve = Boundary::random((4, 2), 1.0, 1.0, &mut Rng::new(43)).curve();
    let samples = curve.sample(&[], Quantity::Jerk, Interrupt::NEVER).unwrap();
    assert!(samples.is_empty() && samples.iter().count() == 0);
}

// -------------------------------------------------------------------- bad input

#[test]
fn bad_parameters_are_refused() {
    let curve = Boundary::random((4, 2), 1.0, 1.0, &mut Rng::new(51)).curve();
    let sample = |t: &[f64], quantity| curve.sample(t, quantity, Interrupt::NEVER).err();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = sample(&[0.0, 0.5, bad], Quantity::Derivative(0));
        assert_eq!(
            error,
            Some(Error::NonFinite {
                name: "t",
                index: 2
            })
        );
        assert_eq!(
            curve.point(bad).err(),
            Some(Error::NonFinite {
                name: "t",
                index: 0
            })
        );
    }
    for t in [&[0.5][..], &[]] {
        let error = sample(t, Quantity::Derivative(4));
        assert!(
            matches!(
                error,
                Some(Error::InvalidArgument {
                    name: "nu",
                    found: 4.0,
                    ..
                })
            ),
            "{error:?}"
        );
    }
    let stopped = curve
        .sample(&[0.5], Quantity::Derivative(0), Interrupt::new(&|| true))
        .err();
    assert!(
        matches!(stopped, Some(Error::Interrupted { .. })),
        "{stopped:?}"
    );
}

#[test]
fn bad_boundary_data_are_refused() {
    let data = Boundary::random((4, 2), 1.0, 1.0, &mut Rng::new(52));
    let parts = [&data.s0, &data.v0, &data.s1, &data.v1];
    let with = |at: usize, replacement: Mat<f64>| {
        let mut parts = parts.map(|p| p.clone());
        parts[at] = replacement;
        let [s0, v0, s1, v1] = parts.each_ref().map(|p| p.as_ref());
        GeometricCubic::from_boundary(s0, v0, s1, v1).err()
    };
    for (at, expected) in ["S0", "V0", "S1", "V1"].into_iter().enumerate() {
        for bad in [f64::NAN, f64::INFINITY] {
            let error = with(at, parts[at] * Scale(bad));
            assert!(
                matches!(error, Some(Error::NonFinite { name, .. }) if name == expected),
                "{expected}: {error:?}"
            );
        }
        if at > 0 {
            let error = with(at, Mat::zeros(5, 2));
            assert!(
                matches!(error, Some(Error::Shape { name, .. }) if name == expected),
                "{expected}: {error:?}"
            );
        }
    }
    let error = with(0, Mat::zeros(2, 4));
    assert!(
        matches!(error, Some(Error::Shape { name: "S0", .. })),
        "{error:?}"
    );
    for (at, expected) in [(0, "S0"), (2, "S1")] {
        let error = with(at, parts[at] * Scale(1.0 + 1e-6));
        assert!(
            matches!(error, Some(Error::NotOrthonormal { name, .. }) if name == expected),
            "{error:?}"
        );
    }
    for (at, point, expected) in [(1, &data.s0, "V0"), (3, &data.s1, "V1")] {
        let error = with(at, parts[at] + point * Scale(1e-6));
        assert!(
            matches!(error, Some(Error::NotTangent { name, .. }) if name == expected),
            "{error:?}"
        );
    }
}

#[test]
fn bad_control_points_are_refused() {
    let points = Boundary::random((4, 2), 1.0, 1.0, &mut Rng::new(53))
        .curve()
        .control_points();
    let with = |replacement: Mat<f64>| {
        let [a, b, _, d] = points.each_ref().map(|p| p.as_ref());
        GeometricCubic::from_control_points([a, b, replacement.as_ref(), d]).err()
    };
    assert!(matches!(
        with(&points[2] * Scale(f64::NAN)),
        Some(Error::NonFinite {
            name: "control points",
            ..
        })
    ));
    assert!(matches!(
        with(&points[2] * Scale(1.5)),
        Some(Error::NotOrthonormal {
            name: "control points",
            ..
        })
    ));
    assert!(matches!(
        with(Mat::zeros(4, 3)),
        Some(Error::Shape {
            name: "control points",
            ..
        })
    ));
    let three = GeometricCubic::try_from(&points[..3]).err();
    assert!(
        matches!(
            three,
            Some(Error::Shape {
                name: "control points",
                ..
            })
        ),
        "{three:?}"
    );
    let sphere = random_point(3, 1, &mut Rng::new(54));
    let opposite = -&sphere;
    let error = GeometricCubic::from_control_points(
        [&sphere, &opposite, &sphere, &sphere].map(|p| p.as_ref()),
    )
    .err();
    assert!(
        matches!(error, Some(Error::NoJoiningCurve { .. })),
        "{error:?}"
    );
}
