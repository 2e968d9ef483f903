//! Solving for a spline through given knots: where it starts, how long it may take, and what comes of it.

use std::sync::Arc;

use super::chain::{Chain, Piece};
use super::ends::Ends;
use super::motion::Motion;
use super::options::SplineOptions;
use crate::cubic::lazy_path::Legs;
use crate::cubic::work::Work;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::legs::Curves;
use crate::report::{SolverReport, StopReason};

/// How exactly, and for how long, the equations are solved.
#[derive(Clone, Copy)]
pub(super) struct Effort<'a> {
    pub(super) tolerance: f64,
    pub(super) max_iterations: usize,
    /// Of all attempts together.
    pub(super) work: &'a Work,
    pub(super) interrupt: Interrupt<'a>,
}

impl<'a> Effort<'a> {
    pub(super) fn new(options: &SplineOptions<'a>, work: &'a Work) -> Self {
        Effort {
            tolerance: options.tolerance,
            max_iterations: options.max_iterations,
            work,
            interrupt: options.interrupt,
        }
    }

    /// Why a search that took so many iterations and found nothing ends.
    pub(super) fn reason(&self, iterations: usize) -> StopReason {
        match iterations >= self.max_iterations {
            _ if self.work.is_done() => StopReason::WorkLimit,
            true => StopReason::MaxIterations,
            false => StopReason::Stagnated,
        }
    }

    /// Whether a solver that took so many iterations is the last one.
    pub(super) fn is_spent(&self, iterations: usize) -> bool {
        iterations >= self.max_iterations || self.work.is_done()
    }
}

/// Where a solver starts.
pub(super) enum Start {
    /// At the spline of flat space.
    Flat,
    /// Near a solution, which is not to be left.
    Near(Motion),
}

/// What a solver has reached.
pub(super) struct Solution {
    pub(super) motion: Motion,
    pub(super) report: SolverReport,
    /// The curves between the knots, where the solver has them.
    pub(super) polynomials: Option<SolvedLegs>,
}

/// The curves of solved legs, and what makes paths of them.
#[derive(Clone)]
pub(super) struct SolvedLegs {
    pub(super) curves: Arc<dyn Curves>,
    pub(super) paths: Arc<Legs>,
}

impl Solution {
    /// None, for a reason.
    pub(super) fn none(report: SolverReport) -> Self {
        Solution {
            motion: Motion::zeros(0, 1),
            report,
            polynomials: None,
        }
    }
}

/// `None` for a start that cannot be integrated.
pub(super) fn unless_interrupted<T>(outcome: Result<T>) -> Result<Option<T>> {
    match outcome {
        Err(error) if error.is_interrupted() => Err(error),
        other => Ok(other.ok()),
    }
}

/// A chain with a solver for its splines.
pub(super) trait Solvable: Chain {
    /// Solves the equations of a spline.
    ///
    /// # Errors
    /// Where the start cannot be integrated; `Interrupted`.
    fn solve(&self, ends: &Ends, start: Start, effort: Effort<'_>) -> Result<Solution>;

    /// The curve of a leg on `[0, 1]`.
    ///
    /// # Errors
    /// Where it cannot be integrated; `Interrupted`.
    fn piece(&self, leg: usize, solution: &Solution, interrupt: Interrupt<'_>) -> Result<Piece> {
        self.integrated(leg, &solution.motion, interrupt)
    }
}
