//! Riemannian cubics for unusual and bad input: a typed error or the correct result, after few steps.

mod common;

use std::sync::atomic::{AtomicUsize, Ordering};

use common::*;
use faer::{Mat, Scale};
use stiefel_rs::cubic::IntegrationOptions;
use stiefel_rs::{Curve, Error, Interrupt, Result, RiemannianCubic};

/// Number of steps allowed for these integrations, far below the limit of 100000. The longest takes 1158; one that
/// would exceed the limit is stopped by a forecast.
const FEW: usize = 2_000;

fn from_state(state: &[Mat<f64>; 4], t_end: f64) -> Result<RiemannianCubic> {
    // The interrupt is polled before each step.
    let steps = AtomicUsize::new(0);
    let count = || {
        steps.fetch_add(1, Ordering::Relaxed);
        false
    };
    let options = IntegrationOptions {
        t_end,
        ..IntegrationOptions::default()
    };
    let [s, v, a, j] = state.each_ref().map(|x| x.as_ref());
    let result = RiemannianCubic::from_initial(s, v, a, j, &options, Interrupt::new(&count));
    let steps = steps.into_inner();
    assert!(steps <= FEW, "t_end {t_end:e}: {steps} steps");
    if let Ok(curve) = &result {
        let between = curve.steps() as f64 / steps as f64;
        assert!(between <= 1.0, "{between} steps between two checks");
    }
    result
}

/// A state with unit vectors, multiplied by the given lengths.
fn state((n, k): (usize, usize), scales: [f64; 3]) -> [Mat<f64>; 4] {
    let mut rng = Rng::new((5 * n + k) as u64);
    let s = random_point(n, k, &mut rng);
    let [v, a, j] = scales.map(|scale| random_tangent(&s, 1.0, &mut rng) * Scale(scale));
    [s, v, a, j]
}

const SHAPES: [(usize, usize); 5] = [(3, 1), (2, 1), (3, 2), (3, 3), (20, 2)];

/// All values of the curve are finite, or errors.
fn assert_finite(curve: &RiemannianCubic, what: &str) {
    let (start, end) = curve.t_span();
    if let Ok(x) = curve.jerk(3.0 * end - 2.0 * start) {
        assert!(largest_entry(x.as_ref()).is_finite(), "{what}: beyond");
    }
    for t in [start, 0.5 * start + 0.5 * end, end] {
        for nu in 0..=3 {
            if let Ok(x) = curve.derivative(t, nu) {
                assert!(
                    largest_entry(x.as_ref()).is_finite(),
                    "{what}: order {nu} at {t}"
                );
            }
        }
        for x in [curve.acceleration(t), curve.jerk(t)].into_iter().flatten() {
            assert!(largest_entry(x.as_ref()).is_finite(), "{what}: at {t}");
        }
        if let Ok(x) = curve.point(t) {
            let bound = 1e-12 + 8.0 * EPS * curve.steps() as f64;
            assert_within(orthonormality(&x), bound, &format!("{what}: at {t}"));
        }
    }
    for number in [curve.cost(Interrupt::NEVER), curve.energy()]
        .into_iter()
        .flatten()
    {
        assert!(number.is_finite(), "{what}");
    }
    if let Ok(x) = curve.momentum() {
        assert!(largest_entry(x.as_ref()).is_finite(), "{what}: momentum");
    }
    if let Ok(data) = curve.initial() {
        for x in data {
            assert!(largest_entry(x.as_ref()).is_finite(), "{what}: initial");
        }
    }
}

#[test]
fn extreme_speeds_and_times() {
    let scales = [0.0, 1e-300, 1e-160, 1e-6, 1.0, 30.0, 1e150, 1e300];
    for shape in SHAPES {
        for i in 0..scales.len().pow(2) {
            let v = scales[i % scales.len()];
            let (a, j) = (scales[i / scales.len()], scales[(3 * i + 1) % scales.len()]);
            for t_end in [1.0, -1.0, 1e-300, 1e-9, 1e9, 1e300] {
                let what = format!("{shape:?}, V {v:e}, A {a:e}, J {j:e}, t_end {t_end:e}");
                let data = state(shape, [v, a, j]);
                match from_state(&data, t_end) {
                    Ok(curve) => assert_finite(&curve, &what),
                    Err(Error::TooManySteps { report, .. }) => {
                        assert!(!report.converged && report.residual > 0.0, "{what}");
                        assert!(report.residual.is_finite(), "{what}: {report}");
                    }
                    Err(Error::Overflow { .. }) => {}
                    Err(other) => panic!("{what}: {other}"),
                }
            }
        }
    }
}

