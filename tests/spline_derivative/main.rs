//! Derivatives of splines with respect to their data, compared with differences and with their own transposes.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/knots.rs"]
mod knots;

mod bad_input;
mod family;

use common::{Rng, assert_within, frobenius, gaussian, random_orthogonal};
use faer::{Mat, MatRef};
use family::{ALL_ENDS, Ends, Family, difference, dot, entries, sampled};
use stiefel_rs::spline::{Outside, SplineGradient};
use stiefel_rs::{Curve, Interrupt};

/// Spheres, `k < n`, `k = n`, `k = n - 1`; and points that do not span the whole space.
const SHAPES: [(usize, usize); 8] = [
    (2, 1),
    (3, 1),
    (3, 2),
    (3, 3),
    (4, 3),
    (5, 2),
    (4, 4),
    (30, 2),
];

const COUNTS: [usize; 3] = [2, 3, 6];

/// Times in all pieces, unsorted, including knots.
fn times(family: &Family) -> Vec<f64> {
    let (t, last) = (&family.t, family.t.len() - 1);
    let mut times = vec![t[last], t[0], t[1], t[0] + 0.3 * (t[1] - t[0])];
    times.extend(t.windows(2).map(|t| 0.6 * t[0] + 0.4 * t[1]));
    times.push(t[last] - 0.01);
    times
}

fn cases() -> impl Iterator<Item = (String, Family)> {
    let sizes = SHAPES
        .into_iter()
        .flat_map(|shape| COUNTS.map(|count| (shape, count)));
    sizes
        .flat_map(|(shape, count)| ALL_ENDS.map(|ends| (shape, count, ends)))
        // A closed curve through one point is constant.
        .filter(|(_, count, ends)| *ends != Ends::Periodic || *count > 2)
        .map(|(shape, count, ends)| {
            let what = format!("{shape:?}, {count} knots, {ends:?}");
            (what, Family::new(shape, count, ends, 40 + count as u64))
        })
        // 66 dimensions: pieces do not keep displacements.
        .chain(std::iter::once((
            "(12, 12), 3 knots".to_owned(),
            Family::new((12, 12), 3, Ends::Natural, 43),
        )))
}

/// Differences with steps of 2e-3: the solver's 1e-12 divided by the step, and the fifth derivative times 5e-13.
const DIFFERENCE: f64 = 1e-8;

#[test]
fn points_move_as_differences_of_solutions() {
    for (what, family) in cases() {
        let data = family.at(0.0);
        let curve = data.spline();
        // Not at the ends, which the moved interval may not contain.
        let times: Vec<f64> = times(&family)[3..].to_vec();
        let derivative = curve
            .data_derivative(&data.conditions, Interrupt::NEVER)
            .unwrap();
        let found = family.with_variation(|variation| {
            derivative
                .points(variation, &times, Interrupt::NEVER)
                .unwrap()
        });
        let expected = difference(|h| {
            let curve = family.at(h).spline().with_outside(Outside::Continued);
            sampled(&curve, &times)
        });
        let found: Vec<f64> = found.iter().flat_map(entries).collect();
        let size = expected.iter().fold(1.0_f64, |size, x| size.max(x.abs()));
        let error = found.iter().zip(&expected).map(|(a, b)| (a - b).abs());
        let error = error.fold(0.0, f64::max) / size;
        println!("{what}: {error:.1e} of {size:.1}");
        assert_within(error, DIFFERENCE, &what);
    }
}

#[test]
fn pulling_back_is_the_transpose() {
    for (what, family) in cases() {
        let data = family.at(0.0);
        let curve = data.spline();
        let times = times(&family);
        let mut rng = Rng::new(7);
        let (n, k) = data.points[0].shape();
        let cotangents: Vec<Mat<f64>> = times.iter().map(|_| gaussian(n, k, &mut rng)).collect();
        let views: Vec<MatRef<'_, f64>> = cotangents.iter().map(Mat::as_ref).collect();
        let derivative = curve
            .data_derivative(&data.conditions, Interrupt::NEVER)
            .unwrap();
        let moved = family.with_variation(|variation| {
            derivative
                .points(variation, &times, Interrupt::NEVER)
                .unwrap()
        });
        let gradient = derivative
            .pull_back(&times, &views, Interrupt::NEVER)
            .unwrap();
        let products = moved
            .iter()
            .zip(&views)
            .map(|(moved, w)| dot(moved.as_ref(), *w));
        let expected: f64 = products.sum();
        let error = (family.product(&gradient) - expected).abs() / size(&gradient);
        println!("{what}: {error:.1e}");
        // The condition number of the system, below 100, times the round-off of the solution: the curves are accurate
        // to 1e-13.
        assert_within(error, 1e-11, &what);
    }
}

/// The size of all summands.
fn size(gradient: &SplineGradient) -> f64 {
    let points = gradient.points.iter().chain(gradient.ends.iter().flatten());
    let times = gradient.times.iter().map(|x| x.abs()).sum::<f64>();
    1.0 + times + points.map(|x| frobenius(x.as_ref())).sum::<f64>()
}

#[test]
fn the_cost_changes_by_its_gradient() {
    for (what, family) in cases() {
        let data = family.at(0.0);
        let curve = data.spline();
        let gradient = curve
            .cost_gradient(&data.conditions, Interrupt::NEVER)
            .unwrap();
        let found = family.product(&gradient);
        let expected =
            difference(|h| vec![family.at(h).spline().cost(Interrupt::NEVER).unwrap()])[0];
        let error = (found - expected).abs() / (1.0 + expected.abs());
        println!("{what}: {error:.1e} of {expected:.1}");
        assert_within(error, DIFFERENCE, &what);
        let other = curve
            .data_derivative(&data.conditions, Interrupt::NEVER)
            .unwrap()
            .cost_gradient()
            .unwrap();
        let error = (family.product(&other) - found).abs() / size(&gradient);
        assert_within(error, 1e-10, &format!("{what}: with the linear system"));
    }
}

