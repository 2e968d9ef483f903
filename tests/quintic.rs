//! The quintic with given end accelerations: its data, curves it must reproduce, symmetry, and refusals.

mod common;

use common::*;
use faer::{Mat, Scale};
use stiefel_rs::{Curve, Error, GeometricPolynomial, QuasiGeodesic};

/// Boundary data with end accelerations.
struct Data {
    ends: Boundary,
    a0: Mat<f64>,
    a1: Mat<f64>,
}

impl Data {
    fn random(size: (usize, usize), speed: f64, acceleration: f64, rng: &mut Rng) -> Self {
        let ends = Boundary::random(size, 1.0, speed, rng);
        let a0 = random_tangent(&ends.s0, acceleration, rng);
        let a1 = random_tangent(&ends.s1, acceleration, rng);
        Data { ends, a0, a1 }
    }

    fn curve(&self) -> Result<GeometricPolynomial, Error> {
        let Boundary { s0, v0, s1, v1 } = &self.ends;
        let [s0, v0, a0, s1, v1, a1] = [s0, v0, &self.a0, s1, v1, &self.a1].map(|a| a.as_ref());
        GeometricPolynomial::quintic(s0, v0, a0, s1, v1, a1)
    }

    fn of(all: &[Mat<f64>]) -> Self {
        Data {
            ends: Boundary::of(&all[..4]),
            a0: all[4].clone(),
            a1: all[5].clone(),
        }
    }

    fn all(&self) -> Vec<&Mat<f64>> {
        [&self.ends.all()[..], &[&self.a0, &self.a1]].concat()
    }
}

#[test]
fn meets_points_velocities_and_accelerations() {
    let mut rng = Rng::new(1);
    let mut worst = ["points", "velocities", "accelerations"].map(Worst::new);
    for size in SIZES {
        for (speed, acceleration) in [(0.0, 0.0), (1.0, 0.0), (0.0, 2.0), (1.5, 3.0), (1e-7, 1e-7)]
        {
            let data = Data::random(size, speed, acceleration, &mut rng);
            let curve = data.curve().unwrap();
            assert_eq!(curve.degree(), 5);
            let Boundary { s0, v0, s1, v1 } = &data.ends;
            for (t, s, v, a) in [(0.0, s0, v0, &data.a0), (1.0, s1, v1, &data.a1)] {
                let place =
                    || format!("{size:?}, speed {speed}, acceleration {acceleration}, t = {t}");
                let scale = (5 * size.1) as f64;
                worst[0].see(distance(&curve.point(t).unwrap(), s) / scale, place);
                worst[1].see(distance(&curve.derivative(t, 1).unwrap(), v) / scale, place);
                worst[2].see(distance(&curve.acceleration(t).unwrap(), a) / scale, place);
            }
        }
    }
    // The round-off of a stage is a few eps k, and stages add up; derivatives multiply it by 5 and 20, with
    // cancellation between their parts.
    for (worst, bound) in worst.iter().zip([16.0, 160.0, 1600.0]) {
        worst.assert_at_most(bound * EPS);
    }
}

/// Every polynomial of degree five is the quintic of its own end data.
#[test]
fn end_data_of_a_polynomial_give_its_control_points_back() {
    let mut rng = Rng::new(2);
    let mut worst = Worst::new("control points");
    for size in SIZES.into_iter().filter(|size| *size != (1, 1)) {
        for step in [1e-6, 0.1, 0.4] {
            let mut points = vec![random_point(size.0, size.1, &mut rng)];
            for _ in 0..5 {
                let from = &points[points.len() - 1];
                points.push(retract(from, &random_tangent(from, step, &mut rng)));
            }
            let curve = GeometricPolynomial::try_from(points.as_slice()).unwrap();
            let at = |t, nu| curve.derivative(t, nu).unwrap();
            let data = Data {
                ends: Boundary {
                    s0: at(0.0, 0),
                    v0: at(0.0, 1),
                    s1: at(1.0, 0),
                    v1: at(1.0, 1),
                },
                a0: curve.acceleration(0.0).unwrap(),
                a1: curve.acceleration(1.0).unwrap(),
            };
            for (i, found) in data.curve().unwrap().control_points().iter().enumerate() {
                worst.see(distance(found, &points[i]), || {
                    format!("{size:?}, step {step}, point {i}")
                });
            }
        }
    }
    worst.assert_at_most(1e-12);
}

