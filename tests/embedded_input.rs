//! The method in the embedding: curves at rest, coordinate columns, and bad, huge and tiny input.

mod common;
#[path = "common/embedded.rs"]
mod embedding;
#[path = "common/splitting.rs"]
mod trajectories;

use common::*;
use embedding::*;
use faer::{Mat, Scale};
use stiefel_rs::chart::{CovariantData, Sphere, state_from_covariant};
use stiefel_rs::cubic::{CubicTrajectory, integrate_embedded};
use stiefel_rs::{Error, Interrupt, StopReason};
use trajectories::{difference, random_data, size, state};

#[test]
fn at_rest_it_stays() {
    for shape in SHAPES {
        let zero = Mat::zeros(shape.0, shape.1);
        let [s, ..] = random_data(shape, 1.0, 61);
        let data = [s, zero.clone(), zero.clone(), zero];
        for (steps, t_end) in [(1, 1.0), (9, -3.0), (2, 1e300)] {
            let bound = 8.0 * shape.0 as f64 * EPS;
            let found = embedded_end(&data, steps, t_end);
            assert_within(difference(&found, &data), bound, &format!("{shape:?}"));
        }
    }
}

/// Columns of the identity, where the paper's chart has its pole, and data in one plane.
#[test]
fn coordinate_columns_are_points_like_others() {
    let unit = |n: usize, i: usize| Mat::from_fn(n, 1, |row, _| f64::from(u8::from(row == i)));
    let pole = [unit(3, 2), unit(3, 0), unit(3, 1), Mat::zeros(3, 1)];
    let [point, velocity, acceleration, jerk] = pole.clone();
    let covariant = CovariantData {
        point,
        velocity,
        acceleration,
        jerk,
    };
    let refused = state_from_covariant(&Sphere, &covariant);
    assert!(matches!(refused, Err(Error::OutsideChart { .. })));
    let plane = [unit(3, 0), unit(3, 1), unit(3, 1), unit(3, 1)];
    let n = 5;
    let s = Mat::from_fn(n, 2, |i, j| f64::from(u8::from(i == j)));
    let tangent = |seed| random_tangent(&s, 1.0, &mut Rng::new(seed));
    let frame = [s.clone(), tangent(1), tangent(2), tangent(3)];
    for data in [pole, plane, frame] {
        let exact = exact(&data, 1.0);
        let errors = [50, 100].map(|steps| difference(&embedded_end(&data, steps, 1.0), &exact));
        println!("{:?}: {errors:?}", data[0].shape());
        assert_within(errors[0], 2e-2, "coordinate columns");
        assert_within(
            (errors[0] / errors[1]).log2() - 2.0,
            0.2,
            "coordinate columns: order",
        );
    }
}

#[test]
fn bad_input_is_refused() {
    let data = random_data((4, 2), 1.0, 62);
    let argument = |result: Result<CubicTrajectory, Error>| match result {
        Err(Error::InvalidArgument { name, .. }) => name,
        other => panic!("{other:?}"),
    };
    for steps in [0, usize::MAX, usize::MAX / 64] {
        assert_eq!(argument(try_embedded(&data, steps, 1.0)), "steps");
    }
    assert_eq!(argument(try_embedded(&data, 3, 0.0)), "t_end");
    for t_end in [f64::NAN, f64::INFINITY] {
        let result = try_embedded(&data, 3, t_end);
        assert!(matches!(
            result,
            Err(Error::NonFinite { name: "t_end", .. })
        ));
    }
    for i in 0..4 {
        let wrong = |matrix: Mat<f64>| {
            let mut wrong = data.clone();
            wrong[i] = matrix;
            try_embedded(&wrong, 3, 1.0).unwrap_err()
        };
        let mut nan = data[i].clone();
        nan[(0, 0)] = f64::NAN;
        assert!(matches!(wrong(nan), Error::NonFinite { .. }));
        let error = wrong(Mat::zeros(5, 2));
        assert!(matches!(
            error,
            Error::Shape { .. } | Error::NotOrthonormal { .. }
        ));
        let error = wrong(&data[0] * Scale(1.5));
        assert!(matches!(
            error,
            Error::NotOrthonormal { .. } | Error::NotTangent { .. }
        ));
    }
}

/// A step that is too long does not converge, and the error says how far the iteration got.
#[test]
fn steps_that_are_too_long_are_refused() {
    let data = random_data((4, 2), 1.0, 63);
    match try_embedded(&data, 1, 20.0) {
        Err(Error::NoConvergence { report, .. }) => {
            assert!(!report.converged && report.residual > report.tolerance);
            assert!(matches!(
                report.reason,
                StopReason::Diverged | StopReason::MaxIterations
            ));
        }
        other => panic!("{other:?}"),
    }
}

/// Either a correct result or an error, but neither NaN nor an endless loop.
#[test]
fn huge_and_tiny_data_and_times_are_refused_or_right() {
    for shape in [(3, 1), (3, 2), (4, 2), (1, 1), (20, 2)] {
        for speed in [1e-200, 1e-8, 1.0, 1e8, 1e160, 1e300] {
            for t_end in [1e-300, 1.0, 1e6, 1e200, 1e308] {
                let what = format!("{shape:?} {speed:e} {t_end:e}");
                match try_embedded(&random_data(shape, speed, 64), 4, t_end) {
                    Ok(trajectory) => {
                        let state = state(&trajectory, 4);
                        assert!(size(&state).is_finite(), "{what}");
                        assert_within(orthonormality(&state[0]), 1e-9, &what);
                    }
                    Err(Error::Overflow { .. } | Error::NoConvergence { .. }) => {}
                    Err(other) => panic!("{what}: {other}"),
                }
            }
        }
    }
}

#[test]
fn it_can_be_stopped() {
    let data = random_data((4, 2), 1.0, 65);
    let [s, v, a, j] = data.each_ref().map(Mat::as_ref);
    let question = || true;
    let result = integrate_embedded(s, v, a, j, 10, 1.0, Interrupt::new(&question));
    assert!(matches!(result, Err(Error::Interrupted { .. })));
}
