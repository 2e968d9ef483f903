//! Single shooting: the end of a cubic as a function of `(x', x'')` at its start, and Newton's method for the
//! [equations](super::end_equations) there.
//!
//! Guesses between frames lead to solutions by it, and continuation follows them, saddles of the cost included. The exact derivatives come from the Taylor
//! recurrence on [dual numbers](crate::linalg::dual).

use std::rc::Rc;

use faer::Mat;

use super::end_equations::{EndResidual, Target, evaluate};
use super::problem::BoundaryProblem;
use crate::cubic::taylor::blocks::{BlockSizes, Sizes};
use crate::cubic::taylor::march::{Accuracy, TaylorMarch};
use crate::cubic::taylor::work::{Work, work_of_step};
use crate::error::{Result, unless_interrupted};
use crate::interrupt::Interrupt;
use crate::linalg::decomp::solve_square;
use crate::linalg::dual::{Dual, jacobian};
use crate::report::{SolverReport, StopReason};
use crate::solve::line_search::backtracked;

const SOLVER: &str = "shooting for a Riemannian cubic";

/// Directions of one pass of dual numbers: one vector instruction of the widest kind.
const ABREAST: usize = 8;

/// Number of lengths of a Newton step that are tried.
const STEP_LENGTHS: i32 = 8;

/// Residuals above this are not round-off.
pub(crate) const ROUND_OFF: f64 = 1e-9;

/// Relative change of the start used to measure the round-off of the end: a solution cannot be known more accurately.
const LAST_DIGITS: f64 = 16.0 * f64::EPSILON;

/// Work of a step on dual numbers, in units of a step on real numbers.
const DUAL_WORK: f64 = 4.0;

/// A boundary value problem as equations for `(x', x'')` at the start.
pub(crate) struct SingleShooting<'a> {
    pub(crate) target: Target,
    pub(crate) work: Rc<Work>,
    plain: TaylorMarch<f64, Sizes>,
    dual: TaylorMarch<Dual<ABREAST>, Sizes>,
    interrupt: Interrupt<'a>,
}

impl<'a> SingleShooting<'a> {
    pub(crate) fn new(problem: &BoundaryProblem, work: Rc<Work>, interrupt: Interrupt<'a>) -> Self {
        let blocks = problem.blocks();
        SingleShooting {
            target: Target::new(&problem.velocity, &problem.end, problem.tension),
            work,
            plain: TaylorMarch::new(blocks, Accuracy::FULL),
            dual: TaylorMarch::new(blocks, Accuracy::FULL),
            interrupt,
        }
    }

    /// Damped Newton from `y = (x', x'')`, in place.
    ///
    /// # Errors
    /// `Interrupted`, and an error if the start cannot be integrated.
    pub(crate) fn solve(
        &mut self,
        y: &mut [f64],
        tolerance: f64,
        max_iterations: usize,
    ) -> Result<SolverReport> {
        let mut found = self.residual(y, Accuracy::FULL)?;
        let (mut iterations, mut reached) = (0, tolerance);
        let reason = loop {
            if found.distance <= tolerance {
                break StopReason::Converged;
            }
            if iterations == max_iterations {
                break StopReason::MaxIterations;
            }
            if self.work.is_done() {
                break StopReason::WorkLimit;
            }
            iterations += 1;
            let (jacobian, _) = self.derivative(y, Accuracy::FULL)?;
            let Some(step) = solve_square(jacobian.as_ref(), &found.equations) else {
                break StopReason::SingularJacobian;
            };
            let Some(nearer) = self.descend(y, &step, found.distance)? else {
                if found.distance < ROUND_OFF && found.distance <= self.noise(y, &found)? {
                    reached = found.distance;
                    break StopReason::Converged;
                }
                break StopReason::Stagnated;
            };
            found = nearer;
        };
        Ok(SolverReport::new(
            reason,
            iterations,
            found.distance,
            reached,
        ))
    }

    /// Takes the first halved step that brings the end nearer; the new residual.
    fn descend(
        &mut self,
        y: &mut [f64],
        step: &[f64],
        distance: f64,
    ) -> Result<Option<EndResidual<f64>>> {
        let found = backtracked(distance, STEP_LENGTHS, |share| {
            self.interrupt.check(SOLVER)?;
            let trial: Vec<f64> = y.iter().zip(step).map(|(y, s)| y - share * s).collect();
            let found = unless_interrupted(self.residual(&trial, Accuracy::FULL))?;
            Ok(found.map(|found| (found.distance, (trial, found))))
        })?;
        Ok(found.map(|((nearer, found), _)| {
            y.copy_from_slice(&nearer);
            found
        }))
    }

    /// A bound on the round-off in the distance of the end: the effect of changing the last digits of the start.
    fn noise(&mut self, y: &[f64], found: &EndResidual<f64>) -> Result<f64> {
        let digit = |i: usize| 1.0 + LAST_DIGITS * [1.0, -1.0][i % 2];
        let beside: Vec<f64> = y.iter().enumerate().map(|(i, y)| digit(i) * y).collect();
        let beside = self.residual(&beside, Accuracy::FULL)?;
        let pairs = beside.equations.iter().zip(&found.equations);
        let squares = pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        Ok((self.plain.blocks.weight() * squares).sqrt())
    }

    /// The equations at `y`, and the distance of the end from its target.
    ///
    /// # Errors
    /// `Interrupted`, and an error if the curve cannot be integrated.
    pub(crate) fn residual(&mut self, y: &[f64], accuracy: Accuracy) -> Result<EndResidual<f64>> {
        self.plain.accuracy = accuracy;
        let found = evaluate(&mut self.plain, &self.target, y, self.interrupt);
        let step = work_of_step(self.plain.blocks);
        self.work.count(step * self.plain.steps as f64);
        found
    }

    /// The derivative of the equations, shape `(2d, 2d)`, and the equations.
    ///
    /// # Errors
    /// As [`SingleShooting::residual`].
    pub(crate) fn derivative(
        &mut self,
        y: &[f64],
        accuracy: Accuracy,
    ) -> Result<(Mat<f64>, Vec<f64>)> {
        let step = DUAL_WORK * work_of_step(self.dual.blocks);
        self.dual.accuracy = accuracy;
        jacobian(y, |unknown| {
            let outcome = evaluate(&mut self.dual, &self.target, unknown, self.interrupt);
            self.work.count(step * self.dual.steps as f64);
            Ok(outcome?.equations)
        })
    }

    /// The end of the curve of `y`: point and velocity, shape `(r, k)` each.
    ///
    /// # Errors
    /// As [`SingleShooting::residual`].
    pub(crate) fn end(&mut self, y: &[f64], accuracy: Accuracy) -> Result<[Mat<f64>; 2]> {
        self.residual(y, accuracy)?;
        let TaylorMarch { blocks, series, .. } = &self.plain;
        let (m, k, r) = (blocks.m, blocks.k, blocks.m + blocks.k);
        let (rows, normals) = (blocks.r::<f64>(), blocks.m::<f64>());
        let s = Mat::from_fn(r, k, |i, j| series.s()[i + rows * j]);
        let e = Mat::from_fn(r, m, |i, j| series.e()[i + rows * j]);
        let omega = Mat::from_fn(k, k, |i, j| series.omega(0)[i + k * j]);
        let b = Mat::from_fn(m, k, |i, j| series.b(0)[i + normals * j]);
        let v = &s * omega + e * b;
        Ok([s, v])
    }
}
