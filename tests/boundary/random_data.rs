//! Random boundary data: success rates, and symmetries of the solutions.

use faer::Mat;
use stiefel_rs::cubic::IntegrationOptions;
use stiefel_rs::{Curve, Error, Interrupt, Strategy};

use crate::common::{
    Rng, assert_close, assert_within, cubic_from, distance, frobenius, random_orthogonal,
    random_point, random_tangent,
};
use crate::data::{Data, END};

pub const SHAPES: [(usize, usize); 6] = [(3, 1), (3, 2), (4, 2), (5, 2), (6, 3), (10, 3)];

#[test]
fn moderate_data_are_solved_from_the_flat_start() {
    for shape in SHAPES {
        let (mut rng, mut moderate) = (Rng::new(11), 0);
        let count = if shape.0 > 5 { 10 } else { 60 };
        for _ in 0..count {
            let data = Data::random(shape, 2.0, 2.0, &mut rng);
            let curve = data.solve().unwrap_or_else(|e| panic!("{shape:?}: {e}"));
            let report = curve.report().unwrap();
            assert!(report.converged && report.residual <= 1e-12);
            assert_within(data.defect(&curve), END, &format!("{shape:?}"));
            // If the quasi-geodesic is longer than the distance, a curve on another branch may cost less.
            if !data.is_moderate() {
                continue;
            }
            moderate += 1;
            assert_eq!(report.strategy, Some(Strategy::Direct), "{report}");
            assert!(report.iterations <= 12, "{shape:?}: {report}");
        }
        assert!(
            10 * moderate >= 9 * count,
            "{shape:?}: {moderate} of {count}"
        );
    }
}

/// Problems whose descents would exceed the work limit are solved from the flat start alone.
#[test]
fn far_data_of_many_unknowns_are_solved() {
    for (shape, longest) in [
        ((20, 5), 2.0),
        ((100, 5), 2.0),
        ((24, 6), 1.5),
        ((40, 10), 1.2),
    ] {
        let mut rng = Rng::new(17);
        let count = if shape.1 > 5 { 1 } else { 4 };
        for _ in 0..count {
            let data = Data::random(shape, longest, 2.0 * longest, &mut rng);
            let curve = data.solve().unwrap_or_else(|e| panic!("{shape:?}: {e}"));
            let report = curve.report().unwrap();
            assert!(report.converged && report.residual <= 1e-12);
            assert_eq!(report.strategy, Some(Strategy::Direct), "{report}");
            assert_within(data.defect(&curve), END, &format!("{shape:?}"));
        }
    }
}

#[test]
fn far_and_fast_data_are_solved() {
    for (shape, count) in [
        ((3, 1), 200),
        ((3, 2), 100),
        ((4, 2), 50),
        ((5, 2), 30),
        ((6, 3), 10),
    ] {
        let mut rng = Rng::new(12);
        let (mut failures, mut strategies) = (Vec::new(), Vec::new());
        for _ in 0..count {
            let data = Data::random(shape, 3.0, 6.0, &mut rng);
            match data.solve() {
                Ok(curve) => {
                    assert_within(data.defect(&curve), END, &format!("{shape:?}"));
                    let report = curve.report().unwrap();
                    assert!(report.converged && report.residual <= 1e-12);
                    strategies.push(report.strategy);
                }
                Err(Error::NoConvergence { report, .. }) => failures.push(report),
                Err(error) => panic!("{shape:?}: {error}"),
            }
        }
        println!("{shape:?}: {} of {count} fail {failures:?}", failures.len());
        if shape == (3, 1) {
            // Moderate data are included.
            for strategy in [Strategy::Direct, Strategy::Descent] {
                assert!(strategies.contains(&Some(strategy)), "{strategy:?}");
            }
        }
        // At most one in a hundred.
        assert!(100 * failures.len() <= count, "{shape:?}: {failures:?}");
    }
}

/// Curves that are too fast for Newton's method at nodes: the legs of the descent are then one curve, whose derivatives up
/// to the third do not jump.
#[test]
fn fast_data_are_solved_on_the_chain_of_the_descent() {
    for (shape, speed) in [
        ((3, 1), 60.0),
        ((3, 2), 40.0),
        ((4, 2), 30.0),
        ((3, 3), 40.0),
    ] {
        let mut rng = Rng::new(33);
        for _ in 0..3 {
            let mut data = Data::random(shape, 2.0, 1.0, &mut rng);
            data.v0 = random_tangent(&data.s0, speed, &mut rng);
            data.v1 = random_tangent(&data.s1, 0.9 * speed, &mut rng);
            let what = format!("{shape:?} at speed {speed}");
            let curve = data.solve().unwrap_or_else(|e| panic!("{what}: {e}"));
            assert_eq!(curve.report().unwrap().strategy, Some(Strategy::Descent));
            assert!(curve.steps() > 8, "{what}: {} pieces", curve.steps());
            assert_within(data.defect(&curve), END * speed, &what);
            // Legs begin at multiples of an eighth, at least.
            for t in (1..8).map(|i| f64::from(i) / 8.0) {
                let unit = 1e-13;
                for order in 0..4 {
                    let at = |t: f64| curve.derivative(t, order).unwrap();
                    let size = speed.powi(order as i32 + 1);
                    let jump = distance(&at(t - unit), &at(t + unit));
                    assert_within(jump, 1e-11 * size, &format!("{what}, derivative {order}"));
                }
            }
        }
    }
}

