//! The Riemannian logarithm: inverse of the exponential, reports, symmetry, bad input.

mod common;

use std::f64::consts::PI;

use common::*;
use faer::{Mat, Scale};
use stiefel_rs::{Error, Interrupt, LogReport, Metric, Stiefel, orthogonal_log, skew_exp};

/// Shapes of the population test.
const POPULATION: [(usize, usize); 8] = [
    (3, 1),
    (3, 2),
    (4, 2),
    (4, 3),
    (4, 4),
    (10, 3),
    (50, 5),
    (200, 20),
];

/// Distance up to which a logarithm must be found.
const REACH: f64 = 0.89 * PI;

/// Random pairs `(S0, V)` with `V` of canonical norm up to `REACH`: log must return `V`.
fn population(shape: (usize, usize), count: usize, seed: u64) -> (usize, usize, f64, f64) {
    let (n, k) = shape;
    let manifold = Stiefel::new(n, k).unwrap();
    let mut rng = Rng::new(seed);
    let (mut failures, mut most, mut sum, mut worst) = (0, 0, 0, 0.0_f64);
    for i in 0..count {
        let s0 = random_point(n, k, &mut rng);
        // Half of them at large distances, which are the hard cases.
        let d = if i % 2 == 0 {
            REACH
        } else {
            REACH * rng.uniform()
        };
        let v = random_tangent(&s0, d, &mut rng);
        let s1 = manifold.exp(s0.as_ref(), v.as_ref()).unwrap();
        match manifold.log_with_report(s0.as_ref(), s1.as_ref(), Interrupt::NEVER) {
            Ok((found, report)) => {
                let error = distance(&found, &v);
                let angle = frobenius(found.as_ref());
                assert!(report.residual < 1e-11 && report.converged);
                // On SO(n), the principal logarithm may be shorter than a long geodesic.
                if error > 1e-9 {
                    println!(
                        "{shape:?} {i}: d {d:.4}, |log - V| = {error:.2e}, |V| {angle:.4}, {report:?}"
                    );
                    failures += 1;
                } else {
                    worst = worst.max(error);
                }
                most = most.max(report.iterations);
                sum += report.iterations;
            }
            Err(error) => {
                println!("{shape:?} {i}: d {d:.4}, {error}");
                failures += 1;
            }
        }
    }
    (failures, most, sum as f64 / count as f64, worst)
}

fn assert_population(count: usize, seed: u64) {
    for shape in POPULATION {
        let (failures, most, mean, worst) = population(shape, count, seed);
        println!(
            "St{shape:?}: {failures} failures of {count}, at most {most} iterations, mean {mean:.2}, \
             largest |log - V| {worst:.1e}"
        );
        assert_eq!(failures, 0, "{shape:?}");
        assert!(most <= 10, "{shape:?}: {most} iterations");
    }
}

#[test]
fn log_returns_the_velocity_of_random_pairs() {
    assert_population(300, 1);
}

#[test]
#[ignore = "ten thousand pairs per shape take minutes"]
fn log_returns_the_velocity_of_ten_thousand_pairs() {
    assert_population(10_000, 2);
}

fn log(s0: &Mat<f64>, s1: &Mat<f64>, metric: Metric) -> stiefel_rs::Result<(Mat<f64>, LogReport)> {
    let manifold = Stiefel::new(s0.nrows(), s0.ncols())
        .unwrap()
        .with_metric(metric);
    manifold.log_with_report(s0.as_ref(), s1.as_ref(), Interrupt::NEVER)
}

#[test]
fn log_inverts_exp_for_the_family() {
    let mut rng = Rng::new(31);
    let mut worst = Worst::new("log(exp V) - V over the family");
    // The farther from the canonical metric, the more intermediate metrics are needed; a failed direct attempt counts.
    let mut most = [0; 2];
    for (n, k) in SIZES {
        for alpha in [-0.5, 0.7, -0.8, -0.2, 3.0] {
            let manifold = Stiefel::new(n, k)
                .unwrap()
                .with_metric(Metric::new(alpha).unwrap());
            for size in [1e-12, 1e-4, 0.5, 1.0, 1.6] {
                let s0 = random_point(n, k, &mut rng);
                // Shorter than 2 in the canonical metric and in the manifold's: far from both cut loci.
                let raw = random_tangent(&s0, size, &mut rng);
                let ratio = manifold.norm(s0.as_ref(), raw.as_ref()).unwrap() / size;
                let v = raw * Scale(1.0 / ratio.max(1.0));
                let s1 = manifold.exp(s0.as_ref(), v.as_ref()).unwrap();
                let what = || format!("St({n},{k}), alpha {alpha}, size {size}");
                let (found, report) =
                    log(&s0, &s1, manifold.metric()).unwrap_or_else(|e| panic!("{}: {e}", what()));
                worst.see(distance(&found, &v), what);
                let length = manifold.norm(s0.as_ref(), v.as_ref()).unwrap();
                assert_within((report.length - length).abs(), 1e-11, &what());
                let extreme = usize::from(alpha == -0.8 || alpha == 3.0);
                most[extreme] = most[extreme].max(report.iterations);
            }
        }
    }
    worst.assert_at_most(1e-11);
    println!("{most:?} iterations");
    assert!(most[0] <= 10 && most[1] <= 35, "{most:?} iterations");
}

