//! Geometric polynomials of any degree: the algorithm compared with its definition, the domain of the fast method,
//! branch jumps.

mod common;

use std::f64::consts::PI;

use common::*;
use faer::{Mat, Scale};
use stiefel_rs::{
    Curve, Error, GeometricCubic, GeometricPolynomial, Interrupt, Quantity, QuasiGeodesic, Stiefel,
};

/// De Casteljau's algorithm by its definition, with [`QuasiGeodesic::between`] in every stage.
fn by_definition(points: &[Mat<f64>], t: f64) -> Mat<f64> {
    let mut stage = points.to_vec();
    while stage.len() > 1 {
        stage = stage
            .windows(2)
            .map(|pair| {
                QuasiGeodesic::between(pair[0].as_ref(), pair[1].as_ref())
                    .unwrap()
                    .point(t)
                    .unwrap()
            })
            .collect();
    }
    stage.remove(0)
}

fn polynomial(points: &[Mat<f64>]) -> Result<GeometricPolynomial, Error> {
    GeometricPolynomial::try_from(points)
}

/// Control points, each a step of the given canonical length from the one before.
fn walk((n, k): (usize, usize), degree: usize, step: f64, rng: &mut Rng) -> Vec<Mat<f64>> {
    let mut points = vec![random_point(n, k, rng)];
    for _ in 0..degree {
        let from = points[points.len() - 1].clone();
        points.push(retract(&from, &random_tangent(&from, step, rng)));
    }
    points
}

/// Thirteen parameters, one full block of lanes and a partial one: inside, at the ends, and outside `[0, 1]`.
const TIMES: [f64; 13] = [
    0.0, 1e-300, 1e-9, 0.1, 0.25, 0.5, 0.77, 0.999, 1.0, -0.5, 1.5, 2.5, -3.0,
];

#[test]
fn every_degree_is_the_algorithm_by_its_definition() {
    let mut rng = Rng::new(1);
    let mut worst = Worst::new("polynomial against its definition");
    for size in SIZES.into_iter().filter(|size| *size != (1, 1)) {
        for degree in [1, 2, 3, 5] {
            for step in [0.0, 1e-9, 1e-5, 0.3, 0.9] {
                let points = walk(size, degree, step, &mut rng);
                let curve = polynomial(&points).unwrap();
                let samples = curve
                    .sample(&TIMES, Quantity::Derivative(0), Interrupt::NEVER)
                    .unwrap();
                for (i, &t) in TIMES.iter().enumerate().filter(|(_, t)| t.abs() <= 1.0) {
                    let error = distance(&samples.get(i).to_owned(), &by_definition(&points, t));
                    // The round-off of one stage is a few eps k; stages add up.
                    worst.see(error / (size.1 * degree) as f64, || {
                        format!("{size:?}, degree {degree}, step {step}, t = {t}")
                    });
                }
            }
        }
    }
    worst.assert_at_most(16.0 * EPS);
}

/// Derivatives are computed by the slow method, so order 0 of a jet and the fast position must agree everywhere.
#[test]
fn fast_and_careful_route_agree() {
    let mut rng = Rng::new(2);
    let mut worst = Worst::new("fast against careful route");
    let mut sizes = SIZES.to_vec();
    sizes.extend([(4, 1), (9, 2), (13, 3), (12, 12), (24, 8)]);
    for size in sizes.into_iter().filter(|size| *size != (1, 1)) {
        for step in [1e-12, 1e-3, 0.5, 1.2, 2.0] {
            let points = walk(size, 3, step, &mut rng);
            let Ok(curve) = polynomial(&points) else {
                continue;
            };
            let mut work = curve.workspace();
            let rows = curve.frame().map_or(size.0, |frame| frame.ncols());
            let mut jet = stiefel_rs::linalg::jet::MatrixJet::zeros(rows, size.1);
            for t in [0.0, 0.13, 0.5, 0.81, 1.0] {
                curve.coordinates_into(t, 0, &mut work, &mut jet).unwrap();
                let careful = match curve.frame() {
                    Some(frame) => frame * &jet.c[0],
                    None => jet.c[0].clone(),
                };
                let error = distance(&careful, &curve.point(t).unwrap());
                worst.see(error, || format!("{size:?}, step {step}, t = {t}"));
            }
        }
    }
    worst.assert_at_most(2e-13);
}