/// The curve of least cost continues in the direction of its speed; solutions that brake instead cost a hundred times
/// as much.
#[test]
fn speeds_of_thirty_are_solved_from_both_ends() {
    let speed = 30.0;
    for (shape, count) in [((3, 1), 8), ((4, 1), 4), ((3, 2), 6), ((3, 3), 6)] {
        let mut rng = Rng::new(21);
        for _ in 0..count {
            let mut data = Data::random(shape, 3.0, 1.0, &mut rng);
            data.v0 = random_tangent(&data.s0, speed, &mut rng);
            data.v1 = random_tangent(&data.s1, speed, &mut rng);
            let there = data.solve().unwrap_or_else(|e| panic!("{shape:?}: {e}"));
            let cost = there.cost(Interrupt::NEVER).unwrap();
            assert!(cost < 10.0 * speed * speed, "{shape:?}: {cost:.3e}");
            assert_within(data.defect(&there), speed * END, &format!("{shape:?}"));
            let back = data.reversed().solve().unwrap();
            let ratio = back.cost(Interrupt::NEVER).unwrap() / cost;
            assert_within((ratio - 1.0).abs(), 1e-9, &format!("{shape:?}, reversed"));
        }
    }
}

/// Around a circle and back to the start with the same velocity: `12 (2 pi m - v)^2` for `m` turns.
#[test]
fn whole_turns_are_made_as_often_as_the_speed_says() {
    let turn = std::f64::consts::TAU;
    for speed in [turn, turn + 1e-12, 9.0, 10.0, 12.0, 2.0 * turn, 14.0, 15.5] {
        for n in [2, 3] {
            let unit =
                |row: usize, x: f64| Mat::from_fn(n, 1, |i, _| if i == row { x } else { 0.0 });
            let (s, v) = (unit(0, 1.0), unit(1, speed));
            let data = Data {
                s0: s.clone(),
                v0: v.clone(),
                s1: s,
                v1: v,
            };
            let cost = data.solve().unwrap().cost(Interrupt::NEVER).unwrap();
            let turns = (speed / turn).round();
            let least = 12.0 * (turns * turn - speed).powi(2);
            assert!(
                cost <= 1.01 * least + 1e-12,
                "speed {speed}: {cost:.3e}, least {least:.3e}"
            );
        }
    }
}

#[test]
fn the_equation_is_satisfied() {
    // D_t^3 S' + R(D_t S', S') S' = 0, verified by the conservation of energy and momentum along the curve.
    let mut rng = Rng::new(13);
    for shape in [(3, 1), (4, 2), (5, 3), (9, 2)] {
        let curve = Data::random(shape, 2.0, 2.0, &mut rng).solve().unwrap();
        let options = IntegrationOptions::default();
        let state = |t: f64| {
            let (s, v) = (curve.point(t).unwrap(), curve.derivative(t, 1).unwrap());
            let (a, j) = (curve.acceleration(t).unwrap(), curve.jerk(t).unwrap());
            cubic_from([&s, &v, &a, &j], &options)
        };
        let size = 1.0 + frobenius(curve.momentum().unwrap().as_ref());
        for t in [0.3, 0.8] {
            let later = state(t);
            let drift = distance(&later.momentum().unwrap(), &curve.momentum().unwrap());
            assert_within(drift, 1e-11 * size, &format!("{shape:?} momentum"));
            assert_within(
                (later.energy().unwrap() - curve.energy().unwrap()).abs(),
                1e-10 * size * size,
                "energy",
            );
        }
    }
}

#[test]
fn symmetries_carry_solutions_to_solutions() {
    let mut rng = Rng::new(14);
    for shape in [(3, 1), (3, 2), (5, 2), (6, 3), (4, 4)] {
        let data = Data::random(shape, 1.5, 1.5, &mut rng);
        let curve = data.solve().unwrap();
        let (q, p) = (
            random_orthogonal(shape.0, &mut rng),
            random_orthogonal(shape.1, &mut rng),
        );
        let turned = data.map(|x| &q * x * &p).solve().unwrap();
        let back = data.reversed().solve().unwrap();
        // The residual times the growth of an error over the interval.
        for t in [0.0, 0.25, 0.6, 1.0] {
            let point = curve.point(t).unwrap();
            assert_close(
                &turned.point(t).unwrap(),
                &(&q * &point * &p),
                1e-10,
                "O(n) and O(k)",
            );
            assert_close(
                &back.point(1.0 - t).unwrap(),
                &point,
                1e-10,
                "time reversal",
            );
        }
    }
}

#[test]
fn the_reduction_loses_nothing() {
    let mut rng = Rng::new(15);
    let small = Data::random((8, 2), 1.5, 1.5, &mut rng);
    let frame = random_point(30, 8, &mut rng);
    let large = small.map(|x| &frame * x);
    let (small, large) = (small.solve().unwrap(), large.solve().unwrap());
    for t in [0.2, 0.7] {
        let lifted = &frame * small.point(t).unwrap();
        assert_close(&large.point(t).unwrap(), &lifted, 1e-11, "reduction");
    }
}
