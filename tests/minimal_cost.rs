//! Control points of minimal cost: boundary data, stationarity by differences of the exact cost, distance to Riemannian
//! cubics, symmetry, degenerate data, and refusals.

mod common;
#[path = "common/paper.rs"]
mod experiment;

use common::*;
use faer::{Mat, MatRef, Scale};
use nalgebra::SVector;
use stiefel_rs::chart::{Chart, Frame, Sphere, reference};
use stiefel_rs::{
    Curve, Error, GeometricCubic, GeometricPolynomial, Interrupt, Quantity, QuasiGeodesic,
    SolverReport, StopReason,
};

/// Shapes small enough for a search in a test, with every special case of [`SIZES`].
const SHAPES: [(usize, usize); 9] = [
    (3, 1),
    (2, 1),
    (20, 1),
    (3, 2),
    (4, 2),
    (20, 2),
    (5, 3),
    (3, 3),
    (4, 4),
];

fn search(data: &Boundary, degree: usize) -> Result<(GeometricPolynomial, SolverReport), Error> {
    let [s0, v0, s1, v1] = [&data.s0, &data.v0, &data.s1, &data.v1].map(|a| a.as_ref());
    let never = Interrupt::NEVER;
    GeometricPolynomial::minimal_cost(s0, v0, s1, v1, degree, never)
}

fn found(data: &Boundary, degree: usize) -> GeometricPolynomial {
    search(data, degree).unwrap().0
}

#[test]
fn degree_three_is_the_geometric_cubic() {
    let mut rng = Rng::new(1);
    for size in SIZES {
        let data = Boundary::random(size, 1.0, 1.5, &mut rng);
        let (curve, report) = search(&data, 3).unwrap();
        assert!(report.converged && report.iterations == 0, "{report}");
        let cubic = data.curve();
        for t in [0.0, 0.3, 0.8, 1.0] {
            let (a, b) = (curve.point(t).unwrap(), cubic.point(t).unwrap());
            assert_close(&a, &b, 1e-14 * size.0 as f64, &format!("{size:?}, t = {t}"));
        }
    }
}

#[test]
fn meets_its_boundary_data_within_few_steps() {
    let mut rng = Rng::new(2);
    let mut worst = ["points", "velocities"].map(Worst::new);
    for size in SHAPES {
        for degree in [4, 5, 6] {
            let data = Boundary::random(size, 1.2, 1.5, &mut rng);
            let (curve, report) = search(&data, degree).unwrap();
            assert_eq!(curve.degree(), degree);
            assert!(
                report.converged && report.residual <= report.tolerance,
                "{report}"
            );
            assert!(
                report.iterations <= 10,
                "{size:?}, degree {degree}: {report}"
            );
            for (t, s, v) in [(0.0, &data.s0, &data.v0), (1.0, &data.s1, &data.v1)] {
                let place = || format!("{size:?}, degree {degree}, t = {t}");
                worst[0].see(distance(&curve.point(t).unwrap(), s), place);
                worst[1].see(distance(&curve.derivative(t, 1).unwrap(), v), place);
            }
        }
    }
    worst[0].assert_at_most(2e-14);
    worst[1].assert_at_most(1e-12);
}

/// The decrease that a Newton step in one direction would still achieve, relative to the cost, from exact costs.
///
/// Costs are accurate to 1e-12, so a difference of two has the relative error 2e-12, and its square divided by a second
/// difference of at least 1e-8 is far below the bounds; the error of the central difference itself is of order `h^4 =
/// 1e-16`.
fn decrement(points: &[Mat<f64>], index: usize, direction: &Mat<f64>) -> f64 {
    let h = 1e-4;
    let line = QuasiGeodesic::from_velocity(points[index].as_ref(), direction.as_ref()).unwrap();
    let [behind, here, ahead] = [-h, 0.0, h].map(|t| {
        let mut moved = points.to_vec();
        moved[index] = line.point(t).unwrap();
        let curve = GeometricPolynomial::try_from(moved.as_slice()).unwrap();
        curve.cost(Interrupt::NEVER).unwrap()
    });
    let (slope, bend) = (ahead - behind, ahead + behind - 2.0 * here);
    assert!(bend > 0.0, "a minimum: {bend:.3e}");
    slope * slope / (8.0 * bend * here)
}

