//! Composed steps: measured orders, symmetry, symplecticity, the adjoint, bad input.

#[path = "common/curved_map.rs"]
mod curved_map;
#[path = "common/paper.rs"]
mod paper;

use curved_map::Curved;
use nalgebra::{SMatrix, SVector};
use stiefel_rs::chart::composition::{Adjoint, Stage};
use stiefel_rs::chart::{
    Chart, Composition, DiscretizationMap, Frame, LinearMap, RetractionMap, ShootingOptions,
    SpaceRetraction, Sphere, integrate, integrate_composed, integrate_composed_with_tangent,
    reference, shoot,
};
use stiefel_rs::{Error, Interrupt};

/// Least-squares slope of log error against log h; `steps` in increasing order.
fn measured_order<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    order: usize,
    z0: &SVector<f64, Z>,
    steps: &[usize],
) -> f64 {
    let composition = Composition::new(map.order(), order).unwrap();
    let exact = reference(chart, z0, &[1.0], Interrupt::NEVER).unwrap()[0];
    let points: Vec<(f64, f64)> = steps
        .iter()
        .map(|&n| {
            let never = Interrupt::NEVER;
            let path = integrate_composed(chart, map, &composition, z0, n, 1.0, never).unwrap();
            (-(n as f64).ln(), (path[n] - exact).norm().ln())
        })
        .collect();
    let n = points.len() as f64;
    let (mx, my) = points
        .iter()
        .fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let sxy: f64 = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    let sxx: f64 = points.iter().map(|p| (p.0 - mx) * (p.0 - mx)).sum();
    sxy / sxx
}

/// Step counts for which the leading term dominates and errors are above round-off.
fn range(order: usize) -> &'static [usize] {
    match order {
        2 => &[40, 80, 160, 320, 640],
        4 => &[16, 24, 32, 48, 64, 96],
        6 => &[6, 8, 10, 14, 20],
        _ => &[6, 8, 10, 12, 14],
    }
}

fn check_orders<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    z0: &SVector<f64, Z>,
    name: &str,
) {
    for order in [2, 4, 6] {
        let measured = measured_order(chart, map, order, z0, range(order));
        assert!(
            (measured - order as f64).abs() < 0.2,
            "{name}: order {measured:.3}, expected {order}"
        );
    }
}

#[test]
fn measured_orders_are_two_four_six() {
    let (s, f) = (paper::sphere(), paper::frame());
    check_orders(&Sphere, &LinearMap::MIDPOINT, &s, "sphere, mid-point");
    check_orders(&Frame, &LinearMap::MIDPOINT, &f, "frame, mid-point");
    check_orders(&Frame, &LinearMap::INITIAL_POINT, &f, "initial point");
    for retraction in [SpaceRetraction::Exponential, SpaceRetraction::Cayley] {
        let map = RetractionMap::midpoint(retraction);
        check_orders(&Sphere, &map, &s, &format!("sphere, {map:?}"));
        check_orders(&Frame, &map, &f, &format!("frame, {map:?}"));
    }
    let map = RetractionMap::initial_point(SpaceRetraction::Exponential);
    check_orders(&Sphere, &map, &s, "sphere, exponential with its adjoint");
}

#[test]
fn order_eight_is_measured_above_round_off() {
    let map = RetractionMap::midpoint(SpaceRetraction::Cayley);
    for (name, measured) in [
        (
            "sphere",
            measured_order(&Sphere, &LinearMap::MIDPOINT, 8, &paper::sphere(), range(8)),
        ),
        (
            "frame",
            measured_order(&Frame, &map, 8, &paper::frame(), range(8)),
        ),
    ] {
        assert!(
            (measured - 8.0).abs() < 0.5,
            "{name}: order {measured:.3}, expected 8"
        );
    }
}

