//! Geodesic polynomials: cases where geodesics are quasi-geodesics, ends, exact derivatives, and the domain.

mod common;

use std::f64::consts::PI;

use common::*;
use faer::{Mat, Scale};
use stiefel_rs::{
    Curve, Error, Geodesic, GeodesicPolynomial, GeometricPolynomial, Interrupt, Quantity, Stiefel,
};

/// Control points, each a geodesic step of the given length from the one before.
fn walk((n, k): (usize, usize), degree: usize, step: f64, rng: &mut Rng) -> Vec<Mat<f64>> {
    let manifold = Stiefel::new(n, k).unwrap();
    let mut points = vec![random_point(n, k, rng)];
    for _ in 0..degree {
        let from = points[points.len() - 1].clone();
        let velocity = random_tangent(&from, step, rng);
        points.push(manifold.exp(from.as_ref(), velocity.as_ref()).unwrap());
    }
    points
}

fn polynomial(points: &[Mat<f64>]) -> Result<GeodesicPolynomial, Error> {
    GeodesicPolynomial::try_from(points)
}

const SHAPES: [(usize, usize); 9] = [
    (3, 1),
    (4, 2),
    (5, 3),
    (6, 6),
    (20, 4),
    (3, 2),
    (7, 6),
    (2, 1),
    (20, 2),
];

/// On spheres and rotation groups geodesics are quasi-geodesics.
#[test]
fn spheres_and_rotations_have_one_kind_of_polynomial() {
    let mut rng = Rng::new(1);
    let mut worst = [0, 1, 2, 3].map(|nu| Worst::new(&format!("derivative {nu}")));
    for size in [(3, 1), (2, 1), (9, 1), (3, 3), (4, 4), (6, 6)] {
        for degree in [1, 2, 3, 4] {
            for step in [1e-9, 0.4, 1.2] {
                let points = walk(size, degree, step, &mut rng);
                let one = polynomial(&points).unwrap();
                let other = GeometricPolynomial::try_from(points.as_slice()).unwrap();
                for t in [0.0, 0.3, 0.5, 1.0] {
                    for (nu, worst) in worst.iter_mut().enumerate() {
                        let expected = other.derivative(t, nu).unwrap();
                        let error = distance(&one.derivative(t, nu).unwrap(), &expected);
                        let scale = 1.0 + frobenius(expected.as_ref());
                        worst.see(error / scale, || {
                            format!("{size:?}, degree {degree}, step {step}, t = {t}")
                        });
                    }
                }
            }
        }
    }
    for (worst, bound) in worst.iter().zip([1e-13, 3e-13, 1e-12, 4e-12]) {
        worst.assert_at_most(bound);
    }
}

#[test]
fn degree_one_is_the_geodesic() {
    let mut rng = Rng::new(2);
    for size in SHAPES {
        let points = walk(size, 1, 1.3, &mut rng);
        let line = polynomial(&points).unwrap();
        let geodesic = Geodesic::between(points[0].as_ref(), points[1].as_ref()).unwrap();
        for t in [0.0, 0.4, 1.0] {
            let (found, expected) = (line.point(t).unwrap(), geodesic.point(t).unwrap());
            assert_close(&found, &expected, 1e-13, &format!("{size:?}, t = {t}"));
        }
    }
}

#[test]
fn meets_its_ends_with_the_velocities_of_the_outer_legs() {
    let mut rng = Rng::new(3);
    let mut worst = Worst::new("end points and velocities");
    for size in SHAPES {
        for degree in [2, 3] {
            let points = walk(size, degree, 0.8, &mut rng);
            let curve = polynomial(&points).unwrap();
            let legs = [0, degree - 1]
                .map(|i| Geodesic::between(points[i].as_ref(), points[i + 1].as_ref()).unwrap());
            for (t, end, leg) in [
                (0.0, &points[0], &legs[0]),
                (1.0, &points[degree], &legs[1]),
            ] {
                worst.see(distance(&curve.point(t).unwrap(), end), || {
                    format!("{size:?}, point")
                });
                let expected = leg.derivative(t, 1).unwrap() * Scale(degree as f64);
                let error = distance(&curve.derivative(t, 1).unwrap(), &expected);
                worst.see(error, || {
                    format!("{size:?}, degree {degree}, velocity at {t}")
                });
            }
        }
    }
    worst.assert_at_most(1e-12);
}

