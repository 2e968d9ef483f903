//! The explicit symplectic splitting for bad and huge input: a typed error or the correct result, and interrupts.

mod common;
#[path = "common/splitting.rs"]
mod trajectories;

use common::*;
use faer::{Mat, Scale};
use stiefel_rs::cubic::{CubicTrajectory, SplittingOptions, SplittingOrder, integrate_cubic};
use stiefel_rs::{Error, Interrupt};
use trajectories::*;

#[test]
fn bad_input_is_refused() {
    let data = random_data((4, 2), 1.0, 22);
    let six = SplittingOrder::Six;
    let argument = |result: Result<CubicTrajectory, Error>| match result {
        Err(Error::InvalidArgument { name, .. }) => name,
        other => panic!("{other:?}"),
    };
    assert_eq!(argument(try_integrate(&data, 0, six, 1.0)), "steps");
    assert_eq!(
        argument(try_integrate(&data, usize::MAX, six, 1.0)),
        "steps"
    );
    assert_eq!(
        argument(try_integrate(&data, usize::MAX / 64, six, 1.0)),
        "steps"
    );
    assert_eq!(argument(try_integrate(&data, 3, six, 0.0)), "t_end");
    for shape in [(4, 2), (3, 1), (3, 2)] {
        let data = random_data(shape, 1.0, 22);
        assert!(matches!(
            try_integrate(&data, 3, six, 1e4),
            Err(Error::TooFewSteps { angle, largest: 100.0 }) if angle > 100.0
        ));
    }
    for t_end in [f64::NAN, f64::INFINITY] {
        let result = try_integrate(&data, 3, six, t_end);
        assert!(matches!(
            result,
            Err(Error::NonFinite { name: "t_end", .. })
        ));
    }
    for i in 0..4 {
        let mut wrong = data.clone();
        wrong[i][(0, 0)] = f64::NAN;
        assert!(matches!(
            try_integrate(&wrong, 3, six, 1.0),
            Err(Error::NonFinite { .. })
        ));
        let mut wrong = data.clone();
        wrong[i] = Mat::zeros(5, 2);
        assert!(matches!(
            try_integrate(&wrong, 3, six, 1.0),
            Err(Error::Shape { .. } | Error::NotOrthonormal { .. })
        ));
        let mut wrong = data.clone();
        wrong[i] = &data[0] * Scale(1.5);
        let result = try_integrate(&wrong, 3, six, 1.0);
        assert!(matches!(
            result,
            Err(Error::NotOrthonormal { .. } | Error::NotTangent { .. })
        ));
    }
    for order in [-2, 0, 1, 3, 5, 7, 10] {
        let refused = SplittingOrder::try_from(order);
        assert!(matches!(
            refused,
            Err(Error::InvalidArgument { name: "order", .. })
        ));
    }
    for order in ORDERS {
        assert_eq!(SplittingOrder::try_from(order.number() as i64), Ok(order));
    }
}

/// Either a correct result or an error, but neither NaN nor an endless loop.
#[test]
fn huge_data_and_times_are_refused_or_right() {
    for shape in [(3, 1), (3, 2), (4, 2), (1, 1), (20, 2)] {
        for (speed, t_end) in [
            (1e8, 1.0),
            (1e160, 1.0),
            (1e300, 1.0),
            (1.0, 1e6),
            (1.0, 1e200),
            (1.0, 1e308),
        ] {
            let data = random_data(shape, speed, 23);
            for order in ORDERS {
                match try_integrate(&data, 4, order, t_end) {
                    Ok(trajectory) => {
                        let state = state(&trajectory, 4);
                        assert!(size(&state).is_finite(), "{shape:?} {speed:e} {t_end:e}");
                        let defect = orthonormality(&state[0]);
                        assert_within(defect, 1e-9, &format!("{shape:?} {speed:e} {t_end:e}"));
                    }
                    Err(Error::Overflow { .. } | Error::TooFewSteps { .. }) => {}
                    Err(other) => panic!("{shape:?} {speed:e} {t_end:e}: {other}"),
                }
            }
        }
    }
}

#[test]
fn it_can_be_stopped() {
    let data = random_data((4, 2), 1.0, 24);
    let [s, v, a, j] = data.each_ref().map(Mat::as_ref);
    let question = || true;
    let (options, interrupt) = (SplittingOptions::default(), Interrupt::new(&question));
    let result = integrate_cubic(s, v, a, j, 10, &options, interrupt);
    assert!(matches!(result, Err(Error::Interrupted { .. })));
}
