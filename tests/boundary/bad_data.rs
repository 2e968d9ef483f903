//! Data without a solution, bad options, and interrupts.

use std::sync::atomic::{AtomicUsize, Ordering};

use faer::Mat;
use stiefel_rs::cubic::BoundaryOptions;
use stiefel_rs::{Curve, Error, Interrupt, StopReason};

use crate::common::{Rng, assert_within, counted, distance, random_tangent};
use crate::data::{Data, END};

#[test]
fn huge_velocities_end_soon() {
    let mut rng = Rng::new(19);
    for shape in [(3, 1), (4, 2)] {
        for speed in [1e2, 1e3, 1e6, 1e150, 1e300] {
            let mut data = Data::random(shape, 1.0, 1.0, &mut rng);
            if speed == 1e150 {
                data.v1 = random_tangent(&data.s1, speed, &mut rng);
            } else {
                data.v0 = random_tangent(&data.s0, speed, &mut rng);
            }
            let (checks, outcome) =
                counted(|interrupt| data.solve_with(&BoundaryOptions::default(), interrupt));
            println!(
                "{shape:?} speed {speed:e}: {checks} checks {:?}",
                outcome.as_ref().err()
            );
            match outcome {
                Ok(curve) => {
                    assert_within(data.defect(&curve), END * speed, "fast curve");
                    // High speed only excuses round-off of the point.
                    let off = distance(&curve.point(1.0).unwrap(), &data.s1);
                    assert_within(off, 1e-8, "end of a fast curve");
                    assert!(curve.report().unwrap().tolerance <= 1e-9);
                }
                Err(Error::NoConvergence { solver, report }) => {
                    assert!(solver.starts_with("boundary value problem"), "{solver}");
                    assert!(report.residual > report.tolerance, "{report}");
                }
                Err(error) => panic!("{shape:?} {speed:e}: {error}"),
            }
            // The largest number is 427 000, for St(3,1) at speed 1000.
            assert!(checks < 1_000_000, "{shape:?} {speed:e}: {checks} checks");
        }
    }
}

#[test]
fn bad_options_and_data_are_errors() {
    let mut rng = Rng::new(20);
    let data = Data::random((4, 2), 1.0, 1.0, &mut rng);
    for tolerance in [0.0, -1.0, f64::NAN, 1.0] {
        let options = BoundaryOptions {
            tolerance,
            ..Default::default()
        };
        let error = data.solve_with(&options, Interrupt::NEVER).unwrap_err();
        assert!(
            matches!(
                error,
                Error::InvalidArgument {
                    name: "tolerance",
                    ..
                }
            ),
            "{error}"
        );
    }
    let none = BoundaryOptions {
        max_iterations: 0,
        ..Default::default()
    };
    let error = data.solve_with(&none, Interrupt::NEVER).unwrap_err();
    assert!(matches!(
        error,
        Error::InvalidArgument {
            name: "max_iterations",
            ..
        }
    ));
    let one = BoundaryOptions {
        max_iterations: 1,
        ..Default::default()
    };
    match data.solve_with(&one, Interrupt::NEVER) {
        Err(Error::NoConvergence { report, .. }) => {
            assert_eq!(
                (report.reason, report.iterations),
                (StopReason::MaxIterations, 1)
            );
            assert!(!report.converged && report.residual > report.tolerance);
        }
        other => panic!("{other:?}"),
    }
    let normal = (data.s0.clone(), Mat::<f64>::zeros(4, 2));
    let guessed = BoundaryOptions {
        guess: Some((normal.0.as_ref(), normal.1.as_ref())),
        ..Default::default()
    };
    assert!(matches!(
        data.solve_with(&guessed, Interrupt::NEVER),
        Err(Error::NotTangent { name: "A", .. })
    ));
    let mut broken = data.map(Mat::clone);
    broken.v1[(0, 0)] = f64::NAN;
    assert!(matches!(broken.solve(), Err(Error::NonFinite { .. })));
}

#[test]
fn an_interrupt_stops_a_solve() {
    let mut rng = Rng::new(21);
    let data = Data::random((4, 2), 2.0, 2.0, &mut rng);
    let asked = AtomicUsize::new(0);
    let question = || asked.fetch_add(1, Ordering::Relaxed) >= 2;
    let options = BoundaryOptions::default();
    let stopped = data.solve_with(&options, Interrupt::new(&question));
    assert!(matches!(stopped, Err(Error::Interrupted { .. })));
}
