//! The symplectic one-step methods: formulas, symplecticity, tangents, orders, invariants, bad input.

#[path = "common/curved_map.rs"]
mod curved_map;
#[path = "common/paper.rs"]
mod paper;

use std::f64::consts::{FRAC_PI_2, PI};

use curved_map::Curved;
use nalgebra::{SMatrix, SVector};
use stiefel_rs::chart::discretization::cotangent_lift;
use stiefel_rs::chart::{
    Chart, DiscretizationMap, Frame, LinearMap, RetractionMap, SpaceRetraction, Sphere, integrate,
    integrate_with_tangent, reference,
};
use stiefel_rs::{Error, Interrupt};

const SPHERE_STATE: [f64; 8] = [1.1, 0.4, 0.3, -0.2, 0.7, -0.5, 0.9, 0.35];
const FRAME_STATE: [f64; 12] = [
    1.2, 0.4, -0.8, 0.3, -0.2, 0.5, 0.7, -0.5, 0.2, 0.9, 0.35, -0.6,
];

const RETRACTIONS: [SpaceRetraction; 3] = [
    SpaceRetraction::Exponential,
    SpaceRetraction::Cayley,
    SpaceRetraction::QuasiGeodesic,
];

/// The largest entry of `J^T Omega J - Omega`.
fn symplectic_defect<const Z: usize>(jacobian: &SMatrix<f64, Z, Z>) -> f64 {
    let half = Z / 2;
    let omega = SMatrix::<f64, Z, Z>::from_fn(|i, j| {
        if j == i + half {
            1.0
        } else if i == j + half {
            -1.0
        } else {
            0.0
        }
    });
    (jacobian.transpose() * omega * jacobian - omega).amax()
}

fn check_step<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    z: &SVector<f64, Z>,
    name: &str,
) {
    let (_, jacobian) = integrate_with_tangent(chart, map, z, 1, 0.05, Interrupt::NEVER).unwrap();
    let defect = symplectic_defect(&jacobian);
    assert!(defect < 1e-12, "{name}: J^T Omega J - Omega = {defect:e}");
    // The tangent is the derivative of the step: compared with differences of order 4, whose round-off is eps / h.
    let h = 1e-3;
    for i in 0..Z {
        let moved = |s: f64| {
            let mut moved = *z;
            moved[i] += s * h;
            integrate(chart, map, &moved, 1, 0.05, Interrupt::NEVER).unwrap()[1]
        };
        let column = ((moved(1.0) - moved(-1.0)) * 8.0 - (moved(2.0) - moved(-2.0))) / (12.0 * h);
        let defect = (column - jacobian.column(i)).amax();
        assert!(defect < 1e-10, "{name}, column {i}: {defect:e}");
    }
}

#[test]
fn steps_are_symplectic_with_exact_tangents() {
    let (s, f) = (SPHERE_STATE.into(), FRAME_STATE.into());
    check_step(
        &Sphere,
        &LinearMap::INITIAL_POINT,
        &s,
        "sphere, initial point",
    );
    check_step(&Sphere, &LinearMap::MIDPOINT, &s, "sphere, mid-point");
    check_step(&Sphere, &Curved(0.3), &s, "sphere, a user's map");
    check_step(
        &Frame,
        &LinearMap::INITIAL_POINT,
        &f,
        "frame, initial point",
    );
    check_step(&Frame, &LinearMap::MIDPOINT, &f, "frame, mid-point");
    check_step(&Frame, &Curved(0.3), &f, "frame, a user's map");
    for retraction in RETRACTIONS {
        let maps = [
            RetractionMap::initial_point(retraction),
            RetractionMap::midpoint(retraction),
        ];
        for map in maps {
            check_step(&Sphere, &map, &s, &format!("sphere, {map:?}"));
            check_step(&Frame, &map, &f, &format!("frame, {map:?}"));
        }
    }
}

#[test]
fn initial_point_step_is_symplectic_euler() {
    // q_1 = q_0 + h H_p(q_0, p_1), p_1 = p_0 - h H_q(q_0, p_1).
    let (z0, h): (SVector<f64, 12>, f64) = (FRAME_STATE.into(), 0.05);
    let z1 = integrate(
        &Frame,
        &LinearMap::INITIAL_POINT,
        &z0,
        1,
        h,
        Interrupt::NEVER,
    )
    .unwrap()[1];
    let mixed = SVector::<f64, 12>::from_fn(|i, _| if i < 6 { z0[i] } else { z1[i] });
    let gradient = Frame.gradient(&mixed);
    for i in 0..6 {
        let (position, momentum) = (
            z1[i] - z0[i] - h * gradient[6 + i],
            z1[6 + i] - z0[6 + i] + h * gradient[i],
        );
        assert!(
            position.abs() < 1e-15 && momentum.abs() < 1e-15,
            "{i}: {position:e}, {momentum:e}"
        );
    }
}