#[test]
fn euclidean_log_of_random_pairs_below_pi() {
    for (n, k) in [(4, 2), (5, 3), (10, 3), (50, 5)] {
        let manifold = Stiefel::new(n, k).unwrap().with_metric(Metric::EUCLIDEAN);
        let mut rng = Rng::new(32);
        let (mut worst, mut most) = (0.0_f64, 0);
        for i in 0..100 {
            let s0 = random_point(n, k, &mut rng);
            let raw = random_tangent(&s0, 1.0, &mut rng);
            let d = REACH * rng.uniform() / manifold.norm(s0.as_ref(), raw.as_ref()).unwrap();
            let v = raw * Scale(d);
            let s1 = manifold.exp(s0.as_ref(), v.as_ref()).unwrap();
            let (found, report) = manifold
                .log_with_report(s0.as_ref(), s1.as_ref(), Interrupt::NEVER)
                .unwrap_or_else(|e| panic!("St({n},{k}) {i}: {e}"));
            assert!(report.certainly_shortest, "St({n},{k}) {i}: {report:?}");
            worst = worst.max(distance(&found, &v));
            most = most.max(report.iterations);
        }
        println!("Euclidean St({n},{k}): |log - V| {worst:.1e}, {most} iterations");
        assert_within(worst, 1e-10, "Euclidean logarithm");
    }
}

#[test]
fn round_sphere() {
    let mut rng = Rng::new(33);
    for n in [2, 3, 7, 100] {
        let s0 = random_point(n, 1, &mut rng);
        for angle in [0.0, 1e-300, 1e-9, 0.4, 1.6, 3.0, PI - 1e-6] {
            let v = random_tangent(&s0, angle, &mut rng);
            let unit = if angle > 0.0 {
                &v * Scale(1.0 / angle)
            } else {
                v.clone()
            };
            let s1 = &s0 * Scale(angle.cos()) + unit * Scale(angle.sin());
            for alpha in [0.0, -0.5, 2.0] {
                let (found, report) = log(&s0, &s1, Metric::new(alpha).unwrap()).unwrap();
                assert_close(
                    &found,
                    &v,
                    1e-9 * angle.max(1e-6),
                    &format!("S^{}, {angle}", n - 1),
                );
                assert_within((report.length - angle).abs(), 1e-14, "angle");
                assert!(report.certainly_shortest);
            }
        }
        let antipode = &s0 * Scale(-1.0);
        let error = log(&s0, &antipode, Metric::CANONICAL).unwrap_err();
        assert!(matches!(error, Error::NoJoiningCurve { angle } if (angle - PI).abs() < 1e-14));
    }
}

