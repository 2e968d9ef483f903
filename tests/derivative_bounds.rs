//! Bounds of derivatives: closed forms, enclosures of cubics against dense samples, pieces, scaling.

mod common;

use common::{Boundary, Rng, assert_within, cubic_from, random_point, random_tangent};
use faer::{Mat, MatRef, Scale, mat};
use stiefel_rs::cubic::IntegrationOptions;
use stiefel_rs::curve::{DerivativeBounds, Guarantee};
use stiefel_rs::spline::{EndConditions, SplineOptions, cubic_spline, geometric_hermite};
use stiefel_rs::{Curve, Interrupt, Quantity, QuasiGeodesic, RiemannianCubic, Stiefel};

/// Allowed relative distance of an enclosure from the largest norm and, if derivatives of lower order are larger,
/// relative to these. A sample misses less than its squared step of a maximum.
const GAP: f64 = 1.01e-3;
const LOWER_GAP: f64 = 1.01e-4;

/// The allowed bounds, given the largest norms on an interval of the given length.
fn limits(norms: [f64; 3], length: f64) -> [f64; 3] {
    let mut scale = 0.0;
    norms.map(|norm| {
        let lower = scale / length;
        scale = lower.max(norm);
        norm + (GAP * norm).max(LOWER_GAP * lower)
    })
}

fn array(bounds: &DerivativeBounds) -> [f64; 3] {
    [bounds.velocity, bounds.acceleration, bounds.jerk]
}

/// The largest norms of a dense sample.
fn dense(curve: &impl Curve, count: usize) -> [f64; 3] {
    let (start, end) = curve.t_span();
    let manifold = Stiefel::new(curve.n(), curve.k()).unwrap();
    let t: Vec<f64> = (0..=count)
        .map(|i| start + (end - start) * i as f64 / count as f64)
        .collect();
    let sample = |quantity| curve.sample(&t, quantity, Interrupt::NEVER).unwrap();
    let points = sample(Quantity::Derivative(0));
    [
        Quantity::Derivative(1),
        Quantity::Acceleration,
        Quantity::Jerk,
    ]
    .map(|quantity| {
        let norms = points
            .iter()
            .zip(sample(quantity).iter())
            .map(|(s, v)| manifold.norm(s, v).unwrap())
            .collect::<Vec<f64>>();
        norms.into_iter().fold(0.0, f64::max)
    })
}

fn cubic(shape: (usize, usize), sizes: [f64; 3], t_end: f64, seed: u64) -> RiemannianCubic {
    let mut rng = Rng::new(seed);
    let s = random_point(shape.0, shape.1, &mut rng);
    let [v, a, j] = sizes.map(|size| random_tangent(&s, size, &mut rng));
    let options = IntegrationOptions {
        t_end,
        ..IntegrationOptions::default()
    };
    cubic_from([&s, &v, &a, &j], &options)
}

#[test]
fn cubics_have_bounds_that_hold_and_are_tight() {
    for shape in [(1, 1), (2, 1), (3, 1), (3, 2), (3, 3), (6, 3), (20, 2)] {
        for (sizes, t_end) in [
            ([1.0, 2.0, 3.0], 1.0),
            ([2.0, 3.0, 10.0], 1.5),
            ([0.0, 1.0, 0.0], 1.0),
            ([1.0, 1.0, 1.0], -1.5),
            ([0.0, 0.0, 5.0], 0.01),
            // Derivatives of lower order are larger, in units of the interval's length.
            ([2.0, 2.0, 0.1], 1.0),
            ([4.0, 0.5, 0.1], 0.5),
        ] {
            let curve = cubic(shape, sizes, t_end, 1);
            let name = format!("{shape:?} {sizes:?} {t_end}");
            let found = curve.derivative_bounds(Interrupt::NEVER);
            let bounds = found.unwrap_or_else(|error| panic!("{name}: {error}"));
            let name = format!("{name}: {bounds:?}");
            assert_eq!(bounds.guarantee, Guarantee::Enclosure);
            let samples = dense(&curve, 500);
            let limits = limits(samples, t_end.abs());
            for (i, (bound, sample)) in array(&bounds).into_iter().zip(samples).enumerate() {
                let noise = 1e-11 * t_end.abs().powi(-(i as i32 + 1));
                assert_within(sample, bound * (1.0 + 1e-12) + noise, &name);
                assert_within(bound, limits[i] + noise, &name);
            }
        }
    }
}

