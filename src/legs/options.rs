//! Options of the solvers of a chain of legs, and their progress.

use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::report::{SolverReport, StopReason};

/// Accuracy of residuals, relative to the largest acceleration or third vector of a leg, in its own time.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

const SOLVER: &str = "chain of Riemannian cubics";

/// Stopping criteria of a solver.
pub(crate) struct Options<'a> {
    /// Bound on the residuals of all equations, in the time of the legs.
    pub(crate) tolerance: f64,
    pub(crate) max_iterations: usize,
    /// Called with the number of products of the next iteration: whether the iteration may begin.
    pub(crate) may_go_on: &'a dyn Fn(f64) -> bool,
    /// Polled before every iteration.
    pub(crate) interrupt: Interrupt<'a>,
}

impl Options<'_> {
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn check(&self) -> Result<()> {
        self.interrupt.check(SOLVER)
    }
}

/// Progress of an iteration.
pub(crate) struct Progress {
    iterations: usize,
    residual: f64,
    goal: f64,
}

impl Progress {
    pub(crate) fn new(tolerance: f64) -> Self {
        Progress {
            iterations: 0,
            residual: f64::INFINITY,
            goal: tolerance,
        }
    }

    /// Records a residual, for a chain whose largest acceleration or third vector has the size `derivative`; returns
    /// the target of the residual.
    pub(crate) fn set(&mut self, residual: f64, derivative: f64, tolerance: f64) -> f64 {
        // Infinite if it is not a number.
        self.residual = if residual.is_nan() {
            f64::INFINITY
        } else {
            residual
        };
        self.goal = tolerance.max(ROUND_OFF * derivative);
        self.goal
    }

    /// Counts another iteration that costs the given number of products; returns a reason if it may not begin.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn step(
        &mut self,
        products: f64,
        options: &Options<'_>,
    ) -> Result<Option<StopReason>> {
        if self.iterations >= options.max_iterations {
            return Ok(Some(StopReason::MaxIterations));
        }
        if !(options.may_go_on)(products) {
            return Ok(Some(StopReason::WorkLimit));
        }
        options.check()?;
        self.iterations += 1;
        Ok(None)
    }

    pub(crate) fn report(&self, reason: StopReason) -> SolverReport {
        SolverReport::new(reason, self.iterations, self.residual, self.goal)
    }
}
