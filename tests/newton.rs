//! The damped Newton solver on problems with known solutions and known failures.

use faer::MatMut;
use stiefel_rs::newton::{NewtonOptions, Problem, solve};
use stiefel_rs::{Error, Interrupt, Result, StopReason};

/// A system defined by two closures.
struct System<F, J> {
    dim: usize,
    residual: F,
    jacobian: J,
}

impl<F, J> Problem for System<F, J>
where
    F: Fn(&[f64], &mut [f64]) -> Result<()>,
    J: Fn(&[f64], MatMut<'_, f64>),
{
    fn dim(&self) -> usize {
        self.dim
    }

    fn evaluate(
        &mut self,
        x: &[f64],
        residual: &mut [f64],
        jacobian: Option<MatMut<'_, f64>>,
    ) -> Result<()> {
        (self.residual)(x, residual)?;
        if let Some(jacobian) = jacobian {
            (self.jacobian)(x, jacobian);
        }
        Ok(())
    }
}

fn scalar(f: impl Fn(f64) -> f64, df: impl Fn(f64) -> f64) -> impl Problem {
    System {
        dim: 1,
        residual: move |x: &[f64], r: &mut [f64]| {
            r[0] = f(x[0]);
            Ok(())
        },
        jacobian: move |x: &[f64], mut j: MatMut<'_, f64>| j[(0, 0)] = df(x[0]),
    }
}

#[test]
fn converges_quadratically() {
    let mut x = [1.5];
    let report = solve(
        &mut scalar(|x| x * x - 2.0, |x| 2.0 * x),
        &mut x,
        &NewtonOptions::default(),
        Interrupt::NEVER,
    )
    .unwrap();
    assert!(report.converged && report.reason == StopReason::Converged);
    assert!(
        (x[0] - 2.0_f64.sqrt()).abs() < 1e-15,
        "{:e}",
        x[0] - 2.0_f64.sqrt()
    );
    assert!(report.iterations <= 4, "{report}");
}

#[test]
fn damping_makes_the_arctangent_converge() {
    // Full Newton steps diverge from |x| > 1.39.
    let mut x = [10.0];
    let report = solve(
        &mut scalar(f64::atan, |x| 1.0 / (1.0 + x * x)),
        &mut x,
        &NewtonOptions::default(),
        Interrupt::NEVER,
    )
    .unwrap();
    assert!(report.converged && x[0].abs() < 1e-12, "{report}");
    assert!(report.iterations <= 12, "{report}");
}

#[test]
fn solves_a_linear_system_in_one_step() {
    let mut problem = System {
        dim: 2,
        residual: |x: &[f64], r: &mut [f64]| {
            (r[0], r[1]) = (2.0 * x[0] + x[1] - 3.0, x[0] - 3.0 * x[1] + 2.0);
            Ok(())
        },
        jacobian: |_: &[f64], mut j: MatMut<'_, f64>| {
            (j[(0, 0)], j[(0, 1)], j[(1, 0)], j[(1, 1)]) = (2.0, 1.0, 1.0, -3.0);
        },
    };
    let mut x = [10.0, -7.0];
    let report = solve(
        &mut problem,
        &mut x,
        &NewtonOptions::default(),
        Interrupt::NEVER,
    )
    .unwrap();
    assert_eq!((report.iterations, report.converged), (1, true), "{report}");
    assert!(
        (x[0] - 1.0).abs() < 1e-15 && (x[1] - 1.0).abs() < 1e-15,
        "{x:?}"
    );
}

#[test]
fn says_when_there_is_no_root() {
    let mut x = [1.0];
    let report = solve(
        &mut scalar(|x| x * x + 1.0, |x| 2.0 * x),
        &mut x,
        &NewtonOptions::default(),
        Interrupt::NEVER,
    )
    .unwrap();
    assert!(!report.converged, "{report}");
    let reasons = [
        StopReason::Stagnated,
        StopReason::SingularJacobian,
        StopReason::MaxIterations,
    ];
    assert!(reasons.contains(&report.reason), "{report}");
    assert!(report.residual >= 1.0);
}

#[test]
fn says_when_the_jacobian_is_singular() {
    let mut x = [0.0];
    let report = solve(
        &mut scalar(|x| x * x - 1.0, |x| 2.0 * x),
        &mut x,
        &NewtonOptions::default(),
        Interrupt::NEVER,
    )
    .unwrap();
    assert_eq!(report.reason, StopReason::SingularJacobian, "{report}");
}

#[test]
fn keeps_inside_of_the_domain() {
    // log x = -3 from x = 1: the full step leads to x = -2, where the logarithm is undefined.
    let mut problem = System {
        dim: 1,
        residual: |x: &[f64], r: &mut [f64]| {
            if x[0] <= 0.0 {
                return Err(Error::NonFinite {
                    name: "x",
                    index: 0,
                });
            }
            r[0] = x[0].ln() + 3.0;
            Ok(())
        },
        jacobian: |x: &[f64], mut j: MatMut<'_, f64>| j[(0, 0)] = 1.0 / x[0],
    };
    let mut x = [1.0];
    let report = solve(
        &mut problem,
        &mut x,
        &NewtonOptions::default(),
        Interrupt::NEVER,
    )
    .unwrap();
    assert!(
        report.converged && (x[0] - (-3.0_f64).exp()).abs() < 1e-13,
        "{report}"
    );
    // A start outside the domain returns the problem's own error.
    assert!(matches!(
        solve(
            &mut problem,
            &mut [-1.0],
            &NewtonOptions::default(),
            Interrupt::NEVER
        ),
        Err(Error::NonFinite { .. })
    ));
}

#[test]
fn limits_and_interrupts() {
    let run = |options: NewtonOptions, interrupt: Interrupt<'_>| {
        solve(
            &mut scalar(|x| x * x - 2.0, |x| 2.0 * x),
            &mut [1.5],
            &options,
            interrupt,
        )
    };
    let report = run(
        NewtonOptions {
            max_iterations: 0,
            ..NewtonOptions::default()
        },
        Interrupt::NEVER,
    )
    .unwrap();
    assert_eq!(
        (report.iterations, report.reason, report.residual),
        (0, StopReason::MaxIterations, 0.25)
    );
    let stop = || true;
    let stopped = run(NewtonOptions::default(), Interrupt::new(&stop));
    assert!(matches!(stopped, Err(Error::Interrupted { .. })));
}