#[test]
fn on_the_circle_a_cubic_has_the_derivatives_of_its_angle() {
    // Angle u - 2 u^2 + u^3 / 3 on [0, 2], with the derivatives 1 - 4 u + u^2, -4 + 2 u, 2.
    let state = [
        mat![[1.0], [0.0]],
        mat![[0.0], [1.0]],
        mat![[0.0], [-4.0]],
        mat![[0.0], [2.0]],
    ];
    let [s, v, a, j] = state.each_ref().map(Mat::as_ref);
    let options = IntegrationOptions {
        t_end: 2.0,
        ..IntegrationOptions::default()
    };
    let curve = RiemannianCubic::from_initial(s, v, a, j, &options, Interrupt::NEVER).unwrap();
    let bounds = array(&curve.derivative_bounds(Interrupt::NEVER).unwrap());
    let exact = [3.0, 4.0, 2.0];
    for ((bound, exact), limit) in bounds.into_iter().zip(exact).zip(limits(exact, 2.0)) {
        assert!(bound >= exact * (1.0 - 1e-12), "{bound} {exact}");
        assert_within(bound, limit, "circle");
    }
}

#[test]
fn splines_of_plane_rotations_have_bounds() {
    // On some pieces the acceleration is round-off without any tangent part.
    let turn = |[i, j]: [usize; 2], angle: f64| {
        let mut out = common::identity(3);
        let (sin, cos) = angle.sin_cos();
        (out[(i, i)], out[(j, j)], out[(i, j)], out[(j, i)]) = (cos, cos, -sin, sin);
        out
    };
    let planes = [[0, 1], [0, 2], [1, 2]];
    let options = SplineOptions::default();
    for k in [2, 3] {
        for (first, second) in planes
            .iter()
            .flat_map(|p| planes.iter().map(move |q| (*p, *q)))
        {
            for (a, b) in [(0.3, 0.4), (0.5, 0.3), (1.0, -0.9), (-0.7, 1.1)] {
                let middle = turn(first, a);
                let points = [
                    common::identity(3),
                    middle.clone(),
                    &middle * turn(second, b),
                ];
                let views = points.each_ref().map(|point| point.as_ref().subcols(0, k));
                let times = [0.0, 1.0, 2.0];
                let (curve, _) = cubic_spline(
                    &times,
                    &views,
                    &EndConditions::Natural,
                    &options,
                    Interrupt::NEVER,
                )
                .unwrap();
                let bounds = curve.derivative_bounds(Interrupt::NEVER);
                let bounds =
                    bounds.unwrap_or_else(|error| panic!("{k} {first:?} {second:?}: {error}"));
                assert!(bounds.velocity >= 0.3, "{bounds:?}");
            }
        }
    }
}

#[test]
fn fast_geodesics_and_cubics_have_bounds() {
    for shape in [(3, 1), (3, 2), (5, 3)] {
        for speed in [1000.0, 5000.0] {
            let curve = cubic(shape, [speed, 0.0, 0.0], 1.0, 3);
            let [velocity, acceleration, jerk] =
                array(&curve.derivative_bounds(Interrupt::NEVER).unwrap());
            assert_within((velocity / speed - 1.0).abs(), GAP, "speed");
            // No covariant derivative, and no round-off of ambient derivatives either, which would be 1e-16 speed^2 or
            // more.
            assert_within(acceleration + jerk, 1e-290, "geodesic");
        }
        let curve = cubic(shape, [1000.0, 1.0, 1.0], 1.0, 4);
        let bounds = curve.derivative_bounds(Interrupt::NEVER).unwrap();
        // Of the order of |A| |V| after a first rotation.
        assert!((1.0..1e5).contains(&bounds.jerk), "{bounds:?}");
    }
}