#[test]
fn end_data_of_a_quasi_geodesic_give_it_back() {
    let mut rng = Rng::new(3);
    let mut worst = Worst::new("quintic against the quasi-geodesic");
    for size in SIZES {
        for speed in [1e-9, 0.5, 2.0] {
            let s0 = random_point(size.0, size.1, &mut rng);
            let v0 = random_tangent(&s0, speed, &mut rng);
            let line = QuasiGeodesic::from_velocity(s0.as_ref(), v0.as_ref()).unwrap();
            let (s1, v1) = (line.point(1.0).unwrap(), line.derivative(1.0, 1).unwrap());
            let ends = Boundary { s0, v0, s1, v1 };
            let [a0, a1] = [0.0, 1.0].map(|t| line.acceleration(t).unwrap());
            let curve = Data { ends, a0, a1 }.curve().unwrap();
            for t in [0.0, 0.2, 0.5, 0.9, 1.0] {
                let error = distance(&curve.point(t).unwrap(), &line.point(t).unwrap());
                worst.see(error, || format!("{size:?}, speed {speed}, t = {t}"));
            }
        }
    }
    worst.assert_at_most(1e-13);
}

#[test]
fn is_equivariant_and_reversible() {
    let mut rng = Rng::new(4);
    let mut worst = Worst::new("reversed");
    for size in SIZES.into_iter().filter(|size| *size != (1, 1)) {
        const TIMES: [f64; 3] = [0.1, 0.5, 0.7];
        let data = Data::random(size, 1.0, 2.0, &mut rng);
        let curve = data.curve().unwrap();
        let points = |a: &[Mat<f64>]| {
            let curve = Data::of(a).curve().unwrap();
            TIMES.map(|t| curve.point(t).unwrap()).to_vec()
        };
        let what = format!("{size:?}");
        assert_equivariant(Actions::Both, &data.all(), points, 1e-13, &what, &mut rng);
        let back = Data {
            ends: Boundary {
                s0: data.ends.s1.clone(),
                v0: -&data.ends.v1,
                s1: data.ends.s0.clone(),
                v1: -&data.ends.v0,
            },
            a0: data.a1.clone(),
            a1: data.a0.clone(),
        };
        let back = back.curve().unwrap();
        for t in TIMES {
            let [point, other] = [curve.point(t), back.point(1.0 - t)].map(Result::unwrap);
            worst.see(distance(&other, &point), || format!("{what}, t = {t}"));
        }
    }
    worst.assert_at_most(1e-13);
}

#[test]
fn data_that_cannot_be_met_are_refused_with_their_size() {
    let mut rng = Rng::new(5);
    for size in [(3, 1), (4, 2), (5, 3), (3, 3), (20, 2)] {
        for acceleration in [1e3, 1e9, 1e160, 1e307] {
            let data = Data::random(size, 1.0, acceleration, &mut rng);
            match data.curve() {
                Err(Error::InvalidArgument {
                    name: "A0", found, ..
                }) => {
                    let relative = found / frobenius(data.a0.as_ref());
                    assert_within((relative - 1.0).abs(), 1e-12, "reported length");
                }
                other => panic!("{size:?}, acceleration {acceleration:e}: {other:?}"),
            }
        }
        let fast = Data::random(size, 60.0, 1.0, &mut rng).curve();
        assert!(
            matches!(fast, Err(Error::InvalidArgument { name: "V0", .. })),
            "{size:?}: {fast:?}"
        );
    }
}

#[test]
fn bad_input_is_refused_with_the_measured_defect() {
    let mut rng = Rng::new(6);
    let size = (5, 2);
    let mut data = Data::random(size, 1.0, 1.0, &mut rng);
    data.a1[(1, 1)] = f64::NAN;
    assert!(matches!(
        data.curve(),
        Err(Error::NonFinite { name: "A1", .. })
    ));
    let mut data = Data::random(size, 1.0, 1.0, &mut rng);
    data.a0 += &data.ends.s0 * Scale(1e-3);
    match data.curve() {
        Err(Error::NotTangent {
            name: "A0", defect, ..
        }) => {
            assert_within(
                (defect / (1e-3 * 2.0_f64.sqrt()) - 1.0).abs(),
                1e-9,
                "defect",
            );
        }
        other => panic!("{other:?}"),
    }
    let mut data = Data::random(size, 1.0, 1.0, &mut rng);
    data.a1 = Mat::zeros(4, 2);
    assert!(matches!(data.curve(), Err(Error::Shape { name: "A1", .. })));
    let mut data = Data::random((3, 3), 1.0, 1.0, &mut rng);
    for part in [&mut data.ends.s1, &mut data.ends.v1, &mut data.a1] {
        for i in 0..3 {
            part[(0, i)] = -part[(0, i)];
        }
    }
    assert!(matches!(
        data.curve(),
        Err(Error::DifferentComponents { n: 3 })
    ));
}
