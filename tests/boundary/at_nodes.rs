//! Solutions found at Gauss nodes, for any data.

use faer::{Mat, MatRef};
use stiefel_rs::cubic::{BoundaryOptions, IntegrationOptions};
use stiefel_rs::linalg::complex_embedding::embed;
use stiefel_rs::{Curve, Interrupt, RiemannianCubic, ScalarField, Strategy};

use crate::common::{
    Rng, Worst, assert_within, cyclic_permutation, distance, gaussian, identity,
    integrated_from_start, negate_column, partner_at_angles, random_orthogonal, random_point,
    random_tangent, retract,
};
use crate::data::{Data, END};

/// Spaces of more than three dimensions: spans of the data, rotations, one column less than these, many columns.
const SHAPES: [(usize, usize); 8] = [
    (4, 2),
    (5, 2),
    (4, 3),
    (4, 4),
    (6, 5),
    (10, 3),
    (12, 7),
    (40, 4),
];

/// Asserts that the flat start leads to a curve with the given ends, and that its reversal is the solution of the reversed
/// problem.
fn assert_is_solution(data: &Data, options: &BoundaryOptions<'_>, what: &str) {
    let [there, back] = [data.clone(), data.reversed()].map(|data| {
        let curve = data.solve_with(options, Interrupt::NEVER);
        let curve = curve.unwrap_or_else(|error| panic!("{what}: {error}"));
        let report = curve.report().unwrap();
        assert_eq!(report.strategy, Some(Strategy::Direct), "{what}");
        assert_within(data.defect(&curve), END, what);
        assert_is_cubic(&curve, what);
        curve
    });
    let mut worst = Worst::new(what);
    for i in 0..=10 {
        let t = f64::from(i) / 10.0;
        let defect = distance(&there.point(t).unwrap(), &back.point(1.0 - t).unwrap());
        worst.see(defect, || format!("{t}"));
    }
    // Both solutions have residuals up to 1e-12, which grow inside.
    worst.assert_at_most(1e-11);
}

/// Asserts that a curve, a polynomial or several, has the derivatives of the cubic integrated from its start.
fn assert_is_cubic(curve: &RiemannianCubic, what: &str) {
    let integrated = integrated_from_start(curve);
    for order in 0..4 {
        let at = |curve: &RiemannianCubic, t: f64| curve.derivative(t, order).unwrap();
        for t in [0.0, 0.1, 0.37, 0.5, 0.8, 1.0] {
            let (found, exact) = (at(curve, t), at(&integrated, t));
            let size = 1.0 + exact.norm_l2();
            let what = format!("{what}, derivative {order} at {t}");
            assert_within(distance(&found, &exact), 5e-12 * size, &what);
        }
    }
}

/// Solutions of a single series, which are integrated.
#[test]
fn random_data_in_few_dimensions() {
    let mut rng = Rng::new(66);
    for shape in [(2, 1), (3, 1), (4, 1), (2, 2), (3, 2), (3, 3)] {
        for size in [0.1, 0.6, 1.2] {
            let s0 = random_point(shape.0, shape.1, &mut rng);
            let s1 = retract(&s0, &random_tangent(&s0, size, &mut rng));
            let [v0, v1] = [&s0, &s1].map(|s| random_tangent(s, size, &mut rng));
            let data = Data { s0, v0, s1, v1 };
            let curve = data.solve().unwrap();
            assert_is_cubic(&curve, &format!("{shape:?}, size {size}"));
        }
    }
}

#[test]
fn random_data() {
    let mut rng = Rng::new(61);
    for shape in SHAPES {
        for (size, tension) in [(0.3, 0.0), (1.0, 0.0), (1.8, 0.0), (1.0, 9.0)] {
            let s0 = random_point(shape.0, shape.1, &mut rng);
            let s1 = retract(&s0, &random_tangent(&s0, size, &mut rng));
            let [v0, v1] = [&s0, &s1].map(|s| random_tangent(s, size, &mut rng));
            let options = BoundaryOptions {
                tension,
                ..Default::default()
            };
            let data = Data { s0, v0, s1, v1 };
            let what = format!("{shape:?}, size {size}, tension {tension}");
            assert_is_solution(&data, &options, &what);
        }
    }
}

/// Coordinate columns and sparse vectors, equal principal angles, rest at the ends.
#[test]
fn special_data() {
    let mut rng = Rng::new(62);
    for (n, k) in [(4, 2), (6, 3), (5, 4), (9, 2)] {
        let s0 = identity(n).subcols(0, k).to_owned();
        let sparse = |s: &Mat<f64>| {
            let mut v = Mat::zeros(n, k);
            v[(n - 1, 0)] = 1.0;
            v[(k, k - 1)] = -0.5;
            let inner = s.transpose() * &v;
            &v - s * (&inner + inner.transpose()) * faer::Scale(0.5)
        };
        let partner = (n >= 2 * k).then(|| partner_at_angles(&s0, &vec![0.7; k], &mut rng));
        // A rotation by a small angle in the plane of the first and the last coordinate.
        let mut turned = s0.clone();
        (turned[(0, 0)], turned[(n - 1, 0)]) = (0.8, 0.6);
        let ends = [("equal angles", partner), ("coordinates", Some(turned))];
        for (which, s1) in ends {
            let Some(s1) = s1 else { continue };
            for speed in [0.0, 1.0] {
                let [v0, v1] = [&s0, &s1].map(|s| sparse(s) * faer::Scale(speed));
                let data = Data {
                    s0: s0.clone(),
                    v0,
                    s1: s1.clone(),
                    v1,
                };
                let what = format!("({n}, {k}), {which}, speed {speed}");
                assert_is_solution(&data, &BoundaryOptions::default(), &what);
                let p = cyclic_permutation(n);
                assert_is_solution(&data.map(|x| &p * x), &BoundaryOptions::default(), &what);
            }
        }
    }
}

