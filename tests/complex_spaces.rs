//! Splines and cubics of complex frames and subspaces, solved in complex unknowns, compared with those of the embedded
//! real matrices.

mod common;

use common::*;
use faer::{Mat, MatRef, Scale};
use stiefel_rs::cubic::{BoundaryOptions, RiemannianCubic, SearchOptions, solve_boundary};
use stiefel_rs::linalg::complex_embedding::{embed, embedding_defect, nearest_embedded};
use stiefel_rs::linalg::decomp::unitary_q;
use stiefel_rs::spline::{
    EndCondition, EndConditions, SmoothingOptions, SplineOptions, cubic_spline, smoothing_spline,
};
use stiefel_rs::{Curve, Error, Grassmann, Interrupt, Quotient, ScalarField};

/// Complex `(n, k)`: a circle, spheres, unitary groups, one column less than these, others.
const SHAPES: [(usize, usize); 8] = [
    (1, 1),
    (2, 1),
    (3, 1),
    (2, 2),
    (3, 2),
    (4, 2),
    (3, 3),
    (6, 2),
];

fn complex(n: usize, k: usize, rng: &mut Rng) -> Mat<f64> {
    let [re, im] = [(); 2].map(|()| gaussian(n, k, rng));
    embed(Mat::from_fn(n, k, |i, j| faer::c64::new(re[(i, j)], im[(i, j)])).as_ref())
}

fn point(n: usize, k: usize, rng: &mut Rng) -> Mat<f64> {
    let a = complex(n, k, rng);
    let a = Mat::from_fn(n, k, |i, j| faer::c64::new(a[(i, j)], a[(n + i, j)]));
    embed(unitary_q(a.as_ref(), false).as_ref())
}

/// A tangent vector of the given length, horizontal for subspaces.
fn tangent(quotient: Quotient, s: &Mat<f64>, length: f64, rng: &mut Rng) -> Mat<f64> {
    let (n, k) = (s.nrows() / 2, s.ncols() / 2);
    let a = complex(n, k, rng);
    let inner = s.transpose() * &a;
    let v = match quotient {
        Quotient::Frames => a - s * (&inner + inner.transpose()) * Scale(0.5),
        Quotient::Subspaces => a - s * inner,
    };
    let norm = v.norm_l2();
    if norm > 1e-12 {
        v * Scale(length / norm)
    } else {
        v
    }
}

fn moved(quotient: Quotient, s: &Mat<f64>, v: &Mat<f64>) -> Mat<f64> {
    let (n, k) = s.shape();
    let moved = match quotient {
        Quotient::Frames => retract(s, v),
        Quotient::Subspaces => Grassmann::new(n, k)
            .unwrap()
            .exp(s.as_ref(), v.as_ref())
            .unwrap(),
    };
    nearest_embedded(moved.as_ref()).unwrap()
}

/// Points at the given distance, in units of the embedded metric, at uneven times.
fn walk(
    quotient: Quotient,
    (n, k): (usize, usize),
    count: usize,
    step: f64,
) -> (Vec<f64>, Vec<Mat<f64>>) {
    let mut rng = Rng::new(7 + n as u64);
    let mut points = vec![point(n, k, &mut rng)];
    for i in 1..count {
        let v = tangent(quotient, &points[i - 1], step, &mut rng);
        points.push(moved(quotient, &points[i - 1], &v));
    }
    let t = (0..count)
        .map(|i| i as f64 + 0.3 * (i % 3) as f64)
        .collect();
    (t, points)
}

fn views(points: &[Mat<f64>]) -> Vec<MatRef<'_, f64>> {
    points.iter().map(Mat::as_ref).collect()
}

/// Distance of two points: of frames, or of the spans of bases.
fn apart(quotient: Quotient, a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    match quotient {
        Quotient::Frames => (a - b).norm_l2(),
        Quotient::Subspaces => (a * a.transpose() - b * b.transpose()).norm_l2(),
    }
}