#[test]
fn cost_is_minimal() {
    let mut rng = Rng::new(3);
    let mut worst = Worst::new("relative decrement");
    let mut least = f64::INFINITY;
    for size in [(3, 1), (3, 2), (4, 2), (5, 3), (3, 3)] {
        for degree in [4, 5, 7] {
            let data = Boundary::random(size, 1.0, 1.5, &mut rng);
            let points = found(&data, degree).control_points();
            for index in 2..degree - 1 {
                let direction = random_tangent(&points[index], 1.0, &mut rng);
                worst.see(decrement(&points, index, &direction), || {
                    format!("{size:?}, degree {degree}, point {index}")
                });
                // The same measure detects a displacement of a thousandth.
                let mut moved = points.clone();
                moved[index] = retract(&points[index], &(&direction * Scale(1e-3)));
                let there = QuasiGeodesic::between(points[index].as_ref(), moved[index].as_ref());
                let direction = there.unwrap().derivative(1.0, 1).unwrap() * Scale(1e3);
                least = least.min(decrement(&moved, index, &direction));
            }
        }
    }
    worst.assert_at_most(1e-12);
    assert!(least > 1e-7, "displaced control points: {least:.3e}");
}

/// Mean distance to the exact cubic at 101 points, and the cost, of the geometric cubic and of degrees 4 to 7.
fn on_the_paper<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    z0: SVector<f64, Z>,
) -> Vec<(f64, f64)> {
    let d = X / 2;
    let t: Vec<f64> = (0..=100).map(|i| f64::from(i) / 100.0).collect();
    let exact = reference(chart, &z0, &t, Interrupt::NEVER).unwrap();
    let point = |z: &SVector<f64, Z>| chart.embed(&z.as_slice()[..d]).unwrap();
    let velocity = |z: &SVector<f64, Z>| {
        let (q, qdot) = z.as_slice()[..X].split_at(d);
        chart.embed_velocity(q, qdot).unwrap()
    };
    let data = Boundary {
        s0: point(&exact[0]),
        v0: velocity(&exact[0]),
        s1: point(&exact[100]),
        v1: velocity(&exact[100]),
    };
    (3..=7)
        .map(|degree| {
            let curve = found(&data, degree);
            let samples = curve
                .sample(&t, Quantity::Derivative(0), Interrupt::NEVER)
                .unwrap();
            let distances = samples
                .iter()
                .zip(&exact)
                .map(|(s, z)| (s - point(z)).norm_l2());
            (
                distances.sum::<f64>() / 101.0,
                curve.cost(Interrupt::NEVER).unwrap(),
            )
        })
        .collect()
}

/// Ratios to the mean error of the geometric cubic, measured and rounded down.
#[test]
fn comes_closer_to_the_papers_cubics_with_every_degree() {
    let sphere = on_the_paper(&Sphere, experiment::sphere());
    let frame = on_the_paper(&Frame, experiment::frame());
    for (found, gcp, factors) in [
        (sphere, 1.0757e-4, [39.0, 216.0, 2.4e3, 5.0e4]),
        (frame, 4.5209e-3, [10.8, 133.0, 1.4e3, 1.4e4]),
    ] {
        assert_within((found[0].0 / gcp - 1.0).abs(), 1e-4, "geometric cubic");
        for (degree, factor) in (4..).zip(factors) {
            let improved = found[0].0 / found[degree - 3].0;
            assert!(
                improved > factor,
                "degree {degree}: {improved:.4e}, not {factor:e}"
            );
        }
        let costs: Vec<f64> = found.iter().map(|(_, cost)| *cost).collect();
        for pair in costs.windows(2) {
            // Costs are accurate to 1e-12.
            assert!(pair[1] <= pair[0] * (1.0 + 2e-12), "costs: {costs:?}");
        }
    }
}

