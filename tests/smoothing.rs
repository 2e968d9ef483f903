//! Smoothing splines: flat space, first variation, limits, symmetries, repeated data, cross-validation, bad input.

mod common;
#[path = "common/knots.rs"]
mod knots;

use common::{Rng, assert_within, distance, random_point, random_rotation, random_tangent};
use faer::linalg::solvers::Solve;
use faer::{Mat, Scale};
use knots::views;
use stiefel_rs::spline::{
    EndConditions, SmoothingOptions, SmoothingSpline, SplineOptions, cubic_spline, smoothing_spline,
};
use stiefel_rs::{Curve, Error, Interrupt, Stiefel};

fn smooth(t: &[f64], data: &[Mat<f64>], weights: Option<&[f64]>, lambda: f64) -> SmoothingSpline {
    let options = SmoothingOptions {
        lambda: Some(lambda),
        ..SmoothingOptions::default()
    };
    let found = smoothing_spline(t, &views(data), weights, &options, Interrupt::NEVER);
    found.unwrap_or_else(|error| panic!("{:?} {lambda}: {error}", data[0].shape()))
}

/// Noisy points near a geodesic, at unequal times.
fn noisy(shape: (usize, usize), count: usize, noise: f64, seed: u64) -> (Vec<f64>, Vec<Mat<f64>>) {
    let mut rng = Rng::new(seed);
    let manifold = Stiefel::new(shape.0, shape.1).unwrap();
    let start = random_point(shape.0, shape.1, &mut rng);
    let velocity = random_tangent(&start, 1.5 / count as f64, &mut rng);
    let (mut t, mut points) = (vec![-1.0], Vec::new());
    for i in 0..count {
        let along = manifold
            .exp(start.as_ref(), (&velocity * Scale(t[i] + 1.0)).as_ref())
            .unwrap();
        let off = random_tangent(&along, noise, &mut rng);
        points.push(manifold.exp(along.as_ref(), off.as_ref()).unwrap());
        t.push(t[i] + rng.between(0.5, 1.5));
    }
    t.pop();
    (t, points)
}

fn circle(angles: &[f64]) -> Vec<Mat<f64>> {
    let point = |angle: &f64| Mat::from_fn(2, 1, |i, _| [angle.cos(), angle.sin()][i]);
    angles.iter().map(point).collect()
}

/// The matrix of the cost of the natural spline with given values at `t`: `Q R^{-1} Q^T` (Green, Silverman 1994, sec.
/// 2.3.3).
fn roughness(t: &[f64]) -> Mat<f64> {
    let n = t.len();
    let h: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut q = Mat::zeros(n, n - 2);
    let mut r = Mat::zeros(n - 2, n - 2);
    for j in 0..n - 2 {
        q[(j, j)] = 1.0 / h[j];
        q[(j + 1, j)] = -1.0 / h[j] - 1.0 / h[j + 1];
        q[(j + 2, j)] = 1.0 / h[j + 1];
        r[(j, j)] = (h[j] + h[j + 1]) / 3.0;
        if j + 1 < n - 2 {
            r[(j, j + 1)] = h[j + 1] / 6.0;
            r[(j + 1, j)] = h[j + 1] / 6.0;
        }
    }
    &q * r.partial_piv_lu().solve(q.transpose())
}

/// The influence matrix of the smoothing spline of numbers.
fn influence(t: &[f64], weights: &[f64], lambda: f64) -> Mat<f64> {
    let mut left = roughness(t) * Scale(lambda);
    let right = Mat::from_fn(
        t.len(),
        t.len(),
        |i, j| if i == j { weights[i] } else { 0.0 },
    );
    left += &right;
    left.partial_piv_lu().solve(&right)
}

fn angles(count: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let mut rng = Rng::new(3);
    let mut t = vec![0.3];
    for i in 1..count {
        t.push(t[i - 1] + rng.between(0.5, 1.5));
    }
    let y = t
        .iter()
        .map(|t| (0.4 * t).sin() + 0.3 * t + rng.between(-0.2, 0.2))
        .collect();
    let weights = t.iter().map(|_| rng.between(0.5, 2.0)).collect();
    (t, y, weights)
}