fn kinds() -> impl Iterator<Item = (Quotient, (usize, usize))> {
    let frames = SHAPES.map(|shape| (Quotient::Frames, shape));
    let subspaces = SHAPES.into_iter().filter(|(n, k)| n > k);
    frames
        .into_iter()
        .chain(subspaces.map(|shape| (Quotient::Subspaces, shape)))
}

#[test]
fn splines_are_those_of_the_embedded_matrices() {
    // Legs of St(9, 2) have other coordinates than its points.
    for (quotient, shape) in kinds().chain([(Quotient::Frames, (9, 2))]) {
        let (t, mut points) = walk(quotient, shape, 6, 0.9);
        let mut rng = Rng::new(3);
        let last = points.len() - 1;
        let vector = |knot: usize, rng: &mut Rng| tangent(quotient, &points[knot], 0.8, rng);
        let given = EndConditions::Each(Box::new([
            EndCondition::Velocity(vector(0, &mut rng)),
            EndCondition::Acceleration(vector(last, &mut rng)),
        ]));
        for (name, ends) in [
            ("natural", EndConditions::Natural),
            ("given", given),
            ("periodic", EndConditions::Periodic),
        ] {
            if name == "periodic" {
                points[last] = points[0].clone();
            }
            for tension in [0.0, 1.5] {
                let spline = |field| {
                    let options = SplineOptions {
                        quotient,
                        field,
                        tension,
                        ..SplineOptions::default()
                    };
                    match cubic_spline(&t, &views(&points), &ends, &options, Interrupt::NEVER) {
                        Ok((curve, _)) => curve,
                        Err(e) => panic!("{quotient:?} {shape:?} {name} {tension} {field:?}: {e}"),
                    }
                };
                let [native, oracle] = [ScalarField::Complex, ScalarField::Real].map(spline);
                for i in 0..=20 {
                    let at = t[last] * i as f64 / 20.0;
                    let [a, b] = [&native, &oracle].map(|curve| curve.point(at).unwrap());
                    let off = apart(quotient, &a, &b);
                    assert!(
                        off < 1e-10,
                        "{quotient:?} {shape:?} {name} {tension}: {off:e}"
                    );
                    assert!(
                        embedding_defect(a.as_ref()) < 1e-12,
                        "{quotient:?} {shape:?} {name}"
                    );
                }
                for knot in &t[1..last] {
                    let [before, after] =
                        [-1e-9, 1e-9].map(|h| native.acceleration(knot + h).unwrap());
                    assert!(
                        apart(Quotient::Frames, &before, &after) < 1e-7,
                        "{shape:?} {name}"
                    );
                }
                let [a, b] = [&native, &oracle].map(|curve| curve.cost(Interrupt::NEVER).unwrap());
                assert!(
                    (a - b).abs() < 1e-9 * (1.0 + b),
                    "{shape:?} {name}: {a} {b}"
                );
            }
        }
    }
}

#[test]
fn splines_of_many_unknowns_are_those_of_the_embedded_matrices() {
    for (quotient, shape) in [
        (Quotient::Frames, (40, 3)),
        (Quotient::Frames, (9, 2)),
        (Quotient::Frames, (12, 2)),
        (Quotient::Frames, (14, 4)),
        (Quotient::Frames, (9, 1)),
        (Quotient::Frames, (7, 7)),
        (Quotient::Frames, (8, 7)),
        (Quotient::Subspaces, (9, 4)),
        (Quotient::Subspaces, (11, 2)),
        (Quotient::Subspaces, (40, 3)),
    ] {
        let (t, points) = walk(quotient, shape, 8, 0.6);
        for tension in [0.0, 0.8] {
            let spline = |field| {
                let options = SplineOptions {
                    quotient,
                    field,
                    tension,
                    ..SplineOptions::default()
                };
                cubic_spline(
                    &t,
                    &views(&points),
                    &EndConditions::Natural,
                    &options,
                    Interrupt::NEVER,
                )
                .unwrap()
                .0
            };
            let [native, oracle] = [ScalarField::Complex, ScalarField::Real].map(spline);
            for i in 0..=14 {
                let at = t[t.len() - 1] * i as f64 / 14.0;
                let [a, b] = [&native, &oracle].map(|curve| curve.point(at).unwrap());
                let off = apart(quotient, &a, &b);
                assert!(off < 1e-10, "{quotient:?} {shape:?} {tension}: {off:e}");
                let defect = embedding_defect(a.as_ref());
                assert!(defect < 1e-12, "{quotient:?} {shape:?}: {defect:e}");
            }
        }
    }
}