#[test]
fn is_equivariant_and_reversible() {
    let mut rng = Rng::new(4);
    // Derivatives by differences are accurate to 1e-8; those of the last step but one, 1e-3 of the whole, to 1e-6.
    const BOUND: f64 = 1e-8;
    const TIMES: [f64; 3] = [0.1, 0.5, 0.7];
    let mut worst = Worst::new("reversed");
    for size in SHAPES {
        let data = Boundary::random(size, 1.0, 1.0, &mut rng);
        let curve = found(&data, 5);
        let points = |a: &[Mat<f64>]| {
            let curve = found(&Boundary::of(a), 5);
            TIMES.map(|t| curve.point(t).unwrap()).to_vec()
        };
        let what = format!("{size:?}");
        assert_equivariant(Actions::Both, &data.all(), points, BOUND, &what, &mut rng);
        let back = Boundary {
            s0: data.s1.clone(),
            v0: -&data.v1,
            s1: data.s0.clone(),
            v1: -&data.v0,
        };
        let back = found(&back, 5);
        for t in TIMES {
            let [point, other] = [curve.point(t), back.point(1.0 - t)].map(Result::unwrap);
            worst.see(distance(&other, &point), || format!("{what}, t = {t}"));
        }
    }
    worst.assert_at_most(BOUND);
}

/// A curve of constant speed along a great circle, or at rest, has zero cost.
#[test]
fn curves_without_cost_are_found() {
    let mut rng = Rng::new(5);
    for size in SIZES {
        for (distance, degree) in [(0.0, 4), (0.0, 6), (1e-9, 5), (1.0, 5)] {
            if distance > 0.0 && size.1 != 1 || size == (20, 4) || size == (30, 12) {
                continue;
            }
            let s0 = random_point(size.0, size.1, &mut rng);
            let v0 = random_tangent(&s0, distance, &mut rng);
            let line = QuasiGeodesic::from_velocity(s0.as_ref(), v0.as_ref()).unwrap();
            let (s1, v1) = (line.point(1.0).unwrap(), line.derivative(1.0, 1).unwrap());
            let (curve, report) = search(&Boundary { s0, v0, s1, v1 }, degree).unwrap();
            assert!(report.converged, "{report}");
            assert_within(
                curve.cost(Interrupt::NEVER).unwrap(),
                1e-20,
                &format!("{size:?}, {distance}"),
            );
            for t in [0.2, 0.5, 1.0] {
                let (a, b) = (curve.point(t).unwrap(), line.point(t).unwrap());
                assert_close(&a, &b, 1e-12, &format!("{size:?}, {distance}, t = {t}"));
            }
        }
    }
}

#[test]
fn zero_velocities_and_equal_points_are_data_like_others() {
    let mut rng = Rng::new(6);
    for size in [(3, 1), (4, 2), (3, 3)] {
        for (distance, speed) in [(1.0, 0.0), (0.0, 1.0), (1e-6, 1e-6), (1e-3, 1.0)] {
            let data = Boundary::random(size, distance, speed, &mut rng);
            let (curve, report) = search(&data, 6).unwrap();
            let cubic = data.curve().cost(Interrupt::NEVER).unwrap();
            assert!(report.converged && report.iterations <= 10, "{report}");
            // Costs are accurate to 1e-12, or to the round-off `64 eps` of the accelerations.
            let bound = cubic * (1.0 + 2e-12) + 256.0 * EPS * cubic.sqrt();
            let cost = curve.cost(Interrupt::NEVER).unwrap();
            assert_within(cost, bound, &format!("{size:?}, {distance}, {speed}"));
        }
    }
}