#[test]
fn on_the_circle_the_angle_is_smoothed() {
    let (t, y, weights) = angles(12);
    for lambda in [1e-3, 0.1, 1.0, 30.0] {
        let a = influence(&t, &weights, lambda);
        let expected = &a * Mat::from_fn(12, 1, |i, _| y[i]);
        let found = smooth(&t, &circle(&y), Some(&weights), lambda);
        let mut misfit = 0.0;
        for i in 0..12 {
            let point = found.curve.point(t[i]).unwrap();
            let wanted = &circle(&[expected[(i, 0)]])[0];
            assert_within(distance(&point, wanted), 1e-10, &format!("{lambda} {i}"));
            misfit += weights[i] * (expected[(i, 0)] - y[i]).powi(2);
        }
        assert_within((found.misfit - misfit).abs(), 1e-9 * misfit, "misfit");
        let trace: f64 = (0..12).map(|i| a[(i, i)]).sum();
        assert_within((found.degrees_of_freedom - trace).abs(), 1e-9, "trace");
    }
}

#[test]
fn infinite_weight_is_regression() {
    let (t, y, weights) = angles(12);
    let sum = |f: &dyn Fn(usize) -> f64| (0..12).map(|i| weights[i] * f(i)).sum::<f64>();
    let (w, wt, wy) = (sum(&|_| 1.0), sum(&|i| t[i]), sum(&|i| y[i]));
    let slope = (w * sum(&|i| t[i] * y[i]) - wt * wy) / (w * sum(&|i| t[i] * t[i]) - wt * wt);
    let line = |t: f64| (wy - slope * wt) / w + slope * t;
    let misfit = sum(&|i| (line(t[i]) - y[i]).powi(2));
    for lambda in [1e18, 1e60, 1e300, f64::INFINITY] {
        let found = smooth(&t, &circle(&y), Some(&weights), lambda);
        for t in &t {
            let point = found.curve.point(*t).unwrap();
            assert_within(distance(&point, &circle(&[line(*t)])[0]), 1e-11, "line");
        }
        assert_within((found.misfit - misfit).abs(), 1e-12, "misfit");
        assert_within(found.degrees_of_freedom - 2.0, 1e-12, "degrees of freedom");
        assert_within(found.curve.cost(Interrupt::NEVER).unwrap(), 1e-30, "cost");
    }
}

#[test]
fn cross_validation_finds_the_least_score() {
    let (t, y, weights) = angles(25);
    let score = |lambda: f64| {
        let a = influence(&t, &weights, lambda);
        let fitted = &a * Mat::from_fn(25, 1, |i, _| y[i]);
        let squares: f64 = (0..25)
            .map(|i| weights[i] * (fitted[(i, 0)] - y[i]).powi(2))
            .sum();
        let trace: f64 = (0..25).map(|i| a[(i, i)]).sum();
        25.0 * squares / (25.0 - trace).powi(2)
    };
    let points = circle(&y);
    let found = smoothing_spline(
        &t,
        &views(&points),
        Some(&weights),
        &SmoothingOptions::default(),
        Interrupt::NEVER,
    )
    .unwrap();
    let least = (0..400)
        .map(|i| score(10.0_f64.powf(-4.0 + 0.025 * f64::from(i))))
        .fold(f64::INFINITY, f64::min);
    assert!(
        score(found.lambda) <= least * (1.0 + 1e-6),
        "{} {least}",
        score(found.lambda)
    );
    for factor in [0.99, 1.01] {
        assert!(score(found.lambda * factor) >= score(found.lambda) * (1.0 - 1e-9));
    }
}

#[test]
fn data_pull_as_much_as_the_jerk_jumps() {
    for shape in [(3, 1), (3, 2), (3, 3), (4, 2), (6, 3), (20, 2)] {
        let (t, data) = noisy(shape, 9, 0.2, 5);
        for lambda in [0.05, 5.0] {
            let found = smooth(&t, &data, None, lambda);
            let manifold = Stiefel::new(shape.0, shape.1).unwrap();
            let pieces = found.curve.pieces();
            let h: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
            for i in 0..t.len() {
                let point = found.curve.point(t[i]).unwrap();
                let pull =
                    manifold.log(point.as_ref(), data[i].as_ref()).unwrap() * Scale(1.0 / lambda);
                let mut jump = Mat::zeros(shape.0, shape.1);
                let mut bend = Mat::zeros(shape.0, shape.1);
                if i < pieces.len() {
                    jump += pieces[i].jerk(0.0).unwrap() * Scale(h[i].powi(-3));
                    bend += pieces[i].acceleration(0.0).unwrap() * Scale(h[i].powi(-2));
                }
                if i > 0 {
                    jump -= pieces[i - 1].jerk(1.0).unwrap() * Scale(h[i - 1].powi(-3));
                    bend -= pieces[i - 1].acceleration(1.0).unwrap() * Scale(h[i - 1].powi(-2));
                }
                let name = format!("{shape:?} {lambda} {i}");
                // The tolerance of 1e-11 on positions, times the stiffness 24 / h^3 + 1 / lambda.
                assert_within(distance(&jump, &pull), 1e-7, &name);
                assert_within(bend.norm_l2(), 1e-9, &name);
            }
        }
    }
}