#[test]
fn smoothing_splines_are_those_of_the_embedded_matrices() {
    for (quotient, shape) in kinds() {
        let (t, points) = walk(quotient, shape, 7, 0.6);
        for lambda in [Some(0.3), None] {
            let fit = |field| {
                let options = SmoothingOptions {
                    lambda,
                    quotient,
                    field,
                    ..SmoothingOptions::default()
                };
                smoothing_spline(&t, &views(&points), None, &options, Interrupt::NEVER)
                    .unwrap_or_else(|e| panic!("{quotient:?} {shape:?} {lambda:?} {field:?}: {e}"))
            };
            let [native, oracle] = [ScalarField::Complex, ScalarField::Real].map(fit);
            let relative = |a: f64, b: f64| (a - b).abs() / (1e-3 + b.abs());
            assert!(
                relative(native.lambda, oracle.lambda) < 1e-6,
                "{quotient:?} {shape:?}"
            );
            assert!(
                relative(native.misfit, oracle.misfit) < 1e-6,
                "{quotient:?} {shape:?}"
            );
            for i in 0..=10 {
                let at = t[t.len() - 1] * i as f64 / 10.0;
                let [a, b] = [&native, &oracle].map(|fit| fit.curve.point(at).unwrap());
                let off = apart(quotient, &a, &b);
                assert!(off < 1e-7, "{quotient:?} {shape:?} {lambda:?}: {off:e}");
            }
        }
    }
}

/// Boundary data, near or distant.
fn problem(quotient: Quotient, (n, k): (usize, usize), far: f64, seed: u64) -> [Mat<f64>; 4] {
    let mut rng = Rng::new(seed);
    let s0 = point(n, k, &mut rng);
    let v = tangent(quotient, &s0, far, &mut rng);
    let s1 = moved(quotient, &s0, &v);
    let v0 = tangent(quotient, &s0, 2.0 * far, &mut rng);
    let v1 = tangent(quotient, &s1, 2.0 * far, &mut rng);
    [s0, v0, s1, v1]
}

#[test]
fn cubics_between_ends_are_stationary_and_no_dearer_than_embedded_ones() {
    for (quotient, shape) in kinds() {
        for (far, seed) in [(0.7, 1), (1.2, 2), (2.2, 3)] {
            // Beyond a right angle, no unique geodesic joins subspaces.
            let far = if quotient == Quotient::Subspaces {
                0.5 * far
            } else {
                far
            };
            let data = problem(quotient, shape, far, seed);
            let [s0, v0, s1, v1] = data.each_ref().map(Mat::as_ref);
            let solve = |field| {
                let options = BoundaryOptions {
                    field,
                    quotient,
                    ..BoundaryOptions::default()
                };
                RiemannianCubic::from_boundary(s0, v0, s1, v1, &options, Interrupt::NEVER)
                    .unwrap_or_else(|e| panic!("{quotient:?} {shape:?} {far} {field:?}: {e}"))
            };
            let [native, oracle] = [ScalarField::Complex, ScalarField::Real].map(solve);
            let name = format!("{quotient:?} {shape:?} {far}");
            let [a, b] = [&native, &oracle].map(|curve| curve.cost(Interrupt::NEVER).unwrap());
            // Another solution of the same cost is equally good.
            assert!(a <= b * (1.0 + 1e-9), "{name}: {a} {b}");
            let end = native.point(1.0).unwrap();
            assert!(apart(quotient, &end, &data[2]) < 1e-11, "{name}");
            assert!(
                embedding_defect(native.point(0.5).unwrap().as_ref()) < 1e-11,
                "{name}"
            );
            let speed = native.derivative(1.0, 1).unwrap().norm_l2();
            assert!((speed - data[3].norm_l2()).abs() < 1e-10, "{name}");
        }
    }
}