#[test]
fn orthogonal_group_and_its_frames() {
    let mut rng = Rng::new(34);
    for n in [2, 3, 4, 6, 11] {
        let g = random_rotation(n, &mut rng);
        let angles = scaled(&spread_angles(n, &mut rng), 3.0);
        let q = rotation_with_angles(&angles, n, &mut rng);
        let expected = orthogonal_log(q.as_ref()).unwrap();
        let length = frobenius(expected.as_ref()) * 0.5_f64.sqrt();
        // k = n: S0 log(S0^T S1); k = n - 1: the first columns of the same rotation of R^n.
        let s1 = &g * &q;
        let (found, report) = log(&g, &s1, Metric::CANONICAL).unwrap();
        assert_close(&found, &(&g * &expected), 1e-13, "O(n)");
        assert_within((report.length - length).abs(), 1e-13, "length");
        assert!(report.certainly_shortest && report.residual < 1e-13);
        let scale = (2.0 * Metric::EUCLIDEAN.weight()).sqrt();
        let euclidean = log(&g, &s1, Metric::EUCLIDEAN).unwrap().1.length;
        assert_within(
            (euclidean - scale * length).abs(),
            1e-13,
            "multiple of the bi-invariant metric",
        );
        let frame = |a: &Mat<f64>| a.as_ref().subcols(0, n - 1).to_owned();
        let (found, report) = log(&frame(&g), &frame(&s1), Metric::CANONICAL).unwrap();
        assert_close(&found, &frame(&(&g * &expected)), 1e-12, "frames");
        assert_within((report.length - length).abs(), 1e-12, "length");
        assert!(report.certainly_shortest);
        let mut mirrored = s1.clone();
        negate_column(&mut mirrored, 0);
        let error = log(&g, &mirrored, Metric::CANONICAL).unwrap_err();
        assert!(matches!(error, Error::DifferentComponents { n: found } if found == n));
    }
    let one = Mat::from_fn(1, 1, |_, _| 1.0);
    assert_eq!(log(&one, &one, Metric::CANONICAL).unwrap().0[(0, 0)], 0.0);
    let minus = Mat::from_fn(1, 1, |_, _| -1.0);
    assert!(matches!(
        log(&one, &minus, Metric::CANONICAL),
        Err(Error::DifferentComponents { n: 1 })
    ));
    // A rotation by pi has no sign.
    let half = plane_rotations(&[PI], 4);
    let error = log(&identity(4), &half, Metric::CANONICAL).unwrap_err();
    assert!(matches!(error, Error::NoJoiningCurve { angle } if (angle - PI).abs() < 1e-12));
}

#[test]
fn distance_is_symmetric_invariant_and_obeys_the_triangle() {
    let mut rng = Rng::new(35);
    for (n, k) in SIZES {
        for metric in [Metric::CANONICAL, Metric::EUCLIDEAN] {
            let manifold = Stiefel::new(n, k).unwrap().with_metric(metric);
            let dist = |a: &Mat<f64>, b: &Mat<f64>| manifold.dist(a.as_ref(), b.as_ref()).unwrap();
            let a = random_point(n, k, &mut rng);
            let near = |a: &Mat<f64>, d: f64, rng: &mut Rng| {
                manifold
                    .exp(a.as_ref(), random_tangent(a, d, rng).as_ref())
                    .unwrap()
            };
            let b = near(&a, 0.9, &mut rng);
            let c = near(&b, 0.7, &mut rng);
            let what = format!("St({n},{k}), alpha {}", metric.alpha());
            assert_within((dist(&a, &b) - dist(&b, &a)).abs(), 1e-12, &what);
            assert!(
                dist(&a, &c) <= dist(&a, &b) + dist(&b, &c) + 1e-12,
                "{what}"
            );
            let (left, right) = (
                random_orthogonal(n, &mut rng),
                random_orthogonal(k, &mut rng),
            );
            let moved = |s: &Mat<f64>| &left * s * &right;
            assert_within(
                (dist(&moved(&a), &moved(&b)) - dist(&a, &b)).abs(),
                1e-12,
                &what,
            );
            let v = manifold.log(a.as_ref(), b.as_ref()).unwrap();
            let w = manifold
                .log(moved(&a).as_ref(), moved(&b).as_ref())
                .unwrap();
            assert_close(&w, &moved(&v), 1e-11, &what);
        }
    }
}

#[test]
fn degenerate_pairs() {
    let mut rng = Rng::new(36);
    for (n, k) in SIZES {
        let manifold = Stiefel::new(n, k).unwrap();
        let s = random_point(n, k, &mut rng);
        let (found, report) = log(&s, &s, Metric::CANONICAL).unwrap();
        assert_within(frobenius(found.as_ref()), 1e-14 * k as f64, "equal points");
        assert!(report.certainly_shortest && report.length < 1e-14 * k as f64);
        // Points with the same span, and normal parts of graded size.
        let turned = &s * skew_exp(random_skew(k, 1.0, &mut rng).as_ref()).unwrap();
        let (found, _) = log(&s, &turned, Metric::CANONICAL).unwrap();
        let end = manifold.exp(s.as_ref(), found.as_ref()).unwrap();
        assert_close(&end, &turned, 1e-12, "the same span");
        if n > k {
            let g = project_off(&s, &project_off(&s, &gaussian(n, k, &mut rng)));
            let graded = Mat::from_fn(n, k, |i, j| g[(i, j)] * 10.0_f64.powi(-4 * j as i32));
            let graded = &graded * Scale(0.8 / frobenius(graded.as_ref()));
            let v = graded + &s * random_skew(k, 0.5, &mut rng);
            let s1 = manifold.exp(s.as_ref(), v.as_ref()).unwrap();
            let (found, _) = log(&s, &s1, Metric::CANONICAL).unwrap();
            assert_close(
                &found,
                &v,
                1e-12,
                &format!("graded normal part, St({n},{k})"),
            );
        }
        // Tiny distances keep their relative accuracy up to the round-off of the points.
        let v = random_tangent(&s, 1e-8, &mut rng);
        let s1 = manifold.exp(s.as_ref(), v.as_ref()).unwrap();
        assert_close(
            &manifold.log(s.as_ref(), s1.as_ref()).unwrap(),
            &v,
            1e-14,
            "near points",
        );
    }
}