#[test]
fn stays_orthonormal_in_every_degree() {
    let mut rng = Rng::new(3);
    let mut worst = Worst::new("orthonormality defect");
    for size in SIZES.into_iter().filter(|size| *size != (1, 1)) {
        for degree in [2, 3, 8] {
            let curve = polynomial(&walk(size, degree, 0.7, &mut rng)).unwrap();
            for i in 0..=40 {
                let point = curve.point(f64::from(i) / 40.0).unwrap();
                worst.see(orthonormality(&point) / (size.1 * degree) as f64, || {
                    format!("{size:?}, degree {degree}")
                });
            }
        }
    }
    worst.assert_at_most(16.0 * EPS);
}

#[test]
fn degree_one_is_the_quasi_geodesic_and_degree_three_the_cubic() {
    let mut rng = Rng::new(4);
    for size in SIZES.into_iter().filter(|size| *size != (1, 1)) {
        let points = walk(size, 3, 0.8, &mut rng);
        let line = polynomial(&points[..2]).unwrap();
        let leg = QuasiGeodesic::between(points[0].as_ref(), points[1].as_ref()).unwrap();
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| points[i].as_ref());
        let cubic = GeometricCubic::from_control_points([a, b, c, d]).unwrap();
        let same = polynomial(&points).unwrap();
        for t in [0.0, 0.3, 1.0] {
            let bound = 16.0 * EPS * size.1 as f64;
            assert_close(
                &line.point(t).unwrap(),
                &leg.point(t).unwrap(),
                bound,
                "degree 1",
            );
            assert_eq!(cubic.point(t).unwrap(), same.point(t).unwrap(), "degree 3");
        }
        assert_eq!(GeometricPolynomial::from(cubic).degree(), 3);
    }
}

/// End velocities are `degree` times those of the outer legs.
#[test]
fn end_velocities_are_those_of_the_outer_legs() {
    let mut rng = Rng::new(5);
    let mut worst = Worst::new("end velocities");
    for size in SIZES.into_iter().filter(|size| *size != (1, 1)) {
        for degree in [2, 4] {
            let points = walk(size, degree, 0.6, &mut rng);
            let curve = polynomial(&points).unwrap();
            let first = QuasiGeodesic::between(points[0].as_ref(), points[1].as_ref()).unwrap();
            let last = QuasiGeodesic::between(points[degree - 1].as_ref(), points[degree].as_ref())
                .unwrap();
            for (t, leg) in [(0.0, first), (1.0, last)] {
                let expected = leg.derivative(t, 1).unwrap() * Scale(degree as f64);
                let error = distance(&curve.derivative(t, 1).unwrap(), &expected);
                worst.see(error, || format!("{size:?}, degree {degree}, t = {t}"));
            }
        }
    }
    worst.assert_at_most(1e-12);
}