#[test]
fn little_weight_interpolates_and_much_weight_straightens() {
    for shape in [(3, 2), (3, 3), (20, 2)] {
        let (t, data) = noisy(shape, 7, 0.2, 6);
        let (through, _) = cubic_spline(
            &t,
            &views(&data),
            &EndConditions::Natural,
            &SplineOptions::default(),
            Interrupt::NEVER,
        )
        .unwrap();
        let close = smooth(&t, &data, None, 1e-9);
        let exact = smooth(&t, &data, None, 0.0);
        let middle = 0.5 * (t[2] + t[3]);
        let wanted = through.point(middle).unwrap();
        assert_within(
            distance(&close.curve.point(middle).unwrap(), &wanted),
            1e-6,
            "close",
        );
        assert_within(
            distance(&exact.curve.point(middle).unwrap(), &wanted),
            1e-10,
            "exact",
        );
        let straight = smooth(&t, &data, None, 1e6);
        assert!(
            straight.curve.cost(Interrupt::NEVER).unwrap() < 1e-9,
            "{shape:?}"
        );
        assert!((straight.degrees_of_freedom - 2.0).abs() < 1e-3);
        // With more weight, the cost decreases and the misfit increases.
        let mut before = (f64::INFINITY, 0.0);
        for lambda in [1e-3, 1e-1, 1.0, 10.0, 1e3] {
            let found = smooth(&t, &data, None, lambda);
            let cost = found.curve.cost(Interrupt::NEVER).unwrap();
            assert!(
                cost < before.0 && found.misfit > before.1,
                "{shape:?} {lambda}"
            );
            before = (cost, found.misfit);
        }
    }
}

#[test]
fn no_spline_through_distant_data_is_better() {
    // From the data alone, some of these splines are not found, or others that cost more.
    for shape in [(3, 1), (3, 2)] {
        let mut rng = Rng::new(76);
        for _ in 0..3 {
            let points: Vec<Mat<f64>> = (0..5)
                .map(|_| random_point(shape.0, shape.1, &mut rng))
                .collect();
            let t: Vec<f64> = (0..5).map(f64::from).collect();
            let (natural, options) = (EndConditions::Natural, SplineOptions::default());
            let (through, _) =
                cubic_spline(&t, &views(&points), &natural, &options, Interrupt::NEVER).unwrap();
            for lambda in [1e-8, 1e-5, 1e-3] {
                let found = smooth(&t, &points, None, lambda);
                let objective = found.misfit + lambda * found.curve.cost(Interrupt::NEVER).unwrap();
                let bound = lambda * through.cost(Interrupt::NEVER).unwrap();
                assert!(
                    objective <= bound * (1.0 + 1e-9) + 1e-20,
                    "{shape:?} {lambda}"
                );
            }
        }
    }
}

#[test]
fn repeated_data_count_by_their_weights() {
    let (t, data) = noisy((4, 2), 6, 0.2, 7);
    let weights = [1.0, 1.0, 3.0, 1.0, 1.0, 1.0];
    let once = smooth(&t, &data, Some(&weights), 0.5);
    let (mut times, mut more) = (t.clone(), data.clone());
    for _ in 0..2 {
        times.insert(3, t[2]);
        more.insert(3, data[2].clone());
    }
    let thrice = smooth(&times, &more, None, 0.5);
    for i in 0..=10 {
        let t = t[0] + 0.1 * f64::from(i) * (t[5] - t[0]);
        let both = [&once, &thrice].map(|s| s.curve.point(t.min(times[7])).unwrap());
        assert_within(distance(&both[0], &both[1]), 1e-10, "repeated");
    }
    // Different points at one time.
    more[4] = data[3].clone();
    let found = smoothing_spline(
        &times,
        &views(&more),
        None,
        &SmoothingOptions::default(),
        Interrupt::NEVER,
    )
    .unwrap();
    assert!(found.lambda > 0.0 && found.degrees_of_freedom > 2.0);
}

