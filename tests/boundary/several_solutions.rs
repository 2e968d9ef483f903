//! Several solutions of the same data, and their costs.

use faer::Mat;
use stiefel_rs::cubic::{BoundaryOptions, SearchOptions};
use stiefel_rs::curve::Samples;
use stiefel_rs::{
    Curve, GeodesicPolynomial, GeometricCubic, GeometricPolynomial, Interrupt, Quantity, Result,
    RiemannianCubic,
};

use crate::common::{Rng, assert_within, distance, random_point, random_tangent};
use crate::data::{Data, END};

/// Acceleration and jerk at the start of the known curves for the data, and the cost of the adjusted de Casteljau
/// curve.
fn known_starts(data: &Data) -> (Vec<[Mat<f64>; 2]>, Option<f64>) {
    let [s0, v0, s1, v1] = [&data.s0, &data.v0, &data.s1, &data.v1].map(|x| x.as_ref());
    let mut starts = Vec::new();
    let geometric = GeometricCubic::from_boundary(s0, v0, s1, v1);
    let at_start = |curve: &dyn Fn(Quantity) -> Result<Samples>| -> Result<[Mat<f64>; 2]> {
        let value = |quantity| Ok(curve(quantity)?.get(0).to_owned());
        Ok([value(Quantity::Acceleration)?, value(Quantity::Jerk)?])
    };
    if let Ok(curve) = &geometric {
        starts.extend(at_start(&|q| curve.sample(&[0.0], q, Interrupt::NEVER)));
    }
    if let Ok(curve) = GeodesicPolynomial::from_boundary(s0, v0, s1, v1) {
        starts.extend(at_start(&|q| curve.sample(&[0.0], q, Interrupt::NEVER)));
    }
    if let Ok((curve, _)) = GeometricPolynomial::minimal_cost(s0, v0, s1, v1, 6, Interrupt::NEVER) {
        starts.extend(at_start(&|q| curve.sample(&[0.0], q, Interrupt::NEVER)));
    }
    (
        starts,
        geometric
            .and_then(|curve| curve.cost(Interrupt::NEVER))
            .ok(),
    )
}

fn all_found(data: &Data) -> Vec<RiemannianCubic> {
    let [s0, v0, s1, v1] = [&data.s0, &data.v0, &data.s1, &data.v1].map(|x| x.as_ref());
    RiemannianCubic::all_from_boundary(s0, v0, s1, v1, &SearchOptions::default(), Interrupt::NEVER)
        .unwrap()
}

#[test]
fn solutions_are_no_dearer_than_the_de_casteljau_curve() {
    for (shape, count) in [((3, 1), 100), ((3, 2), 100), ((4, 4), 10), ((4, 2), 25)] {
        let mut rng = Rng::new(28);
        let (mut dearer, mut compared) = (0, 0);
        for _ in 0..count {
            let data = Data::random(shape, 3.0, 6.0, &mut rng);
            let (Ok(curve), (_, Some(bound))) = (data.solve(), known_starts(&data)) else {
                continue;
            };
            compared += 1;
            // The solver knows the bound to one percent.
            dearer += usize::from(curve.cost(Interrupt::NEVER).unwrap() > bound * 1.02);
        }
        println!("{shape:?}: {dearer} of {compared} dearer");
        assert!(2 * compared > count, "{shape:?}: {compared} have both");
        // At most one in a hundred.
        assert!(
            100 * dearer <= compared,
            "{shape:?}: {dearer} of {compared}"
        );
    }
}

#[test]
fn a_search_finds_what_known_curves_lead_to() {
    for (shape, count) in [((3, 1), 5), ((3, 2), 10), ((4, 4), 1), ((4, 2), 2)] {
        let mut rng = Rng::new(29);
        for i in 0..count {
            let data = Data::random(shape, 3.0, 6.0, &mut rng);
            let cheapest = all_found(&data)[0].cost(Interrupt::NEVER).unwrap();
            for [a, j] in &known_starts(&data).0 {
                let options = BoundaryOptions {
                    guess: Some((a.as_ref(), j.as_ref())),
                    ..Default::default()
                };
                if let Ok(curve) = data.solve_with(&options, Interrupt::NEVER) {
                    let cost = curve.cost(Interrupt::NEVER).unwrap();
                    assert!(
                        cheapest <= cost * (1.0 + 1e-6),
                        "{shape:?}, {i}: {cheapest} > {cost}"
                    );
                }
            }
        }
    }
}

/// For equal and opposite points there is no quasi-geodesic, or one of length zero, along which to add a turn.
#[test]
fn a_search_finds_several_solutions_for_equal_and_opposite_points() {
    let mut rng = Rng::new(30);
    for (n, k) in [(3, 1), (3, 2)] {
        let s0 = random_point(n, k, &mut rng);
        let v0 = random_tangent(&s0, 1.0, &mut rng);
        for s1 in [s0.clone(), -&s0] {
            let data = Data {
                v1: random_tangent(&s1, 1.0, &mut rng),
                s0: s0.clone(),
                v0: v0.clone(),
                s1,
            };
            let found = all_found(&data).len();
            assert!(found > 1, "St({n},{k}): {found}");
        }
    }
}

#[test]
fn several_solutions_are_distinct_and_ranked() {
    let mut rng = Rng::new(22);
    let data = Data::random((3, 1), 1.5, 1.0, &mut rng);
    let all = all_found(&data);
    println!("{} solutions", all.len());
    assert!(
        all.len() >= 3,
        "full turns around the sphere: {}",
        all.len()
    );
    let costs: Vec<f64> = all
        .iter()
        .map(|c| c.cost(Interrupt::NEVER).unwrap())
        .collect();
    assert!(costs.is_sorted(), "{costs:?}");
    assert!(costs[0] <= data.solve().unwrap().cost(Interrupt::NEVER).unwrap() * (1.0 + 1e-9));
    for (i, curve) in all.iter().enumerate() {
        assert_within(data.defect(curve), END, "one of several");
        for other in &all[..i] {
            let apart = distance(&curve.jerk(0.0).unwrap(), &other.jerk(0.0).unwrap())
                + distance(
                    &curve.acceleration(0.0).unwrap(),
                    &other.acceleration(0.0).unwrap(),
                );
            assert!(apart > 1e-7, "{apart:e}");
        }
    }
    let again = all_found(&data);
    assert_eq!(again.len(), all.len(), "the same seed");
    for (a, b) in all.iter().zip(&again) {
        assert_eq!(a.point(0.5).unwrap(), b.point(0.5).unwrap());
    }
}