#[test]
fn rotated_data_have_rotated_derivatives() {
    for (what, family) in cases() {
        let n = family.points[0].nrows();
        let rotation = random_orthogonal(n, &mut Rng::new(8));
        let permutation = common::cyclic_permutation(n);
        for q in [rotation, permutation] {
            let other = family.mapped(|x| &q * x);
            let times = [family.t[0] + 0.2, family.t[1] - 0.1];
            let [one, two] = [&family, &other].map(|family| {
                let data = family.at(0.0);
                let curve = data.spline();
                let derivative = curve
                    .data_derivative(&data.conditions, Interrupt::NEVER)
                    .unwrap();
                family.with_variation(|variation| {
                    derivative
                        .points(variation, &times, Interrupt::NEVER)
                        .unwrap()
                })
            });
            for (one, two) in one.iter().zip(&two) {
                let error = frobenius((&q * one - two).as_ref()) / (1.0 + frobenius(one.as_ref()));
                assert_within(error, 1e-10, &what);
            }
        }
    }
}

#[test]
fn rotations_of_all_data_rotate_the_curve() {
    for (what, mut family) in cases() {
        let n = family.points[0].nrows();
        let g = gaussian(n, n, &mut Rng::new(9));
        let turn = &g - g.transpose();
        family.dt.fill(0.0);
        family.ds = family.points.iter().map(|point| &turn * point).collect();
        // The tangent part of the vectors rotates with the points.
        family.shifts = family.vectors.each_ref().map(|v| &turn * v);
        let data = family.at(0.0);
        let curve = data.spline();
        let derivative = curve
            .data_derivative(&data.conditions, Interrupt::NEVER)
            .unwrap();
        let times = times(&family);
        let found = family.with_variation(|variation| {
            derivative
                .points(variation, &times, Interrupt::NEVER)
                .unwrap()
        });
        for (found, t) in found.iter().zip(&times) {
            let expected = &turn * curve.point(*t).unwrap();
            let error = frobenius((found - &expected).as_ref());
            // Splines pass their points to 1e-12, multiplied by the rotation and the condition number of the system,
            // about 10.
            let bound = 1e-11 * frobenius(turn.as_ref());
            assert_within(error, bound, &format!("{what} at {t}"));
        }
    }
}

#[test]
fn equal_points_stand_still_until_they_are_moved_apart() {
    // In flat space, and to first order on every manifold: the natural spline through 0, 1, 0 is 11/16 at 1/2.
    for shape in [(3, 3), (3, 1), (5, 2)] {
        let mut family = Family::new(shape, 3, Ends::Natural, 3);
        family.points = vec![family.points[0].clone(); 3];
        family.t = vec![0.0, 1.0, 2.0];
        family.ds = vec![
            Mat::zeros(shape.0, shape.1),
            family.ds[0].clone(),
            Mat::zeros(shape.0, shape.1),
        ];
        let data = family.at(0.0);
        let curve = data.spline();
        let derivative = curve
            .data_derivative(&data.conditions, Interrupt::NEVER)
            .unwrap();
        let found = family.with_variation(|variation| {
            derivative
                .points(variation, &[0.5, 1.0], Interrupt::NEVER)
                .unwrap()
        });
        for (found, share) in found.iter().zip([11.0 / 16.0, 1.0]) {
            let expected = &family.ds[1] * faer::Scale(share);
            assert_within(
                frobenius((found - expected).as_ref()),
                1e-13,
                &format!("{shape:?}"),
            );
        }
    }
}

#[test]
fn legs_of_very_different_lengths() {
    let mut family = Family::new((3, 3), 5, Ends::Natural, 12);
    family.t = vec![0.0, 1.0, 1.001, 2.0, 12.0];
    let manifold = stiefel_rs::Stiefel::new(3, 3).unwrap();
    let (one, other) = (family.points[1].as_ref(), family.points[2].as_ref());
    let v = manifold.log(one, other).unwrap() * faer::Scale(1e-3);
    family.points[2] = manifold.exp(one, v.as_ref()).unwrap();
    family.ds[2] = common::random_tangent(&family.points[2], 1.0, &mut Rng::new(13));
    let data = family.at(0.0);
    let curve = data.spline();
    let times = [0.5, 1.0005, 1.5, 7.0];
    let cotangents = times.map(|t| gaussian(3, 3, &mut Rng::new((1e4 * t) as u64)));
    let views = cotangents.each_ref().map(|x| x.as_ref());
    let derivative = curve
        .data_derivative(&data.conditions, Interrupt::NEVER)
        .unwrap();
    let moved = family.with_variation(|variation| {
        derivative
            .points(variation, &times, Interrupt::NEVER)
            .unwrap()
    });
    let gradient = derivative
        .pull_back(&times, &views, Interrupt::NEVER)
        .unwrap();
    let expected: f64 = moved
        .iter()
        .zip(views)
        .map(|(moved, w)| dot(moved.as_ref(), w))
        .sum();
    let error = (family.product(&gradient) - expected).abs() / size(&gradient);
    assert_within(error, 1e-11, "the transpose");
}