/// Each derivative compared with an eighth-order difference of the previous one.
#[test]
fn derivatives_are_those_of_the_position() {
    let mut rng = Rng::new(4);
    let weights = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
    let mut worst = Worst::new("derivatives against differences, relative");
    for size in SHAPES {
        for step in [0.05, 0.7] {
            let curve = polynomial(&walk(size, 3, step, &mut rng)).unwrap();
            for nu in 1..=3 {
                for t in [0.2, 0.5, 0.9] {
                    let h = 0.01;
                    let mut difference = Mat::zeros(size.0, size.1);
                    for (j, weight) in weights.iter().enumerate() {
                        let shift = h * (j + 1) as f64;
                        let [ahead, behind] =
                            [t + shift, t - shift].map(|t| curve.derivative(t, nu - 1).unwrap());
                        difference += (ahead - behind) * Scale(weight / h);
                    }
                    let exact = curve.derivative(t, nu).unwrap();
                    let scale = frobenius(exact.as_ref()).max(frobenius(difference.as_ref()));
                    let error = distance(&exact, &difference) / (1e-3 + scale);
                    worst.see(error, || {
                        format!("{size:?}, step {step}, nu = {nu}, t = {t}")
                    });
                }
            }
        }
    }
    worst.assert_at_most(1e-9);
}

#[test]
fn stays_orthonormal_and_is_equivariant() {
    let mut rng = Rng::new(5);
    for size in SHAPES {
        let points = walk(size, 3, 1.0, &mut rng);
        let curve = polynomial(&points).unwrap();
        const TIMES: [f64; 4] = [0.0, 0.25, 0.6, 1.0];
        for t in TIMES {
            let point = curve.point(t).unwrap();
            assert_within(orthonormality(&point), 1e-13, "orthonormality");
        }
        let sampled = |a: &[Mat<f64>]| {
            let curve = polynomial(a).unwrap();
            TIMES.map(|t| curve.point(t).unwrap()).to_vec()
        };
        let (points, what) = (points.iter().collect::<Vec<_>>(), format!("{size:?}"));
        assert_equivariant(Actions::Both, &points, sampled, 1e-12, &what, &mut rng);
    }
}

#[test]
fn far_control_points_are_refused_with_their_distance() {
    let mut rng = Rng::new(6);
    let mut refused = 0;
    for _ in 0..20 {
        // The end points of such a walk may be closer along another geodesic, but not always.
        match polynomial(&walk((5, 2), 2, 3.0, &mut rng)) {
            Err(Error::BeyondInjectivity {
                distance, bound, ..
            }) => {
                refused += 1;
                assert!(distance >= bound && (bound - 0.8_f64.sqrt() * PI).abs() < 1e-12);
            }
            Ok(curve) => {
                for pair in curve.control_points().windows(2) {
                    let manifold = Stiefel::new(5, 2).unwrap();
                    let distance = manifold.dist(pair[0].as_ref(), pair[1].as_ref()).unwrap();
                    assert!(distance < 0.8_f64.sqrt() * PI);
                }
            }
            Err(Error::NoConvergence { .. }) => {}
            Err(error) => panic!("{error}"),
        }
    }
    assert!(refused > 0, "none of 20 was refused");
    let x = Mat::from_fn(3, 1, |i, _| [1.0, 0.0, 0.0][i]);
    assert!(matches!(
        polynomial(&[x.clone(), -&x]),
        Err(Error::NoJoiningCurve { .. })
    ));
    assert!(matches!(polynomial(&[x]), Err(Error::Shape { .. })));
    let (a, b) = (identity(3), -identity(3));
    assert!(matches!(
        polynomial(&[a, b]),
        Err(Error::DifferentComponents { .. })
    ));
}