/// Near antipodes, near rotations by pi, and near equal cosines of opposite sign, the fast method must leave the result
/// to the slow one.
#[test]
fn edges_of_the_fast_route_are_right() {
    let angle = |a: f64| Mat::from_fn(3, 1, |i, _| [a.cos(), a.sin(), 0.0][i]);
    let mut worst = Worst::new("great circle through control points near antipodes");
    for gap in [1.0, 0.5, 0.46, 0.45, 1e-2, 1e-6, 1e-10] {
        let total = PI - gap;
        let curve = polynomial(&[angle(0.0), angle(total)]).unwrap();
        let quadratic = polynomial(&[angle(0.0), angle(0.5 * total), angle(total)]).unwrap();
        for t in [0.1, 0.5, 0.9] {
            for (name, curve) in [("line", &curve), ("quadratic", &quadratic)] {
                let error = distance(&curve.point(t).unwrap(), &angle(t * total));
                // The direction between points a gap from antipodal is accurate to eps / gap.
                worst.see(error * gap.min(1.0), || {
                    format!("{name}, gap {gap}, t = {t}")
                });
            }
        }
    }
    worst.assert_at_most(4e-15);
    let mut worst = Worst::new("rotations by nearly pi");
    for m in [2, 3, 4, 6] {
        for gap in [0.5, 1e-3, 1e-9] {
            let turn = |t: f64| {
                let mut plane = Mat::<f64>::identity(m, m);
                let (sin, cos) = (t * (PI - gap)).sin_cos();
                plane[(0, 0)] = cos;
                plane[(1, 1)] = cos;
                plane[(1, 0)] = sin;
                plane[(0, 1)] = -sin;
                plane
            };
            let curve = polynomial(&[turn(0.0), turn(0.4), turn(1.0)]).unwrap();
            for t in [0.2, 0.7] {
                let expected = turn(2.0 * 0.4 * t * (1.0 - t) + t * t);
                let error = distance(&curve.point(t).unwrap(), &expected);
                worst.see(error * gap.min(1.0), || {
                    format!("SO({m}), gap {gap}, t = {t}")
                });
            }
        }
    }
    worst.assert_at_most(2e-14);
}

const FAR_SIZES: [(usize, usize); 6] = [(3, 1), (3, 2), (4, 2), (3, 3), (5, 3), (8, 4)];

fn far_points((n, k): (usize, usize), rng: &mut Rng) -> Vec<Mat<f64>> {
    (0..4).map(|_| random_point(n, k, rng)).collect()
}

/// Regression: for distant control points a stage crossed the cut locus inside the interval, and the curve jumped.
#[test]
fn a_curve_that_would_jump_is_refused() {
    let mut rng = Rng::new(6);
    let mut refused = 0;
    for size in FAR_SIZES {
        for _ in 0..600 {
            let points = far_points(size, &mut rng);
            match polynomial(&points) {
                Ok(_) | Err(Error::DifferentComponents { .. } | Error::OutsideLogDomain { .. }) => {
                }
                // Near the ends a stage has little weight, so its jump is small.
                Err(Error::BranchJump { t }) if !(0.05..=0.95).contains(&t) => {}
                Err(Error::BranchJump { t }) => {
                    refused += 1;
                    let [a, b, c, d] =
                        [-3e-4, -1e-4, 1e-4, 3e-4].map(|step| by_definition(&points, t + step));
                    let (jump, beside) = (distance(&b, &c), distance(&a, &b).max(distance(&c, &d)));
                    assert!(
                        jump > 2.0 * beside,
                        "{size:?}: {jump:.2e} at t = {t}, {beside:.2e} beside it, is no jump"
                    );
                }
                Err(error) => panic!("{size:?}: {error}"),
            }
        }
    }
    println!("{refused} refused");
    assert!(refused >= 3, "{refused} refused");
}

/// No step between neighbouring parameters is much larger than the adjacent ones, as for a jump; a fast rotation is
/// allowed.
fn assert_no_jump(curve: &GeometricPolynomial, t: &[f64], small: f64) {
    let samples = curve
        .sample(t, Quantity::Derivative(0), Interrupt::NEVER)
        .unwrap();
    let steps: Vec<f64> = (1..t.len())
        .map(|i| distance(&samples.get(i).to_owned(), &samples.get(i - 1).to_owned()))
        .collect();
    for i in 1..steps.len() - 1 {
        let beside = steps[i - 1].max(steps[i + 1]);
        assert!(
            steps[i] < small || steps[i] < 3.0 * beside,
            "({}, {}): jump of {:.2e} at t = {:.6}, beside {beside:.2e}",
            curve.n(),
            curve.k(),
            steps[i],
            t[i]
        );
    }
}

