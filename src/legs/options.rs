//! How a chain of legs is solved: where to start, when to stop, how far an iteration has come.

use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::report::{SolverReport, StopReason};

/// Residuals are known to this share of the largest acceleration or third vector of a leg, in its own time.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

const SOLVER: &str = "chain of Riemannian cubics";

/// `x'''` of a leg at some times between 0 and 1, one vector after the other.
pub(crate) type ThirdDerivative<'a> = dyn Fn(usize, &[f64]) -> Result<Vec<f64>> + 'a;

/// Where to start, and when to stop.
pub(crate) struct Options<'a> {
    /// Of a start near a solution; otherwise it is left out, as in flat space.
    pub(crate) third_derivative: Option<&'a ThirdDerivative<'a>>,
    /// Of all equations, in the time of the legs.
    pub(crate) tolerance: f64,
    pub(crate) max_iterations: usize,
    /// Asked before every iteration, which takes so many products: whether it may be begun.
    pub(crate) may_go_on: &'a dyn Fn(f64) -> bool,
    /// Asked before every iteration.
    pub(crate) interrupt: Interrupt<'a>,
}

/// How far an iteration has come.
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

    /// Takes over a residual, of a chain with the largest acceleration or third vector `bend`; what it is to come down to.
    pub(crate) fn set(&mut self, residual: f64, bend: f64, tolerance: f64) -> f64 {
        // None where it is not a number.
        self.residual = if residual.is_nan() {
            f64::INFINITY
        } else {
            residual
        };
        self.goal = tolerance.max(ROUND_OFF * bend);
        self.goal
    }

    /// Counts one more iteration, of so many products; a reason where it may not be begun.
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
        options.interrupt.check(SOLVER)?;
        self.iterations += 1;
        Ok(None)
    }

    pub(crate) fn report(&self, reason: StopReason) -> SolverReport {
        SolverReport::new(reason, self.iterations, self.residual, self.goal)
    }
}
