//! Several solutions of one boundary problem: compared with products of circles, and with lines orthogonal to planes.

use faer::{Mat, Scale};
use stiefel_rs::cubic::{BoundaryOptions, IntegrationOptions, RiemannianCubic, SearchOptions};
use stiefel_rs::{Curve, Error, Grassmann, Interrupt, Quotient};

use crate::common::{Rng, assert_close, assert_within, random_orthogonal, random_point};
use crate::derivative::vector;
use crate::{boundary_options, reflection, search_options, view};

fn all(data: &[Mat<f64>; 4], seed: u64) -> Vec<RiemannianCubic> {
    let [y0, v0, y1, v1] = data.each_ref().map(view);
    let options = SearchOptions {
        seed,
        ..search_options()
    };
    RiemannianCubic::all_from_boundary(y0, v0, y1, v1, &options, Interrupt::NEVER).unwrap()
}

fn costs(curves: &[RiemannianCubic]) -> Vec<f64> {
    curves
        .iter()
        .map(|curve| curve.cost(Interrupt::NEVER).unwrap())
        .collect()
}

/// Distinct cubics with the given ends, cheapest first.
fn check(found: &[RiemannianCubic], data: &[Mat<f64>; 4], what: &str) {
    let costs = costs(found);
    assert!(costs.is_sorted(), "{what}: {costs:?}");
    for (i, curve) in found.iter().enumerate() {
        let (end, velocity) = (curve.point(1.0).unwrap(), curve.derivative(1.0, 1).unwrap());
        // Approximate speed along the curve.
        let speed = 1.0 + costs[i].sqrt();
        let (start, first) = (curve.point(0.0).unwrap(), curve.derivative(0.0, 1).unwrap());
        assert_close(&start, &data[0], 1e-12, what);
        assert_within((first - &data[1]).norm_l2() / speed, 1e-11, what);
        let q = data[2].transpose() * &end;
        let wanted: Mat<f64> = &data[2] * &q;
        assert_close(&end, &wanted, 1e-11, what);
        let wanted: Mat<f64> = &data[3] * &q;
        assert_within((&velocity - wanted).norm_l2() / speed, 1e-11, what);
        let initial = curve.initial().unwrap();
        let options = IntegrationOptions {
            quotient: Quotient::Subspaces,
            ..IntegrationOptions::default()
        };
        let [y, v, a, j] = initial.each_ref().map(view);
        let again = RiemannianCubic::from_initial(y, v, a, j, &options, Interrupt::NEVER).unwrap();
        let [p, q] = [curve, &again].map(|curve| reflection(view(&curve.point(0.6).unwrap())));
        assert_close(&p, &q, 1e-9, what);
        for other in &found[..i] {
            let other = other.initial().unwrap();
            let off = (&initial[2] - &other[2]).norm_l2() + (&initial[3] - &other[3]).norm_l2();
            assert!(off > 1e-7, "{what}: twice the same");
        }
        assert!(curve.report().unwrap().converged);
    }
}

/// A line in each of two planes: a flat torus, totally geodesic in `Gr(4, 2)`.
#[test]
fn lines_in_two_planes_turn_either_way() {
    let mut rng = Rng::new(61);
    let pi = std::f64::consts::PI;
    for angles in [[0.4, 0.9], [0.7, 0.7], [0.0, 1.1]] {
        let torus = |angles: [f64; 2]| {
            let [(s0, c0), (s1, c1)] = angles.map(f64::sin_cos);
            faer::mat![[c0, 0.0], [s0, 0.0], [0.0, c1], [0.0, s1]]
        };
        let turn = random_orthogonal(2, &mut rng);
        let data = [
            torus([0.0; 2]),
            Mat::zeros(4, 2),
            torus(angles) * turn,
            Mat::zeros(4, 2),
        ];
        let found = all(&data, 0);
        let what = format!("{angles:?}");
        check(&found, &data, &what);
        let costs = costs(&found);
        println!("{what}: {costs:?}");
        for turns in [[0.0, 0.0], [-1.0, 0.0], [0.0, -1.0]] {
            let angle = [0, 1].map(|i: usize| angles[i] + pi * turns[i]);
            let cost = 12.0 * (angle[0].powi(2) + angle[1].powi(2));
            let is_found = costs.iter().any(|x| (x / cost - 1.0).abs() < 1e-8);
            assert!(is_found, "{what}: {cost} is not among {costs:?}");
        }
    }
}