#[test]
fn isometries_and_time_carry_smoothing_along() {
    let (t, data) = noisy((4, 2), 8, 0.2, 8);
    let options = SmoothingOptions::default();
    let found = smoothing_spline(&t, &views(&data), None, &options, Interrupt::NEVER).unwrap();
    let mut rng = Rng::new(9);
    let (left, right) = (random_rotation(4, &mut rng), random_rotation(2, &mut rng));
    let turned: Vec<Mat<f64>> = data.iter().map(|s| &left * s * &right).collect();
    let image = smoothing_spline(&t, &views(&turned), None, &options, Interrupt::NEVER).unwrap();
    assert_within((image.lambda / found.lambda - 1.0).abs(), 1e-3, "lambda");
    let slower: Vec<f64> = t.iter().map(|t| 3.0 * t).collect();
    let slow = smooth(&slower, &data, None, 27.0 * found.lambda);
    let fixed = smooth(&t, &turned, None, found.lambda);
    for i in 0..=10 {
        let t = t[0] + 0.1 * f64::from(i) * (t[7] - t[0]);
        let point = found.curve.point(t).unwrap();
        let at = (3.0 * t).clamp(slower[0], slower[7]);
        assert_within(
            distance(&slow.curve.point(at).unwrap(), &point),
            1e-10,
            "time",
        );
        let image = &left * &point * &right;
        assert_within(
            distance(&fixed.curve.point(t).unwrap(), &image),
            1e-10,
            "isometry",
        );
    }
}

#[test]
fn bad_data_are_named() {
    let (t, data) = noisy((3, 2), 5, 0.1, 10);
    let solve = |t: &[f64], data: &[Mat<f64>], weights: Option<&[f64]>, lambda: Option<f64>| {
        let options = SmoothingOptions {
            lambda,
            ..SmoothingOptions::default()
        };
        smoothing_spline(t, &views(data), weights, &options, Interrupt::NEVER).map(|_| ())
    };
    for lambda in [-1.0, f64::NAN, f64::NEG_INFINITY] {
        assert!(matches!(
            solve(&t, &data, None, Some(lambda)),
            Err(Error::InvalidArgument { name: "lam", .. })
        ));
    }
    assert!(matches!(
        solve(&t, &data, Some(&[1.0; 4]), None),
        Err(Error::Shape {
            name: "weights",
            ..
        })
    ));
    for wrong in [0.0, -1.0, f64::NAN] {
        let weights = [1.0, 1.0, wrong, 1.0, 1.0];
        assert!(matches!(
            solve(&t, &data, Some(&weights), None),
            Err(Error::AtKnot { knot: 2, .. })
        ));
    }
    assert!(matches!(
        solve(&t[..2], &data[..2], None, None),
        Err(Error::Shape { name: "t", .. })
    ));
    let falling = [t[0], t[2], t[1], t[3], t[4]];
    assert!(matches!(
        solve(&falling, &data, None, None),
        Err(Error::AtKnot { knot: 2, .. })
    ));
    assert!(matches!(
        solve(&[t[0]; 5], &data, None, None),
        Err(Error::AtKnot { knot: 4, .. })
    ));
    let repeated = [t[0], t[1], t[1], t[3], t[4]];
    assert!(matches!(
        solve(&repeated, &data, None, Some(0.0)),
        Err(Error::InvalidArgument { name: "lam", .. })
    ));
}

#[test]
fn cross_validation_of_many_data_and_of_unequal_times() {
    // With unit steps, the largest tried values of lambda exceed the range of floating-point numbers.
    let mut rng = Rng::new(11);
    for count in [500, 2000] {
        let angle = |i: usize| (6.0 * i as f64 / count as f64).sin();
        let y: Vec<f64> = (0..count)
            .map(|i| angle(i) + rng.between(-0.2, 0.2))
            .collect();
        let t: Vec<f64> = (0..count).map(|i| i as f64).collect();
        let points = circle(&y);
        let found = smoothing_spline(
            &t,
            &views(&points),
            None,
            &SmoothingOptions::default(),
            Interrupt::NEVER,
        )
        .unwrap();
        let worst = (0..count)
            .map(|i| distance(&found.curve.point(t[i]).unwrap(), &circle(&[angle(i)])[0]))
            .fold(0.0, f64::max);
        assert!(worst < 0.1, "{count}: {worst}");
    }
}

#[test]
fn close_times_and_a_heavy_cost() {
    // Two close times and a large weight of the cost: the misfit of a straight line is 0.068, and anything far above is
    // no minimum.
    let t = [0.0, 1e-4, 1.0, 2.0, 3.0];
    let data = circle(&[0.0, 0.2, 0.5, 1.1, 1.2]);
    for lambda in [1.0, 1e2, 1e4, 1e6, 1e10] {
        let options = SmoothingOptions {
            lambda: Some(lambda),
            ..SmoothingOptions::default()
        };
        let found = smoothing_spline(&t, &views(&data), None, &options, Interrupt::NEVER).unwrap();
        let objective = found.misfit + lambda * found.curve.cost(Interrupt::NEVER).unwrap();
        // If times are 1e-4 apart, 1e-6 is round-off of accelerations, and its square round-off of the cost.
        assert!(
            objective <= 0.0681 + 1e-12 * lambda,
            "{lambda}: {objective}"
        );
    }
}