/// The slowest and the fastest curves are the ordinary one, traversed in another time.
#[test]
fn the_unit_of_time_does_not_matter() {
    for shape in SHAPES {
        let [s, v, a, j] = state(shape, [1.0, 2.0, 3.0]);
        let curve = from_state(&[s.clone(), v.clone(), a.clone(), j.clone()], 1.0).unwrap();
        // Powers of two cause no rounding; the jerk scales with the third power.
        for power in [-300, -30, 7, 300] {
            let rate = 2.0_f64.powi(power);
            let scaled = |x: &Mat<f64>, order: i32| x * Scale(rate.powi(order));
            let data = [s.clone(), scaled(&v, 1), scaled(&a, 2), scaled(&j, 3)];
            let other = from_state(&data, 1.0 / rate).unwrap();
            for t in [0.0, 0.3, 1.0] {
                assert_eq!(other.point(t / rate).unwrap(), curve.point(t).unwrap());
            }
            let initial = other.initial().unwrap();
            for (found, given) in initial.iter().zip(&data) {
                let size = largest_entry(given.as_ref());
                let error = largest_entry((found - given).as_ref()) / size;
                assert_within(error, 20.0 * EPS * shape.0 as f64, "initial data");
            }
        }
    }
}

#[test]
fn slow_and_short_curves_are_right() {
    for shape in SHAPES {
        for scale in [1e-300, 1e-160, 1e-20] {
            let data = state(shape, [scale, 0.0, 0.0]);
            let curve = from_state(&data, 1.0).unwrap();
            assert_close(&curve.point(1.0).unwrap(), &data[0], 1e-15, "hardly moves");
            let error = (curve.derivative(1.0, 1).unwrap() - &data[1]) * Scale(1.0 / scale);
            assert_within(frobenius(error.as_ref()), 1e-14, "velocity of a slow curve");
            // In a proportional time it comes as far as any other.
            let there = from_state(&data, 1.0 / scale).unwrap();
            let unit = from_state(&state(shape, [1.0, 0.0, 0.0]), 1.0).unwrap();
            let (found, expected) = (there.point(1.0 / scale), unit.point(1.0));
            assert_close(&found.unwrap(), &expected.unwrap(), 1e-14, "slow and long");
        }
        for scale in [1e20, 1e150, 1e300] {
            let data = state(shape, [scale, 0.0, 0.0]);
            let curve = from_state(&data, 1.0 / scale).unwrap();
            let unit = from_state(&state(shape, [1.0, 0.0, 0.0]), 1.0).unwrap();
            let (found, expected) = (curve.point(1.0 / scale), unit.point(1.0));
            assert_close(&found.unwrap(), &expected.unwrap(), 1e-14, "fast and short");
        }
    }
}

#[test]
fn bad_times_and_tolerances() {
    let data = state((5, 2), [1.0; 3]);
    for t_end in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let result = from_state(&data, t_end);
        assert!(
            matches!(result, Err(Error::NonFinite { name: "t_end", .. })),
            "{t_end}"
        );
    }
    for zero in [0.0, -0.0] {
        let result = from_state(&data, zero);
        assert!(matches!(
            result,
            Err(Error::InvalidArgument { name: "t_end", .. })
        ));
    }
    let [s, v, a, j] = data.each_ref().map(|x| x.as_ref());
    for tolerance in [0.0, -1.0, 1e-18, 0.2, f64::NAN, f64::INFINITY] {
        let options = IntegrationOptions {
            tolerance,
            ..IntegrationOptions::default()
        };
        let result = RiemannianCubic::from_initial(s, v, a, j, &options, Interrupt::NEVER);
        let found = matches!(
            result,
            Err(Error::InvalidArgument {
                name: "tolerance",
                ..
            })
        );
        assert!(found, "{tolerance}");
    }
    for t_end in [1e6, -1e6, 1e300, f64::MAX] {
        let result = from_state(&data, t_end);
        let Err(Error::TooManySteps {
            limit,
            forecast,
            report,
            ..
        }) = result
        else {
            panic!("{t_end}: {result:?}");
        };
        // It is stopped by the forecast, long before the limit.
        assert!(report.iterations < limit && report.iterations as f64 + forecast > limit as f64);
        let text = result.unwrap_err().to_string();
        assert!(text.contains("more than 100000 steps"), "{text}");
        assert!(
            !report.converged && report.residual <= t_end.abs(),
            "{report}"
        );
    }
}

#[test]
fn bad_intervals() {
    let curve = from_state(&state((5, 2), [1.0; 3]), 1.0).unwrap();
    for (start, end) in [(1.0, 1.0), (1.0, 0.0), (0.0, -1.0), (f64::MIN, f64::MAX)] {
        let parts = [
            curve.restricted(start, end, Interrupt::NEVER),
            curve.reparametrised(start, end),
        ];
        for result in parts {
            let found = matches!(result, Err(Error::InvalidArgument { name: "end", .. }));
            assert!(found, "[{start}, {end}]: {result:?}");
        }
    }
    for (start, end) in [(f64::NAN, 1.0), (0.0, f64::NAN), (0.0, f64::INFINITY)] {
        for result in [
            curve.restricted(start, end, Interrupt::NEVER),
            curve.reparametrised(start, end),
        ] {
            assert!(
                matches!(result, Err(Error::NonFinite { .. })),
                "[{start}, {end}]"
            );
        }
    }
    let far = curve.restricted(0.0, 1e9, Interrupt::NEVER);
    assert!(matches!(far, Err(Error::TooManySteps { .. })), "{far:?}");
}