/// Beyond the injectivity radius: a geodesic that reaches the point and is no longer than the one that generated it, or
/// an error.
#[test]
fn far_pairs_give_a_short_geodesic_or_an_error() {
    let mut rng = Rng::new(37);
    for (n, k) in [(4, 2), (5, 3), (6, 3), (10, 3), (8, 4), (30, 5)] {
        let manifold = Stiefel::new(n, k).unwrap();
        let (mut solved, mut longer, mut refused) = (0, 0, 0);
        for _ in 0..100 {
            let s0 = random_point(n, k, &mut rng);
            let d = rng.between(0.9, 1.4) * PI;
            let v = random_tangent(&s0, d, &mut rng);
            let s1 = manifold.exp(s0.as_ref(), v.as_ref()).unwrap();
            match manifold.log_with_report(s0.as_ref(), s1.as_ref(), Interrupt::NEVER) {
                Ok((found, report)) => {
                    let end = manifold.exp(s0.as_ref(), found.as_ref()).unwrap();
                    assert_close(&end, &s1, 1e-11, "end");
                    let certain = report.length < manifold.injectivity_bound();
                    assert_eq!(report.certainly_shortest, certain);
                    solved += 1;
                    longer += usize::from(report.length > d + 1e-9);
                }
                Err(Error::NoConvergence { .. } | Error::NoJoiningCurve { .. }) => refused += 1,
                Err(error) => panic!("St({n},{k}): {error}"),
            }
        }
        println!(
            "St({n},{k}): {solved} found, {longer} of them longer than a known one, {refused} refused"
        );
        assert!(
            longer == 0 && refused <= 15,
            "{longer} longer, {refused} refused"
        );
    }
}

#[test]
fn geodesics_beyond_the_bound_that_turn_little_are_found_both_ways() {
    let mut rng = Rng::new(241);
    for ((n, k), distance) in [
        ((50, 5), 0.95),
        ((30, 10), 1.1),
        ((24, 12), 1.2),
        ((200, 20), 1.5),
    ] {
        let manifold = Stiefel::new(n, k).unwrap();
        let s = random_point(n, k, &mut rng);
        let v = random_tangent(&s, 1.0, &mut rng);
        let length = manifold.norm(s.as_ref(), v.as_ref()).unwrap();
        let v = v * Scale(distance * PI / length);
        let y = manifold.exp(s.as_ref(), v.as_ref()).unwrap();
        let (found, report) = manifold
            .log_with_report(s.as_ref(), y.as_ref(), Interrupt::NEVER)
            .unwrap();
        assert_within(frobenius((&found - &v).as_ref()), 1e-11, "velocity");
        assert!(!report.certainly_shortest);
        let back = manifold.dist(y.as_ref(), s.as_ref()).unwrap();
        assert_within((report.length / back - 1.0).abs(), 1e-13, "distance back");
    }
}

/// Points that are only orthonormal up to the tolerance of the input.
#[test]
fn slightly_defective_points_are_joined() {
    let mut rng = Rng::new(38);
    for (n, k) in [(3, 1), (4, 2), (5, 4), (6, 6), (20, 4)] {
        let manifold = Stiefel::new(n, k).unwrap();
        let s0 = random_point(n, k, &mut rng);
        let v = random_tangent(&s0, 1.0, &mut rng);
        let s1 = manifold.exp(s0.as_ref(), v.as_ref()).unwrap();
        let off = |s: &Mat<f64>, rng: &mut Rng| s + gaussian(n, k, rng) * Scale(2e-11);
        let (a, b) = (off(&s0, &mut rng), off(&s1, &mut rng));
        let (found, _) = log(&a, &b, Metric::CANONICAL).unwrap();
        assert_close(&found, &v, 1e-8, &format!("St({n},{k})"));
    }
}