#[test]
fn midpoint_step_is_the_implicit_midpoint_rule() {
    let (z0, h): (SVector<f64, 8>, f64) = (SPHERE_STATE.into(), 0.05);
    let z1 = integrate(&Sphere, &LinearMap::MIDPOINT, &z0, 1, h, Interrupt::NEVER).unwrap()[1];
    let gradient = Sphere.gradient(&((z0 + z1) / 2.0));
    for i in 0..4 {
        let (position, momentum) = (
            z1[i] - z0[i] - h * gradient[4 + i],
            z1[4 + i] - z0[4 + i] + h * gradient[i],
        );
        assert!(
            position.abs() < 1e-15 && momentum.abs() < 1e-15,
            "{i}: {position:e}, {momentum:e}"
        );
    }
}

/// The point `(x, p)` whose scaled Hamiltonian vector the lift maps to a pair that starts at `z0`, by fixed-point
/// iteration (the lift starts within the length of a step), and the end of that pair.
fn step_through_the_lift(
    map: &impl DiscretizationMap<6>,
    z0: &SVector<f64, 12>,
    h: f64,
) -> SVector<f64, 12> {
    let join = |(x, p): (SVector<f64, 6>, SVector<f64, 6>)| {
        SVector::<f64, 12>::from_column_slice(&[x.as_slice(), p.as_slice()].concat())
    };
    let mut middle = *z0;
    for _ in 0..200 {
        let gradient = Frame.gradient(&middle);
        let (x, p) = (
            middle.fixed_rows::<6>(0).into_owned(),
            middle.fixed_rows::<6>(6).into_owned(),
        );
        let (v, rate) = (
            gradient.fixed_rows::<6>(6) * h,
            gradient.fixed_rows::<6>(0) * -h,
        );
        let [start, end] = cotangent_lift(map, &x, &p, &v, &rate).unwrap().map(join);
        let defect = start - z0;
        if defect.amax() < 1e-15 {
            return end;
        }
        middle -= defect;
    }
    panic!("the fixed-point iteration does not settle");
}

#[test]
fn a_step_is_the_cotangent_lift_of_the_hamiltonian_vector() {
    fn check(map: &impl DiscretizationMap<6>, name: &str) {
        let (z0, h): (SVector<f64, 12>, f64) = (FRAME_STATE.into(), 0.01);
        let step = integrate(&Frame, map, &z0, 1, h, Interrupt::NEVER).unwrap()[1];
        let defect = (step - step_through_the_lift(map, &z0, h)).amax();
        assert!(defect < 1e-14, "{name}: {defect:e}");
    }
    check(&LinearMap::INITIAL_POINT, "initial point");
    check(&LinearMap::MIDPOINT, "mid-point");
    check(&Curved(0.3), "a user's map");
    for retraction in RETRACTIONS {
        let name = format!("{retraction:?}");
        check(&RetractionMap::initial_point(retraction), &name);
        check(&RetractionMap::midpoint(retraction), &name);
    }
}

/// Least-squares slope of log error against log h over five halvings.
fn order<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    z0: &SVector<f64, Z>,
) -> f64 {
    let exact = reference(chart, z0, &[1.0], Interrupt::NEVER).unwrap()[0];
    let (mut sx, mut sy, mut sxx, mut sxy) = (0.0, 0.0, 0.0, 0.0);
    for level in 0..6 {
        let steps = 20 << level;
        let end = integrate(chart, map, z0, steps, 1.0, Interrupt::NEVER).unwrap()[steps];
        let (x, y) = (-(steps as f64).ln(), (end - exact).norm().ln());
        (sx, sy, sxx, sxy) = (sx + x, sy + y, sxx + x * x, sxy + x * y);
    }
    (6.0 * sxy - sx * sy) / (6.0 * sxx - sx * sx)
}

