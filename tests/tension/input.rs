//! Invalid tensions.

use faer::mat;
use stiefel_rs::cubic::{BoundaryOptions, IntegrationOptions, SplittingOptions, integrate_cubic};
use stiefel_rs::spline::{EndConditions, SplineOptions, cubic_spline, geometric_spline};
use stiefel_rs::{Error, Interrupt, RiemannianCubic};

#[track_caller]
fn refused<T>(result: Result<T, Error>, value: f64) {
    match result {
        Err(Error::InvalidArgument {
            name: "tension",
            found,
            ..
        }) => {
            assert!(found == value || found.is_nan() && value.is_nan());
        }
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("{value} is taken"),
    }
}

#[test]
fn negative_and_endless_tensions_are_refused() {
    let (s, v) = (mat![[1.0], [0.0]], mat![[0.0], [1.0]]);
    let (s, v) = (s.as_ref(), v.as_ref());
    for tension in [-1.0, -f64::MIN_POSITIVE, f64::NAN, f64::INFINITY] {
        let options = IntegrationOptions {
            tension,
            ..Default::default()
        };
        refused(
            RiemannianCubic::from_initial(s, v, v, v, &options, Interrupt::NEVER),
            tension,
        );
        let options = BoundaryOptions {
            tension,
            ..Default::default()
        };
        refused(
            RiemannianCubic::from_boundary(s, v, s, v, &options, Interrupt::NEVER),
            tension,
        );
        let options = SplittingOptions {
            tension,
            ..Default::default()
        };
        refused(
            integrate_cubic(s, v, v, v, 3, &options, Interrupt::NEVER),
            tension,
        );
        let options = SplineOptions {
            tension,
            ..Default::default()
        };
        refused(
            cubic_spline(
                &[0.0, 1.0],
                &[s, s],
                &EndConditions::Natural,
                &options,
                Interrupt::NEVER,
            ),
            tension,
        );
    }
}

#[test]
fn boundary_problems_and_geometric_splines_say_what_they_take() {
    let (s, v) = (mat![[1.0], [0.0]], mat![[0.0], [1.0]]);
    let (s, v) = (s.as_ref(), v.as_ref());
    let options = BoundaryOptions {
        tension: 64.1,
        ..Default::default()
    };
    refused(
        RiemannianCubic::from_boundary(s, v, s, v, &options, Interrupt::NEVER),
        64.1,
    );
    let options = SplineOptions {
        tension: 0.5,
        ..Default::default()
    };
    refused(
        geometric_spline(
            &[0.0, 1.0],
            &[s, s],
            &EndConditions::Natural,
            &options,
            Interrupt::NEVER,
        ),
        0.5,
    );
}

/// Huge tensions of initial values give an error or finite numbers.
#[test]
fn extreme_tensions_of_initial_values_are_integrated_or_refused() {
    let (s, v) = (mat![[1.0], [0.0]], mat![[0.0], [1.0]]);
    let rest = mat![[0.0], [0.0]];
    for tension in [1e-300, 1e6, 1e100, 1e300] {
        let options = IntegrationOptions {
            tension,
            ..Default::default()
        };
        for a in [&v, &rest] {
            let data = [&s, &v, a, &rest].map(|x| x.as_ref());
            let [s, v, a, j] = data;
            if let Ok(curve) = RiemannianCubic::from_initial(s, v, a, j, &options, Interrupt::NEVER)
            {
                use stiefel_rs::Curve;
                assert!(curve.point(1.0).unwrap().norm_l2().is_finite());
            }
        }
    }
}