/// The defect of the curve's end conditions.
fn missed(quotient: Quotient, curve: &RiemannianCubic, data: &[Mat<f64>; 4]) -> f64 {
    let end = apart(quotient, &curve.point(1.0).unwrap(), &data[2]);
    let speed = curve.derivative(1.0, 1).unwrap().norm_l2();
    end + (speed - data[3].norm_l2()).abs() + embedding_defect(curve.point(0.4).unwrap().as_ref())
}

#[test]
fn cubics_in_tension_and_near_guesses_end_where_they_should() {
    for (quotient, shape) in kinds() {
        let data = problem(quotient, shape, 0.6, 4);
        let [s0, v0, s1, v1] = data.each_ref().map(Mat::as_ref);
        let mut rng = Rng::new(6);
        let guess = [(); 2].map(|()| tangent(quotient, &data[0], 1.5, &mut rng));
        let guesses = [None, Some((guess[0].as_ref(), guess[1].as_ref()))];
        for (tension, guess) in [(2.0, guesses[0]), (0.0, guesses[1]), (1.0, guesses[1])] {
            let options = BoundaryOptions {
                field: ScalarField::Complex,
                tension,
                guess,
                quotient,
                ..BoundaryOptions::default()
            };
            let curve = RiemannianCubic::from_boundary(s0, v0, s1, v1, &options, Interrupt::NEVER)
                .unwrap_or_else(|e| panic!("{quotient:?} {shape:?} {tension} {guess:?}: {e}"));
            let missed = missed(quotient, &curve, &data);
            assert!(
                missed < 1e-10,
                "{quotient:?} {shape:?} {tension}: {missed:e}"
            );
        }
    }
}

#[test]
fn all_cubics_that_are_found_are_complex_and_end_where_they_should() {
    for (quotient, shape) in kinds().filter(|(_, shape)| shape.0 <= 3) {
        let data = problem(quotient, shape, 0.7, 8);
        let [s0, v0, s1, v1] = data.each_ref().map(Mat::as_ref);
        let options = SearchOptions {
            boundary: BoundaryOptions {
                field: ScalarField::Complex,
                quotient,
                ..BoundaryOptions::default()
            },
            ..SearchOptions::default()
        };
        let found = RiemannianCubic::all_from_boundary(s0, v0, s1, v1, &options, Interrupt::NEVER)
            .unwrap_or_else(|e| panic!("{quotient:?} {shape:?}: {e}"));
        for curve in &found {
            let missed = missed(quotient, curve, &data);
            let bound = 1e-10 * (1.0 + curve.cost(Interrupt::NEVER).unwrap());
            assert!(missed < bound, "{quotient:?} {shape:?}: {missed:e}");
        }
    }
}

#[test]
fn a_batch_of_complex_problems_has_their_costs() {
    for shape in [(1, 1), (3, 1)] {
        let data = problem(Quotient::Frames, shape, 0.8, 5);
        let views = data.each_ref().map(Mat::as_ref);
        let costs = [ScalarField::Complex, ScalarField::Real].map(|field| {
            let options = BoundaryOptions {
                field,
                ..BoundaryOptions::default()
            };
            solve_boundary(&[views; 3], &options, Interrupt::NEVER).unwrap()[2]
                .as_ref()
                .unwrap()
                .cost
        });
        assert!(
            (costs[0] - costs[1]).abs() < 1e-9 * costs[1],
            "{shape:?}: {costs:?}"
        );
    }
}