#[test]
fn measured_orders_are_one_and_two() {
    let (s, f) = (paper::sphere(), paper::frame());
    let mut orders = vec![
        (order(&Sphere, &LinearMap::INITIAL_POINT, &s), 1.0),
        (order(&Frame, &LinearMap::INITIAL_POINT, &f), 1.0),
        (order(&Sphere, &LinearMap::MIDPOINT, &s), 2.0),
        (order(&Frame, &LinearMap::MIDPOINT, &f), 2.0),
        (order(&Frame, &Curved(0.3), &f), 1.0),
    ];
    for retraction in RETRACTIONS {
        let (first, second) = (
            RetractionMap::initial_point(retraction),
            RetractionMap::midpoint(retraction),
        );
        orders.push((order(&Sphere, &first, &s), 1.0));
        orders.push((order(&Frame, &first, &f), 1.0));
        orders.push((order(&Sphere, &second, &s), 2.0));
        orders.push((order(&Frame, &second, &f), 2.0));
    }
    for (measured, expected) in orders {
        assert!(
            (measured - expected).abs() < 0.2,
            "measured order {measured:.3}, expected {expected}"
        );
    }
}

#[test]
fn midpoint_step_is_symmetric_in_time() {
    let z0 = paper::sphere();
    let there = integrate(
        &Sphere,
        &LinearMap::MIDPOINT,
        &z0,
        50,
        1.0,
        Interrupt::NEVER,
    )
    .unwrap()[50];
    let back = integrate(
        &Sphere,
        &LinearMap::MIDPOINT,
        &there,
        50,
        -1.0,
        Interrupt::NEVER,
    )
    .unwrap()[50];
    assert!((back - z0).amax() < 1e-13, "{:e}", (back - z0).amax());
}

#[test]
fn cyclic_momenta_are_conserved_to_round_off() {
    // phi and psi are cyclic: their momenta are linear invariants, which both maps preserve exactly.
    let z0 = paper::frame();
    for map in [LinearMap::INITIAL_POINT, LinearMap::MIDPOINT] {
        for z in integrate(&Frame, &map, &z0, 1000, 1.0, Interrupt::NEVER).unwrap() {
            let drift = (z[7] - z0[7]).abs().max((z[8] - z0[8]).abs());
            assert!(drift < 1e-12, "{map:?}: {drift:e}");
        }
    }
}

#[test]
fn bad_input_is_a_typed_error() {
    let z0 = paper::sphere();
    let map = LinearMap::MIDPOINT;
    let run =
        |z: &SVector<f64, 8>, steps, t| integrate(&Sphere, &map, z, steps, t, Interrupt::NEVER);
    assert!(matches!(
        run(&z0, 0, 1.0),
        Err(Error::InvalidArgument { name: "steps", .. })
    ));
    assert!(matches!(
        run(&z0, 10, f64::NAN),
        Err(Error::NonFinite { name: "t_end", .. })
    ));
    assert!(matches!(
        run(&z0, usize::MAX, 1.0),
        Err(Error::InvalidArgument { name: "steps", .. })
    ));
    let mut bad = z0;
    bad[5] = f64::INFINITY;
    assert!(matches!(
        run(&bad, 10, 1.0),
        Err(Error::NonFinite { index: 5, .. })
    ));
    for theta in [0.0, -0.3, PI, 4.0] {
        bad = z0;
        bad[0] = theta;
        assert!(
            matches!(run(&bad, 10, 1.0), Err(Error::OutsideChart { value, .. }) if value == theta)
        );
    }
    // A single step that is far too long for its equations, and a curve that leaves the chart.
    bad = z0;
    bad[2] = 40.0;
    assert!(matches!(
        run(&bad, 4, 1.0),
        Err(Error::OutsideChart { .. } | Error::NoConvergence { .. })
    ));
    // Along a meridian the curve runs through the pole.
    let meridian = SVector::from([FRAC_PI_2, PI, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let out = reference(&Sphere, &meridian, &[1.0], Interrupt::NEVER);
    assert!(
        matches!(out, Err(Error::OutsideChart { value, .. }) if value >= PI),
        "{out:?}"
    );
    assert!(matches!(
        reference(&Sphere, &z0, &[0.1, f64::NAN], Interrupt::NEVER),
        Err(Error::NonFinite { index: 1, .. })
    ));
    assert_eq!(
        reference(&Sphere, &z0, &[], Interrupt::NEVER)
            .unwrap()
            .len(),
        0
    );
}