#[test]
fn extreme_parameters_lose_nothing() {
    for shape in SHAPES {
        let curve = from_state(&state(shape, [1.0, 2.0, 3.0]), 1.0).unwrap();
        for length in [1e-300, 1e-100, 1e-16, 1e16, 1e100, 1e300] {
            let other = curve.reparametrised(0.0, length).unwrap();
            for t in [0.0, 0.25, 1.0] {
                let (found, expected) = (other.point(t * length), curve.point(t));
                assert_close(&found.unwrap(), &expected.unwrap(), 1e-14, "point");
            }
            assert_finite(&other, &format!("{shape:?} on [0, {length:e}]"));
            let back = other.reparametrised(0.0, 1.0).unwrap();
            let (found, expected) = (back.jerk(0.5).unwrap(), curve.jerk(0.5).unwrap());
            assert_close(&found, &expected, 1e-11, "jerk there and back");
        }
        let speed = curve.reparametrised(0.0, 1e300).unwrap();
        let again = speed.reparametrised(0.0, 1e-300).unwrap();
        assert_close(
            &again.point(1e-300).unwrap(),
            &curve.point(1.0).unwrap(),
            1e-14,
            "end",
        );
        let result = speed
            .reparametrised(0.0, f64::MAX)
            .and_then(|c| c.reparametrised(0.0, 1.0));
        if let Ok(same) = result {
            assert_close(
                &same.point(1.0).unwrap(),
                &curve.point(1.0).unwrap(),
                1e-14,
                "end",
            );
        }
    }
}

#[test]
fn bad_matrices() {
    let [s, v, a, j] = state((5, 2), [1.0; 3]);
    let with = |i: usize, x: Mat<f64>| {
        let mut data = [s.clone(), v.clone(), a.clone(), j.clone()];
        data[i] = x;
        from_state(&data, 1.0)
    };
    for (i, expected) in ["S", "V", "A", "J"].into_iter().enumerate() {
        let mut broken = [s.clone(), v.clone(), a.clone(), j.clone()][i].clone();
        broken[(4, 1)] = f64::NAN;
        let result = with(i, broken);
        assert!(matches!(result, Err(Error::NonFinite { name, .. }) if name == expected));
        for shape in [(4, 2), (5, 1), (0, 0), (5, 0), (2, 5)] {
            let result = with(i, Mat::zeros(shape.0, shape.1));
            let refused = matches!(
                result,
                Err(Error::Shape { .. } | Error::NotOrthonormal { .. })
            );
            assert!(refused, "{expected} of shape {shape:?}: {result:?}");
        }
    }
    let result = with(0, &s * Scale(1.0 + 1e-6));
    assert!(matches!(
        result,
        Err(Error::NotOrthonormal { name: "S", .. })
    ));
    for (i, expected) in ["V", "A", "J"].into_iter().enumerate() {
        let result = with(i + 1, &v + &s * Scale(1e-3));
        assert!(matches!(result, Err(Error::NotTangent { name, .. }) if name == expected));
    }
}

#[test]
fn what_does_not_fit_into_memory_is_refused() {
    let n = 20_000;
    let s = Mat::from_fn(n, 1, |i, _| f64::from(u8::from(i == 0)));
    let v = Mat::from_fn(n, 1, |i, _| f64::from(u8::from(i == 1)));
    let a = Mat::from_fn(n, 1, |i, _| f64::from(u8::from(i == 2)));
    let curve = from_state(&[s, v, a.clone(), a], 1.0).unwrap();
    let result = curve.momentum();
    assert!(
        matches!(result, Err(Error::InvalidArgument { name: "n", .. })),
        "{:?}",
        result.err()
    );
    assert!(curve.energy().unwrap().is_finite());
}

#[test]
fn a_question_stops_an_integration() {
    let data = state((40, 10), [1.0; 3]);
    let [s, v, a, j] = data.each_ref().map(|x| x.as_ref());
    let stop = || true;
    let options = IntegrationOptions {
        t_end: 100.0,
        ..IntegrationOptions::default()
    };
    let result = RiemannianCubic::from_initial(s, v, a, j, &options, Interrupt::new(&stop));
    assert!(matches!(result, Err(Error::Interrupted { .. })));
    let curve = from_state(&data, 1.0).unwrap();
    let far = curve.sample(
        &[0.5, 50.0],
        stiefel_rs::Quantity::Derivative(0),
        Interrupt::new(&stop),
    );
    assert!(matches!(far, Err(Error::Interrupted { .. })));
    let far = curve.restricted(0.0, 50.0, Interrupt::new(&stop));
    assert!(matches!(far, Err(Error::Interrupted { .. })));
}

#[test]
fn parameters_that_are_no_numbers() {
    let curve = from_state(&state((5, 2), [1.0; 3]), 1.0).unwrap();
    for t in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(matches!(
            curve.point(t),
            Err(Error::NonFinite { name: "t", .. })
        ));
        assert!(matches!(
            curve.jerk(t),
            Err(Error::NonFinite { name: "t", .. })
        ));
    }
    for t in [1e9, -1e9, f64::MAX, f64::MIN] {
        let result = curve.point(t);
        assert!(matches!(result, Err(Error::TooManySteps { .. })), "{t}");
    }
}