/// Rounded decimals are accepted as complex numbers, and replaced by the nearest ones.
#[test]
fn numbers_to_ten_digits_pass_for_complex_ones() {
    let rounded = |a: &Mat<f64>| {
        let entry = |i, j| (a[(i, j)] * 1e10).round() * 1e-10 + 1e-10 * ((3 * i + j) as f64).sin();
        Mat::from_fn(a.nrows(), a.ncols(), entry)
    };
    // Also shapes whose splines are solved in the coordinates of all rows.
    let large = [Quotient::Frames, Quotient::Subspaces].map(|quotient| (quotient, (9, 1)));
    for (quotient, shape) in kinds().chain(large) {
        let (t, points) = walk(quotient, shape, 5, 0.8);
        let points: Vec<_> = points.iter().map(rounded).collect();
        let options = SplineOptions {
            quotient,
            field: ScalarField::Complex,
            ..SplineOptions::default()
        };
        let (curve, _) = cubic_spline(
            &t,
            &views(&points),
            &EndConditions::Natural,
            &options,
            Interrupt::NEVER,
        )
        .unwrap_or_else(|e| panic!("{quotient:?} {shape:?}: {e}"));
        let middle = curve.point(t[2]).unwrap();
        let off = apart(quotient, &middle, &points[2]);
        assert!(off < 1e-9, "{quotient:?} {shape:?}: {off:e}");
        let defect = embedding_defect(middle.as_ref());
        assert!(defect < 1e-13, "{quotient:?} {shape:?}: {defect:e}");

        let data = problem(quotient, shape, 0.5, 3).each_ref().map(rounded);
        let [s0, v0, s1, v1] = data.each_ref().map(Mat::as_ref);
        let options = BoundaryOptions {
            field: ScalarField::Complex,
            tension: 1.0,
            quotient,
            ..BoundaryOptions::default()
        };
        let curve = RiemannianCubic::from_boundary(s0, v0, s1, v1, &options, Interrupt::NEVER)
            .unwrap_or_else(|e| panic!("{quotient:?} {shape:?}: {e}"));
        let missed = missed(quotient, &curve, &data);
        assert!(missed < 1e-8, "{quotient:?} {shape:?}: {missed:e}");
    }
}

#[test]
fn matrices_that_are_not_complex_are_refused() {
    let mut rng = Rng::new(2);
    let [a, b] = [(); 2].map(|()| random_point(4, 2, &mut rng));
    let options = SplineOptions {
        field: ScalarField::Complex,
        ..SplineOptions::default()
    };
    let points = [a.as_ref(), b.as_ref()];
    let found = cubic_spline(
        &[0.0, 1.0],
        &points,
        &EndConditions::Natural,
        &options,
        Interrupt::NEVER,
    );
    assert!(matches!(found, Err(Error::NotComplex { defect, .. }) if defect > 0.1));
    let odd = random_point(3, 2, &mut rng);
    let points = [odd.as_ref(), odd.as_ref()];
    let found = cubic_spline(
        &[0.0, 1.0],
        &points,
        &EndConditions::Natural,
        &options,
        Interrupt::NEVER,
    );
    assert!(matches!(found, Err(Error::Shape { .. })));
    let rest = Mat::zeros(4, 2);
    let options = BoundaryOptions {
        field: ScalarField::Complex,
        ..BoundaryOptions::default()
    };
    let [a, b, rest] = [&a, &b, &rest].map(|a| a.as_ref());
    let found = RiemannianCubic::from_boundary(a, rest, b, rest, &options, Interrupt::NEVER);
    assert!(matches!(found, Err(Error::NotComplex { .. })));
}