#[test]
fn samples_find_the_largest_norms_of_other_curves() {
    for shape in [(2, 1), (3, 2), (4, 4), (20, 2)] {
        for seed in 0..4 {
            let curve = Boundary::random(shape, 1.0, 1.5, &mut Rng::new(seed)).curve();
            let bounds = curve.derivative_bounds(Interrupt::NEVER).unwrap();
            assert_eq!(bounds.guarantee, Guarantee::Sampling);
            for (bound, sample) in array(&bounds).into_iter().zip(dense(&curve, 2000)) {
                let name = format!("{shape:?} {seed}");
                // Third derivatives are accurate to about 1e-11.
                assert_within(sample, bound * (1.0 + 1e-9), &name);
                assert_within(bound, sample * (1.0 + 1e-5), &name);
            }
        }
    }
    // A quasi-geodesic has constant norms.
    let s = random_point(5, 2, &mut Rng::new(9));
    let v = random_tangent(&s, 2.0, &mut Rng::new(10));
    let curve = QuasiGeodesic::from_velocity(s.as_ref(), v.as_ref()).unwrap();
    let bounds = curve.derivative_bounds(Interrupt::NEVER).unwrap();
    assert_within((bounds.velocity - 2.0).abs(), 1e-14, "speed");
}

#[test]
fn pieces_are_bounded_one_by_one_in_the_time_of_the_curve() {
    let mut rng = Rng::new(11);
    let mut points = vec![random_point(4, 2, &mut rng)];
    for i in 0..5 {
        let v = random_tangent(&points[i], 0.6, &mut rng);
        points.push(common::retract(&points[i], &v));
    }
    let views: Vec<MatRef<'_, f64>> = points.iter().map(Mat::as_ref).collect();
    let t = [0.0, 0.2, 1.0, 3.0, 3.5, 5.0];
    let options = SplineOptions::default();
    let (curve, _) = cubic_spline(
        &t,
        &views,
        &EndConditions::Natural,
        &options,
        Interrupt::NEVER,
    )
    .unwrap();
    let bounds = curve.derivative_bounds(Interrupt::NEVER).unwrap();
    assert_eq!(bounds.guarantee, Guarantee::Enclosure);
    for (bound, sample) in array(&bounds).into_iter().zip(dense(&curve, 2000)) {
        assert_within(sample, bound * (1.0 + 1e-12), "spline");
        assert_within(bound, sample * (1.0 + 3.0 * GAP), "spline");
    }
    // At half the speed: halves, quarters, eighths.
    let slow = t.map(|t| 2.0 * t);
    let (other, _) = cubic_spline(
        &slow,
        &views,
        &EndConditions::Natural,
        &options,
        Interrupt::NEVER,
    )
    .unwrap();
    let slower = array(&other.derivative_bounds(Interrupt::NEVER).unwrap());
    for ((fast, slow), rate) in array(&bounds).into_iter().zip(slower).zip([2.0, 4.0, 8.0]) {
        assert_within((fast - rate * slow).abs(), 1e-9 * fast, "time");
    }
    // One piece without a guarantee removes the guarantee of the curve.
    let velocities: Vec<Mat<f64>> = t.iter().map(|t| curve.derivative(*t, 1).unwrap()).collect();
    let tangents: Vec<Mat<f64>> = velocities.iter().map(|v| v * Scale(1.0)).collect();
    let tangents: Vec<MatRef<'_, f64>> = tangents.iter().map(Mat::as_ref).collect();
    let other = geometric_hermite(&t, &views, &tangents).unwrap();
    assert_eq!(
        other.derivative_bounds(Interrupt::NEVER).unwrap().guarantee,
        Guarantee::Sampling
    );
}