/// De Casteljau's algorithm by its definition, with the geodesics of the manifold in every stage.
fn by_definition(points: &[Mat<f64>], t: f64) -> Mat<f64> {
    let mut stage = points.to_vec();
    while stage.len() > 1 {
        let step = |pair: &[Mat<f64>]| {
            let piece = Geodesic::between(pair[0].as_ref(), pair[1].as_ref()).unwrap();
            piece.point(t).unwrap()
        };
        stage = stage.windows(2).map(step).collect();
    }
    stage.remove(0)
}

/// `St(n, n-1)` is computed with rotations, the other shapes are not.
#[test]
fn every_route_is_the_algorithm_by_its_definition() {
    let mut rng = Rng::new(8);
    let mut worst = Worst::new("polynomial against its definition");
    let mut ends = Worst::new("last control point, through rotations");
    for size in [(3, 2), (2, 1), (4, 3), (7, 6), (5, 4), (4, 2), (5, 3)] {
        for (degree, step) in [(2, 1.0), (3, 0.7), (3, 1e-7), (5, 0.4), (1, 1.0)] {
            let points = walk(size, degree, step, &mut rng);
            let curve = polynomial(&points).unwrap();
            let t: Vec<f64> = (0..11).map(|i| f64::from(i) / 10.0).collect();
            let samples = curve
                .sample(&t, Quantity::Derivative(0), Interrupt::NEVER)
                .unwrap();
            for (found, &t) in samples.iter().zip(&t) {
                let error = distance(&found.to_owned(), &by_definition(&points, t));
                worst.see(error / (size.0 * degree) as f64, || {
                    format!("{size:?}, degree {degree}, step {step}, t = {t}")
                });
            }
            if size.0 == size.1 + 1 {
                let error = distance(&samples.get(10).to_owned(), &points[degree]);
                ends.see(error / (size.0 * degree) as f64, || {
                    format!("{size:?}, degree {degree}, step {step}")
                });
            }
        }
    }
    // A stage of the definition computes a logarithm, to a few n eps; stages add up. Rotations have closed forms.
    worst.assert_at_most(64.0 * EPS);
    ends.assert_at_most(16.0 * EPS);
}

#[test]
fn the_cubic_from_boundary_data_meets_them() {
    let mut rng = Rng::new(9);
    let mut worst = ["points", "velocities"].map(Worst::new);
    for size in SHAPES {
        for speed in [0.0, 1e-8, 1.0, 3.0] {
            let Boundary { s0, v0, s1, v1 } = Boundary::random(size, 0.5, speed, &mut rng);
            let [a, b, c, d] = [&s0, &v0, &s1, &v1].map(|x| x.as_ref());
            let curve = GeodesicPolynomial::from_boundary(a, b, c, d).unwrap();
            for (t, s, v) in [(0.0, &s0, &v0), (1.0, &s1, &v1)] {
                let place = || format!("{size:?}, speed {speed}, t = {t}");
                worst[0].see(distance(&curve.point(t).unwrap(), s), place);
                worst[1].see(distance(&curve.derivative(t, 1).unwrap(), v), place);
            }
        }
    }
    worst[0].assert_at_most(1e-13);
    worst[1].assert_at_most(1e-12);
}

#[test]
fn end_velocities_beyond_the_injectivity_radius_are_refused() {
    let mut rng = Rng::new(10);
    for size in [(3, 2), (4, 2), (3, 1), (3, 3)] {
        for speed in [9.6, 1e3, 1e200] {
            let Boundary { s0, v0, s1, v1 } = Boundary::random(size, 0.5, 1.0, &mut rng);
            let v1 = v1 * Scale(speed);
            let [a, b, c, d] = [&s0, &v0, &s1, &v1].map(|x| x.as_ref());
            match GeodesicPolynomial::from_boundary(a, b, c, d) {
                Err(Error::InvalidArgument {
                    name: "V1", found, ..
                }) => {
                    assert_within((found / speed - 1.0).abs(), 1e-12, "speed");
                }
                other => panic!("{size:?}, speed {speed:e}: {other:?}"),
            }
        }
    }
}
