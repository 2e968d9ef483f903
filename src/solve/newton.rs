//! Damped Newton iteration on `R^m`, with a report.
//!
//! The solver is independent of the problem, which provides residuals and exact Jacobians. A trial step at which the
//! problem cannot be evaluated (for example because a curve leaves its chart) is treated as one that does not reduce
//! the residual.

use faer::{Mat, MatMut};

use super::gmres::norm;
use super::line_search::backtracked;
use crate::error::{Error, Result, unless_interrupted};
use crate::interrupt::Interrupt;
use crate::linalg::decomp::solve_square;
use crate::report::{SolverReport, StopReason};

/// Number of lengths of a step that are tried.
const STEP_LENGTHS: i32 = 30;

/// A square system of equations `F(x) = 0`.
///
/// # Examples
/// ```
/// use faer::{MatMut, mat};
/// use stiefel_rs::{Interrupt, Result};
/// use stiefel_rs::newton::{NewtonOptions, Problem, solve};
/// /// Where the circle of radius 5 meets the line `y = x - 1`.
/// struct Meeting;
/// impl Problem for Meeting {
///     fn dim(&self) -> usize {
///         2
///     }
///     fn evaluate(&mut self, x: &[f64], residual: &mut [f64], jacobian: Option<MatMut<'_, f64>>) -> Result<()> {
///         residual.copy_from_slice(&[x[0] * x[0] + x[1] * x[1] - 25.0, x[0] - x[1] - 1.0]);
///         if let Some(mut jacobian) = jacobian {
///             jacobian.copy_from(mat![[2.0 * x[0], 2.0 * x[1]], [1.0, -1.0]]);
///         }
///         Ok(())
///     }
/// }
/// let mut x = [5.0, 5.0];
/// let report = solve(&mut Meeting, &mut x, &NewtonOptions::default(), Interrupt::NEVER)?;
/// assert!(report.converged);
/// assert!((x[0] - 4.0).hypot(x[1] - 3.0) < 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub trait Problem {
    /// Number of unknowns and of equations.
    fn dim(&self) -> usize;

    /// Computes `residual = F(x)` and, if requested, `jacobian = DF(x)`.
    ///
    /// # Errors
    /// An error if `F` is not defined at `x`.
    fn evaluate(
        &mut self,
        x: &[f64],
        residual: &mut [f64],
        jacobian: Option<MatMut<'_, f64>>,
    ) -> Result<()>;
}

/// Stopping criteria.
///
/// # Examples
/// ```
/// use faer::MatMut;
/// use stiefel_rs::newton::{NewtonOptions, Problem, solve};
/// use stiefel_rs::{Interrupt, Result, StopReason};
/// /// `x^2 = 2`.
/// struct Root;
/// impl Problem for Root {
/// #    fn dim(&self) -> usize {
/// #        1
/// #    }
///     // ...
/// #    fn evaluate(&mut self, x: &[f64], residual: &mut [f64], jacobian: Option<MatMut<'_, f64>>) -> Result<()> {
/// #        residual[0] = x[0] * x[0] - 2.0;
/// #        if let Some(mut jacobian) = jacobian {
/// #            jacobian[(0, 0)] = 2.0 * x[0];
/// #        }
/// #        Ok(())
/// #    }
/// }
/// let mut x = [1.0];
/// let one = NewtonOptions { max_iterations: 1, ..Default::default() };
/// assert_eq!(solve(&mut Root, &mut x, &one, Interrupt::NEVER)?.reason, StopReason::MaxIterations);
/// assert_eq!(x, [1.5]);
/// assert!(solve(&mut Root, &mut x, &NewtonOptions::default(), Interrupt::NEVER)?.converged);
/// assert!((x[0] - 2.0_f64.sqrt()).abs() < 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct NewtonOptions {
    /// The iteration has converged once the Euclidean norm of the residual is at most this.
    pub tolerance: f64,
    /// Maximal number of Newton steps.
    pub max_iterations: usize,
}

impl Default for NewtonOptions {
    /// Residual `1e-12`, at most 50 steps.
    fn default() -> Self {
        NewtonOptions {
            tolerance: 1e-12,
            max_iterations: 50,
        }
    }
}

/// Solves `F(x) = 0` from `x`, in place.
///
/// ```math
/// x \leftarrow x - \lambda\, DF(x)^{-1} F(x),\qquad \lambda = 1, \tfrac12, \tfrac14, \dots
/// ```
///
/// The first `lambda` that reduces `|F|` is used. On return `x` is the best iterate; the report says whether it is a
/// solution.
///
/// # Errors
/// `Shape`, the error of the problem at the starting point, and `Interrupted`. Failure to converge is not an error but
/// part of the report.
/// # Source
/// Dennis, Schnabel (1996), "Numerical Methods for Unconstrained Optimization and Nonlinear Equations", ch. 6.
pub fn solve(
    problem: &mut impl Problem,
    x: &mut [f64],
    options: &NewtonOptions,
    interrupt: Interrupt<'_>,
) -> Result<SolverReport> {
    let m = problem.dim();
    if x.len() != m {
        let (expected, found) = (format!("({m},)"), format!("({},)", x.len()));
        return Err(Error::Shape {
            name: "x",
            expected,
            found,
        });
    }
    let (mut residual, mut jacobian) = (vec![0.0; m], Mat::zeros(m, m));
    problem.evaluate(x, &mut residual, None)?;
    let mut size = norm(&residual);
    let mut iterations = 0;
    let reason = loop {
        if size <= options.tolerance {
            break StopReason::Converged;
        }
        if iterations == options.max_iterations {
            break StopReason::MaxIterations;
        }
        interrupt.check("Newton iteration")?;
        problem.evaluate(x, &mut residual, Some(jacobian.as_mut()))?;
        let Some(step) = solve_square(jacobian.as_ref(), &residual) else {
            break StopReason::SingularJacobian;
        };
        let found = backtracked(size, STEP_LENGTHS, |share| {
            interrupt.check("Newton iteration")?;
            let trial: Vec<f64> = x
                .iter()
                .zip(&step)
                .map(|(x, step)| x - share * step)
                .collect();
            let evaluated = problem.evaluate(&trial, &mut residual, None);
            let size = unless_interrupted(evaluated)?.map(|()| norm(&residual));
            Ok(size.map(|size| (size, (trial, size))))
        })?;
        let Some(((next, now), _)) = found else {
            break StopReason::Stagnated;
        };
        x.copy_from_slice(&next);
        size = now;
        iterations += 1;
    };
    Ok(SolverReport::new(
        reason,
        iterations,
        size,
        options.tolerance,
    ))
}
