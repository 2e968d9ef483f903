//! Solutions of the equations of a spline: where solvers start, their work limit, and their result.

use std::sync::Arc;

use faer::Mat;

use super::chain::{Chain, SpannedPiece};
use super::motion::Motion;
use crate::cubic::taylor::work::Work;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::legs::{Curves, Options};
use crate::report::{SolverReport, StopReason, Strategy};
use crate::spline::options::SplineOptions;

/// Accuracy and work limit of a solver.
#[derive(Clone, Copy)]
pub(crate) struct Effort<'a> {
    pub(crate) tolerance: f64,
    pub(crate) max_iterations: usize,
    /// Shared by all attempts.
    pub(crate) work: &'a Work,
    pub(crate) interrupt: Interrupt<'a>,
}

impl<'a> Effort<'a> {
    pub(crate) fn new(options: &SplineOptions, work: &'a Work, interrupt: Interrupt<'a>) -> Self {
        Effort {
            tolerance: options.tolerance,
            max_iterations: options.max_iterations,
            work,
            interrupt,
        }
    }

    /// Options of a solver of chains.
    pub(crate) fn options<'o>(&self, may_go_on: &'o dyn Fn(f64) -> bool) -> Options<'o>
    where
        'a: 'o,
    {
        Options {
            tolerance: self.tolerance,
            max_iterations: self.max_iterations,
            may_go_on,
            interrupt: self.interrupt,
        }
    }

    /// The reason for stopping a search without result after `iterations` iterations.
    pub(crate) fn reason(&self, iterations: usize) -> StopReason {
        match iterations >= self.max_iterations {
            _ if self.work.is_done() => StopReason::WorkLimit,
            true => StopReason::MaxIterations,
            false => StopReason::Stagnated,
        }
    }

    /// Whether the limit of iterations leaves room for no other solver.
    pub(crate) fn is_spent(&self, iterations: usize) -> bool {
        iterations >= self.max_iterations || self.work.is_done()
    }
}

/// The result of a solver.
pub(crate) struct ChainSolution {
    pub(crate) motion: Motion,
    pub(crate) report: SolverReport,
    /// The curves between the knots, if the solver provides them.
    pub(crate) legs: Option<SolvedLegs>,
}

/// The curves of solved legs.
#[derive(Clone)]
pub(crate) struct SolvedLegs {
    /// Their polynomials, for solvers that compute them together.
    pub(crate) polynomials: Option<Arc<dyn Curves>>,
    /// The curve of a leg; `None` if it has to be integrated.
    pub(crate) piece: Arc<dyn Fn(usize) -> Option<SpannedPiece> + Send + Sync>,
    /// For subspaces, what turns the basis at the next knot to the one that a leg reaches, if the solver computes it.
    pub(crate) turns: Option<Arc<[Mat<f64>]>>,
}

impl ChainSolution {
    /// The [turns](SolvedLegs::turns) of the legs.
    pub(crate) fn turns(&self) -> Option<&[Mat<f64>]> {
        self.legs.as_ref()?.turns.as_deref()
    }

    /// The same with what found it in the report.
    pub(crate) fn found_by(self, strategy: Strategy) -> Self {
        ChainSolution {
            report: self.report.found_by(strategy),
            ..self
        }
    }

    /// No solution, because nothing could be tried.
    pub(crate) fn unsolved(effort: Effort<'_>) -> Self {
        let tolerance = effort.tolerance;
        Self::none(SolverReport::new(
            effort.reason(0),
            0,
            f64::INFINITY,
            tolerance,
        ))
    }

    /// No solution, with the reason in the report.
    pub(crate) fn none(report: SolverReport) -> Self {
        ChainSolution {
            motion: Motion::zeros(0, 1),
            report,
            legs: None,
        }
    }
}

/// The curve of a leg of a solution on `[0, 1]`.
///
/// # Errors
/// An error if it cannot be integrated; `Interrupted`.
pub(crate) fn piece(
    chain: &impl Chain,
    leg: usize,
    solution: &ChainSolution,
    interrupt: Interrupt<'_>,
) -> Result<SpannedPiece> {
    let known = solution.legs.as_ref().and_then(|legs| (legs.piece)(leg));
    match known {
        Some(piece) => Ok(piece),
        None => chain.integrated(leg, &solution.motion, interrupt),
    }
}