#[test]
fn no_curve_that_is_made_jumps() {
    let mut rng = Rng::new(8);
    let t: Vec<f64> = (0..=800).map(|i| f64::from(i) / 800.0).collect();
    let mut seen = 0;
    for size in FAR_SIZES {
        for _ in 0..60 {
            let Ok(curve) = polynomial(&far_points(size, &mut rng)) else {
                continue;
            };
            seen += 1;
            assert_no_jump(&curve, &t, 0.05);
        }
    }
    assert!(seen > 200, "only {seen} curves were made");
}

/// Regression: for high degrees a narrow dip of the margin near an end was missed by the grid.
#[test]
fn long_walks_of_high_degree_do_not_jump_near_their_ends() {
    let mut rng = Rng::new(9);
    let near = |i: i32| 0.06 * f64::from(i) / 800.0;
    let t: Vec<f64> = (0..=800).map(near).collect();
    let back: Vec<f64> = t.iter().map(|t| 1.0 - t).collect();
    let manifold = Stiefel::new(5, 2).unwrap();
    let (mut made, mut refused) = (0, 0);
    for i in 0..80 {
        let mut points = vec![random_point(5, 2, &mut rng)];
        for _ in 0..4 + i % 6 {
            let from = points[points.len() - 1].clone();
            // Jumps are caused by the rotation, which is as large as in a projected matrix.
            let g = gaussian(5, 2, &mut rng);
            let velocity = manifold.project_tangent(from.as_ref(), g.as_ref()).unwrap();
            let length = rng.between(2.3, 3.1) / spectral(velocity.as_ref());
            points.push(retract(&from, &(velocity * Scale(length))));
        }
        let Ok(curve) = polynomial(&points) else {
            refused += 1;
            continue;
        };
        made += 1;
        for t in [&t, &back] {
            assert_no_jump(&curve, t, 0.005);
        }
    }
    assert!(made >= 20 && refused >= 5, "{made} made, {refused} refused");
}

/// Up to the largest size for lanes.
#[test]
fn stays_orthonormal_for_many_columns() {
    let mut rng = Rng::new(10);
    let mut worst = Worst::new("orthonormality defect over k degree");
    for (n, k) in [(100, 40), (200, 64), (130, 65)] {
        let curve = polynomial(&walk((n, k), 3, 1.0, &mut rng)).unwrap();
        for t in [0.1, 0.3, 0.5, 0.8] {
            let point = curve.point(t).unwrap();
            worst.see(orthonormality(&point) / (3 * k) as f64, || {
                format!("({n}, {k})")
            });
        }
    }
    worst.assert_at_most(32.0 * EPS);
}

#[test]
fn bad_control_points_are_refused() {
    let mut rng = Rng::new(7);
    let point = random_point(4, 2, &mut rng);
    assert!(matches!(polynomial(&[]), Err(Error::Shape { .. })));
    assert!(matches!(
        polynomial(std::slice::from_ref(&point)),
        Err(Error::Shape { .. })
    ));
    let other = random_point(5, 2, &mut rng);
    assert!(matches!(
        polynomial(&[point.clone(), other]),
        Err(Error::Shape { .. })
    ));
    let mut broken = point.clone();
    broken[(0, 0)] = f64::NAN;
    assert!(matches!(
        polynomial(&[point.clone(), broken]),
        Err(Error::NonFinite { .. })
    ));
    let long = &point * Scale(1.0 + 1e-6);
    match polynomial(&[point.clone(), long]) {
        Err(Error::NotOrthonormal { defect, .. }) => assert_within(defect / 2.83e-6, 1.1, "defect"),
        other => panic!("{other:?}"),
    }
    let x = Mat::from_fn(3, 1, |i, _| [1.0, 0.0, 0.0][i]);
    match polynomial(&[x.clone(), -&x]) {
        Err(Error::NoJoiningCurve { angle }) => assert_within((angle - PI).abs(), 1e-12, "angle"),
        other => panic!("{other:?}"),
    }
}