#[test]
fn bad_input_is_a_typed_error() {
    let mut rng = Rng::new(39);
    let s = random_point(4, 2, &mut rng);
    let manifold = Stiefel::new(4, 2).unwrap();
    let call = |a: &Mat<f64>, b: &Mat<f64>| manifold.log(a.as_ref(), b.as_ref()).unwrap_err();
    assert!(matches!(
        call(&s, &Mat::zeros(4, 3)),
        Error::Shape { name: "S1", .. }
    ));
    assert!(matches!(
        call(&Mat::zeros(3, 2), &s),
        Error::Shape { name: "S0", .. }
    ));
    assert!(matches!(
        call(&s, &(&s * Scale(1.1))),
        Error::NotOrthonormal { name: "S1", .. }
    ));
    let mut bad = s.clone();
    bad[(0, 0)] = f64::NAN;
    assert!(matches!(
        call(&bad, &s),
        Error::NonFinite {
            name: "S0",
            index: 0
        }
    ));
    for huge in [1e200, 1e300] {
        assert!(matches!(
            call(&(&s * Scale(huge)), &s),
            Error::NotOrthonormal { .. }
        ));
    }
    // The antipode: a rotation by pi in the plane of the two columns, in either direction.
    let error = call(&s, &(&s * Scale(-1.0)));
    assert!(
        matches!(error.cause(), Error::NoJoiningCurve { angle } if (angle - PI).abs() < 1e-12),
        "{error}"
    );
}

#[test]
fn an_interrupt_stops_a_far_logarithm() {
    let mut rng = Rng::new(40);
    let (s0, s1) = (random_point(10, 3, &mut rng), random_point(10, 3, &mut rng));
    let question = || true;
    let manifold = Stiefel::new(10, 3).unwrap();
    let result = manifold.log_with_report(s0.as_ref(), s1.as_ref(), Interrupt::new(&question));
    assert!(matches!(result, Err(Error::Interrupted { .. })));
}

/// Regression: if the normal part was round-off, its frame was not orthogonal to the point, which the reported residual
/// did not reveal.
#[test]
fn points_that_span_the_same_subspace() {
    let mut rng = Rng::new(41);
    let mut worst = Worst::new("|exp(S0, log) - S1|, relative to k");
    for (n, k) in [(4, 2), (6, 3), (8, 4), (10, 3), (100, 5)] {
        let manifold = Stiefel::new(n, k).unwrap();
        for i in 0..400 {
            let s0 = random_point(n, k, &mut rng);
            let turn =
                skew_exp(random_skew(k, if i % 2 == 0 { 0.0 } else { 1.5 }, &mut rng).as_ref());
            let s1 = &s0 * turn.unwrap();
            let velocity = manifold.log(s0.as_ref(), s1.as_ref()).unwrap();
            let end = manifold.exp(s0.as_ref(), velocity.as_ref()).unwrap();
            worst.see(distance(&end, &s1) / k as f64, || format!("({n}, {k})"));
        }
    }
    worst.assert_at_most(1e-14);
}

/// Regression: depending on round-off, a geodesic of length 1.41 pi was returned for opposite points, whose distance is
/// at most pi.
#[test]
fn points_with_a_rotation_by_pi_between_them_are_refused() {
    let mut rng = Rng::new(42);
    for (n, k) in [(4, 2), (6, 3), (10, 3), (8, 4)] {
        let manifold = Stiefel::new(n, k).unwrap();
        for _ in 0..100 {
            let s0 = random_point(n, k, &mut rng);
            let opposite = -&s0;
            let mut turned = s0.clone();
            negate_column(&mut turned, 0);
            for s1 in [&opposite, &turned] {
                let found = manifold.log_with_report(s0.as_ref(), s1.as_ref(), Interrupt::NEVER);
                match found.as_ref().map_err(Error::cause) {
                    Err(Error::NoJoiningCurve { angle } | Error::OutsideLogDomain { angle }) => {
                        assert_within((angle - PI).abs(), 1e-6, "angle")
                    }
                    Err(Error::NoConvergence { .. }) => {}
                    other => panic!("({n}, {k}): {other:?}"),
                }
            }
        }
    }
}
