//! Shooting: both ends are reached for any discretization map, and failures state their reason.

#[path = "common/curved_map.rs"]
mod curved_map;
#[path = "common/paper.rs"]
mod paper;

use curved_map::Curved;
use nalgebra::SVector;
use stiefel_rs::chart::{
    Chart, DiscretizationMap, Frame, LinearMap, ShootingOptions, Sphere, reference, shoot,
};
use stiefel_rs::newton::NewtonOptions;
use stiefel_rs::{Error, Interrupt, StopReason};

fn check_shooting<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    z0: &SVector<f64, Z>,
) {
    let exact = reference(chart, z0, &[1.0], Interrupt::NEVER).unwrap()[0];
    let (x0, x1) = (
        z0.fixed_rows::<X>(0).into_owned(),
        exact.fixed_rows::<X>(0).into_owned(),
    );
    let found = shoot(
        chart,
        map,
        &x0,
        &x1,
        40,
        &ShootingOptions::default(),
        Interrupt::NEVER,
    )
    .unwrap();
    assert!(found.report.converged && found.report.reason == StopReason::Converged);
    assert!(
        found.report.iterations <= 5,
        "{} steps",
        found.report.iterations
    );
    let (first, last) = (found.trajectory[0], found.trajectory[40]);
    assert_eq!(first.fixed_rows::<X>(0), x0, "the start is exact");
    let defect = (last.fixed_rows::<X>(0) - x1).norm();
    assert!(defect <= 1e-12, "end defect {defect:e}");
    // Starting from the solution takes no step.
    let again = ShootingOptions {
        guess: Some(found.momenta),
        ..ShootingOptions::default()
    };
    assert_eq!(
        shoot(chart, map, &x0, &x1, 40, &again, Interrupt::NEVER)
            .unwrap()
            .report
            .iterations,
        0
    );
}

#[test]
fn shooting_meets_both_ends_for_any_map() {
    check_shooting(&Sphere, &LinearMap::INITIAL_POINT, &paper::sphere());
    check_shooting(&Sphere, &LinearMap::MIDPOINT, &paper::sphere());
    check_shooting(&Sphere, &Curved(0.2), &paper::sphere());
    check_shooting(&Frame, &LinearMap::INITIAL_POINT, &paper::frame());
    check_shooting(&Frame, &LinearMap::MIDPOINT, &paper::frame());
    check_shooting(&Frame, &Curved(0.2), &paper::frame());
}

#[test]
fn shooting_reports_why_it_stopped() {
    let z0 = paper::sphere();
    let x0 = z0.fixed_rows::<4>(0).into_owned();
    let x1 = SVector::from([1.2, 3.5, 0.4, 0.1]);
    let run = |newton: NewtonOptions, interrupt: Interrupt<'_>| {
        let options = ShootingOptions {
            newton,
            ..ShootingOptions::default()
        };
        shoot(
            &Sphere,
            &LinearMap::MIDPOINT,
            &x0,
            &x1,
            20,
            &options,
            interrupt,
        )
    };
    let never = run(
        NewtonOptions {
            max_iterations: 0,
            ..NewtonOptions::default()
        },
        Interrupt::NEVER,
    );
    match never {
        Err(Error::NoConvergence { report, .. }) => {
            assert!(!report.converged && report.iterations == 0 && report.residual > 0.0);
            assert_eq!(report.reason, StopReason::MaxIterations);
        }
        other => panic!("expected NoConvergence, found {other:?}"),
    }
    let exact = run(
        NewtonOptions {
            tolerance: 0.0,
            ..NewtonOptions::default()
        },
        Interrupt::NEVER,
    );
    match exact {
        // Round-off limits the accuracy: either the target is reached exactly, or the report says that no step reduces
        // the residual.
        Ok(found) => assert_eq!(found.report.residual, 0.0),
        Err(Error::NoConvergence { report, .. }) => assert!(report.residual < 1e-13, "{report}"),
        other => panic!("{other:?}"),
    }
    let stop = || true;
    let interrupted = run(NewtonOptions::default(), Interrupt::new(&stop));
    assert!(matches!(interrupted, Err(Error::Interrupted { .. })));
    let negative = run(
        NewtonOptions {
            tolerance: -1.0,
            ..NewtonOptions::default()
        },
        Interrupt::NEVER,
    );
    assert!(matches!(
        negative,
        Err(Error::InvalidArgument {
            name: "tolerance",
            ..
        })
    ));
}