#[test]
fn complex_data() {
    let mut rng = Rng::new(63);
    for (n, k) in [(3, 1), (3, 2), (2, 2), (3, 3), (6, 2)] {
        let mut complex = || {
            let [re, im] = [(); 2].map(|()| gaussian(n, k, &mut rng));
            embed(Mat::from_fn(n, k, |i, j| faer::c64::new(re[(i, j)], im[(i, j)])).as_ref())
        };
        let tangent = |s: &Mat<f64>, a: Mat<f64>, length: f64| {
            let inner = s.transpose() * &a;
            let v = a - s * (&inner + inner.transpose()) * faer::Scale(0.5);
            let size = v.norm_l2();
            v * faer::Scale(length / size)
        };
        let origin = embed(
            Mat::from_fn(n, k, |i, j| {
                faer::c64::new(f64::from(u8::from(i == j)), 0.0)
            })
            .as_ref(),
        );
        let s0 = retract(&origin, &tangent(&origin, complex(), 1.3));
        let s1 = retract(&s0, &tangent(&s0, complex(), 1.2));
        let [v0, v1] = [&s0, &s1].map(|s| tangent(s, complex(), 1.5));
        let options = BoundaryOptions {
            field: ScalarField::Complex,
            ..Default::default()
        };
        let data = Data { s0, v0, s1, v1 };
        assert_is_solution(&data, &options, &format!("complex ({n}, {k})"));
    }
}

/// The solution of a guess is the curve of the guess, at speeds at which there are others.
#[test]
fn a_guess_leads_back_to_its_curve() {
    let mut rng = Rng::new(64);
    for shape in [(4, 2), (6, 3), (12, 3)] {
        let s = random_point(shape.0, shape.1, &mut rng);
        let [v, a, j] = [2.0, 6.0, 12.0].map(|size| random_tangent(&s, size, &mut rng));
        let [s_, v_, a_, j_] = [&s, &v, &a, &j].map(|x| x.as_ref());
        let options = IntegrationOptions::default();
        let curve =
            RiemannianCubic::from_initial(s_, v_, a_, j_, &options, Interrupt::NEVER).unwrap();
        let data = Data {
            s0: s.clone(),
            v0: v.clone(),
            s1: curve.point(1.0).unwrap(),
            v1: curve.derivative(1.0, 1).unwrap(),
        };
        let guess: (MatRef<'_, f64>, MatRef<'_, f64>) = (a_, j_);
        let found = data.solve_with(
            &BoundaryOptions {
                guess: Some(guess),
                ..Default::default()
            },
            Interrupt::NEVER,
        );
        let found = found.unwrap();
        for t in [0.3, 0.7] {
            let defect = distance(&found.point(t).unwrap(), &curve.point(t).unwrap());
            assert_within(defect, 1e-10, &format!("{shape:?}"));
        }
        assert_is_cubic(&found, &format!("{shape:?}, guess"));
    }
}

/// A guess at rest, whose end is a reflection of the given one: the equations for the displacement vanish there as well.
#[test]
fn reflections_are_no_solutions() {
    for (n, k) in [(4, 3), (5, 4), (4, 2), (5, 2), (8, 2)] {
        for angle in [1.7, 2.5, 3.0] {
            let s0 = identity(n).subcols(0, k).to_owned();
            let mut s1 = s0.clone();
            (s1[(0, 0)], s1[(n - 1, 0)]) = (f64::cos(angle), f64::sin(angle));
            let zero = Mat::zeros(n, k);
            let data = Data {
                s0,
                v0: zero.clone(),
                s1,
                v1: zero.clone(),
            };
            let options = BoundaryOptions {
                guess: Some((zero.as_ref(), zero.as_ref())),
                ..Default::default()
            };
            let what = format!("({n}, {k}), angle {angle}");
            let curve = data
                .solve_with(&options, Interrupt::NEVER)
                .unwrap_or_else(|error| panic!("{what}: {error}"));
            assert_within(data.defect(&curve), END, &what);
        }
    }
}

/// The other component of O(4) is out of reach, with a guess as well.
#[test]
fn a_guess_does_not_lead_to_another_component() {
    let mut rng = Rng::new(65);
    let s0 = identity(4);
    let mut s1 = random_orthogonal(4, &mut rng);
    if s1.determinant() > 0.0 {
        negate_column(&mut s1, 0);
    }
    let [v0, v1] = [&s0, &s1].map(|s| random_tangent(s, 0.5, &mut rng));
    let [a, j] = [1.0, 2.0].map(|size| random_tangent(&s0, size, &mut rng));
    let data = Data { s0, v0, s1, v1 };
    let options = BoundaryOptions {
        guess: Some((a.as_ref(), j.as_ref())),
        ..Default::default()
    };
    assert!(data.solve_with(&options, Interrupt::NEVER).is_err());
}