/// `Gr(3, 2)` is `Gr(3, 1)`: planes and the lines orthogonal to them.
#[test]
fn planes_of_space_have_the_solutions_of_their_normals() {
    let mut rng = Rng::new(62);
    let (mut wanted, mut seen) = (0, 0);
    for speed in [0.0, 0.5, 1.5, 3.0] {
        for seed in 0..6 {
            let [y0, y1] = [(); 2].map(|()| random_point(3, 2, &mut rng));
            let [v0, v1] = [&y0, &y1].map(|y| vector(y, 1.0, &mut rng) * Scale(speed));
            let normal = |y: &Mat<f64>| {
                let [a, b] = [y.col(0), y.col(1)];
                let entry = |i: usize| {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    a[j] * b[k] - a[k] * b[j]
                };
                Mat::from_fn(3, 1, |i, _| entry(i))
            };
            let [n0, n1] = [&y0, &y1].map(normal);
            let moved =
                |y: &Mat<f64>, v: &Mat<f64>, n: &Mat<f64>| y * (v.transpose() * n) * Scale(-1.0);
            let lines = [
                n0.clone(),
                moved(&y0, &v0, &n0),
                n1.clone(),
                moved(&y1, &v1, &n1),
            ];
            let data = [y0, v0, y1, v1];
            let (planes, lines) = (all(&data, seed), all(&lines, seed));
            check(&planes, &data, &format!("speed {speed}"));
            let [planes, lines] = [planes, lines].map(|found| costs(&found));
            println!(
                "speed {speed}: {} of {}\n  {planes:?}\n  {lines:?}",
                planes.len(),
                lines.len()
            );
            assert_within((planes[0] / lines[0] - 1.0).abs(), 1e-9, "the cheapest");
            let cheap = &lines[..lines.len().min(3)];
            wanted += cheap.len();
            let is_seen = |cost: &&f64| planes.iter().any(|x| (x / *cost - 1.0).abs() < 1e-7);
            seen += cheap.iter().filter(is_seen).count();
        }
    }
    // Measured: 68 of 72; the descents miss expensive ones.
    assert!(
        10 * seen >= 9 * wanted,
        "{seen} of {wanted} cheap solutions on the sphere"
    );
}

#[test]
fn random_problems_have_several_solutions() {
    let mut rng = Rng::new(63);
    for (n, k) in [(4, 2), (5, 2), (5, 3), (30, 2)] {
        let mut counts = Vec::new();
        for _ in 0..4 {
            let [y0, y1] = [(); 2].map(|()| random_point(n, k, &mut rng));
            let [v0, v1] = [&y0, &y1].map(|y| vector(y, 1.5, &mut rng));
            let data = [y0, v0, y1, v1];
            let found = all(&data, 0);
            check(&found, &data, &format!("({n}, {k})"));
            let [a, b, c, d] = data.each_ref().map(view);
            let options = boundary_options();
            let one =
                RiemannianCubic::from_boundary(a, b, c, d, &options, Interrupt::NEVER).unwrap();
            let cheapest = found[0].cost(Interrupt::NEVER).unwrap();
            assert!(
                cheapest <= one.cost(Interrupt::NEVER).unwrap() * (1.0 + 1e-3),
                "({n}, {k})"
            );
            counts.push(found.len());
        }
        println!("({n}, {k}): {counts:?}");
        assert!(counts.iter().sum::<usize>() >= 8, "({n}, {k}): {counts:?}");
    }
}

#[test]
fn solutions_in_many_dimensions_are_found_again_from_themselves() {
    let mut rng = Rng::new(67);
    let mut several = 0;
    for (n, k) in [(12, 4), (12, 6), (13, 5)] {
        let y0 = random_point(n, k, &mut rng);
        let away = vector(&y0, 1.3, &mut rng);
        let manifold = Grassmann::new(n, k).unwrap();
        let y1 = manifold.exp(view(&y0), view(&away)).unwrap();
        let [v0, v1] = [&y0, &y1].map(|y| vector(y, 0.5, &mut rng));
        let data = [y0, v0, y1, v1];
        let found = all(&data, 0);
        check(&found, &data, &format!("({n}, {k})"));
        several += usize::from(found.len() > 1);
        let [a, b, c, d] = data.each_ref().map(view);
        for curve in &found {
            let [_, _, acceleration, jerk] = curve.initial().unwrap();
            let options = BoundaryOptions {
                guess: Some((view(&acceleration), view(&jerk))),
                ..boundary_options()
            };
            let again =
                RiemannianCubic::from_boundary(a, b, c, d, &options, Interrupt::NEVER).unwrap();
            let [cost, known] = [&again, curve].map(|curve| curve.cost(Interrupt::NEVER).unwrap());
            assert_within((cost / known - 1.0).abs(), 1e-9, &format!("({n}, {k})"));
        }
    }
    assert!(several >= 2, "{several}");
}

#[test]
fn the_same_subspace_the_whole_space_and_bad_input() {
    let mut rng = Rng::new(64);
    let y0 = Mat::<f64>::identity(4, 4).as_ref().subcols(0, 2).to_owned();
    let swapped = Mat::from_fn(4, 2, |i, j| y0[(i, 1 - j)]);
    let rest = Mat::zeros(4, 2);
    let data = [y0.clone(), rest.clone(), swapped, rest];
    let found = all(&data, 0);
    check(&found, &data, "permuted");
    assert_within(found[0].cost(Interrupt::NEVER).unwrap(), 1e-20, "still");
    let whole = [(); 2].map(|()| random_orthogonal(3, &mut rng));
    let rest = Mat::zeros(3, 3);
    let [first, last] = whole;
    let found = all(&[first, rest.clone(), last, rest], 0);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].cost(Interrupt::NEVER).unwrap(), 0.0);
    let data = [&y0, &y0, &y0, &y0].map(view);
    let [a, b, c, d] = data;
    let error = RiemannianCubic::all_from_boundary(a, b, c, d, &search_options(), Interrupt::NEVER);
    assert!(matches!(
        error,
        Err(Error::NotHorizontal { name: "V0", .. })
    ));
    let options = SearchOptions {
        distinct: 2.0,
        ..search_options()
    };
    let error = RiemannianCubic::all_from_boundary(a, b, c, d, &options, Interrupt::NEVER);
    assert!(matches!(
        error,
        Err(Error::InvalidArgument {
            name: "distinct",
            ..
        })
    ));
}