#[test]
fn bad_input_is_refused() {
    let mut rng = Rng::new(7);
    let data = Boundary::random((4, 2), 1.0, 1.0, &mut rng);
    for degree in [0, 1, 2, 11, usize::MAX] {
        match search(&data, degree) {
            Err(Error::InvalidArgument {
                name: "degree",
                found,
                ..
            }) => {
                assert_eq!(found, degree as f64);
            }
            other => panic!("degree {degree}: {other:?}"),
        }
    }
    let wide = Boundary::random((300, 40), 1.0, 1.0, &mut rng);
    match search(&wide, 5) {
        // St(160, 40) has dimension 160 * 40 - 40 * 41 / 2; degree 5 has two free points, and joins ten pairs.
        Err(Error::InvalidArgument { found, .. }) => {
            assert_eq!(found, 2.0 * 5580.0 * 10.0 * 160.0 * 1600.0);
        }
        other => panic!("{other:?}"),
    }
    let fast = Boundary::random((4, 2), 1.0, 50.0, &mut rng);
    assert!(matches!(
        search(&fast, 5),
        Err(Error::InvalidArgument { name: "V0", .. })
    ));
    let mut broken = data.mapped(Mat::clone);
    broken.v1[(0, 0)] = f64::INFINITY;
    assert!(matches!(
        search(&broken, 5),
        Err(Error::NonFinite { name: "V1", .. })
    ));
    let mut broken = data.mapped(Mat::clone);
    broken.s1[(0, 0)] += 1e-3;
    assert!(matches!(
        search(&broken, 5),
        Err(Error::NotOrthonormal { name: "S1", .. })
    ));
    let mut apart = Boundary::random((3, 3), 1.0, 1.0, &mut rng);
    for part in [&mut apart.s1, &mut apart.v1] {
        for j in 0..3 {
            part[(0, j)] = -part[(0, j)];
        }
    }
    assert!(matches!(
        search(&apart, 5),
        Err(Error::DifferentComponents { n: 3 })
    ));
}

#[test]
fn hard_data_are_searched_or_refused_with_a_reason() {
    let mut rng = Rng::new(8);
    let (mut met, mut refused) = (0, 0);
    for _ in 0..40 {
        let data = Boundary::random((4, 2), 3.0, 7.0, &mut rng);
        match search(&data, 5) {
            Ok((curve, report)) => {
                met += 1;
                assert!(report.converged, "{report}");
                assert_close(
                    &curve.derivative(1.0, 1).unwrap(),
                    &data.v1,
                    1e-11,
                    "velocity",
                );
            }
            Err(
                Error::BranchJump { .. }
                | Error::InvalidArgument { .. }
                | Error::NoJoiningCurve { .. }
                | Error::OutsideLogDomain { .. },
            ) => refused += 1,
            Err(Error::NoConvergence { report, .. }) => {
                refused += 1;
                assert_ne!(report.reason, StopReason::Converged);
            }
            Err(error) => panic!("{error}"),
        }
    }
    println!("{met} met, {refused} refused");
    assert!(met > 0 && met + refused == 40);
}

#[test]
fn can_be_stopped() {
    let mut rng = Rng::new(9);
    let data = Boundary::random((6, 3), 1.0, 1.0, &mut rng);
    let parts: [MatRef<'_, f64>; 4] = [&data.s0, &data.v0, &data.s1, &data.v1].map(|a| a.as_ref());
    let stop = || true;
    let interrupt = Interrupt::new(&stop);
    let [s0, v0, s1, v1] = parts;
    let stopped = GeometricPolynomial::minimal_cost(s0, v0, s1, v1, 5, interrupt).map(|_| ());
    assert!(
        matches!(stopped, Err(Error::Interrupted { .. })),
        "{stopped:?}"
    );
    let cubic = GeometricCubic::from_boundary(s0, v0, s1, v1).unwrap();
    let (curve, _) =
        GeometricPolynomial::minimal_cost(s0, v0, s1, v1, 4, Interrupt::NEVER).unwrap();
    assert!(curve.cost(Interrupt::NEVER).unwrap() < cubic.cost(Interrupt::NEVER).unwrap());
}