/// The order conditions without commutators: power sums of the fractions.
#[test]
fn fractions_satisfy_the_power_sums() {
    for order in [4, 6, 8] {
        let fractions: Vec<f64> = Composition::new(2, order)
            .unwrap()
            .stages()
            .map(|stage| match stage {
                Stage::Method(part) | Stage::Adjoint(part) => part,
            })
            .collect();
        let reversed: Vec<f64> = fractions.iter().rev().copied().collect();
        assert_eq!(fractions, reversed, "symmetric");
        let sum = |power: i32| -> f64 { fractions.iter().map(|x| x.powi(power)).sum() };
        // At most 17 numbers below 1, with one rounding each.
        assert!((sum(1) - 1.0).abs() < 17.0 * f64::EPSILON, "order {order}");
        for power in (3..order as i32).step_by(2) {
            let defect = sum(power).abs();
            assert!(defect < 17.0 * f64::EPSILON, "{order}, {power}: {defect:e}");
        }
    }
}

#[test]
fn composed_steps_are_symplectic_and_symmetric() {
    fn check<const X: usize, const Z: usize>(
        chart: &impl Chart<X, Z>,
        map: &impl DiscretizationMap<X>,
        z0: &SVector<f64, Z>,
    ) {
        for order in [2, 4, 6, 8] {
            let composition = Composition::new(map.order(), order).unwrap();
            let never = Interrupt::NEVER;
            let (end, tangent) =
                integrate_composed_with_tangent(chart, map, &composition, z0, 1, 0.05, never)
                    .unwrap();
            let half = Z / 2;
            let omega = SMatrix::<f64, Z, Z>::from_fn(|i, j| {
                f64::from(i8::from(j == i + half) - i8::from(i == j + half))
            });
            let defect = (tangent.transpose() * omega * tangent - omega).amax();
            assert!(defect < 1e-12, "order {order}: {defect:e}");
            let back =
                integrate_composed(chart, map, &composition, &end, 1, -0.05, never).unwrap()[1];
            let defect = (back - z0).amax();
            assert!(defect < 1e-13, "order {order}, there and back: {defect:e}");
        }
    }
    check(&Sphere, &LinearMap::INITIAL_POINT, &paper::sphere());
    check(&Frame, &LinearMap::MIDPOINT, &paper::frame());
    check(&Frame, &Curved(0.3), &paper::frame());
    let map = RetractionMap::initial_point(SpaceRetraction::QuasiGeodesic);
    check(&Frame, &map, &paper::frame());
}

#[test]
fn the_adjoint_undoes_the_step_backwards() {
    let z0 = paper::frame();
    let there = integrate(&Frame, &Curved(0.3), &z0, 1, 0.05, Interrupt::NEVER).unwrap()[1];
    let back = integrate(
        &Frame,
        &Adjoint(&Curved(0.3)),
        &there,
        1,
        -0.05,
        Interrupt::NEVER,
    )
    .unwrap()[1];
    assert!((back - z0).amax() < 1e-14, "{:e}", (back - z0).amax());
}

#[test]
fn composed_steps_shoot() {
    let z0 = paper::frame();
    let exact = reference(&Frame, &z0, &[1.0], Interrupt::NEVER).unwrap()[0];
    let (x0, x1) = (
        z0.fixed_rows::<6>(0).into_owned(),
        exact.fixed_rows::<6>(0).into_owned(),
    );
    let map = RetractionMap::midpoint(SpaceRetraction::Exponential);
    let options = ShootingOptions {
        composition: Composition::new(2, 6).unwrap(),
        ..ShootingOptions::default()
    };
    let found = shoot(&Frame, &map, &x0, &x1, 40, &options, Interrupt::NEVER).unwrap();
    assert!(found.report.converged && found.report.iterations <= 5);
    // The discrete flow of order 6 is exact to 1e-8, and so are the momenta it needs.
    let defect = (found.momenta - z0.fixed_rows::<6>(6)).amax();
    assert!(defect < 1e-6, "{defect:e}");
}

#[test]
fn unknown_orders_are_refused() {
    for (base, order) in [(1, 0), (1, 3), (2, 1), (2, 5), (2, 10), (1, 7)] {
        let out = Composition::new(base, order);
        assert!(
            matches!(out, Err(Error::InvalidArgument { name: "order", found, .. }) if found == order as f64),
            "{base}, {order}: {out:?}"
        );
    }
}
